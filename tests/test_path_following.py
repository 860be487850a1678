"""Where the vessel is on its path, and when it gets a new one."""

import functools

import numpy as np
import pytest
from helpers import known_at_start, moved
from hypothesis import given
from hypothesis import strategies as st

from asv_env import make_params
from asv_env.geometry import wrap
from asv_env.params.obstacle_params import Circle
from asv_env.tasks.formation import relate
from baselines.paper.arcs import ArcPath
from baselines.scripted import PathGains, PathPlanner, PushGains, Tolerances
from baselines.scripted.clear_planner import ClearPlanner
from baselines.scripted.gains import GraspGains
from baselines.scripted.observer import VesselMemory
from baselines.scripted.path_following import (
    OFF_PATH,
    PAST_GOAL,
    PATIENCE,
    PathFollower,
    PathMemory,
)


@functools.cache
def planner_of(params):
    return PathPlanner(params.hulls()[0], PathGains())


@functools.cache
def follower_of(params):
    return PathFollower(params, planner_of(params), PushGains(), Tolerances())


def path_of(memory):
    return ArcPath(memory.start, memory.curvature, memory.length)


def planned(params, sensed, drift):
    """Follower and memory of paths that begin where the vessels are."""
    worlds = len(sensed.side)
    follower, memory = follower_of(params), PathMemory.empty(worlds)
    relations = relate(sensed.measured, sensed.goal, sensed.slot, sensed.side)
    follower.plan(relations, carried_by(drift), memory, np.ones(worlds, dtype=bool))
    return follower, memory


def carried_by(drift):
    """What is known of vessels in water that has carried them like this all the time."""
    vessel = VesselMemory.empty(len(drift), 4)
    vessel.drift[:] = vessel.mean[:] = drift
    return vessel


@given(st.floats(0.05, 0.95), st.floats(-0.05, 0.05), st.floats(-0.5, 0.5))
def test_vessel_knows_where_it_is_on_its_path(share, cross_track, turned):
    """At a distance from a point of the path, and turned off its heading there."""
    params = make_params("push", goal=(0.8, -1.0, 0.7))
    sensed, still = known_at_start(params, [0]), np.zeros(1, complex)
    follower, memory = planned(params, sensed, still)
    total = memory.length.sum()
    abreast = path_of(memory).pose_at(share * total)[0]
    off_path = np.array(
        [cross_track * np.cos(abreast[2]), cross_track * np.sin(abreast[2]), turned]
    )
    placed = moved(sensed, (abreast + off_path)[None])
    relations = relate(placed.measured, placed.goal, placed.slot, placed.side)
    speed = np.array([0.05])
    for _ in range(60):
        seen = follower.track(relations, carried_by(still), speed, still.real, memory)
    offset, off, left, curvature = seen
    assert offset[0] == pytest.approx(cross_track, abs=1e-6)
    assert off[0] == pytest.approx(turned, abs=1e-6)
    assert left[0] == pytest.approx((1 - share) * total, abs=1e-6)
    ends = np.cumsum(memory.length[0])
    ahead = share * total + speed * follower.preview_times
    sharp = np.abs(ahead[:, None] - ends).min(axis=1) < 1e-4
    segment = (ahead[:, None] >= ends).sum(axis=1)
    expected = np.append(memory.curvature[0], 0.0)[segment]
    np.testing.assert_array_equal(curvature[0, ~sharp], expected[~sharp])


def test_path_and_water_meet_at_the_goal():
    """The water carries what follows the path to the goal when its time is over."""
    params, seeds = make_params("push", delivery="passing"), range(50)
    rng = np.random.default_rng(0)
    sensed = moved(
        known_at_start(params, seeds), rng.uniform(-1, 1, (len(seeds), 3)) * [0.5, 0.5, np.pi]
    )
    drift = 0.01 * np.exp(1j * rng.uniform(-np.pi, np.pi, len(seeds)))
    _, memory = planned(params, sensed, drift)
    pose = path_of(memory).end
    np.testing.assert_allclose(pose[:, :2], sensed.goal[:, :2], atol=1e-9)
    np.testing.assert_allclose(wrap(pose[:, 2] - sensed.goal[:, 2]), 0.0, atol=1e-9)
    planner = planner_of(params)
    # The goal is passed in moving water.
    beyond = planner.run_out(planner.gains.passing_speed)
    carried = drift * (planner.time(memory.length.sum(axis=1) + beyond) - planner.time(beyond))
    begins = memory.start[:, 0] + 1j * memory.start[:, 1] - carried
    vessel = sensed.measured[:, 0, 0] + 1j * sensed.measured[:, 0, 1]
    assert np.median(np.abs(begins - vessel)) < 0.02 * params.vessel.length


@pytest.mark.parametrize(
    ("along", "across", "missed"),
    [(0.5 * PAST_GOAL, 0.0, False), (2 * PAST_GOAL, 0.0, True), (-1.0, 0.9 * OFF_PATH, False),
     (-1.0, 1.1 * OFF_PATH, True), (-1.0, -1.1 * OFF_PATH, True)],
)  # fmt: skip
def test_a_vessel_that_misses_its_goal_gets_a_new_path(along, across, missed):
    """Straight ahead of the goal by so many lengths, and of cross-track error."""
    params, still = make_params("push", goal=(0.0, -1.0, 0.0)), np.zeros(1, complex)
    sensed = known_at_start(params, [0])
    follower, memory = planned(params, sensed, still)
    start, length = memory.start.copy(), params.vessel.length
    assert memory.length.sum() == pytest.approx(1.0, abs=1e-9)
    there = moved(sensed, np.array([[across * length, -1.0 - along * length, 0.0]]))
    relations = relate(there.measured, there.goal, there.slot, there.side)
    for _ in range(2):
        follower.track(relations, carried_by(still), still.real, still.real, memory)
    assert memory.replan[0] == missed
    follower.plan(relations, carried_by(still), memory, memory.replan)
    expected = there.measured[:, 0, :3] if missed else start
    np.testing.assert_allclose(memory.start, expected, atol=1e-9)
    np.testing.assert_allclose(path_of(memory).end[0, :2], params.task.goal[:2], atol=1e-9)


def test_a_vessel_that_does_not_move_among_obstacles_is_let_go_of():
    """After ``PATIENCE``, which begins again when it moves; in open water never."""
    params = make_params("push", obstacles=[Circle((3.0, 3.0), 0.1)])
    among = ClearPlanner(params, PathGains(), GraspGains(), may_switch=True)
    gains = PushGains(), Tolerances()
    followers = (
        PathFollower(params, planner_of(params), *gains, among),
        follower_of(make_params("push")),
    )
    sensed = known_at_start(params, [0, 1])
    never, moves = np.zeros(2, dtype=bool), np.array([True, False])
    ticks = round(PATIENCE * params.clock.control)
    for follower, jams in zip(followers, ([False, True], [False, False]), strict=True):
        memory = PathMemory.empty(2)
        for tick in range(ticks + 2):
            relations = relate(sensed.measured, sensed.goal, sensed.slot, sensed.side)
            relations.position[moves] += 0.01 * tick
            follower.watch(relations, memory, never if tick else ~never)
            assert not memory.lets_go.any() or tick >= ticks
        np.testing.assert_array_equal(memory.lets_go, jams)
