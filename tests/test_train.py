"""``python -m train``: it learns, stops and goes on, and what it leaves is what it says."""

import io
import json
import re
import shutil
import signal
import subprocess
import sys
import time
import types
from collections import deque
from contextlib import redirect_stderr
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from gymnasium.spaces import Box
from hypothesis import given
from hypothesis import strategies as st
from stable_baselines3.common.buffers import RolloutBuffer
from stable_baselines3.common.logger import configure
from stable_baselines3.common.utils import set_random_seed

from asv_env import Simulation, make_params
from asv_env.geometry import wrap
from asv_env.sensing import observation
from asv_env.tasks import TRANSPORT, formation
from baselines import evaluate
from baselines.evaluate.results import read_csv
from baselines.learned import policy_file, shipped
from baselines.learned.sb3_policy import Sb3Policy
from baselines.rollout import trajectories
from train import actors, evaluation, imitation, run
from train.__main__ import main
from train.config import PRESETS, SEEDS_OF_A_RUN, Config, parse
from train.curriculum import Midway, Starts, grown
from train.run import opened
from train.sb3 import export, policies, ppo
from train.sb3.buffer import Rollouts
from train.sb3.ppo import Keeper, Learner
from train.sb3.residual import CorrectedVecEnv
from train.sb3.vec_env import Worlds

ROOT = Path(__file__).parents[1]
TINY_OPTIONS = """
    --num-envs 8 --num-steps 16 --num-minibatches 2 --update-epochs 2 --hidden 16 16
    --scenarios noisy --time-limit 5
    --imitation-rounds 1 --imitation-worlds 4 --imitation-time 3
    --imitation-steps 20 --critic-updates 1 --total-timesteps 4096 --checkpoint-every 1024
    --eval-every 2048 --eval-episodes 2 --torch-threads 1
"""
TINY = TINY_OPTIONS.split()
"""Options of a training that is over in seconds; 512 timesteps an update."""


def tiny(**options):
    return replace(parse(TINY), **options)


def train(folder, *options):
    main([*TINY, "--out", str(folder), *options])


def refusal(*options):
    """With what a command exits; several lines are joined."""
    said = io.StringIO()
    with pytest.raises(SystemExit) as exit, redirect_stderr(said):
        main([*TINY, *map(str, options)])
    return " ".join(f"{exit.value} {said.getvalue()}".replace("│", " ").split())


@pytest.fixture(scope="module")
def trained(tmp_path_factory):
    folder = tmp_path_factory.mktemp("train") / "run"
    train(folder)
    return folder


def layers_of(file):
    return policy_file.read_single(file)[0].layers


def actor_of(folder):
    return layers_of(folder / "policy.npz")


def same(layers, others):
    pairs = zip(layers, others, strict=True)
    return all(np.array_equal(a, b) for one, two in pairs for a, b in zip(one, two, strict=True))


# ------------------------------------------------------------------ what a run leaves


def test_a_run_leaves_its_files(trained):
    left = {path.name for path in trained.iterdir()}
    assert left == {
        *("config.json", "checkpoint.zip", "curve.csv", "best.npz", "best.zip", "policy.npz"),
        "tensorboard",
    }
    told = json.loads((trained / "config.json").read_text())
    assert told["options"]["num_envs"] == 8
    assert told["observation_version"] == observation.VERSION
    assert {"code", "revision", "libraries", "python"} <= told.keys()
    assert list((trained / "tensorboard").iterdir())


def test_a_run_that_has_come_to_its_end_is_left_as_it_is(trained, tmp_path):
    run = tmp_path / "run"
    shutil.copytree(trained, run)
    before = {path: path.read_bytes() for path in run.rglob("*") if path.is_file()}
    train(run)
    assert {path: path.read_bytes() for path in run.rglob("*") if path.is_file()} == before


def test_the_curve_has_a_row_for_each_evaluation(trained):
    rows = np.genfromtxt(trained / "curve.csv", delimiter=",", names=True, dtype=None)
    assert rows["timesteps"].tolist() == [0, 2048, 4096]
    assert (np.diff(rows["seconds"]) > 0).all()


def test_the_policy_file_acts_as_the_model_does(trained):
    params = make_params("push")
    saved = Sb3Policy(trained / "best.zip", params)
    policy = policy_file.load(trained / "best.npz", params)
    simulation = Simulation(params, 8)
    seen, fresh = simulation.reset(seeds=list(range(8))), np.ones(8, dtype=bool)
    for _ in range(20):
        action = policy.forward(seen)
        wanted, _ = saved.act(simulation.sensed, seen, None, fresh)
        np.testing.assert_allclose(action, wanted, atol=1e-5)
        assert np.abs(action).max() > 1e-3
        seen = simulation.step(action).observation


def test_export_writes_the_best_policy_and_refuses_what_is_not_it(trained, tmp_path, capsys):
    file = tmp_path / "mine.npz"
    export.main([str(trained), str(file)])
    assert same(layers_of(file), layers_of(trained / "best.npz"))
    assert "the same to" in capsys.readouterr().out
    with pytest.raises(SystemExit):
        export.main([str(trained), str(file)])
    assert "exists" in capsys.readouterr().err
    other = tmp_path / "other"
    shutil.copytree(trained, other)
    phase, card = policy_file.read_single(other / "best.npz")
    moved = replace(phase, layers=[(weight + 0.01, bias) for weight, bias in phase.layers])
    policy_file.save(other / "best.npz", [moved], card)
    with pytest.raises(SystemExit):
        export.main([str(other), str(tmp_path / "no.npz")])
    assert "differ by up to" in capsys.readouterr().err
    assert not (tmp_path / "no.npz").exists()


def test_what_was_learned_takes_part_in_the_comparison(trained, tmp_path):
    words = f"scripted one={trained / 'best.npz'}"
    options = f"--task push --episodes 2 --workers 0 --out {tmp_path / 'out'}"
    evaluate.main(["--policies", *words.split(), *options.split()])
    assert [row.policy for row in read_csv(tmp_path / "out/episodes.csv")].count("one") == 2


# ------------------------------------------------------------------ stopping and going on


@pytest.mark.parametrize("evaluations", [1, 2])
def test_a_run_that_is_killed_goes_on_to_the_bit(evaluations, trained, tmp_path):
    folder = tmp_path / "run"
    command = [sys.executable, "-m", "train", *TINY, "--out", str(folder)]
    process = subprocess.Popen(command, cwd=ROOT, stderr=subprocess.DEVNULL)
    try:
        while len(_timesteps(folder / "curve.csv")) < evaluations:
            assert process.poll() is None
            time.sleep(0.02)
    finally:
        process.send_signal(signal.SIGKILL)
        process.wait()
    assert len(_timesteps(folder / "curve.csv")) < 3
    train(folder)
    assert _timesteps(folder / "curve.csv") == [0, 2048, 4096]
    assert same(actor_of(folder), actor_of(trained))


def _timesteps(file):
    if not file.exists():
        return []
    return [int(line.split(",")[0]) for line in file.read_text().splitlines()[1:]]


def test_a_run_that_is_over_is_left_alone(trained):
    before = {path: path.read_bytes() for path in trained.iterdir() if path.is_file()}
    train(trained)
    assert {path: path.read_bytes() for path in before} == before


def test_another_seed_learns_something_else(trained, tmp_path):
    train(tmp_path / "run", "--seed", "1")
    assert not same(actor_of(tmp_path / "run"), actor_of(trained))


def test_a_central_critic_changes_what_the_critic_sees_alone(tmp_path):
    train(tmp_path / "run", "--critic", "central")
    learner = Learner.load(tmp_path / "run/checkpoint.zip", device="cpu")
    widths = [one.in_features for one in actors.linear_layers(policies.actor(learner.policy))]
    state = learner.observation_space["state"].shape[0]
    assert widths[0] == len(observation.NAMES)
    assert learner.policy.mlp_extractor.value_net[0].in_features == widths[0] + state
    assert policy_file.load(tmp_path / "run/best.npz", make_params("push"))


# ------------------------------------------------------------------ what is refused


def test_a_changed_configuration_is_refused(trained):
    assert "gamma was 0.996 and is 0.9" in refusal("--out", trained, "--gamma", 0.9)
    assert "task was 'push' and is 'approach'" in refusal("--out", trained, "--task", "approach")


def test_an_option_that_a_run_does_not_know_had_its_default(trained, tmp_path):
    folder = tmp_path / "run"
    shutil.copytree(trained, folder)
    file = folder / "config.json"
    told = json.loads(file.read_text())
    del told["options"]["slot_starts"]
    file.write_text(json.dumps(told))
    opened(tiny(out=folder))
    with pytest.raises(ValueError, match=re.escape("slot_starts was 0.0 and is 0.5")):
        opened(tiny(out=folder, slot_starts=0.5))


def test_another_version_of_the_observation_is_refused(trained, monkeypatch):
    monkeypatch.setattr(observation, "VERSION", observation.VERSION + 1)
    assert f"trained on version {observation.VERSION - 1}" in refusal("--out", trained)


def test_a_folder_of_something_else_is_refused(tmp_path):
    (tmp_path / "thesis.tex").write_text("precious")
    assert "something else" in refusal("--out", tmp_path)


@pytest.mark.parametrize("told", ["precious", '{"options": 1}', "[1]"])
def test_overwriting_leaves_what_is_no_run(told, tmp_path):
    (tmp_path / "config.json").write_text(told)
    assert "something else" in refusal("--out", tmp_path, "--overwrite")
    assert (tmp_path / "config.json").read_text() == told


def test_what_has_no_checkpoint_yet_is_begun_anew(tmp_path):
    opened(tiny(out=tmp_path / "run"))
    opened(tiny(out=tmp_path / "run", gamma=0.5))
    assert json.loads((tmp_path / "run/config.json").read_text())["options"]["gamma"] == 0.5


def test_going_on_with_other_code_is_noted(trained, tmp_path, capsys):
    folder = tmp_path / "run"
    shutil.copytree(trained, folder)
    file = folder / "config.json"
    told = json.loads(file.read_text())
    now = told["code"]
    file.write_text(json.dumps(told | {"code": "old"}))
    train(folder)
    assert "went_on_with" not in json.loads(file.read_text())  # it has come to its end
    (folder / "curve.csv").unlink()
    for _ in range(2):
        train(folder)
        (folder / "curve.csv").unlink()
    assert capsys.readouterr().err.count("goes on with other code") == 1
    told = json.loads(file.read_text())
    assert told["code"] == "old"
    assert [one["code"] for one in told["went_on_with"]] == [now]


def test_the_curve_tells_of_a_policy_that_is_there(trained, tmp_path, monkeypatch):
    scores = evaluation.evaluate(actor_of(trained), run.Run(tiny()).metadata, tiny(), (1, 2.0))
    made = run.Run(tiny(out=tmp_path / "run"))
    made.open()
    evaluation.keep(made, actor_of(trained), scores, best=True)
    assert _timesteps(made.curve) == [1]

    def fails(*_):
        raise OSError("full")

    monkeypatch.setattr(policy_file, "save", fails)
    with pytest.raises(OSError, match="full"):
        evaluation.keep(made, actor_of(trained), [replace(scores[0], timesteps=2)], best=False)
    assert _timesteps(made.curve) == [1]


def test_overwriting_begins_anew(trained, tmp_path):
    folder = tmp_path / "run"
    shutil.copytree(trained, folder)
    train(folder, "--overwrite", "--total-timesteps", "1024", "--eval-every", "1024")
    assert _timesteps(folder / "curve.csv") == [0, 1024]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--eval-seed", "5"], "seed 5 is not for development"),
        (["--teams", "4", "101"], "101"),
        (["--scenarios", "noise"], "Did you mean 'noisy'"),
        (["--decision-rate", "4"], "must divide 10"),
        (["--num-envs", "1", "--teams", "4", "6"], "at least a world each"),
        (["--critic", "central", "--teams", "4", "6"], "train one team size"),
        (["--gamma", "1.5"], "gamma = 1.5"),
        (["--residual", "0.2"], "set decision_rate = 10"),
        (["--total-timesteps", "0"], "total_timesteps = 0"),
        (["--until-wide"], "until_wide with widening = 0"),
        (["--adapt-kl", "-1"], "adapt_kl = -1"),
        (["--target-kl", "0"], "target_kl = 0"),
        (["--time-limit", "-5"], "time_limit = -5"),
        (["--hidden", "16", "0"], "hidden = (16, 0)"),
        (["--init-from", "some.npz"], "imitation would undo what the file has learned"),
        (["--init-from", "nowhere.npz", "--imitation-rounds", "0"], "nowhere.npz"),
        (["--demonstrations", "nowhere"], "no recorded episodes"),
    ],
)
def test_what_makes_no_sense_is_refused_before_anything_is_made(options, said, tmp_path):
    assert said in refusal("--out", tmp_path / "run", *options)
    assert not (tmp_path / "run").exists()


def test_a_policy_that_observes_otherwise_is_no_beginning(trained, tmp_path):
    save_with(trained, tmp_path / "old.npz", observation_version=0)
    assert "observes by version 0" in begun_with(tmp_path / "old.npz")


def save_with(trained, file, **metadata):
    """Saves what was trained with other metadata."""
    phase, card = policy_file.read_single(trained / "best.npz")
    policy_file.save(file, [replace(phase, metadata=replace(phase.metadata, **metadata))], card)


def begun_with(file, *options):
    """With what a training is refused that would begin with a file."""
    folder = file.parent / "refused"
    refused = refusal("--out", folder, "--init-from", file, "--imitation-rounds", 0, *options)
    assert not folder.exists()
    return refused


@pytest.mark.parametrize(
    ("other", "said"),
    [
        ({"activation": "tanh"}, "its activation is 'tanh', that of the training 'relu'"),
        ({"mirrors": True}, "its mirror is True, that of the training False"),
        ({"residual": 0.5}, "its residual is 0.5, that of the training 0.0"),
        ({"action_repeat": 5}, "its decision_rate is 2, that of the training 5"),
    ],
)
def test_a_policy_that_acts_otherwise_is_no_beginning(other, said, trained, tmp_path):
    save_with(trained, tmp_path / "other.npz", **other)
    assert said in begun_with(tmp_path / "other.npz")


def test_a_policy_of_other_layers_is_no_beginning(trained, tmp_path):
    shutil.copy(trained / "best.npz", tmp_path / "wide.npz")
    assert "wide.npz: layers of sizes [53, 16, 16, 2] do not fit" in begun_with(
        tmp_path / "wide.npz", "--hidden", 8, 16
    )
    shutil.copy(shipped.file_for(TRANSPORT), tmp_path / "several.npz")
    assert "several.npz holds 4 networks: it must hold one" in begun_with(tmp_path / "several.npz")


def test_a_policy_file_is_a_beginning(trained, tmp_path):
    learner = Learner.made(tiny(), Worlds(tiny()))
    layers = layers_of(trained / "best.npz")
    actors.put_layers(policies.actor(learner.policy), layers)
    assert same(actors.layers_of(policies.actor(learner.policy)), layers)
    with pytest.raises(ValueError, match="--hidden"):
        actors.put_layers(policies.actor(learner.policy), layers[1:])


def test_a_wider_actor_begins_by_acting_as_the_file(trained):
    layers = layers_of(trained / "best.npz")

    def actor(*hidden):
        config = tiny(hidden=hidden)
        made = policies.actor(Learner.made(config, Worlds(config)).policy)
        actors.put_layers(made, layers)
        return made

    wider = actor(24, 40)
    seen = torch.randn(50, len(observation.NAMES), generator=torch.Generator().manual_seed(1))
    torch.testing.assert_close(wider(seen), actor(16, 16)(seen))
    wider(seen).sum().backward()
    *hidden, last = actors.linear_layers(wider)
    assert [one.out_features for one in (*hidden, last)] == [24, 40, 2]
    assert (last.weight.grad[:, 16:] != 0).any()  # what is new can learn
    with pytest.raises(ValueError, match="or wider"):
        actor(16, 8)


def test_a_missing_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "train.ppo", None)
    for name in ("stable_baselines3", "wandb"):
        monkeypatch.setitem(sys.modules, name, None)
    monkeypatch.delitem(sys.modules, "train.ppo")
    monkeypatch.delitem(sys.modules, "train.networks")
    assert "pip install -e '.[train]'" in refusal()


def test_a_missing_tracker_is_named(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "wandb", None)
    assert "pip install wandb" in refusal("--track", "--out", tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_a_tracker_hears_of_the_run(monkeypatch, tmp_path):
    told = {}

    def init(**options):
        told.update(options)
        return types.SimpleNamespace(finish=lambda: told.update(finished=True))

    monkeypatch.setitem(sys.modules, "wandb", types.SimpleNamespace(init=init))
    train(tmp_path / "run", "--track", "--total-timesteps", "512")
    assert told["config"]["num_envs"] == 8
    assert told["sync_tensorboard"]
    assert told["finished"]
    assert told["id"] == run.Run(tiny(out=tmp_path / "run")).id  # of a run that goes on too
    assert told["resume"] == "allow"


# ------------------------------------------------------------------ recorded episodes


@pytest.fixture(scope="module")
def demonstrations(tmp_path_factory):
    out = tmp_path_factory.mktemp("recorded")
    for seed in (10**9, 5):
        words = f"--task push --random-goals --seed {seed} --episodes 1 --record --workers 0"
        words += " --policies scripted"
        evaluate.main([*words.split(), "--out", str(out / str(seed))])
    return out


def test_recorded_episodes_are_imitated(demonstrations):
    config = tiny(demonstrations=demonstrations / str(10**9))
    imitation.check_recorded(config)
    ((seen, done),) = imitation.recorded(config)
    trajectory, _ = trajectories.load(next(config.demonstrations.rglob("*.npz")))
    assert len(seen) == len(done) == 4 * len(trajectory.action)


def test_episodes_of_the_tests_are_not_learned_from(demonstrations, tmp_path):
    options = ("--demonstrations", demonstrations / "5", "--out", tmp_path / "run")
    assert "seed 5 is for test, not for training" in refusal(*options)
    assert not (tmp_path / "run").exists()


def test_episodes_of_another_task_are_not_learned_from(demonstrations):
    options = ("--demonstrations", demonstrations / str(10**9), "--task", "transport")
    assert "its task is 'push'" in refusal(*options)


def test_imitation_comes_near_to_a_teacher_that_can_be_told_from_what_is_seen():
    torch.manual_seed(0)
    seen = torch.randn(4000, 5)
    wanted = torch.tanh(seen[:, :2])
    actor = torch.nn.Sequential(torch.nn.Linear(5, 64), torch.nn.ReLU(), torch.nn.Linear(64, 2))
    optimizer = torch.optim.Adam(actor.parameters(), 1e-2)
    shuffle = torch.Generator().manual_seed(0)
    before = imitation.fit(actor, optimizer, seen, wanted, 1, shuffle)
    assert imitation.fit(actor, optimizer, seen, wanted, 200, shuffle) < before / 10


# ------------------------------------------------------------------ curriculum and worlds


@given(share=st.floats(0, 1), scenario=st.sampled_from(["nominal", "noisy", "harsh"]))
def test_what_grows_ends_where_the_task_is(share, scenario):
    params = make_params("push", scenario=scenario)
    assert grown(params, 1.0) == params
    some = grown(params, share)
    assert some.sensors.position_noise == share * params.sensors.position_noise
    assert some.variation.mass == share * params.variation.mass


@given(share=st.floats(0, 1), seed=st.integers(0, 1000), side=st.sampled_from(["+n", "-n"]))
def test_goals_widen_from_the_way_ahead(share, seed, side):
    params, config = make_params("push", side=side), tiny()
    narrow, wide = (
        Starts(config, share=some)(params, np.random.default_rng(seed)).goal for some in (share, 1)
    )
    assert np.hypot(*narrow[:2]) == pytest.approx(np.hypot(*wide[:2]))
    ahead = -np.pi / 2 if side == "+n" else np.pi / 2
    bearings = [wrap(np.arctan2(goal[1], goal[0]) - ahead) for goal in (narrow, wide)]
    assert bearings[0] == pytest.approx(share * bearings[1], abs=1e-9)
    assert narrow[2] == pytest.approx(share * wide[2])


def test_goals_are_nearer_and_boats_beside_the_hull_as_often_as_asked_for():
    params, rng = make_params("transport"), np.random.default_rng(0)
    starts = [Starts(tiny(near_goals=0.5, near_starts=0.25))(params, rng) for _ in range(400)]
    near = [np.hypot(*start.goal[:2]) < params.task.goal_distance[0] for start in starts]
    reach = np.array([np.abs(start.motion[1:, :2]).max() for start in starts])
    assert 0.1 < np.mean(near) < 0.4  # a goal that is drawn nearer need not be that near
    assert 0.15 < np.mean(reach < 0.6) < 0.4
    assert all(len(np.unique(start.motion[1:, 0])) == 4 for start in starts)


def test_boats_beside_the_hull_touch_nothing():
    params = make_params("transport")
    simulation = Simulation(params, 32, initial_states=Starts(tiny(near_starts=1.0)))
    simulation.reset(seeds=range(32))
    simulation.step(np.zeros((32, 4, 2)))
    assert not simulation.state.touching.any()
    assert np.abs(simulation.state.motion[:, 1:, :2]).max() < 0.62


def test_boats_begin_in_the_slots_of_either_side():
    params, rng = make_params("transport"), np.random.default_rng(0)
    sides = []
    for _ in range(60):
        boats = Starts(tiny(slot_starts=1.0))(params, rng).motion[1:]
        side = np.sign(boats[:, 1].sum())
        slots = formation.slots(params, 4)
        np.testing.assert_allclose(boats[:, 0], slots.real, atol=2e-3)
        np.testing.assert_allclose(side * boats[:, 1], slots.imag, atol=2e-3)
        np.testing.assert_allclose(boats[:, 2], -side * np.pi / 2)
        sides.append(side)
    assert 15 < sides.count(1.0) < 45


def test_pushes_begin_where_others_have_brought_the_vessel_into_closure():
    """Told from the +n side, in closure, also where the team pushes from the other one."""
    file = shipped.file_for(TRANSPORT)
    params = make_params("transport", scenario="noisy")
    midway = Midway.handed_over(file, params, range(10**9, 10**9 + 8))
    assert len(midway.goal) >= 8
    config = tiny(midway_starts=1.0, mirror=True)
    simulation = Simulation(make_params("push"), 32, initial_states=Starts(config, midway))
    simulation.reset(seeds=range(32))
    assert simulation.relations.slot_error.max() < 2 * params.task.slot_distance
    drawn = simulation.state.motion
    assert all((start == midway.motion).all(axis=(1, 2)).any() for start in drawn)


def test_a_hand_over_by_something_else_is_refused(trained, tmp_path):
    given = ("--out", tmp_path / "r", "--hand-over", trained / "best.npz")
    assert "best.npz: 1 networks for a team of 4" in refusal(*given, "--midway-starts", 0.5)
    assert "midway_starts = 0: no episode would begin there" in refusal(*given)
    both = policy_file.read(shipped.file_for(TRANSPORT))[0]
    file = tmp_path / "four.npz"
    policy_file.save(file, [one for one in both if one.team_size == 4], {})
    given = ("--out", tmp_path / "r", "--hand-over", file, "--midway-starts", 0.5, "--teams", 6)
    assert "four.npz: 0 networks for a team of 6" in refusal(*given)
    assert not (tmp_path / "r").exists()


def test_a_hand_over_that_never_pushes_is_named(tmp_path):
    idle = [
        replace(one, layers=[(0 * weight, 0 * bias) for weight, bias in one.layers])
        for one in policy_file.read(shipped.file_for(TRANSPORT))[0]
    ]
    policy_file.save(tmp_path / "idle.npz", idle, {})
    given = ("--out", tmp_path / "r", "--hand-over", tmp_path / "idle.npz", "--midway-starts", 0.5)
    assert "idle.npz: it never brought the vessel into closure with 4 boats" in refusal(*given)


def test_minibatches_are_those_of_the_library():
    seen, does = Box(-1, 1, (3,)), Box(-1, 1, (2,))
    made = [buffer(8, seen, does, device="cpu", n_envs=5) for buffer in (RolloutBuffer, Rollouts)]
    for buffer in made:
        rng, begins = np.random.default_rng(0), np.zeros(5)
        while not buffer.full:
            one, two = (torch.as_tensor(rng.random(5), dtype=torch.float32) for _ in range(2))
            buffer.add(rng.random((5, 3)), rng.random((5, 2)), rng.random(5), begins, one, two)
        buffer.compute_returns_and_advantage(one, begins)
    batches = []
    for buffer in made:
        set_random_seed(0)
        batches.append(list(buffer.get(16)))
    assert len(batches[0]) == 3
    for theirs, ours in zip(*batches, strict=True):
        for name in theirs._fields:
            assert torch.equal(getattr(theirs, name), getattr(ours, name)), name


def test_the_noise_of_the_actions_is_kept_up(tmp_path):
    config = tiny(log_std_init=-3.0, log_std_min=-1.0, out=tmp_path)
    worlds = Worlds(config)
    learner = Learner.made(replace(config, critic_updates=0, adapt_kl=None), worlds)
    learner.set_logger(configure(None, []))
    learner.learn(1024)
    assert learner.policy.log_std.min() >= -1.0


def test_episodes_begin_midway_in_scripted_ones():
    params, config = make_params("push"), tiny(midway_starts=1.0, mirror=True)
    midway = Midway.watched(config, params, range(10**9, 10**9 + 2))
    starts = Starts(config, midway)
    start = starts(params, np.random.default_rng(0))
    assert (start.motion == midway.motion).all(axis=(1, 2)).any()
    moving = np.abs(midway.motion[:, 0, 3:]).max(axis=1) > 0
    assert moving.mean() > 0.5
    assert (midway.goal[:, 1] <= 0).all()


@pytest.mark.parametrize(
    ("succeed", "share"), [([1, 1, 1, 0, 1], 0.5), ([1, 1, 0], 0.2), ([], 0.2)]
)
def test_the_curriculum_widens_where_most_episodes_succeed(succeed, share, tmp_path):
    config = tiny(widening=0.3, out=tmp_path)
    worlds = Worlds(config)
    learner = Learner.made(config, worlds)
    learner.set_logger(configure(None, []))
    learner.ep_success_buffer = deque(succeed)
    keeper = Keeper(run.Run(config), worlds, None, None)
    keeper.init_callback(learner)
    keeper.widen()
    assert learner.share == pytest.approx(share)
    assert not learner.ep_success_buffer
    learner.save(tmp_path / "kept.zip")
    assert Learner.load(tmp_path / "kept.zip", device="cpu").share == learner.share
    for _ in range(9):
        learner.ep_success_buffer = deque([1])
        keeper.widen()
    assert learner.share == 1.0


def test_a_run_ends_where_goals_have_widened_to_all(monkeypatch, tmp_path, capsys):
    folder = tmp_path / "run"
    options = ["--until-wide", "--narrowest", "0.5", "--widening", "0.5"]
    train(folder, *options)
    assert _timesteps(folder / "curve.csv") == [0, 2048, 4096]  # hardly any episode succeeds
    assert "goals have widened to 50% only" in capsys.readouterr().err

    monkeypatch.setattr(ppo, "WIDENS", 0.0)
    train(folder, *options, "--overwrite")
    first, last = _timesteps(folder / "curve.csv")
    assert first == 0 < last < 2048
    checkpoint = Learner.load(folder / "checkpoint.zip", device="cpu")
    assert checkpoint.share == 1.0
    kept = actor_of(folder)
    (folder / "curve.csv").write_text("")  # as if killed before the last evaluation
    for _ in range(2):
        train(folder, *options)
        assert _timesteps(folder / "curve.csv") == [last]
        assert same(actor_of(folder), kept)


def test_worlds_are_the_same_after_the_same_renewal():
    config = tiny(teams=(4, 6), scenarios=("noisy", "mismatch"))
    worlds = Worlds(config)
    action = np.full((worlds.num_envs, 2), 0.5, dtype=np.float32)
    assert worlds.num_envs == 2 * (2 * 4 + 2 * 6)

    weighted = tiny(teams=(4, 6, 6), num_envs=7)
    assert weighted.shared_out(7) == {(4, "noisy"): 3, (6, "noisy"): 4}
    assert Worlds(weighted).num_envs == 3 * 4 + 4 * 6

    def begun(progress, seed):
        seen = [worlds.renew(progress, seed)]
        for _ in range(5):
            seen.append(worlds.step(action)[0])
        return np.array(seen)

    first = begun(0.5, 10**9)
    assert not np.array_equal(first, begun(0.5, 10**9 + 100))
    assert np.array_equal(first, begun(0.5, 10**9))


def test_corrections_are_made_in_training_as_in_the_policy_file(tmp_path):
    residual = ["--residual", "0.3", "--decision-rate", "10", "--imitation-rounds", "0"]
    train(tmp_path / "run", *residual, "--total-timesteps", "512", "--scenarios", "nominal")
    policy = policy_file.load(tmp_path / "run/policy.npz", make_params("push"))
    boats = CorrectedVecEnv("push", num_envs=3, share=0.3)
    boats.seed(10**9)
    seen = boats.reset()
    simulation, memory = Simulation(make_params("push"), 3), None
    observed, fresh = simulation.reset(seeds=[10**9, 10**9 + 4, 10**9 + 8]), np.ones(3, bool)
    for _ in range(30):
        assert np.array_equal(seen.reshape(observed.shape), observed)
        correction = policy.forward(observed)
        action, memory = policy.act(simulation.sensed, observed, memory, fresh)
        observed, fresh = simulation.step(action).observation, np.zeros(3, bool)
        seen = boats.step(correction.reshape(-1, 2))[0]
    assert np.abs(correction).max() > 0


def test_the_state_for_a_central_critic_is_that_of_the_rows_own_world():
    worlds = Worlds(tiny(critic="central"))
    seen = worlds.renew(0.0, 10**9)
    states = seen["state"].reshape(8, 4, -1)
    assert (states == states[:, :1]).all()
    assert len(np.unique(states[:, 0], axis=0)) == 8


# ------------------------------------------------------------------ options and scores


@pytest.mark.parametrize("task", ["approach", "push", "transport"])
def test_each_task_presets_its_own(task):
    assert parse(["--task", task]).task == task
    assert parse([f"--task={task}", "--gamma", "0.5"]) == replace(PRESETS[task], gamma=0.5)


def test_seeds_of_runs_do_not_meet():
    assert Config(seed=1).first_seed - Config(seed=0).first_seed == SEEDS_OF_A_RUN


def test_a_score_counts_failures_with_twice_the_time_limit(trained):
    params = make_params("push")
    rows = [
        types.SimpleNamespace(success=done, duration=time, position_error=0.01, heading_error=-0.1)
        for done, time in ((True, 20.0), (True, 40.0), (False, 120.0))
    ]
    score = evaluation.score(rows, params, "noisy", (5, 1.0))
    assert score.success == pytest.approx(2 / 3)
    assert score.median_time == 30.0
    assert score.penalised_time == pytest.approx((20 + 40 + 240) / 3)
    assert score.heading_error == 0.1


def test_a_write_that_fails_leaves_the_old_file(tmp_path):
    file = tmp_path / "policy.npz"
    file.write_text("old")

    def fails(part):
        part.write_text("half")
        raise OSError("full")

    with pytest.raises(OSError, match="full"):
        run.write(file, fails)
    assert [path.name for path in tmp_path.iterdir()] == ["policy.npz"]
    assert file.read_text() == "old"
