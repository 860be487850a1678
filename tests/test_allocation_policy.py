"""The policy that allocates forces, on the real physics."""

import numpy as np
import pytest
from helpers import same, successes

from asv_env import Simulation, make_params
from asv_env.types import rows
from baselines.allocation import AllocationPolicy
from baselines.rollout import runner
from baselines.rollout.loop import rollout
from baselines.scripted import ScriptedPolicy


def episodes(params, count, first=0):
    logs = runner.run(AllocationPolicy, params, range(first, first + count), count)
    return sorted((log.episode for log in logs), key=lambda row: row.seed)


@pytest.fixture(scope="module")
def noisy():
    """Twelve episodes on goals all over the plane."""
    return episodes(make_params("transport", 4, "noisy"), 12)


def test_delivers_to_goals_all_over_the_plane_in_little_time(noisy):
    assert sum(row.success for row in noisy) >= 11
    assert np.median([row.duration for row in noisy]) < 75.0


def test_a_world_does_not_depend_on_the_others(noisy):
    (alone,) = episodes(make_params("transport", 4, "noisy"), 1, first=3)
    assert alone == noisy[3]


@pytest.mark.parametrize(
    ("num_boats", "scenario", "options"),
    [
        (3, "noisy", {}),
        (8, "nominal", {}),
        (4, "gusts", {}),
        (4, "current", {}),
        (6, "failure", {}),
        (4, "noisy", {"vessel": "triangle"}),
        (4, "nominal", {"preset": "otter", "clock": {"control": 5, "sensing": 5}}),
    ],
)
def test_delivers_in_other_worlds(num_boats, scenario, options):
    params = make_params("transport", num_boats, scenario, **options)
    assert successes(AllocationPolicy, params, 5, enough=4) == 4


def test_the_vessel_is_braked_by_boats():
    """It stops within a small part of the way on which it would coast to rest."""
    simulation = Simulation(make_params("transport", goal=(0.0, -0.9, 0.0)))
    speeds, gaps = [], []
    for tick in rollout(simulation, AllocationPolicy(simulation.params).act, [0]):
        state = simulation.state
        speeds.append(np.hypot(*state.motion[0, 0, 3:5]))
        gaps.append(np.hypot(*(state.motion[0, 0, :2] - state.goal[0, :2])))
        if tick.over[0]:
            break
    speeds, gaps = np.array(speeds), np.array(gaps)
    fast = np.flatnonzero(speeds > 0.04)[-1]
    assert tick.step.ending.reached[0]
    assert gaps[fast] < 0.1  # It coasts 0.2 m from that speed.


@pytest.mark.parametrize("side", [0.9, -0.9])
def test_a_vessel_whose_goal_lies_across_it_is_not_turned_round(side):
    simulation = Simulation(make_params("transport", goal=(0.0, side, 0.0)))
    ticks = rollout(simulation, AllocationPolicy(simulation.params).act, [0])
    headings = [abs(simulation.state.motion[0, 0, 2]) for _ in ticks]
    assert simulation.ending.reached[0]
    assert max(headings) < 1.0


@pytest.mark.parametrize(
    ("task", "num_boats", "options"),
    [
        ("approach", 4, {}),
        ("transport", 4, {"vessel": "disc"}),
        ("transport", 4, {"goal_anchor": "closure", "goal": (0.3, -0.5, 0.0)}),
    ],
)
def test_where_it_has_no_formation_or_no_goal_it_is_the_scripted_policy(task, num_boats, options):
    simulation = Simulation(make_params(task, num_boats, "noisy", **options), 2)
    other = ScriptedPolicy(simulation.params)
    memory, fresh = None, np.ones(2, dtype=bool)
    *_, last = rollout(simulation, AllocationPolicy(simulation.params).act, [0, 1], 30)
    same_seeds = Simulation(simulation.params, 2)
    same_seeds.reset(seeds=[0, 1])
    for _ in range(30):
        action, memory = other.act(same_seeds.sensed, np.zeros(0), memory, fresh)
        same_seeds.step(action)
        fresh = np.zeros(2, dtype=bool)
    assert same(last.action, action)


def test_takes_over_once_the_goal_is_final():
    options = {"goal_anchor": "closure", "goal": (0.3, -0.5, 0.4)}
    done = episodes(make_params("transport", 4, **options), 3)
    assert sum(row.success for row in done) == 3


def test_the_policy_leaves_what_it_is_given_alone():
    simulation = Simulation(make_params(), 3)
    simulation.reset(seeds=range(3))
    policy, fresh = AllocationPolicy(simulation.params), np.ones(3, dtype=bool)
    given = simulation.sensed
    _, memory = policy.act(given, np.zeros(0), None, fresh)
    place = memory.place.copy()
    again = policy.act(simulation.sensed, np.zeros(0), memory, ~fresh)[0]
    assert same(given.estimate, simulation.sensed.estimate)
    assert same(memory.place, place)
    part = policy.act(rows(simulation.sensed, [1]), np.zeros(0), None, fresh[:1])
    alone = policy.act(rows(simulation.sensed, [1]), np.zeros(0), part[1], ~fresh[:1])[0]
    assert same(alone[0], again[1])


def test_thruster_actions_are_refused():
    with pytest.raises(ValueError, match="tracking"):
        AllocationPolicy(make_params(action_mode="thrusters"))


@pytest.mark.parametrize("task", ["push", "transport"])
def test_it_runs_however_little_boats_see_and_whoever_fails(task):
    blind = {"shared": False, "range": 0.3, "delay": 0.3, "dropout": 0.5, "position_noise": 0.02}
    failing = {"failures": 2, "failure_time": (0.0, 10.0)}
    params = make_params(
        task, 4, sensors=blind, variation=failing, obstacles="pillars", time_limit=20.0
    )
    assert all(row.error is None for row in episodes(params, 2))
