"""The reference motion of a vessel on its direct path, without boats: it arrives and rests."""

from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from asv_env import make_params
from asv_env.geometry import wrap
from asv_env.types import zeros
from baselines.allocation.allocation_gains import AllocationGains
from baselines.allocation.contact_points import formation
from baselines.allocation.direct_path import Course, DirectPath, axial_drag, towards
from baselines.paper.coasting import drag

PARAMS = make_params("push")
PATH = DirectPath(PARAMS, AllocationGains())
LIMITS = PATH.limits(formation(*PARAMS.hulls(), 4))


def followed(goal, seconds=120.0):
    """Course, final pose relative to the goal and time of a vessel that moves as is referred."""
    course = zeros(Course, *[(1,)] * 8)
    course.axis[:] = 1j
    place, heading = np.zeros(1, complex), np.zeros(1)
    target, final = np.array([goal[0] + 1j * goal[1]]), np.array([goal[2]])
    moves, dt = np.ones(1, dtype=bool), 1 / PARAMS.clock.control
    for tick in range(round(seconds / dt)):
        here = (target - place) * np.exp(-1j * heading), wrap(final - heading)
        if tick == 0:
            PATH.begin(course, moves, *here)
        PATH.arrive(course, *here, moves, moves)
        PATH.advance(course, LIMITS, *here, moves, np.ones(1))
        if course.holds[0]:
            return course, abs(here[0][0]), abs(here[1][0]), tick * dt
        place = place + dt * course.velocity * np.exp(1j * heading)
        heading = heading + dt * course.yaw_rate
    return course, abs(here[0][0]), abs(here[1][0]), np.inf


@given(st.floats(0.0, 1.2), st.floats(-np.pi, np.pi), st.floats(-np.pi, np.pi))
def test_a_vessel_that_moves_as_is_referred_comes_to_rest_at_its_goal(distance, bearing, heading):
    goal = distance * np.cos(bearing), distance * np.sin(bearing), heading
    course, off, turned, time = followed(goal)
    assert time < 80.0
    assert off < 0.5 * PARAMS.task.position_tolerance
    assert turned < 0.5 * PARAMS.task.heading_tolerance
    assert course.speed == course.yaw_rate == 0.0


def test_a_goal_behind_is_reached_astern_without_turning():
    ahead, behind = (followed((0.0, w, 0.0)) for w in (0.8, -0.8))
    assert ahead[3] == pytest.approx(behind[3], abs=0.2)
    assert ahead[3] < 0.8 / LIMITS.speed + 10.0
    assert ahead[0].axis == -behind[0].axis


def test_teams_can_drive_at_the_limits_that_are_stated():
    vessel, boat = PARAMS.hulls()
    resistance = drag(axial_drag(vessel, 1j), float(LIMITS.speed))
    assert resistance <= 0.6 * 0.8 * 2 * (2 * boat.thrust) * (1 + 1e-9)
    assert axial_drag(vessel, 1.0) == vessel.surge
    assert axial_drag(vessel, -1j) == vessel.sway


@given(st.floats(-3.0, 3.0), st.floats(0.2, 2.0), st.floats(0.01, 1.0), st.floats(0.05, 1.0))
def test_rates_end_where_errors_end(error, gain, braking, limit):
    law = partial(towards, gain=gain, braking=braking, limit=np.array(limit))
    rate, near = law(np.array(error)), 0.99 * np.array(error)
    assert abs(rate) <= min(limit, gain * abs(error)) + 1e-12
    assert rate * error >= 0
    # What is left to go after the distance to it has been covered is braked by no more.
    assert rate**2 - law(near) ** 2 <= 2 * braking * abs(error - near) * 1.02 + 1e-12


def test_no_team_no_motion():
    course = zeros(Course, *[(1,)] * 8)
    course.axis[:], course.speed[:], course.yaw_rate[:] = 1j, 0.05, 0.2
    for _ in range(200):
        still = np.zeros(1, dtype=bool), np.ones(1)
        PATH.advance(course, LIMITS, np.array([0.5 + 0.5j]), np.array([1.0]), *still)
    assert course.speed == course.yaw_rate == course.slide == 0.0
