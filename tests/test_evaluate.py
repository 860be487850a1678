"""The evaluation, from the command line to its files."""

import json
import sqlite3
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from helpers import SEEN

from asv_env import make_params
from baselines import evaluate
from baselines.evaluate.conditions import Condition
from baselines.evaluate.policy_sources import find
from baselines.evaluate.request import FILES
from baselines.evaluate.results import HEADS, read_csv
from baselines.evaluate.store import NAME as STORE
from baselines.evaluate.store import Series, Store
from baselines.evaluate.suites import SUITES
from baselines.evaluate.workers import Job, WorkerError
from baselines.evaluate.workers import run as run_jobs
from baselines.learned import policy_file
from baselines.learned.metadata import Metadata, Phase
from baselines.learned.network import NetworkPolicy
from baselines.policy import Idle
from baselines.rollout import film, runner, trajectories
from baselines.rollout.episodes import Label

EPISODES = 40
"""Of a run that is killed again and again."""
SHORT = ["--task", "push", "--episodes", "3", "--num-envs", "2", "--workers", "0"]


def run(*arguments):
    evaluate.main([str(argument) for argument in arguments])


def rows(folder):
    return read_csv(folder / "episodes.csv")


def refused(capsys, *arguments):
    """What the command line says when it refuses."""
    with pytest.raises(SystemExit) as stopped:
        run(*arguments)
    assert stopped.value.code == 2
    return capsys.readouterr().err


@pytest.fixture(autouse=True)
def no_report(request, monkeypatch):
    """Drawing takes longer than these episodes; ``test_report`` looks at reports."""
    if "results" not in request.fixturenames:
        monkeypatch.setattr("baselines.evaluate.report.document.write", lambda *arguments: [])


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Policies in files, as they come from training, but untrained."""
    from stable_baselines3 import PPO

    from asv_env.envs.sb3 import BoatVecEnv

    folder = tmp_path_factory.mktemp("policies")
    for seed in (0, 1):
        rng = np.random.default_rng(seed)
        layers = [(rng.normal(size=(n, m)), rng.normal(size=m)) for n, m in [(SEEN, 32), (32, 2)]]
        policy_file.save(folder / f"net{seed}.npz", [Phase(layers, Metadata(action_repeat=2))], {})
    PPO("MlpPolicy", BoatVecEnv("push", num_envs=1), device="cpu").save(folder / "model.zip")
    return folder


@pytest.fixture
def network_file(files):
    return files / "net0.npz"


@pytest.fixture
def other_network_file(files):
    return files / "net1.npz"


@pytest.fixture
def sb3_file(files):
    return files / "model.zip"


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("results")
    run(*SHORT, "--policies", "scripted", "idle", "--seed", 7, "--out", folder)
    return folder


# ---------------------------------------------------------------- files


def test_every_policy_meets_the_same_seeds_in_order(results):
    assert [(row.policy, row.seed) for row in rows(results)] == [
        (policy, seed) for policy in ("scripted", "idle") for seed in (7, 8, 9)
    ]


def test_columns_are_empty_where_they_do_not_apply(results):
    assert (results / "episodes.csv").read_text().splitlines()[0] == ",".join(HEADS)
    idle = next(row for row in rows(results) if row.policy == "idle")
    assert not idle.success
    assert idle.cause == "never near"
    assert idle.time_to_goal is None
    assert idle.time_to_closure is None
    assert idle.training_seed is None
    assert idle.position_error == pytest.approx(np.hypot(0.55, 0.95))
    assert idle.heading_error == pytest.approx(-0.1)
    assert idle.path_length_ratio == 0.0
    assert idle.duration == 120.0
    assert (idle.goal_x, idle.goal_y, idle.goal_heading) == (0.55, -0.95, 0.1)


def test_summary_agrees_with_the_rows(results):
    (condition,) = json.loads((results / "summary.json").read_text())["conditions"].values()
    for name in ("scripted", "idle"):
        own = [row for row in rows(results) if row.policy == name]
        summary = condition["policies"][name]
        assert summary["success"]["value"] == np.mean([row.success for row in own])
        assert summary["causes"] == ({"never near": 3} if name == "idle" else {})
        mean = np.mean([row.effort for row in own])
        assert summary["effort"]["mean"]["value"] == pytest.approx(mean)
        errors = np.abs([row.heading_error for row in own])
        assert summary["heading_error"]["median"] == pytest.approx(np.median(errors))
    compared = condition["comparisons"]["idle"]
    assert compared["success"]["value"] == -1.0
    assert compared["improvement"]["value"] == 0.0
    assert compared["mcnemar"] == pytest.approx(0.25)  # three of three: 2 / 2^3


def test_files_are_left_as_the_command_says(results):
    assert all((results / name).exists() for name in FILES)


# ---------------------------------------------------------------- to go on


def test_what_is_there_is_kept_and_only_what_is_new_is_run(tmp_path, capsys):
    run(*SHORT, "--policies", "idle", "--out", tmp_path)
    before = rows(tmp_path)
    with sqlite3.connect(tmp_path / STORE) as base:  # as a mark that it is not run again
        base.execute("UPDATE episode SET row = replace(row, '\"effort\": 0.0', '\"effort\": 7.0')")
    run(*SHORT, "--policies", "idle", "random", "--episodes", 4, "--out", tmp_path)
    after = rows(tmp_path)
    assert [row.effort for row in after if row.policy == "idle"] == [7.0, 7.0, 7.0, 0.0]
    assert [row.seed for row in after if row.policy == "idle"][:3] == [row.seed for row in before]
    assert sum(row.policy == "random" for row in after) == 4


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--task", "push", "--scenario", "noisy"], "another set of episodes"),
        (["--task", "approach"], "another task"),
        (["--suite", "quick-v1"], "another suite"),
    ],
)
def test_results_of_another_origin_are_not_mixed_or_lost(results, arguments, message, capsys):
    before = (results / "episodes.csv").read_bytes()
    common = ["--policies", "idle", "--workers", "0", "--out", results]
    assert message in refused(capsys, *common, *arguments)
    assert (results / "episodes.csv").read_bytes() == before
    assert len(rows(results)) == 6


def test_other_code_is_noticed(tmp_path, capsys, monkeypatch):
    run(*SHORT, "--policies", "idle", "--out", tmp_path)
    monkeypatch.setattr("baselines.rollout.provenance.code", lambda: "other")
    assert "state of the code" in refused(capsys, *SHORT, "--policies", "idle", "--out", tmp_path)
    run(*SHORT, "--policies", "idle", "--out", tmp_path, "--overwrite")


def test_files_of_others_are_not_replaced_unless_asked(tmp_path, capsys):
    (tmp_path / "summary.json").write_text("mine")
    assert "--overwrite" in refused(capsys, *SHORT, "--policies", "idle", "--out", tmp_path)
    assert (tmp_path / "summary.json").read_text() == "mine"
    run(*SHORT, "--policies", "idle", "--out", tmp_path, "--overwrite")
    assert json.loads((tmp_path / "summary.json").read_text())["suite"] == "custom"


def test_two_runs_do_not_write_to_one_folder(tmp_path):
    first = Store(tmp_path, {"suite": "one"}, {}, False)
    with pytest.raises(FileExistsError, match="in use by another run"):
        Store(tmp_path, {"suite": "one"}, {}, False)
    first.close()
    Store(tmp_path, {"suite": "one"}, {}, False).close()


def test_a_folder_that_cannot_be_is_refused(tmp_path, capsys):
    (tmp_path / "file").write_text("")
    said = refused(capsys, *SHORT, "--policies", "idle", "--out", tmp_path / "file" / "below")
    assert "file" in said


def test_a_file_that_is_no_database_is_refused(tmp_path, capsys):
    (tmp_path / STORE).write_text("something else, and long enough to be looked at" * 9)
    said = refused(capsys, *SHORT, "--policies", "idle", "--out", tmp_path)
    assert "not a database of episodes" in said


def test_a_killed_run_goes_on_and_ends_alike(tmp_path):
    """Killed three times, each time after some more episodes."""
    command = [
        *(sys.executable, "-m", "baselines.evaluate", "--task", "push", "--scenario", "noisy"),
        *("--goal", "0", "-0.45", "0", "--policies", "scripted", "--episodes", str(EPISODES)),
        *("--workers", "2", "--num-envs", "2"),
    ]
    whole, killed = tmp_path / "whole", tmp_path / "killed"
    subprocess.run([*command, "--out", whole], check=True, capture_output=True)
    kept = [0]
    for _ in range(3):
        process = subprocess.Popen(
            [*command, "--out", killed], stderr=subprocess.DEVNULL, start_new_session=True
        )
        until = time.monotonic() + 60.0
        while process.poll() is None and stored(killed) <= kept[-1] and time.monotonic() < until:
            time.sleep(0.02)
        process.kill()
        process.wait()
        kept.append(stored(killed))
        assert kept[-2] < kept[-1] < EPISODES
        assert not (killed / "episodes.csv").exists()
    subprocess.run([*command, "--out", killed], check=True, capture_output=True)
    assert (killed / "episodes.csv").read_bytes() == (whole / "episodes.csv").read_bytes()


def stored(folder):
    """Episodes in the database of a folder, 0 while it cannot be read."""
    try:
        base = sqlite3.connect(f"file:{folder / STORE}?mode=ro&immutable=1", uri=True)
        return base.execute("SELECT count(*) FROM episode").fetchone()[0]
    except sqlite3.Error:
        return 0


# ---------------------------------------------------------------- what changes no number


def test_episodes_do_not_depend_on_batch_or_workers(network_file, sb3_file):
    condition = Condition("short", task="push", scenario="harsh", options={"time_limit": 1.0})

    def episodes_of(num_envs, workers, words):
        jobs = [
            job(condition, word, seeds, num_envs)
            for word in words
            for seeds in (range(64), range(64, 70))
        ]
        done = [track for _, track in run_jobs(jobs, workers)]
        done.sort(key=lambda track: (track.episode.policy, track.episode.seed))
        return [(track.episode, track.poses.tobytes()) for track in done]

    words = ["scripted", "paper", "random", str(network_file), str(sb3_file)]
    alone = episodes_of(1, 0, words)
    assert len(alone) == 5 * 70
    assert episodes_of(16, 0, words) == alone
    assert episodes_of(64, 2, words) == alone


def job(condition, word, seeds, num_envs=1):
    source, series = find(word, trust_pickles=True), Series(condition.name, word, 0)
    return Job(series, condition, source, source.fingerprint(), Label(word), tuple(seeds), num_envs)


@pytest.fixture
def mine(monkeypatch):
    """Modules beside the tests can be imported, here and in workers."""
    monkeypatch.syspath_prepend(str(Path(__file__).parent))


@pytest.mark.usefixtures("mine")
def test_a_worker_that_dies_is_noticed():
    condition = Condition("short", task="push", options={"time_limit": 1.0})
    source = find("broken_policies:Dies")
    dying = Job(
        Series("short", "Dies", 0), condition, source, source.fingerprint(), Label("Dies"), (0,), 1
    )
    with pytest.raises(WorkerError, match="exit code -9"):
        list(run_jobs([dying], 1))


def test_a_policy_that_changes_meanwhile_is_not_mixed(network_file, other_network_file, tmp_path):
    condition = Condition("short", task="push", options={"time_limit": 1.0})
    file = tmp_path / "best.npz"
    file.write_bytes(network_file.read_bytes())
    begun = job(condition, str(file), (0,))
    file.write_bytes(other_network_file.read_bytes())
    with pytest.raises(WorkerError, match=r"best\.npz has changed since the run began"):
        list(run_jobs([begun], 1))


# ---------------------------------------------------------------- policies


@pytest.mark.usefixtures("mine")
@pytest.mark.parametrize("workers", [0, 1])
@pytest.mark.parametrize("num_envs", [1, 4])
def test_a_broken_policy_fails_its_own_episodes_alone(tmp_path, capsys, workers, num_envs):
    run(
        *("--task", "push", "--random-goals", "--episodes", 4, "--seed", 20, "--out", tmp_path),
        *("--num-envs", num_envs, "--workers", workers),
        *("--policies", "idle", "broken_policies:RaisesNow", "broken_policies:GivesNan"),
    )
    said = capsys.readouterr().out
    by_policy = {
        name: [row for row in rows(tmp_path) if row.policy == name]
        for name in ("idle", "RaisesNow", "GivesNan")
    }
    assert all(row.error is None for row in by_policy["idle"])
    for name, text in (("RaisesNow", "ArithmeticError: tired"), ("GivesNan", "not finite")):
        broken = [row for row in by_policy[name] if row.error]
        assert 0 < len(broken) < 4  # of those that turn right only
        assert all(row.goal_x > 0 for row in broken)
        assert {(row.cause, row.success) for row in broken} == {("policy error", False)}
        assert all(text in row.error for row in broken)
        assert f"{name}, nominal, seed {broken[0].seed}" in said
        for one, other in zip(by_policy[name], by_policy["idle"], strict=True):
            assert one.error or one.position_error == other.position_error


@pytest.mark.usefixtures("mine")
@pytest.mark.parametrize(
    ("word", "message"),
    [
        ("scriptd", "Did you mean 'scripted'"),
        ("nowhere:Policy", "No module named 'nowhere'"),
        ("broken_policies:Nothing", "no attribute 'Nothing'"),
        ("broken_policies:NoPolicy", "no method act"),
        ("broken_policies:WrongShape", "must be (1, 4, 2)"),
        ("broken_policies:Picky", "I only play approach"),
        ("broken_policies:OldStyle", "act must take (sensed, observation, memory, fresh)"),
        ("broken_policies:OnlyActs", "return (action, memory)"),
        ("broken_policies:Unmade", "AttributeError: nothing"),
        ("broken_policies:turning_right", "AttributeError"),
        ("scripted,idle", "need a name"),
        ("mine=scripted,idle", "need a name"),
        ("../mine=idle", "cannot be a name"),
        ("=idle", "cannot be a name"),
        ("missing.npz", "there is no such file"),
        ("missing.zip", "there is no such file"),
    ],
)
def test_what_is_no_policy_or_does_not_fit_is_refused(tmp_path, capsys, word, message):
    assert message in refused(capsys, *SHORT, "--policies", word, "--out", tmp_path / "none")
    assert not (tmp_path / "none").exists()


def test_a_policy_file_takes_part(tmp_path, network_file):
    run(*SHORT, "--policies", "idle", f"net={network_file}", "--out", tmp_path)
    assert {row.policy for row in rows(tmp_path)} == {"idle", "net"}


def test_several_trainings_are_one_policy(tmp_path, network_file, other_network_file):
    words = ["--policies", "idle", f"net={network_file},{other_network_file}"]
    run(*SHORT, *words, "--out", tmp_path)
    net = [row for row in rows(tmp_path) if row.policy == "net"]
    assert [(row.training_seed, row.seed) for row in net] == [
        (k, s) for k in (0, 1) for s in range(3)
    ]
    (condition,) = json.loads((tmp_path / "summary.json").read_text())["conditions"].values()
    assert condition["policies"]["net"]["trainings"] == 2
    assert condition["comparisons"]["net"]["mcnemar"] is None


def test_another_policy_under_a_known_name_is_noticed(
    tmp_path, capsys, network_file, other_network_file
):
    run(*SHORT, "--policies", "idle", f"net={network_file}", "--out", tmp_path)
    words = ["--policies", "idle", f"net={other_network_file}", "--out", tmp_path]
    assert "another policy net" in refused(capsys, *SHORT, *words)
    run(*SHORT, *words, "--overwrite")
    assert len(rows(tmp_path)) == 6


@pytest.mark.parametrize("text", [b"not an archive", b"PK\x05\x06" + 18 * b"\0"])
def test_a_file_that_is_no_policy_is_refused(tmp_path, capsys, text):
    file = tmp_path / "mine.npz"
    file.write_bytes(text)
    said = refused(capsys, *SHORT, "--policies", file, "--out", tmp_path / "none")
    assert "not a policy file" in said


@pytest.mark.parametrize(
    ("weight", "bias", "metadata", "message"),
    [
        ((SEEN, 2), (3,), {}, "do not fit"),
        ((SEEN,), (2,), {}, "do not fit"),
        ((SEEN - 1, 2), (2,), {}, f"must map an observation of {SEEN}"),
        ((SEEN, 2), (2,), {"tasks": ("approach",)}, "is for the task approach, not for 'push'"),
        ((SEEN, 2), (2,), {"action_mode": "thrusters"}, "gives 'thrusters' actions"),
        ((SEEN, 2), (2,), {"observation_version": 0}, "observes by version 0"),
    ],
)
def test_a_policy_file_that_does_not_fit_is_refused(
    tmp_path, capsys, weight, bias, metadata, message
):
    file = tmp_path / "mine.npz"
    layers = [(np.zeros(weight), np.zeros(bias))]
    policy_file.save(file, [Phase(layers, Metadata(**metadata))], {})
    assert message in refused(capsys, *SHORT, "--policies", file, "--out", tmp_path / "none")


@pytest.mark.parametrize(
    "metadata", ["no json", '"text"', '{"tasks": null}', '{"tasks": [], "unknown": 1}']
)
def test_a_policy_file_with_metadata_that_make_no_sense_is_refused(tmp_path, capsys, metadata):
    file, layer = tmp_path / "mine.npz", {"weight_0": np.zeros((SEEN, 2)), "bias_0": np.zeros(2)}
    phase = f'{{"metadata": {metadata}, "patience": null, "team_size": null}}'
    policy = f'{{"format": "{policy_file.FORMAT}", "phases": [{phase}], "model_card": {{}}}}'
    arrays = {f"phase_0_{name}": array for name, array in layer.items()}
    np.savez(file, policy=np.array(policy), **arrays)
    said = refused(capsys, *SHORT, "--policies", file, "--out", tmp_path / "none")
    assert f"{file} is not a policy file" in said


def test_a_policy_file_gives_what_its_perceptron_says():
    rng = np.random.default_rng(0)
    first, last = rng.normal(size=(SEEN, 3)), rng.normal(size=(3, 2))
    shift = rng.normal(size=3)
    policy = NetworkPolicy(
        [(first, shift), (last, np.zeros(2))], Metadata(activation="relu"), make_params("push")
    )
    seen = rng.normal(size=(5, 4, SEEN)).astype(np.float32)
    wanted = np.clip(np.maximum(seen @ first + shift, 0.0) @ last, -1.0, 1.0)
    np.testing.assert_allclose(policy.forward(seen), wanted, atol=1e-5)


def test_a_policy_that_decides_less_often_holds_its_action():
    policy = NetworkPolicy(
        [(np.eye(SEEN, 2), np.zeros(2))], Metadata(action_repeat=3), make_params("push")
    )
    memory, done = None, []
    for tick in range(8):
        seen = np.full((2, 4, SEEN), tick / 10, dtype=np.float32)
        fresh = np.array([tick == 0, tick in (0, 4)])
        action, memory = policy.act(None, seen, memory, fresh)
        done.append(np.round(10 * action[:, 0, 0]).astype(int).tolist())
    assert done == [[0, 0], [0, 0], [0, 0], [3, 3], [3, 4], [3, 4], [6, 4], [6, 7]]


@pytest.mark.parametrize("kind", ["joint", "off-policy"])
def test_models_of_other_kinds_take_part(tmp_path, kind):
    import gymnasium as gym
    from stable_baselines3 import PPO, SAC

    from asv_env.envs.sb3 import BoatVecEnv

    if kind == "joint":
        model = PPO("MlpPolicy", gym.make("asv_env/Push-v0"), device="cpu", seed=0)
    else:
        model = SAC(
            "MlpPolicy", BoatVecEnv("push", num_envs=1), device="cpu", buffer_size=8, seed=0
        )
    model.save(tmp_path / "other.zip")
    params = make_params("push", time_limit=0.5)
    made = find(tmp_path / "other.zip", trust_pickles=True).make(params)
    (track,) = runner.run(lambda params: made, params, [0], 1, Label("other"), record=True)
    assert track.episode.error is None
    seen = track.trajectory.observation[0]
    action, _ = model.predict(seen, deterministic=True)
    np.testing.assert_allclose(track.trajectory.action[0], action, atol=1e-6)


def test_pickles_are_not_read_unless_trusted(tmp_path, capsys, sb3_file):
    said = refused(capsys, *SHORT, "--policies", sb3_file, "--out", tmp_path / "none")
    assert "--trust-pickles" in said
    run(*SHORT, "--policies", sb3_file, "--trust-pickles", "--out", tmp_path)
    assert {row.policy for row in rows(tmp_path)} == {"model"}


def test_a_model_with_other_spaces_is_refused(tmp_path, capsys):
    from stable_baselines3 import PPO

    PPO("MlpPolicy", "Pendulum-v1", device="cpu").save(tmp_path / "pendulum.zip")
    words = ["--policies", tmp_path / "pendulum.zip", "--trust-pickles"]
    said = refused(capsys, *SHORT, *words, "--out", tmp_path / "none")
    assert "maps observations (3,) to actions (1,)" in said
    assert f"({SEEN},) -> (2,)" in said


# ---------------------------------------------------------------- suites


def test_a_suite_is_run_arm_by_arm(tmp_path):
    run("--suite", "quick-v1", "--task", "push", "--episodes", 2, "--policies", "idle",
        "--workers", 0, "--out", tmp_path)  # fmt: skip
    suite = SUITES["quick-v1"]
    assert [(row.condition, row.seed) for row in rows(tmp_path)] == [
        (condition.name, seed) for condition in suite.conditions for seed in suite.seeds[:2]
    ]


def test_a_sweep_is_a_suite_of_ones_own(tmp_path):
    run(*SHORT, "--policies", "idle", "--scenario", "nominal", "gyre", "--num-boats", 2, 3,
        "--episodes", 1, "--out", tmp_path)  # fmt: skip
    assert [(row.condition, row.num_boats, row.scenario) for row in rows(tmp_path)] == [
        (f"{boats} boats, {scenario}", boats, scenario)
        for scenario in ("nominal", "gyre")
        for boats in (2, 3)
    ]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--task", "transprt"], "Did you mean 'transport'"),
        (["--scenario", "noissy"], "Did you mean 'noisy'"),
        (["--suite", "plane-v9"], "Did you mean 'plane-v1'"),
        (["--suite", "plane-v1", "--scenario", "noisy"], "--scenario cannot go with --suite"),
        (["--suite", "plane-v1", "--seed", "0"], "--seed cannot go with --suite"),
        (["--suite", "plane-v1", "--episodes", "2001"], "has 2000"),
        (["--policies", "idle", "idle"], "once"),
        (["--episodes", "0"], "--episodes 0"),
        (["--num-envs", "-1"], "--num-envs -1"),
        (["--workers", "-1"], "--workers -1"),
        (["--replays", "-1"], "--replays -1"),
        (["--seed", "-1"], "--seed -1"),
        (["--goal", "9", "0", "0"], "arena"),
        (["--goal", "nan", "0", "0"], "finite"),
        (["--num-boats", "1"], "2 to 100"),
        (["--seed", "9223372036854775808"], "must lie below"),
        (["--goal", "1", "0", "0", "--random-goals"], "not allowed with"),
        (["--video", "film.avi"], ".mp4"),
        (["--scenario", "noisy", "noisy"], "once"),
    ],
)
def test_bad_options_are_refused_before_anything_runs(arguments, message, tmp_path, capsys):
    assert message in refused(capsys, *arguments, "--out", tmp_path / "none")
    assert not (tmp_path / "none").exists()


# ---------------------------------------------------------------- trajectories


def test_trajectories_tell_the_episodes_anew(tmp_path):
    run(*SHORT, "--policies", "random", "--scenario", "noisy", "--record", "--out", tmp_path)
    for row in rows(tmp_path):
        folder = trajectories.folder(tmp_path, row.condition, row.policy, None)
        trajectory, about = trajectories.load(trajectories.path(folder, row.seed))
        steps = len(trajectory.action)
        assert steps == round(row.duration * about["control_rate"])
        assert trajectory.observation.shape == (steps + 1, 4, len(about["observation_names"]))
        assert trajectory.motion.shape == (steps + 1, 5, 6)
        assert trajectory.reward.mean(axis=1).sum() == pytest.approx(row.episode_return, abs=1e-4)
        assert not trajectory.terminated
        assert about["purpose"] == "test"
        assert about["episode"]["seed"] == row.seed
        error = trajectory.motion[-1, 0, :2] - trajectory.goal[-1, :2]
        assert np.hypot(*error) == pytest.approx(row.position_error)


def test_actions_of_a_trajectory_lead_to_its_states(tmp_path):
    from asv_env import Simulation

    run(*SHORT, "--policies", "scripted", "--record", "--episodes", 1, "--out", tmp_path)
    folder = trajectories.folder(tmp_path, "nominal", "scripted", None)
    trajectory, _ = trajectories.load(trajectories.path(folder, 0))
    simulation = Simulation(make_params("push", goal=(0.55, -0.95, 0.1)))
    observations = [simulation.reset(seeds=[0])[0]]
    for action in trajectory.action[:50]:
        observations.append(simulation.step(action[None]).observation[0])
    np.testing.assert_array_equal(observations, trajectory.observation[:51])
    np.testing.assert_array_equal(simulation.state.motion[0], trajectory.motion[50])


def test_trajectories_that_are_missing_are_made_later(tmp_path):
    run(*SHORT, "--policies", "idle", "--out", tmp_path)
    before = rows(tmp_path)
    run(*SHORT, "--policies", "idle", "--record", "--out", tmp_path)
    assert rows(tmp_path) == before
    folder = trajectories.folder(tmp_path, "nominal", "idle", None)
    assert len(list(folder.glob("*.npz"))) == 3


def test_trajectories_are_of_the_policy_that_they_are_named_after(
    tmp_path, network_file, other_network_file
):
    def recorded(*words):
        run(*SHORT, "--episodes", 1, "--policies", *words, "--out", tmp_path)
        (row,) = rows(tmp_path)
        file = trajectories.path(trajectories.folder(tmp_path, "nominal", "net", None), 0)
        return row, trajectories.load(file)[1]["episode"] if file.exists() else None

    row, told = recorded(f"net={network_file}", "--record")
    assert told["episode_return"] == row.episode_return
    assert recorded(f"net={other_network_file}", "--overwrite")[1] is None
    other, told = recorded(f"net={other_network_file}", "--record")
    assert told["episode_return"] == other.episode_return != row.episode_return


@pytest.mark.usefixtures("mine")
def test_broken_episodes_are_not_run_again_for_want_of_a_trajectory(tmp_path, monkeypatch):
    words = [*SHORT, "--policies", "broken_policies:RaisesNow", "--record", "--out", tmp_path]
    run(*words)
    assert all(row.error for row in rows(tmp_path))
    monkeypatch.setattr("baselines.rollout.runner.run", lambda *arguments: pytest.fail("run again"))
    run(*words)


def test_a_file_that_is_no_trajectory_is_refused(tmp_path, network_file):
    with pytest.raises(ValueError, match="not a recorded trajectory"):
        trajectories.load(network_file)


# ---------------------------------------------------------------- film


def test_film_shows_the_episode_that_the_row_counts():
    params = make_params("push", goal=(0.0, -0.5, 0.0), time_limit=3.0)
    frames = list(film.frames(Idle, params, 0))
    assert len(frames) == 8 + film.LAST
    (track,) = runner.run(Idle, params, [0], 1, Label("idle"))
    assert track.episode.duration == 3.0
