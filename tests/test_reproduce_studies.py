"""Studies of the reproduction measure what they say."""

from dataclasses import replace

import numpy as np
import pytest

from asv_env import Simulation, make_params
from asv_env.geometry import wrap
from asv_env.tasks import formation
from baselines.paper import dubins, two_arc
from baselines.policy import Idle
from baselines.reproduce import (
    claims,
    fig5_paths,
    planner_comparison,
    single_runs,
)
from baselines.rollout import episodes, runner
from baselines.scripted import PathGains, PathPlanner


def test_noise_disturbs_what_boats_see_of_themselves_and_nothing_else():
    simulation = Simulation(make_params(num_boats=50, start_distance=(3.0, 9.0), arena=20.0), 40)
    simulation.reset(seeds=range(40))
    seen = []

    class Watch:
        def act(self, sensed, observation, memory, fresh):
            seen.append(sensed)

    before = simulation.sensed.estimate.copy()
    single_runs.NoisyPoses(Watch(), seed=0).act(simulation.sensed, None, None, None)
    np.testing.assert_array_equal(simulation.sensed.estimate, before)
    noise = seen[0].estimate - before
    np.testing.assert_array_equal(noise[:, 0], 0.0)
    np.testing.assert_array_equal(noise[..., 3:], 0.0)
    noise = noise[:, 1:, :3].reshape(-1, 3)
    noise[:, 2] = wrap(noise[:, 2])
    # The relative deviation of a variance of n samples is sqrt(2 / n), here 3 %.
    np.testing.assert_allclose(noise.var(axis=0), [0.05e-4, 0.05e-4, 0.05], rtol=0.12)


def test_both_comparisons_of_planners_have_the_same_goals():
    world = planner_comparison.push_to_random_goals("nominal")
    params = replace(world, task=replace(world.task, time_limit=0.2))
    tracks = list(runner.run(Idle, params, range(3, 6), 3))
    tracks.sort(key=lambda track: track.episode.seed)
    expected = [track.goal for track in tracks]
    np.testing.assert_array_equal(planner_comparison.goals(params, range(3, 6)), expected)


def test_lengths_are_none_exactly_where_a_radius_is_too_small():
    goals = planner_comparison.goals(planner_comparison.push_to_random_goals("nominal"), range(40))
    ratios = fig5_paths.lengths(goals, 0.2)
    assert min(r for by in ratios.values() for r in by if r is not None) > 1 - 1e-9
    for goal, one in zip(goals, ratios["alpha1 = 1"], strict=True):
        path = two_arc.plan(goal, 1.0)
        assert (one is None) == (np.abs(path.curvature).max() > 5)


def test_planners_may_turn_as_tightly_as_the_scripted_policy_does():
    params = planner_comparison.push_to_random_goals("nominal")
    goals = planner_comparison.goals(params, range(100))
    planner = PathPlanner(params.vessel, PathGains())
    own = planner.plan(goals[:, 0] + 1j * goals[:, 1], goals[:, 2])
    assert 1 / np.abs(own.curvature).max() == pytest.approx(planner_comparison.least_radius(params))


@pytest.mark.parametrize("name", planner_comparison.PLANNERS)
def test_the_policy_drives_the_paths_of_the_planner(name):
    world = planner_comparison.push_to_random_goals("nominal")
    params = replace(world, task=replace(world.task, time_limit=20.0))
    radius = planner_comparison.least_radius(params)
    seen = []

    def make(params):
        policy = planner_comparison.PLANNERS[name](params)
        act = policy.act

        def watched(*arguments):
            action, memory = act(*arguments)
            seen.append(memory.path)
            return action, memory

        policy.act = watched
        return policy

    tracks = list(runner.run(make, params, range(6), 6))
    goals = planner_comparison.goals(params, range(6))
    expected = dubins.shortest(goals, radius)
    if name == "two arcs":
        arcs = two_arc.shortest(goals, radius)
        able = two_arc.feasible(arcs, radius)
        assert able.sum() > 0
        np.testing.assert_allclose(seen[0].length[able, :2], arcs.length[able])
        np.testing.assert_allclose(seen[0].length[able, 2:], 0.0)
        expected, seen[0].length = expected[~able], seen[0].length[~able]
    np.testing.assert_allclose(seen[0].length[:, :3], expected.length)
    assert all(track.poses[-1, 0, :2] @ track.poses[-1, 0, :2] > 0.2**2 for track in tracks)


def test_crossings_of_ways():
    time = np.linspace(-1, 1, 12)[:, None]
    ways = np.concatenate([time + 0j, 1j * time, 3 + time + 0.1j, 0.35 + 1j * time], axis=1)
    poses = np.zeros((12, 5, 3))
    poses[:, 1:, 0], poses[:, 1:, 1] = ways.real, ways.imag
    assert claims.crossings(poses) == 2
    assert claims.crossings(poses[:, [0, 1, 3]]) == 0


def test_boat_off_its_circle():
    turn = np.linspace(0, 1.5, 40)
    centre, radius, end = 0.5, 0.5, 0.24
    poses = np.zeros((40, 3, 3))
    poses[:, 0, 2] = turn
    way = centre - (radius - end) * np.exp(1j * turn)
    way[turn > 0.5] -= 0.03 * np.exp(1j * turn[turn > 0.5])
    way[turn > 1.2] += 9.0  # later than it is watched
    poses[:, 1, 0], poses[:, 1, 1] = -0.24, 0.0
    poses[:, 2, 0], poses[:, 2, 1] = way.real, way.imag
    track = episodes.PoseLog(
        None, poses, np.zeros(3), np.full(2, np.inf), np.zeros((0, 5)), np.ones(2)
    )
    assert claims.off_circle(track, radius, end) == pytest.approx(0.03)


def test_role_of_the_dead_boat_is_the_one_that_it_has_in_the_simulation():
    params = claims.one_boat_dead()
    simulation = Simulation(params, 12)
    simulation.reset(seeds=range(12))
    slots = simulation.state.slot.copy()
    simulation.step(np.zeros((12, 4, 2)))
    assert (simulation.state.working.sum(axis=1) == 3).all()
    for seed in range(12):
        dead = slots[seed][~simulation.state.working[seed]][0]
        assert claims.role_of_dead(params, seed) == ("end" if abs(dead.real) > 0.2 else "inner")


@pytest.mark.parametrize("condition", claims.ATTRIBUTIONS)
def test_boats_keep_their_targets_unless_re_attributed(condition):
    params = make_params("approach")
    simulation = Simulation(params, 12)
    observation = simulation.reset(seeds=range(12))
    policy, memory = claims.ATTRIBUTIONS[condition](params), None
    targets = []
    for tick in range(60):
        fresh = np.full(12, tick == 0)
        action, memory = policy.act(simulation.sensed, observation, memory, fresh)
        targets.append(memory.target.copy())
        observation = simulation.step(action).observation
    kept = condition.startswith("kept")
    assert (targets[0] == targets[-1]).all() == kept
    number = condition.endswith("numbers")
    expected = formation.slots(params, 4) if number else simulation.state.slot
    np.testing.assert_allclose(targets[0], np.broadcast_to(expected, (12, 4)))
