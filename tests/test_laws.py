"""Laws of the boats, as the compiled loop calls them: turns, motors, autopilot, shelter."""

import math
from dataclasses import replace

import numpy as np
import pytest
from helpers import DOWN, bodies
from hypothesis import given
from hypothesis import strategies as st

from asv_env import make_params
from asv_env.geometry import SMALL, cos_sin
from asv_env.params import THRUST_LAWS, BoatParams
from asv_env.physics import autopilot, shelter, thrusters

approx = pytest.approx
BOATS = st.builds(
    lambda law, astern, thrust: BoatParams(thrust_law=law, astern=astern, thrust=thrust),
    st.sampled_from(THRUST_LAWS),
    st.floats(0.05, 1.0),
    st.floats(1e-3, 1e2),
)
shares = st.floats(-1.0, 1.0)

# ------------------------------------------------------------------ turns


@given(angle=st.floats(-2 * SMALL, 2 * SMALL))
def test_cosine_and_sine_of_small_turns_are_exact(angle):
    """Within two units in the last place."""
    cos, sin = cos_sin(angle)
    assert cos == approx(math.cos(angle), rel=4e-16, abs=0.0)
    assert sin == approx(math.sin(angle), rel=4e-16, abs=0.0)


# ------------------------------------------------------------------ motors


@given(boat=BOATS, share=shares)
def test_signal_and_thrust_are_inverse_to_each_other(boat, share):
    drive = thrusters.drive(boat)
    assert thrusters.signal_for(thrusters.thrust_of(share, drive), drive) == approx(share, abs=1e-9)
    thrust = share * (drive.ahead if share > 0 else drive.astern)
    assert thrusters.thrust_of(thrusters.signal_for(thrust, drive), drive) == approx(
        thrust, rel=1e-12, abs=1e-300
    )


@pytest.mark.parametrize(("law", "half"), [("linear", 0.5), ("quadratic", 0.25)])
def test_half_a_signal_gives_half_or_a_quarter_of_the_thrust(law, half):
    drive = thrusters.drive(BoatParams(thrust_law=law))
    assert thrusters.thrust_of(0.5, drive) == approx(half * 0.010)
    assert thrusters.thrust_of(-0.5, drive) == approx(-half * 0.006)
    assert thrusters.signal_for(1.0, drive) == 1.0
    assert thrusters.signal_for(-1.0, drive) == -1.0


def test_motors_that_cannot_go_astern_are_off_where_they_should():
    drive = thrusters.drive(BoatParams(astern=0.0))
    assert thrusters.signal_for(-0.01, drive) == thrusters.thrust_of(-1.0, drive) == 0.0


@given(boat=BOATS, force=st.floats(-5, 5), moment=st.floats(-2, 2))
def test_the_moment_comes_before_the_force(boat, force, moment):
    """Force and moment in units of what a motor gives ahead, at its distance from the middle."""
    drive = thrusters.drive(boat)
    force, moment = force * drive.ahead, moment * drive.ahead * drive.lever_arm
    left, right = thrusters.allocated(force, moment, drive)
    for thrust in (left, right):
        assert -drive.astern * (1 + 1e-12) <= thrust <= drive.ahead * (1 + 1e-12)
    most = drive.lever_arm * (drive.ahead + drive.astern)
    wanted = min(max(moment, -most), most)
    assert drive.lever_arm * (right - left) == approx(wanted, rel=1e-12, abs=1e-12 * most)
    # Of the forces that leave room for the moment it is the nearest.
    least = -2 * drive.astern + abs(wanted) / drive.lever_arm
    largest = 2 * drive.ahead - abs(wanted) / drive.lever_arm
    nearest = min(max(force, least), largest)
    assert left + right == approx(nearest, abs=1e-12 * drive.ahead)


def test_efforts_of_many_boats_are_those_of_each():
    boat = BoatParams(thrust_law="quadratic")
    drive = thrusters.drive(boat)
    efforts = np.random.default_rng(0).normal(0, 0.02, (3, 4, 2)) * (1, 0.02)
    found = thrusters.signals(efforts, boat)
    for index in np.ndindex(3, 4):
        thrusts = thrusters.allocated(*efforts[index], drive)
        assert found[index].tolist() == [thrusters.signal_for(each, drive) for each in thrusts]


# ------------------------------------------------------------------ reference model


@given(
    start=shares,
    action=shares,
    response=st.floats(0.0, 2.0),
    acceleration=st.floats(0.05, 5.0),
    dt=st.sampled_from([0.1, 0.02, 0.01]),
)
def test_reference_goes_to_the_set_point_with_bounded_acceleration(
    start, action, response, acceleration, dt
):
    axis = autopilot.axes(
        BoatParams(response=(response, response), acceleration=(acceleration, acceleration))
    )[1]
    wanted, reference = axis.full * action, axis.full * start
    for _ in range(math.ceil((25 * response + 2 * axis.full / acceleration) / dt) + 2):
        before = reference
        reference, found = autopilot.referred(before, action, axis, dt)
        assert reference == before + dt * found
        assert abs(found) <= acceleration
        assert abs(wanted - reference) <= abs(wanted - before) * (1 + 1e-12)
        assert (wanted - reference) * (wanted - before) >= -1e-12
    assert reference == approx(wanted, abs=1e-6)


def test_reference_follows_a_small_step_with_its_time_constant():
    boat = BoatParams()
    surge = replace_step(boat, 1e-4)
    reference = 0.0
    for _ in range(round(boat.response[0] / 1e-4)):
        reference, _ = autopilot.referred(reference, 0.1, surge, 1e-4)
    assert reference == approx(0.1 * boat.full_speed * -math.expm1(-1), rel=1e-3)


def replace_step(boat, dt):
    """Axis of surge of a boat whose acceleration is not limited."""
    return autopilot.axes(replace(boat, acceleration=(1 / dt, 1 / dt)))[0]


@given(share=shares)
def test_boat_that_moves_as_it_should_gets_what_its_drag_takes(share):
    for axis in autopilot.axes(BoatParams()):
        speed = share * axis.full
        drag = (axis.linear + axis.quadratic * abs(speed)) * speed
        assert autopilot.effort(speed, speed, 0.0, axis) == approx(drag)
        assert autopilot.effort(speed, speed, 0.3, axis) == approx(drag + 0.3 * axis.mass)


# ------------------------------------------------------------------ shelter

SHARE = 0.3
PARAMS = make_params("push", 4, water={"shelter": SHARE})
COVER = shelter.cover(PARAMS)
BOW = PARAMS.vessel.width / 2 + PARAMS.boat.length / 2
"""Distance from the vessel's middle of a boat whose bow touches its long side."""


def factors_of(*boats):
    """Factors (B, 2) on surge and sway drag of the vessel and boats (x, y, heading)."""
    found = np.ones((1 + len(boats), 2))
    shelter.shelter(COVER, bodies((), *boats), found)
    return found


@pytest.mark.parametrize(
    ("gap", "left"), [(0.0, 1.0), (0.25, 0.75), (0.5, 0.5), (1.0, 0.0), (2, 0)]
)
def test_shelter_of_a_boat_that_points_at_the_vessel_falls_with_the_gap(gap, left):
    """The gap is in widths of the boat."""
    found = factors_of((0.0, BOW + gap * PARAMS.boat.width, DOWN))
    np.testing.assert_allclose(found[1], (1 - SHARE * left, 1.0), atol=1e-12)
    covered = left * PARAMS.boat.width / PARAMS.vessel.length
    np.testing.assert_allclose(found[0], (1.0, 1 - SHARE * covered), atol=1e-12)


def test_shelter_of_a_boat_that_lies_alongside_is_in_sway():
    y = (PARAMS.vessel.width + PARAMS.boat.width) / 2
    found = factors_of((0.0, -y, 0.0))
    np.testing.assert_allclose(found[1], (1.0, 1 - SHARE), atol=1e-12)
    covered = PARAMS.boat.length / PARAMS.vessel.length
    np.testing.assert_allclose(found[0], (1.0, 1 - SHARE * covered), atol=1e-12)


def test_boats_at_both_ends_hide_no_more_than_all_of_them():
    x, half = (PARAMS.vessel.length + PARAMS.boat.length) / 2, PARAMS.boat.width / 2
    assert factors_of((x, 0, math.pi))[0].tolist() == approx(
        [1 - SHARE * PARAMS.boat.width / PARAMS.vessel.width, 1.0]
    )
    many = [(s * x, y, math.pi * (s > 0)) for s in (1, -1) for y in (-half, half)]
    assert factors_of(*many)[0].tolist() == approx([1 - SHARE, 1.0])


poses = st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.floats(-7, 7))


@given(vessel=poses, boats=st.lists(poses, min_size=2, max_size=6), share=st.floats(0, 0.95))
def test_shelter_takes_no_more_than_its_share_and_gives_nothing(vessel, boats, share):
    found = np.full((1 + len(boats), 2), np.nan)
    shelter.shelter(COVER._replace(share=share), bodies(vessel, *boats), found)
    assert (found >= 1 - share - 1e-12).all()
    assert (found <= 1).all()
    turned = np.array(bodies(vessel, *boats))
    turned[:, :2] = turned[:, 1::-1] * (-1, 1)
    turned[:, 2] += math.pi / 2
    again = np.ones_like(found)
    shelter.shelter(COVER._replace(share=share), turned, again)
    np.testing.assert_allclose(again, found, atol=1e-6)
