"""Initial states of a training: easier episodes, and states of rollouts."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from train_helpers import tiny

from asv_env import Simulation, make_params
from asv_env.geometry import wrap
from baselines.scripted.scripted_policy import ScriptedPolicy
from train.curriculum import CurriculumStates, along_episodes, scaled_noise


@given(progress=st.floats(0, 1), scenario=st.sampled_from(["nominal", "noisy", "harsh"]))
def test_noise_and_variation_grow_to_those_of_the_task(progress, scenario):
    params = make_params("push", scenario=scenario)
    assert scaled_noise(params, 1.0) == params
    some = scaled_noise(params, progress)
    assert some.sensors.position_noise == progress * params.sensors.position_noise
    assert some.variation.mass == progress * params.variation.mass


@given(progress=st.floats(0, 1), seed=st.integers(0, 1000), side=st.sampled_from(["+n", "-n"]))
def test_goals_turn_away_from_straight_ahead_with_the_progress(progress, seed, side):
    params, config = make_params("push", side=side), tiny()
    narrow, wide = (
        CurriculumStates(config, progress=some)(params, np.random.default_rng(seed)).goal
        for some in (progress, 1)
    )
    assert np.hypot(*narrow[:2]) == pytest.approx(np.hypot(*wide[:2]))
    ahead = -np.pi / 2 if side == "+n" else np.pi / 2
    bearings = [wrap(np.arctan2(goal[1], goal[0]) - ahead) for goal in (narrow, wide)]
    assert bearings[0] == pytest.approx(progress * bearings[1], abs=1e-9)
    assert narrow[2] == pytest.approx(progress * wide[2])


def test_goals_are_nearer_and_boats_close_to_the_hull_as_often_as_asked_for():
    params, rng = make_params("transport"), np.random.default_rng(0)
    sample = CurriculumStates(tiny(curriculum={"near_goals": 0.5, "near_starts": 0.25}))
    starts = [sample(params, rng) for _ in range(400)]
    near = [np.hypot(*start.goal[:2]) < params.task.goal_distance[0] for start in starts]
    reach = np.array([np.abs(start.motion[1:, :2]).max() for start in starts])
    assert 0.1 < np.mean(near) < 0.4  # a goal that is moved nearer need not be that near
    assert 0.15 < np.mean(reach < 0.6) < 0.4
    assert all(len(np.unique(start.motion[1:, 0])) == 4 for start in starts)


def test_boats_close_to_the_hull_touch_nothing():
    params = make_params("transport")
    config = tiny(curriculum={"near_starts": 1.0})
    simulation = Simulation(params, 32, initial_states=CurriculumStates(config))
    simulation.reset(seeds=range(32))
    simulation.step(np.zeros((32, 4, 2)))
    assert not simulation.state.touching.any()
    assert np.abs(simulation.state.motion[:, 1:, :2]).max() < 0.62


def test_episodes_begin_in_states_of_the_scripted_policy():
    params = make_params("push", time_limit=40.0)
    config = tiny(curriculum={"rollout_starts": 1.0})
    simulation = Simulation(params, 2, initial_states=CurriculumStates(config))
    states = along_episodes(ScriptedPolicy(params), simulation, range(10**9, 10**9 + 2))
    start = CurriculumStates(config, states)(params, np.random.default_rng(0))
    assert (start.motion == states.motion).all(axis=(1, 2)).any()
    moving = np.abs(states.motion[:, 0, 3:]).max(axis=1) > 0
    assert moving.mean() > 0.5
