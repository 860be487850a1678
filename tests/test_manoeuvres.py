"""What two boats do in turn: where they push, what they choose, and when they let go."""

import numpy as np
import pytest
from helpers import successes
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from asv_env import make_params
from asv_env.geometry import wrap
from asv_env.physics.hull import advanced, equip, hulls, kinds
from asv_env.types import zeros
from baselines.allocation import AllocationPolicy
from baselines.allocation.allocation_gains import AllocationGains, ManoeuvreGains
from baselines.allocation.contact_points import columns, gyration, pairs
from baselines.allocation.direct_path import Course
from baselines.allocation.manoeuvres import DRIVE, REST, SLIDE, TURN, ManoeuvreMemory, Manoeuvres
from baselines.allocation.pushes import Pushes
from baselines.scripted.settling import coasted

PARAMS = make_params("push", 2)
VESSEL, BOAT = PARAMS.hulls()
GAINS = ManoeuvreGains()
MANOEUVRES = Manoeuvres(PARAMS, GAINS)
PUSHES = Pushes(PARAMS, AllocationGains(), GAINS, MANOEUVRES)
POSITION, HEADING = PARAMS.task.position_tolerance, PARAMS.task.heading_tolerance
poses = st.tuples(st.floats(-1.2, 1.2), st.floats(-1.2, 1.2), st.floats(-3.1, 3.1))


def pose(u, w, turn):
    return np.array([u + 1j * w]), np.array([turn])


def chosen(u, w, turn, resting=False):
    return int(MANOEUVRES.choose(pose(u, w, turn), np.array([resting]))[0])


@pytest.mark.parametrize("hull", ["plank", "triangle", "hexagon", "barge", "L", "T"])
def test_each_pair_of_contact_points_can_do_its_manoeuvre(hull):
    vessel, boat = make_params("push", 2, vessel=hull).hulls()
    found = pairs(vessel, boat)
    assert found.spans
    point = found.place + found.inward * boat.length / 2
    column = columns(point, found.inward, gyration(vessel))
    moments = column[TURN : TURN + 2, :, 2].sum(axis=1)
    assert moments[0] > 0.5
    assert moments[1] < -0.5
    ways = found.axis * np.array([1, -1, 0, 0, 1j, -1j])
    for kind in (DRIVE, DRIVE + 1, SLIDE, SLIDE + 1):
        pushes = (found.inward[kind] / ways[kind]).real
        assert pushes.max() > 0.4


def test_two_boats_on_a_plank_steer_by_the_difference_of_their_forces():
    found = pairs(VESSEL, BOAT)
    point = found.place + found.inward * BOAT.length / 2
    column = columns(point, found.inward, gyration(VESSEL))
    for kind, way in ((DRIVE, 1j), (DRIVE + 1, -1j), (SLIDE, -1), (SLIDE + 1, 1)):
        way = way if kind < SLIDE else 1j * found.axis * (1 if kind == SLIDE else -1)
        for moment in (0.1, -0.1):
            wrench = [complex(way).real, complex(way).imag, moment]
            assert linprog(np.ones(2), A_eq=column[kind].T, b_eq=wrench).status == 0
    turning = column[TURN].sum(axis=0)
    np.testing.assert_allclose(turning[:2], 0.0, atol=1e-12)


@given(poses)
def test_the_vessel_is_left_alone_where_it_rests_at_its_goal_and_nowhere_else(goal):
    u, w, turn = goal
    error = max(np.hypot(u, w) / POSITION, abs(turn) / HEADING)
    assert (chosen(u, w, turn) == REST) == (error < GAINS.rest_error)
    assert chosen(u * 1e-3, w * 1e-3, turn * 1e-3) == REST


@given(st.floats(-1.2, 1.2), st.floats(-1.2, 1.2), st.floats(-3.1, 3.1))
def test_the_opposite_error_takes_the_opposite_manoeuvre(u, w, turn):
    here = chosen(u, w, turn)
    near = np.hypot(u, w) <= GAINS.far * POSITION
    if near and here != REST and 0 not in (u, w, turn):
        assert chosen(-u, -w, -turn) == here ^ 1


@pytest.mark.parametrize(
    ("goal", "kind"),
    [
        ((0.0, 0.8, 0.0), DRIVE),
        ((0.0, -0.8, 0.0), DRIVE + 1),
        ((0.1, 0.8, 0.2), DRIVE),
        ((-0.8, 0.0, 0.1), TURN),  # With its +w end it has to turn by a quarter to the left.
        ((0.0, 0.04, 0.3), TURN),
        ((0.0, 0.04, -0.3), TURN + 1),
        ((-0.06, 0.01, 0.0), SLIDE),
        ((0.06, 0.01, 0.0), SLIDE + 1),
    ],
)
def test_far_goals_are_driven_to_and_near_ones_approached_by_the_largest_error(goal, kind):
    assert pairs(VESSEL, BOAT).axis == pytest.approx(1j)
    assert chosen(*goal) == kind


def pushed(kind, goal, seconds=60.0):
    """Goal as it lies once the vessel rests that follows its reference until boats let go."""
    course = zeros(Course, *[(1,)] * 8)
    memory = ManoeuvreMemory.empty(1, 2)
    memory.kind[:] = kind
    course.axis = PUSHES.way(memory)
    hull, one = hulls(1, 1), np.ones(1)
    step = 0.2 * VESSEL.masses[1] / VESSEL.sway[0]
    equip(hull, 0, kinds([VESSEL]), one, one, one, step)
    (here, turn), dt = pose(*goal), 1 / PARAMS.clock.control
    for _ in range(round(seconds / dt)):
        motion = np.array([[course.velocity[0].real, course.velocity[0].imag, course.yaw_rate[0]]])
        way, turned = coasted(motion, hull, step)
        rest = (here - way) * np.exp(-1j * turned), wrap(turn - turned)
        PUSHES.advance(course, memory, (here, turn), rest, course.velocity, np.ones(1, bool))
        if PUSHES.done(memory, rest)[0]:
            return rest[0][0], rest[1][0]
        here = (here - dt * course.velocity) * np.exp(-1j * dt * course.yaw_rate)
        turn = turn - dt * course.yaw_rate
    raise AssertionError("the push has no end")


@settings(max_examples=25)
@given(st.floats(0.03, 1.2))
def test_a_vessel_that_is_driven_comes_to_rest_at_its_goal(distance):
    left, turn = pushed(DRIVE, (0.0, distance, 0.0))
    assert abs(left) < 2 * GAINS.release_error * POSITION
    assert turn == 0.0


@settings(max_examples=15)
@given(st.floats(0.1, 3.0))
def test_a_vessel_that_is_turned_comes_to_rest_at_its_heading(angle):
    for sign in (1, -1):
        left, turn = pushed(TURN + (sign < 0), (0.0, 0.0, sign * angle))
        assert abs(turn) < 2 * GAINS.release_error * HEADING
        assert left == 0.0


def test_boats_that_cannot_pull_do_not_brake():
    """The reference slows down no faster than drag slows the vessel."""
    course, memory = zeros(Course, *[(1,)] * 8), ManoeuvreMemory.empty(1, 2)
    course.axis, course.speed[:] = PUSHES.way(memory), 0.07
    gap, dt = 0.5, 1 / PARAMS.clock.control
    hull, one = hulls(1, 1), np.ones(1)
    equip(hull, 0, kinds([VESSEL]), one, one, one, dt)
    while course.speed[0] > 0.005:
        speed = course.speed[0]
        here = pose(0.0, gap, 0.0)
        PUSHES.advance(course, memory, here, here, course.velocity, np.ones(1, bool))
        free = advanced(0.0, speed, 0.0, (0.0, 0.0, 0.0), hull, 0, 0, (1.0, 1.0), dt)[1]
        assert course.speed[0] >= free or speed == 0.07
        gap -= dt * course.speed[0]


def test_two_boats_deliver_to_goals_all_over_the_plane():
    params = make_params("transport", 2, "noisy")
    assert successes(AllocationPolicy, params, 8, enough=6) == 6


def test_a_team_of_four_that_loses_two_boats_continues_by_manoeuvres():
    failing = {"failures": 2, "failure_time": (0.0, 5.0)}
    params = make_params("transport", 4, variation=failing)
    assert successes(AllocationPolicy, params, 6, enough=3) == 3
