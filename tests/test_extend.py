"""What docs/extend.md shows works through every adapter, in the evaluation and in training."""

import re
import sys
from dataclasses import replace
from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest
from helpers import begin_at, bodies

import asv_env
from asv_env import make_params
from asv_env.registry import load
from asv_env.sensing.observation import NAMES
from asv_env.simulation import Simulation
from baselines.evaluate import compare
from baselines.evaluate import main as evaluate_main
from baselines.evaluate.results import read_csv
from train.__main__ import main as train_main

PAGE = (Path(__file__).parents[1] / "docs/extend.md").read_text()
PIECES = re.findall(r"```python file=mine.py\n(.*?)```", PAGE, re.DOTALL)
OPTIONS = {
    "reward": {"task": "mine:STEADY"},
    "initial states": {"task": "mine:ROW"},
    "task": {"task": "mine:TURN"},
    "observation": {"observation": "ALONE"},
    "feature": {"observation": "TIMED"},
    "scenario": {"scenario": "mine:MURKY"},
    "hull": {"vessel": "mine:LONG"},
    "outline": {"vessel": "mine:HOUSE"},
    "obstacles": {"obstacles": "mine:ISLAND"},
    "layout": {"obstacles": "mine:buoys"},
}


@pytest.fixture
def mine(tmp_path, monkeypatch):
    """The module ``mine`` of the page, in the current folder."""
    (tmp_path / "mine.py").write_text("\n".join(PIECES))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.delitem(sys.modules, "mine", raising=False)
    load("mine:STEADY")
    return sys.modules["mine"]


def options(name, mine):
    given = dict(OPTIONS[name])
    if "observation" in given:
        given["observation"] = getattr(mine, given["observation"])
    return given


def test_every_piece_is_short():
    assert len(PIECES) == 7
    assert all(len(piece.splitlines()) <= 30 for piece in PIECES)


@pytest.mark.parametrize("name", OPTIONS)
def test_it_works_through_every_adapter(name, mine):
    given = options(name, mine)
    joint = gym.make("asv_env/Transport-v0", **given)
    observation, _ = joint.reset(seed=3)
    action = np.full(joint.action_space.shape, 0.5, dtype=np.float32)
    seen, reward, _, _, info = joint.step(action)
    assert joint.observation_space.contains(seen)

    vector = gym.make_vec("asv_env/Transport-v0", num_envs=2, **given)
    np.testing.assert_array_equal(vector.reset(seed=3)[0][0], observation)
    assert vector.step(np.stack([action, action]))[1][0] == reward

    parallel = asv_env.parallel_env(**given)
    parallel.reset(seed=3)
    stepped = parallel.step(dict(zip(parallel.agents, action, strict=True)))
    np.testing.assert_array_equal(list(stepped[0].values()), seen)

    boats = asv_env.BoatVecEnv(num_envs=2, **given)
    boats.seed(3)
    np.testing.assert_array_equal(boats.reset()[:4], observation)
    rows = boats.step(np.concatenate([action, action]))
    assert boats.observation_space.contains(rows[0][0])
    if name == "reward":
        assert "reward_turning" in info


def split(line):
    """Words of a command line."""
    return line.split()


@pytest.mark.parametrize("name", OPTIONS)
def test_it_works_in_the_evaluation(name, mine, learned_file):
    params = make_params(**options(name, mine), time_limit=1.0)
    policies = {"class": mine.ToSlot, "word": "mine:ToSlot", "learned": "learned"}
    results = compare(policies, suite=params, episodes=2, workers=0, progress=False)
    assert len(results.episodes) == 3 * 2
    assert results.episodes["error"].isna().all()


def test_it_works_on_the_command_line_and_reaches_workers(mine, no_report, capsys):
    conditions = "--task mine:STEADY --scenario mine:MURKY nominal --episodes 1 --seed 5"
    evaluate_main(split(f"{conditions} --policies idle mine:ToSlot --workers 1 --out run"))
    assert "ToSlot" in capsys.readouterr().out
    rows = read_csv(Path("run/episodes.csv"))
    assert {(row.task, row.error) for row in rows} == {("steady", None)}
    assert len(rows) == 2 * 2


@pytest.mark.parametrize(
    "names", [("reward", "observation", "scenario"), ("initial states", "feature"), ("task",)]
)
def test_it_works_in_training(names, mine, monkeypatch):
    given = {key: value for name in names for key, value in options(name, mine).items()}
    task, scenario = given["task"], given.get("scenario", "nominal")
    task_name = task.removeprefix("mine:")
    brief = replace(getattr(mine, task_name), time_limit=4.0)  # as long as an evaluation lasts
    monkeypatch.setattr(mine, task_name, brief)
    features = [one for one in given.get("observation", ["slot", "goal"]) if isinstance(one, str)]
    worlds = f"--task {task} --scenarios {scenario} --num-envs 2 --time-limit 2"
    learner = "--num-steps 16 --hidden 8 --num-minibatches 1 --total-timesteps 128"
    rest = "--imitation.rounds 0 --evaluation.episodes 2 --out trained --observation"
    train_main([*split(f"{worlds} {learner} {rest}"), *features])
    params = make_params(task, time_limit=1.0)
    own = compare({"own": "trained/best.npz"}, suite=params, episodes=1, workers=0)
    assert own.episodes["error"].isna().all()


def test_the_reward_term_is_paid(mine):
    sim = Simulation(make_params(mine.STEADY))
    begin_at(sim, [bodies((0, 0, 0, 0, 0, 0.5), (1, 1), (1, -1), (-1, 1), (-1, -1))])
    done = sim.step(np.zeros((1, 4, 2)))
    turning = done.terms["turning"]
    assert turning == pytest.approx(-0.01 * sim.state.motion[:, 0, 5:])
    assert turning < -0.004
    np.testing.assert_allclose(done.reward, sum(done.terms.values()))


def test_the_initial_states_are_those_of_the_function(mine):
    env = gym.make("asv_env/Transport-v0", task=mine.ROW).unwrapped
    env.reset(seed=0)
    np.testing.assert_array_equal(env.simulation.state.motion[0, 1:, 1], -1.0)


def test_the_task_ends_when_it_is_done(mine):
    env = gym.make("asv_env/Transport-v0", task=mine.TURN, goal=(1.0, 0.0, 0.05)).unwrapped
    env.reset(seed=0)
    *_, terminated, _, info = env.step(np.zeros((4, 2), dtype=np.float32))
    assert terminated
    assert info["is_success"]
    assert env.params.task.time_limit == 60.0
    assert info.keys() >= {"reward_heading", "reward_success"}


def test_the_observation_lacks_its_neighbours(mine):
    plain = gym.make("asv_env/Push-v0").reset(seed=0)[0]
    alone = gym.make("asv_env/Push-v0", observation=mine.ALONE).reset(seed=0)[0]
    kept = [k for k, name in enumerate(NAMES) if not name.startswith("neighbour")]
    np.testing.assert_array_equal(alone, plain[:, kept])
    env = gym.make("asv_env/Push-v0", observation=mine.TIMED)
    env.reset(seed=0)
    assert env.step(np.zeros((4, 2), dtype=np.float32))[0][0, -1] == np.float32(0.001)


def test_what_is_registered_has_a_name(mine, monkeypatch):
    for registry in (asv_env.TASKS, asv_env.SCENARIOS, asv_env.HULLS):
        monkeypatch.setattr(registry, "_entries", dict(registry._entries))
    asv_env.TASKS.register("steady", mine.STEADY)
    asv_env.SCENARIOS.register("murky", mine.MURKY)
    asv_env.HULLS.register("long", mine.LONG)
    params = make_params("steady", scenario="murky", vessel="long")
    assert params.definition is mine.STEADY
    assert params.sensors.position_noise == 0.03
    assert params.vessel.length == 0.6
    for registry in (asv_env.TASKS, asv_env.SCENARIOS, asv_env.HULLS):
        with pytest.raises(ValueError, match="already"):
            registry.register(next(iter(registry)), {"another": {}})


def test_unknown_names_are_refused_with_the_nearest(mine):
    with pytest.raises(ValueError, match="Did you mean 'transport'"):
        make_params("transpor")
    with pytest.raises(ValueError, match="no attribute 'STEADI'"):
        make_params("mine:STEADI")
    with pytest.raises(ValueError, match="Did you mean 'slot'"):
        make_params(observation=["slott"])
    with pytest.raises(TypeError, match="name of a task"):
        make_params(task={})
