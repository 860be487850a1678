"""Paths of the vessel among obstacles, checked by dense sampling of the team's outline."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from asv_env import make_params
from asv_env.geometry import direction, wrap
from asv_env.tasks.layouts import team_reach
from baselines.paper import dubins
from baselines.paper.arcs import ArcPath
from baselines.scripted.clear_paths import SEGMENTS
from baselines.scripted.clear_planner import EASED, ClearPlanner
from baselines.scripted.gains import GraspGains, PathGains
from baselines.scripted.legs import WORDS, leg
from baselines.scripted.planner import PathPlanner

PARAMS, GAINS = make_params(obstacles="pillars"), PathGains()
LENGTH = PARAMS.vessel.size
ALONG, AHEAD, BEHIND = team_reach(PARAMS)
PLANNER = ClearPlanner(PARAMS, GAINS, GraspGains(), may_switch=True)
STAYING = ClearPlanner(PARAMS, GAINS, GraspGains(), may_switch=False)
OPEN_WATER = PathPlanner(PARAMS.hulls()[0], GAINS)
LEAST = EASED[-1] * GAINS.straight_clearance * LENGTH
SAMPLING = 0.01  #: steps of a path between which clearance may be less, m

places = st.floats(-1.2, 1.2)
angles = st.floats(-np.pi, np.pi)
pillars = st.lists(st.tuples(places, places, st.floats(0.04, 0.1)), min_size=3, max_size=3)


def rows_of(circles):
    return np.array([[x, y, x, y, radius] for x, y, radius in circles])


def box_clearance(poses, rows):
    """Distance (n,) of the team's box at poses (n, 3) to the nearest of round pillars, m."""
    offset = rows[:, 0] + 1j * rows[:, 1] - (poses[:, :1] + 1j * poses[:, 1:2])
    local = offset * direction(-poses[:, 2:])
    beside = np.maximum(np.abs(local.real) - ALONG, 0.0)
    beyond = np.maximum(np.maximum(-AHEAD - local.imag, local.imag - BEHIND), 0.0)
    return (np.hypot(beside, beyond) - rows[:, 4]).min(axis=1)


def plans(planner, goal, rows, slides=True):
    goal = np.atleast_2d(goal)
    free = OPEN_WATER.plan(goal[:, 0] + 1j * goal[:, 1], goal[:, 2])
    rows = np.broadcast_to(rows, (len(goal), *rows.shape[-2:]))
    return planner.plan(np.zeros_like(goal), goal, rows, free, np.full(len(goal), slides)), free


def is_clear_at(pose, rows):
    return box_clearance(np.atleast_2d(pose), rows)[0] > GAINS.turning_clearance * LENGTH


def poses_along(plan, world=0):
    """Poses of the vessel as this side's team drives it, and its path."""
    path, other, *_ = plan
    start = path.start[world] + [0.0, 0.0, np.pi * other[world]]
    path = ArcPath(start, path.curvature[world], path.length[world])
    return path.pose_at(np.linspace(0.0, path.total_length, 300)), path


@settings(deadline=None, max_examples=15)
@given(places, places, angles, pillars)
def test_found_paths_are_clear_and_drivable_and_end_at_the_goal(x, y, heading, circles):
    goal, rows = np.array([x, y, heading]), rows_of(circles)
    assume(is_clear_at(np.zeros(3), rows))
    assume(is_clear_at(goal, rows))
    plan, free = plans(PLANNER, goal, rows)
    poses, path = poses_along(plan)
    if np.array_equal(path.length[: free.length.shape[1]], free.length[0]):
        return  # In open water, or nothing was found: another test's business.
    assert box_clearance(poses, rows).min() > LEAST - SAMPLING
    tightest = GAINS.narrow_radius * LENGTH / 2
    assert np.abs(path.curvature).max() <= (1 + 1e-9) / tightest
    if not plan.switches[0]:
        end = path.end - [0.0, 0.0, np.pi * plan.other[0]]
        assert np.hypot(*(end[:2] - goal[:2])) < 1e-6
        assert abs(wrap(end[2] - heading)) < 1e-6


def test_a_pillar_in_the_way_is_passed():
    goal, rows = np.array([0.0, -2.4, 0.0]), rows_of([(0.05, -1.2, 0.08)])
    plan, free = plans(STAYING, goal, rows)
    blocked = free.pose_at(np.linspace(0.0, 2.4, 200)[:, None])[:, 0]
    assert box_clearance(blocked, rows).min() < 0.0
    poses, path = poses_along(plan)
    assert box_clearance(poses, rows).min() > LEAST - SAMPLING
    np.testing.assert_allclose(path.end, goal, atol=1e-6)
    assert not plan.other[0]
    assert not plan.switches[0]


def test_paths_that_are_clear_stay_as_they_are_to_the_bit():
    rng = np.random.default_rng(0)
    goal = rng.uniform([-1, -1, -np.pi], [1, 1, np.pi], (50, 3))
    plan, free = plans(PLANNER, goal, rows_of([(9.0, 9.0, 0.1)]))
    drawn = free.length.shape[1]
    np.testing.assert_array_equal(plan.path.length[:, :drawn], free.length)
    np.testing.assert_array_equal(plan.path.curvature[:, :drawn], free.curvature)
    assert not plan.path.length[:, drawn:].any()
    assert not plan.other.any()
    assert not plan.switches.any()


def test_no_plan_depends_on_the_others():
    rng = np.random.default_rng(1)
    goal = rng.uniform([-1, -1, -np.pi], [1, 1, np.pi], (12, 3))
    rows = rows_of([(0.1, -0.5, 0.08), (-0.6, 0.3, 0.08)])
    together, _ = plans(PLANNER, goal, rows)
    assert not np.array_equal(together.path.length[:, :4], plans(PLANNER, goal, rows)[1].length)
    for world, pose in enumerate(goal):
        alone, _ = plans(PLANNER, pose, rows)
        np.testing.assert_array_equal(alone.path.length[0], together.path.length[world])
        np.testing.assert_array_equal(alone.path.curvature[0], together.path.curvature[world])


def test_a_goal_ahead_of_the_other_side_is_pushed_to_from_there():
    """A wall close ahead leaves no room for a turn."""
    goal, wall = np.array([[0.0, 1.0, 0.0]]), np.array([[-3.0, -0.45, 3.0, -0.45, 0.02]])
    assert PLANNER.sides(np.zeros((1, 3)), goal, wall[None])[0]
    assert not PLANNER.sides(np.zeros((1, 3)), -goal, -wall[None] * [1, 1, 1, 1, -1])[0]
    plan, _ = plans(PLANNER, goal, wall)
    assert plan.other[0]
    staying, _ = plans(STAYING, goal, wall)
    assert not staying.other[0]


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_vessel_behind_the_end_of_a_pier_is_slid_past_it(side):
    """There is no room for a turn, nor straight ahead."""
    goal, pier = np.array([0.0, -2.4, 0.0]), np.array([side * 3.0, -0.2, side * 0.1, -0.2, 0.02])
    plan, _ = plans(STAYING, goal, pier[None])
    assert plan.slides[0]
    start = plan.path.start[0]
    assert start[0] * side < 0.0
    np.testing.assert_array_equal(start[1:], 0.0)
    np.testing.assert_allclose(poses_along(plan)[1].end, goal, atol=1e-6)
    stays, _ = plans(STAYING, goal, pier[None], slides=False)
    assert not stays.slides[0]
    np.testing.assert_array_equal(stays.path.start[0], 0.0)


def test_a_vessel_without_room_for_a_turn_goes_straight_ahead_first():
    """Between two walls, beyond which is the goal."""
    goal = np.array([1.5, -2.0, 0.5])
    walls = np.array([[x, -0.2, x, 0.6, 0.02] for x in (-ALONG - 0.04, ALONG + 0.04)])
    plan, _ = plans(STAYING, goal, walls)
    assert plan.path.length[0, 0] > 0.0
    assert plan.path.curvature[0, 0] == 0.0
    assert not plan.slides[0]
    np.testing.assert_allclose(poses_along(plan)[1].end, goal, atol=1e-6)


@given(places, places, angles, st.floats(0.1, 0.6))
def test_the_shortest_leg_is_dubins_path_of_its_kind(x, y, heading, radius):
    """Where no word of three turns is shorter."""
    words = [leg(0j, 0.0, complex(x, y), heading, *word, radius) for word in WORDS]
    shortest = dubins.length(np.array([x, y, heading]), radius)
    assert min(map(sum, words)) >= shortest - 1e-6
    if np.hypot(x, y) > 4 * radius:
        assert min(map(sum, words)) == pytest.approx(shortest, abs=1e-6)


def test_paths_have_room_for_two_legs_and_a_straight():
    plan, _ = plans(PLANNER, np.array([0.0, -1.0, 0.0]), rows_of([(9.0, 9.0, 0.1)]))
    assert plan.path.length.shape == (1, SEGMENTS)
