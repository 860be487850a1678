"""Discrete actions are numbers of tracking actions, in every adapter."""

import gymnasium
import numpy as np
import pytest
from helpers import same
from stable_baselines3 import DQN, PPO

import asv_env
from asv_env.envs.sb3 import BoatVecEnv
from asv_env.params import DISCRETE_ACTIONS
from baselines.learned.sb3_policy import Sb3Policy
from baselines.paper.paper_policy import PaperPolicy
from baselines.policy import Idle
from baselines.rollout.runner import run
from baselines.scripted.scripted_policy import ScriptedPolicy

DISCRETE = {"action_mode": "discrete"}
OPTIONS = {"num_boats": 3, "scenario": "harsh", "time_limit": 0.4}
COMMANDS = np.array(DISCRETE_ACTIONS, dtype=np.float32)
WORLDS, TEAM = 2, 3


def joint(flat, **options):
    env = asv_env.JointEnv("push", flat=flat, **OPTIONS, **options)
    env.reset(seed=1)
    return env.step


def parallel(**options):
    env = asv_env.parallel_env("push", **OPTIONS, **options)
    env.reset(seed=1)
    return lambda action: env.step(dict(zip(env.agents, action, strict=True)))


def vector(flat, **options):
    given = {**OPTIONS, **options, "flat": flat}
    env = gymnasium.make_vec("asv_env/Push-v0", num_envs=WORLDS, **given)
    env.reset(seed=1)
    return env.step


def boats(flat, **options):
    env = BoatVecEnv("push", WORLDS, flat=flat, with_state=True, **OPTIONS, **options)
    env.seed(1)
    env.reset()
    return lambda action: [
        [{k: v for k, v in one.items() if k != "episode"} for one in part]
        if isinstance(part, list)
        else part
        for part in env.step(action)
    ]


@pytest.mark.parametrize(
    ("make", "numbers", "commands"),
    [
        (lambda **o: joint(False, **o), (TEAM,), (TEAM, 2)),
        (lambda **o: joint(True, **o), (TEAM,), (2 * TEAM,)),
        (parallel, (TEAM,), (TEAM, 2)),
        (lambda **o: vector(False, **o), (WORLDS, TEAM), (WORLDS, TEAM, 2)),
        (lambda **o: vector(True, **o), (WORLDS, TEAM), (WORLDS, 2 * TEAM)),
        (lambda **o: boats(False, **o), (WORLDS * TEAM,), (WORLDS * TEAM, 2)),
        (lambda **o: boats(True, **o), (WORLDS, TEAM), (WORLDS, 2 * TEAM)),
    ],
    ids=["joint", "joint flat", "parallel", "vector", "vector flat", "boats", "boats flat"],
)
def test_a_number_does_what_its_tracking_action_does(make, numbers, commands):
    rng = np.random.default_rng(0)
    discrete, tracking = make(**DISCRETE), make()
    for _ in range(4):
        action = rng.integers(0, len(COMMANDS), numbers)
        assert same(discrete(action), tracking(COMMANDS[action].reshape(commands)))


def test_the_spaces_are_discrete():
    known = len(DISCRETE_ACTIONS)
    options = {"num_boats": TEAM, **DISCRETE}
    env = asv_env.JointEnv("push", flat=True, **options)
    assert env.action_space == gymnasium.spaces.MultiDiscrete([known] * TEAM)
    assert asv_env.parallel_env("push", **options).action_space("asv_0").n == known
    assert BoatVecEnv("push", 2, **options).action_space == gymnasium.spaces.Discrete(known)
    vector = asv_env.AsvVectorEnv(2, "push", **options)
    assert vector.single_action_space == env.action_space
    assert vector.action_space.sample().shape == (2, TEAM)


def test_zero_stops_and_no_two_numbers_mean_the_same():
    assert DISCRETE_ACTIONS[0] == (0.0, 0.0)
    assert len(set(DISCRETE_ACTIONS)) == len(DISCRETE_ACTIONS)
    assert {(s, -t) for s, t in DISCRETE_ACTIONS} == set(DISCRETE_ACTIONS), "mirror images"
    assert np.abs(COMMANDS).max() == 1.0


@pytest.mark.parametrize(
    ("action", "error", "named"),
    [
        ([0, len(DISCRETE_ACTIONS), 0], ValueError, "action 12 of boat 1 in world 0.*from 0 to 11"),
        ([0, 0, -1], ValueError, "action -1 of boat 2"),
        ([0.0, 1.0, 2.0], TypeError, "give whole numbers of shape"),
        ([True, True, False], TypeError, "give whole numbers of shape"),
        ([[0, 0]] * 3, ValueError, r"shape \(3, 2\): must be \(3,\)"),
    ],
)
def test_other_actions_are_refused(action, error, named):
    env = asv_env.JointEnv("push", TEAM, **DISCRETE)
    env.reset(seed=0)
    with pytest.raises(error, match=named):
        env.step(action)


def test_policies_give_tracking_actions():
    params = asv_env.make_params("push", **DISCRETE)
    for make in (ScriptedPolicy, PaperPolicy):
        with pytest.raises(ValueError, match=r"discrete.*tracking"):
            make(params)
    with pytest.raises(ValueError, match=r"'discrete'.*leave action_mode out"):
        next(run(Idle, params, [10**8], 1))


def test_a_value_based_learner_trains_and_its_file_gives_tracking_actions(tmp_path):
    env = BoatVecEnv("push", 2, **OPTIONS, **DISCRETE)
    model = DQN("MlpPolicy", env, learning_starts=12, batch_size=8, seed=0, device="cpu")
    model.learn(60)
    model.save(tmp_path / "model.zip")
    params = asv_env.make_params("push", TEAM, "harsh")
    simulation = asv_env.Simulation(params, 2)
    observation = simulation.reset(seeds=[10**8, 10**8 + 1])
    policy = Sb3Policy(tmp_path / "model.zip", params)
    fresh = np.ones(2, dtype=bool)
    action, _ = policy.act(simulation.sensed, observation, None, fresh)
    numbers, _ = model.predict(observation.reshape(6, -1), deterministic=True)
    assert np.array_equal(action, COMMANDS[numbers].reshape(2, TEAM, 2))
    with pytest.raises(ValueError, match=r"discrete actions.*action_mode='tracking'"):
        Sb3Policy(
            tmp_path / "model.zip", asv_env.make_params("push", TEAM, action_mode="thrusters")
        )


def test_a_flat_row_is_a_world():
    flat, plain = (BoatVecEnv("push", 2, flat=flat, **OPTIONS) for flat in (True, False))
    for env in (flat, plain):
        env.seed(4)
    flat._seeds = plain._seeds[::TEAM]
    assert flat.num_envs == flat.num_worlds == 2
    assert np.array_equal(flat.reset(), plain.reset().reshape(2, -1))
    for _ in range(4):
        action = np.full((2, 2 * TEAM), 0.3)
        seen, reward, done, infos = flat.step(action)
        rows, rewards, dones, each = plain.step(action.reshape(-1, 2))
        assert np.array_equal(seen, rows.reshape(2, -1))
        assert reward == pytest.approx(rewards.reshape(2, -1).mean(axis=1))
        assert np.array_equal(done, dones[::TEAM])
    last = np.concatenate([info["terminal_observation"] for info in each[:TEAM]])
    assert np.array_equal(infos[0]["terminal_observation"], last)
    returns = [info["episode"]["r"] for info in each[:TEAM]]
    assert infos[0]["episode"]["r"] == pytest.approx(np.mean(returns))


def test_a_flat_model_drives_the_team(tmp_path):
    env = BoatVecEnv("push", 2, flat=True, **OPTIONS, **DISCRETE)
    model = PPO("MlpPolicy", env, n_steps=8, batch_size=16, n_epochs=1, device="cpu")
    model.save(tmp_path / "model.zip")
    params = asv_env.make_params("push", TEAM)
    simulation = asv_env.Simulation(params, 2)
    observation = simulation.reset(seeds=[10**8, 10**8 + 1])
    policy = Sb3Policy(tmp_path / "model.zip", params)
    action, _ = policy.act(simulation.sensed, observation, None, np.ones(2, dtype=bool))
    numbers, _ = model.predict(observation.reshape(2, -1), deterministic=True)
    assert np.array_equal(action, COMMANDS[numbers])
