"""Difficulty: what a tier changes, what it overrides, and how it grows with the vessel."""

import gymnasium
import numpy as np
import pytest

import asv_env
from asv_env import DIFFICULTIES, JointEnv, make_params
from baselines.evaluate.command import Options

TIER = {"task": {"goal_distance": (0.2, 0.4)}, "water": {"gust_speed": 0.01}}


def test_standard_is_the_default():
    assert make_params() == make_params(difficulty="standard")
    assert dict(DIFFICULTIES["standard"]) == {}


def test_options_override_scenarios_and_these_tiers_and_these_presets():
    tank = {"preset": "tank", "difficulty": TIER}
    assert make_params(preset="tank").task.goal_distance == (0.4, 1.0)
    assert make_params(**tank).task.goal_distance == (0.2, 0.4)
    assert make_params(**tank).task.arena == 1.5
    assert make_params(**tank, goal_distance=(0.3, 0.5)).task.goal_distance == (0.3, 0.5)
    calm = {"water": {"gust_speed": 0.0}}
    assert make_params(**tank).water.gust_speed == 0.01
    assert make_params(**tank, scenario=calm).water.gust_speed == 0.0
    assert make_params(**tank, water=calm["water"]).water.gust_speed == 0.0


def test_distances_of_a_tier_grow_with_the_vessel_and_with_the_scale():
    nominal, big = make_params(difficulty=TIER), make_params(difficulty=TIER, scale=4)
    long = make_params(num_boats=12, difficulty=TIER)
    grown = long.vessel.length / nominal.vessel.length
    assert grown > 1.5
    np.testing.assert_allclose(long.task.goal_distance, grown * np.array([0.2, 0.4]))
    np.testing.assert_allclose(big.task.goal_distance, 4 * np.array([0.2, 0.4]))
    assert big.water.gust_speed == pytest.approx(2 * 0.01)


@pytest.mark.parametrize("difficulty", DIFFICULTIES)
@pytest.mark.parametrize("task", ["approach", "push", "transport"])
def test_every_adapter_takes_every_tier(task, difficulty):
    wanted = make_params(task, difficulty=difficulty)
    envs = (
        gymnasium.make(f"asv_env/{task.capitalize()}-v0", difficulty=difficulty).unwrapped,
        asv_env.parallel_env(task, difficulty=difficulty),
        asv_env.AsvVectorEnv(2, task, difficulty=difficulty),
        asv_env.BoatVecEnv(task, num_envs=2, difficulty=difficulty),
    )
    assert all(env.params == wanted for env in envs)


def test_goals_of_the_easy_tier_lie_ahead_and_are_near():
    env = JointEnv("push", difficulty="easy")
    for seed in range(50):
        env.reset(seed=seed)
        x, y, heading = env.simulation.state.goal[0]
        assert abs(np.angle((x + 1j * y) * 1j)) <= env.params.task.goal_bearing
        assert np.hypot(x, y) <= 0.5
        assert abs(heading) <= env.params.task.goal_turn


@pytest.mark.parametrize(
    ("difficulty", "words"),
    [
        ("eazy", r"unknown difficulty 'eazy'.*'easy'"),
        ({"watr": {}}, r"section of the difficulty 'watr'.*'water'"),
        ({"task": {"goal_distanse": (0, 1)}}, r"'goal_distanse'.*'goal_distance'"),
        ({"task": {"goal_bearing": 4.0}}, "goal_bearing = 4.0"),
    ],
)
def test_unknown_tiers_and_fields_are_named(difficulty, words):
    with pytest.raises(ValueError, match=words):
        make_params(difficulty=difficulty)


def test_sweep_of_a_tier_draws_goals():
    (condition,) = Options(difficulty="easy").chosen_suite().conditions
    assert condition.params == make_params(difficulty="easy")
    with pytest.raises(ValueError, match="--difficulty cannot go with --suite"):
        Options(difficulty="easy", suite="quick-v2").chosen_suite()
