"""Drag against closed forms. Bounds are 1 % unless a law is exact."""

import functools
from dataclasses import replace

import numpy as np
import pytest
from helpers import (
    AHEAD,
    BOAT,
    DOWN,
    OFF,
    VESSEL,
    World,
    bodies,
    open_water,
    terminal,
    turned,
)
from hypothesis import given
from hypothesis import strategies as st

from asv_env.params import BoatParams, VesselParams
from asv_env.physics import water

approx = pytest.approx
AXES = ("surge", "sway", "yaw")
LAWS = ("linear", "quadratic", "both")
COASTING = 15.0
"""Seconds."""
PUSHED = {"linear": 30, "quadratic": 20, "both": 20}
"""Seconds; a hull that is pushed turns away after a while, by the Munk moment."""


def under_law(law, hull):
    """The hull's overrides that leave one term of its drag; ``both`` leaves the two."""
    keep = {"linear": (1, 0), "quadratic": (0, 1), "both": (1, 1)}[law]
    drag = {axis: tuple(np.multiply(getattr(hull, axis), keep).tolist()) for axis in AXES}
    if isinstance(hull, VesselParams):
        drag["fins"] = hull.fins * keep[1]
    return drag


def law_params(law, **options):
    hulls = {"boat": under_law(law, BoatParams()), "vessel": under_law(law, VesselParams())}
    return open_water(**{**hulls, **options})


def drag_of(hull, axis):
    """Linear and quadratic coefficient along an axis."""
    return getattr(hull, axis)


def resisted(hull, axis):
    """Effective mass or inertia that moves along an axis."""
    return hull.masses[AXES.index(axis)]


def coasting_distance(mass, linear, quadratic, speed, seconds):
    """Distance made in a time from a speed under m v' = -(linear + quadratic v) v."""
    if quadratic == 0:
        return speed * mass / linear * -np.expm1(-linear / mass * seconds)
    if linear == 0:
        return mass / quadratic * np.log1p(quadratic * speed * seconds / mass)
    reach = 1 + quadratic * speed / linear * -np.expm1(-linear / mass * seconds)
    return mass / quadratic * np.log(reach)


def coasting_time(mass, linear, quadratic, speed, share):
    """Time in which the speed falls to a share of what it was."""
    end = share * speed
    if linear == 0:
        return mass / quadratic * (1 / end - 1 / speed)
    ratio = speed * (linear + quadratic * end) / (end * (linear + quadratic * speed))
    return mass / linear * np.log(ratio)


@functools.cache
def coasting(law, axis):
    """Params, initial speed, and distance and speed (T, 2) of vessel and boat, motors off."""
    params = law_params(law, rate=200)
    speed = 0.5 if axis == "yaw" else 0.1
    start = bodies((), (1.5, 0), (-2, 0))
    start[:2, 3 + AXES.index(axis)] = speed
    motions = World(params, start).record(COASTING)
    column = AXES.index(axis)
    return params, speed, motions[:, :2, column] - start[:2, column], motions[:, :2, 3 + column]


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("body", [VESSEL, BOAT], ids=["vessel", "boat"])
def test_hull_coasts_as_far_as_the_closed_form(law, axis, body):
    params, speed, distance, _ = coasting(law, axis)
    hull = params.hulls()[body]
    expected = coasting_distance(resisted(hull, axis), *drag_of(hull, axis), speed, COASTING)
    assert distance[-1, body] == approx(expected, rel=0.01)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("body", [VESSEL, BOAT], ids=["vessel", "boat"])
def test_hull_halves_its_speed_in_the_time_of_the_closed_form(law, axis, body):
    params, speed, _, speeds = coasting(law, axis)
    hull = params.hulls()[body]
    expected = coasting_time(resisted(hull, axis), *drag_of(hull, axis), speed, share=0.5)
    seconds = np.arange(len(speeds)) / params.clock.control
    assert np.interp(-speed / 2, -speeds[:, body], seconds) == approx(expected, rel=0.01)


def test_quadratic_drag_is_exact_in_time():
    params, speed, _, speeds = coasting("quadratic", "surge")
    mass, quadratic = params.boat.masses[0], params.boat.surge[1]
    seconds = np.arange(len(speeds)) / params.clock.control
    expected = speed / (1 + quadratic * speed * seconds / mass)
    np.testing.assert_allclose(speeds[:, BOAT], expected, rtol=1e-9)


@pytest.mark.parametrize("law", LAWS)
def test_boat_reaches_its_terminal_speed(law):
    params = law_params(law, control=1)
    motion = World(params, bodies((), (0, 2), (0, -2))).run(80, [AHEAD, OFF])
    expected = terminal(2 * params.boat.thrust, *params.boat.surge)
    assert motion[BOAT, 3] == approx(expected, rel=1e-4)


def test_nominal_boat_makes_23_centimetres_a_second():
    motion = World(open_water(control=1), bodies((), (0, 2), (0, -2))).run(40, [AHEAD, OFF])
    assert motion[BOAT, 3] == approx(0.23, abs=0.005)


@pytest.mark.parametrize("law", LAWS)
def test_boat_spins_at_its_terminal_rate(law):
    params = law_params(law, control=1)
    astern = -0.5 / params.boat.astern
    motion = World(params, bodies((), (0, 2), (0, -2))).run(40, [(astern, 0.5), OFF])
    moment = params.boat.lever_arm * params.boat.thrust
    assert motion[BOAT, 5] == approx(terminal(moment, *params.boat.yaw), rel=1e-4)
    assert np.hypot(*motion[BOAT, 3:5]) < 1e-6


@pytest.mark.parametrize("law", LAWS)
def test_vessel_reaches_its_terminal_speed_sideways(law):
    params = law_params(law, control=1)
    pushers = [(x, 0.135, DOWN) for x in (-0.08, 0.08)]
    motion = World(params, bodies((), *pushers)).run(PUSHED[law], AHEAD)
    drag = np.add(drag_of(params.hulls()[VESSEL], "sway"), np.multiply(2, params.boat.surge))
    assert -motion[VESSEL, 4] == approx(terminal(4 * params.boat.thrust, *drag), rel=0.01)


@pytest.mark.parametrize("kind", ["round", "nominal"])
@pytest.mark.parametrize("law", LAWS)
def test_vessel_reaches_its_terminal_speed_lengthwise(law, kind):
    """Contacts see the mass in sway; where that in surge differs, so does the weight of drag."""
    hull = VesselParams(**under_law(law, VesselParams()))
    if kind == "round":
        surge, sway, _ = hull.with_fins().masses
        hull = replace(hull, added_mass=(hull.added_mass[0], hull.added_mass[1] + surge - sway))
    params = law_params(law, control=1, vessel=vars(hull))
    vessel = params.hulls()[VESSEL]
    weight = vessel.contact_mass / vessel.masses[0]
    assert (weight == approx(1)) is (kind == "round")
    drag = np.add(np.multiply(weight, drag_of(vessel, "surge")), np.multiply(2, params.boat.surge))
    expected = terminal(4 * params.boat.thrust, *drag)
    ahead = (0, 0.9 * expected)
    pushers = [(-0.26, y, *ahead) for y in (-0.037, 0.037)]
    motion = World(params, bodies((0, 0, *ahead), *pushers)).run(PUSHED[law], AHEAD)
    assert motion[VESSEL, 3] == approx(expected, rel=0.01)


@given(
    speed=st.one_of(st.floats(1e-9, 5), st.floats(-5, -1e-9)),
    linear=st.floats(1e-6, 1e3),
    quadratic=st.floats(0, 1e3),
    dt_per_mass=st.floats(1e-6, 1e4),
)
def test_terminal_speed_is_kept_whatever_the_step(speed, linear, quadratic, dt_per_mass):
    push = (linear + quadratic * abs(speed)) * speed
    softened = water.softening(dt_per_mass * linear)
    after = water.damped(speed, push, dt_per_mass, linear, quadratic, softened)
    assert abs(after - speed) <= 1e-12 * abs(speed)


@given(
    speed=st.floats(-1e3, 1e3),
    linear=st.floats(0, 1e9),
    quadratic=st.floats(0, 1e9),
    dt_per_mass=st.floats(0, 1e6),
)
def test_drag_alone_never_reverses_nor_speeds_up_a_motion(speed, linear, quadratic, dt_per_mass):
    softened = water.softening(dt_per_mass * linear)
    after = water.damped(speed, 0.0, dt_per_mass, linear, quadratic, softened)
    assert 0.0 <= after / (speed or 1.0) <= 1.0


def test_enormous_drag_stops_a_hull_and_leaves_it_where_it_is():
    thick = dict.fromkeys(AXES, (1e6, 1e6))
    params = open_water(boat=thick, vessel=thick)
    start = bodies((0, 0, 0.3, 0.1, 0.2, 0.5), (1, 0, 0, 0.2), (-1, 0, 2, 0, 0.2, -1))
    motions = World(params, start).record(2, AHEAD)
    assert np.abs(motions[2:, :, 3:]).max() < 1e-5
    assert np.abs(motions[-1, :, :2] - start[:, :2]).max() < 0.01


def test_drag_acts_along_the_axes_of_the_hull():
    params = open_water(control=1)
    straight = World(params, bodies((), (1, 0, 0, 0.1, 0.05), (-1,))).run(3)
    askew = World(params, turned(bodies((), (1, 0, 0, 0.1, 0.05), (-1,)), 0.7)).run(3)
    np.testing.assert_allclose(askew, turned(straight, 0.7), atol=1e-12)


def test_linear_preset_of_the_drag_agrees_with_the_full_one_at_its_speed():
    full, linear = (open_water(water={"drag": drag}) for drag in ("quadratic", "linear"))
    for hull, damped in zip(full.hulls(), linear.hulls(), strict=True):
        for axis, speed in zip(AXES, (0.1, 0.1, 0.5), strict=True):
            a, b = getattr(hull, axis)
            assert getattr(damped, axis) == approx((a + b * speed, 0.0))


def test_two_pushers_bring_the_vessel_to_ten_centimetres_a_second():
    pushers = [(x, 0.135, DOWN) for x in (-0.067, 0.067)]
    motion = World(open_water(control=1), bodies((), *pushers)).run(40, AHEAD)
    assert -motion[VESSEL, 4] == approx(0.10, abs=0.005)


def test_vessel_comes_to_rest_from_4_centimetres_a_second_in_20_centimetres():
    start = bodies((0, 0, 0, 0, -0.04), (2, 2), (-2, 2))
    motion = World(open_water(control=1), start).run(60)
    assert -motion[VESSEL, 1] == approx(0.20, rel=0.02)
    assert np.abs(motion[VESSEL, 3:]).max() < 1e-3
