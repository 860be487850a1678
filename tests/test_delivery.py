"""Delivery: the vessel holds the goal pose, or passes it slowly as in the paper."""

import copy
import math
import pickle
from dataclasses import replace

import numpy as np
import pytest
from helpers import actions, begin_at, bodies, turned

from asv_env import Simulation, make_params
from asv_env.sensing.global_state import global_state
from asv_env.tasks.laws import at_goal, rules
from asv_env.tasks.termination import delivery_ticks, why_not_delivered
from baselines.paper.coasting import coasting_distance, coasting_speed

approx = pytest.approx
PASSING = np.array([0.03, -0.03, 0.09, 0.005, -0.004, 0.04])
"""Motion of a vessel that passes the origin: close, slow, and going away."""
HELD = np.array([0.03, -0.03, 0.09, 0.0015, -0.001, 0.009])
"""Motion of a vessel that hardly moves at the origin."""
APART = (2, 2), (2, -2), (-2, 2), (-2, -2)


def counts(vessel, water=0j, goal=(0.6, -0.9, 0.4), **options):
    """Whether a tick counts with a motion (6,) of the vessel, seen from the goal."""
    motion = turned(bodies(vessel, (2, 2)), goal[2], goal[0] + 1j * goal[1])
    water = complex(water * np.exp(1j * goal[2]))
    return at_goal(motion, np.array(goal), water, rules(make_params(**options)))


def begun(motion, **options):
    """A world whose vessel has a motion (6,), alone: the boats are far away and stay there."""
    params = make_params(**{"goal": (0.0, 0.0, 0.0), **options})
    simulation = Simulation(params)
    begin_at(simulation, [bodies(motion, *APART)])
    return simulation


def step(simulation):
    return simulation.step(actions(simulation, 0.0))


def counted(simulation, ticks):
    """``delivered_ticks`` of one world after each of some ticks, up to the end."""
    found = []
    while len(found) < ticks and not simulation.ending.terminated[0]:
        step(simulation)
        found.append(int(simulation.state.delivered_ticks[0]))
    return found


# ------------------------------------------------------------------ passing


def test_vessel_close_slow_and_no_longer_nearing_passes():
    assert counts(PASSING, delivery="passing")
    assert counts(np.zeros(6), delivery="passing")


@pytest.mark.parametrize(
    "broken",
    [
        {0: 0.042},
        {1: -0.042},
        {2: 0.11},
        {2: -0.11},
        {2: np.pi},
        {3: 0.012},
        {4: -0.012},
        {5: 0.06},
        {5: -0.06},
        {3: -0.005, 4: 0.004},
    ],
    ids=str,
)
def test_each_condition_alone_keeps_a_vessel_from_passing(broken):
    vessel = PASSING.copy()
    vessel[list(broken)] = list(broken.values())
    assert not counts(vessel, delivery="passing")


def test_passing_is_slow_through_the_local_water_not_over_the_ground():
    drifting = PASSING + np.array([0, 0, 0, 0.03, 0, 0])
    assert not counts(drifting, delivery="passing")
    assert counts(drifting, water=0.03, delivery="passing")
    assert not counts(PASSING, water=0.03, delivery="passing")


@pytest.mark.parametrize("task", ["push", "transport"])
def test_passing_takes_one_tick(task):
    simulation = Simulation(make_params(task, goal=(0, -0.04, 0.05), delivery="passing"))
    simulation.reset(seeds=[0])
    assert step(simulation).ending.reached.all()
    summary = simulation.summary()
    assert summary["is_success"].all()
    assert summary["position_error"] == approx(0.04)
    assert summary["heading_error"] == approx(-0.05)
    assert summary["time_to_goal"] == approx(0.1)


def test_a_passing_vessel_may_coast_out_of_the_tolerance():
    """Why an instant is not enough: the numbers that the documentation gives."""
    params = make_params()
    vessel = params.hulls()[0]
    coasts = coasting_distance(vessel, params.task.passing_speed)
    assert coasts > params.task.position_tolerance
    assert coasting_distance(vessel, params.task.speed_tolerance) < 0.02
    fast = [0.0, -0.001, 0.0, 0.0, -0.0099, 0.0]
    passing = begun(fast, delivery="passing")
    assert step(passing).ending.reached.all()
    holding = begun(fast)
    for _ in range(300):
        step(holding)
    assert holding.relations.goal_error[0] > params.task.position_tolerance
    assert holding.state.delivered_ticks[0] == 0


# ------------------------------------------------------------------ holding


def test_vessel_that_hardly_moves_at_the_goal_counts():
    assert counts(HELD)
    assert counts(np.zeros(6))
    assert counts([0.03, -0.03, 0.09, -0.0015, 0.001, 0.0])  # It may still come nearer.


@pytest.mark.parametrize(
    "broken",
    [
        {0: 0.042},
        {1: -0.042},
        {2: 0.11},
        {2: -0.11},
        {2: np.pi},
        {3: 0.0018},
        {4: -0.0014},
        {5: 0.011},
        {5: -0.011},
    ],
    ids=str,
)
def test_each_condition_alone_keeps_a_tick_from_counting(broken):
    vessel = HELD.copy()
    vessel[list(broken)] = list(broken.values())
    assert not counts(vessel)


@pytest.mark.parametrize("task", ["push", "transport"])
@pytest.mark.parametrize(("options", "ticks"), [({}, 30), ({"delivery_time": 0.5}, 5)])
def test_a_held_vessel_is_delivered_after_exactly_the_delivery_time(task, options, ticks):
    simulation = Simulation(make_params(task, goal=(0, -0.04, 0.05), **options))
    simulation.reset(seeds=[0])
    rewards = []
    for _ in range(ticks - 1):
        rewards.append(step(simulation).terms["success"].item())
        assert not simulation.ending.terminated.any()
    last = step(simulation)
    assert last.ending.reached.all()
    assert last.ending.terminated.all()
    assert not last.ending.truncated.any()
    assert rewards == [0.0] * (ticks - 1)
    assert last.terms["success"].item() > 0
    assert simulation.summary()["time_to_goal"] == approx(ticks / 10)
    assert simulation.state.delivered_ticks[0] == ticks == delivery_ticks(simulation.params)


@pytest.mark.parametrize("rate", [10, 25, 50])
def test_the_delivery_time_does_not_depend_on_the_rate_of_control(rate):
    clock = {"physics": 50, "sensing": rate, "control": rate}
    params = make_params(goal=(0, 0, 0), clock=clock)
    assert delivery_ticks(params) == 3 * rate


def test_ticks_count_from_the_first_at_which_a_coasting_vessel_is_slow_enough():
    """A vessel coasts to rest at the goal; its speed falls with the distance left."""
    params = make_params()
    vessel, task = params.hulls()[0], params.task
    left = 0.04
    simulation = begun([0.0, left, 0.0, 0.0, -float(coasting_speed(vessel, left)), 0.0])
    speeds, ticks = [], []
    while not simulation.ending.terminated[0]:
        ticks += counted(simulation, 1)
        speeds.append(float(np.abs(simulation.relations.velocity[0, 0])))
    slow = np.array(speeds) < task.speed_tolerance
    first = int(np.argmax(slow))
    assert first > 30
    assert ticks == [0] * first + list(range(1, 31))
    assert simulation.relations.goal_error[0] < float(
        coasting_distance(vessel, task.speed_tolerance)
    )


def test_a_vessel_that_coasts_through_is_not_delivered():
    simulation = begun([0.0, 0.1, 0.0, 0.0, -0.05, 0.0])
    assert max(counted(simulation, 600)) == 0
    assert simulation.summary()["min_position_error"][0] < 0.002


@pytest.mark.parametrize("column", [1, 4, 5], ids=["position", "speed", "yaw rate"])
def test_a_break_begins_the_count_again(column):
    simulation = begun([])
    assert counted(simulation, 29)[-1] == 29
    motion = simulation.state.motion.copy()
    motion[0, 0, column] = {1: 0.06, 4: 0.004, 5: 0.02}[column]
    before = simulation.state.delivered_ticks
    begin_at(simulation, list(motion))
    state = replace(simulation.state, delivered_ticks=before)
    simulation._state = state
    assert counted(simulation, 1) == [0]
    assert not simulation.ending.reached.any()


def test_a_reset_begins_the_count_again():
    simulation = begun([])
    assert counted(simulation, 7)[-1] == 7
    begin_at(simulation, [bodies((), *APART)])
    assert counted(simulation, 30) == list(range(1, 31))


def test_ticks_before_a_goal_is_final_do_not_count():
    options = {"goal": (0.0, 0.0, 0.0), "goal_anchor": "closure"}
    assert counted(begun([], **options), 40) == [0] * 40


# ------------------------------------------------------------------ moving water


@pytest.mark.parametrize("water", [0.003, 0.01, 0.02, 0.1])
@pytest.mark.parametrize("course", [1, 1j, np.exp(2j)])
def test_a_vessel_that_is_carried_by_the_water_does_not_count(water, course):
    velocity = water * course
    assert not counts([0, 0, 0, velocity.real, velocity.imag, 0], water=velocity)


@pytest.mark.parametrize("water", [0.01, 0.02])
def test_bounds_over_ground_grow_with_the_speed_of_the_water(water):
    speed, yaw_rate = 0.002 + 0.25 * water, 0.01 + 1.25 * water
    inside = [0, 0, 0, 0, 0.99 * speed, -0.99 * yaw_rate]
    assert counts(inside, water=water)
    assert counts(inside, water=-1j * water)
    assert not counts(inside)
    assert not counts([0, 0, 0, 0, 1.01 * speed, 0], water=water)
    assert not counts([0, 0, 0, 0, 0, 1.01 * yaw_rate], water=water)


def test_without_a_tolerance_for_the_water_the_bounds_are_those_of_still_water():
    vessel = [0, 0, 0, 0.0021, 0, 0]
    assert counts(vessel, water=0.01)
    assert not counts(vessel, water=0.01, water_tolerance=0.0)


def test_drifting_through_the_goal_is_no_delivery_and_holding_it_is():
    current = {"current": "uniform", "current_speed": 0.02}
    drifting = begun([-0.2, 0, 0, 0.02, 0, 0], water=current)
    assert max(counted(drifting, 200)) == 0
    assert drifting.summary()["min_position_error"][0] < 0.002
    passing = begun([-0.01, 0, 0, 0.02, 0, 0], water=current, delivery="passing")
    counted(passing, 10)
    assert passing.ending.reached.all()
    # So heavy a vessel is hardly carried along within the delivery time.
    held = begun([], water=current, vessel={"mass": 1e4})
    assert counted(held, 30) == list(range(1, 31))
    assert held.ending.reached.all()


# ------------------------------------------------------------------ state


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda s: pickle.loads(pickle.dumps(s))])
def test_copies_and_snapshots_continue_the_count(copied):
    simulation = begun([])
    assert counted(simulation, 12)[-1] == 12
    snapshot = simulation.snapshot()
    assert counted(copied(simulation), 30) == list(range(13, 31))
    assert counted(simulation, 10)[-1] == 22
    simulation.restore(snapshot)
    assert counted(simulation, 30) == list(range(13, 31))


def test_the_global_state_has_the_share_of_the_delivery_time():
    simulation = begun([])
    before = global_state(simulation.state, simulation.params)
    counted(simulation, 15)
    after = global_state(simulation.state, simulation.params)
    assert (after - before)[0, 16] == approx(0.5)


def test_the_paper_s_presets_take_its_instant():
    for preset, criterion in {
        "nominal": "holding", "tank": "holding",
        "experiment": "passing", "paper_simulation": "passing",
    }.items():  # fmt: skip
        assert make_params(preset=preset).task.delivery == criterion


@pytest.mark.parametrize(
    ("closure", "nearest", "heading", "anchor", "cause"),
    [
        (math.inf, 0.5, 0.0, "world", "no closure"),
        (math.inf, 0.01, 0.0, "closure", "no closure"),
        (math.inf, 0.01, 0.5, "world", "heading off"),
        (math.inf, 0.01, -0.05, "world", "not settled"),
        (20.0, 0.5, 0.0, "world", "never near"),
        (20.0, 0.01, -0.5, "closure", "heading off"),
    ],
)
def test_a_team_may_fail_for_more_than_want_of_closure(closure, nearest, heading, anchor, cause):
    summary = {
        "strayed": False,
        "time_to_closure": closure,
        "min_position_error": nearest,
        "heading_error_at_min": heading,
    }
    assert why_not_delivered(summary, make_params(goal_anchor=anchor)) == cause
    assert why_not_delivered(summary | {"strayed": True}, make_params()) == "strayed"
