"""The physics against closed forms. Bounds are 1 % unless a law is exact."""

import functools
from dataclasses import replace

import numpy as np
import pytest
from helpers import (
    DOWN,
    NO_DRAG,
    NO_VESSEL_DRAG,
    World,
    actions,
    begin_at,
    bodies,
    kinetic_energy,
    masses,
    momentum,
    open_water,
    turned,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import fsolve

from asv_env import geometry, make_params
from asv_env.params import BoatParams, VesselParams
from asv_env.physics import water
from asv_env.simulation import Simulation

approx = pytest.approx
AXES = ("surge", "sway", "yaw")
LAWS = ("linear", "quadratic", "both")
AHEAD, OFF = (1.0, 1.0), (0.0, 0.0)
VESSEL, BOAT = 0, 1
COASTING = 15.0


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
    """Linear and quadratic coefficient along an axis, fins counted."""
    linear, quadratic = getattr(hull, axis)
    return linear, quadratic + (getattr(hull, "fins", 0.0) if axis == "surge" else 0.0)


def resisted(hull, axis):
    """Effective mass or inertia that moves along an axis."""
    return hull.total_inertia if axis == "yaw" else hull.total_mass


def terminal(force, linear, quadratic):
    """Speed at which (linear + quadratic v) v balances a force."""
    if quadratic == 0:
        return force / linear
    return (np.sqrt(linear**2 + 4 * quadratic * force) - linear) / (2 * quadratic)


def coasting_distance(mass, linear, quadratic, speed, seconds):
    """Way made in a time from a speed under m v' = -(linear + quadratic v) v."""
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
    """Params, initial speed, and way and speed (T, 2) of vessel and boat, motors off."""
    params = law_params(law)
    speed = 0.5 if axis == "yaw" else 0.1
    start = bodies((), (1.5, 0), (-2, 0))
    start[:2, 3 + AXES.index(axis)] = speed
    motions = World(params, start).record(COASTING)
    column = AXES.index(axis)
    return params, speed, motions[:, :2, column] - start[:2, column], motions[:, :2, 3 + column]


# ------------------------------------------------------------------ drag


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("body", [VESSEL, BOAT], ids=["vessel", "boat"])
def test_hull_coasts_as_far_as_the_closed_form(law, axis, body):
    params, speed, way, _ = coasting(law, axis)
    hull = (params.vessel, params.boat)[body]
    expected = coasting_distance(resisted(hull, axis), *drag_of(hull, axis), speed, COASTING)
    assert way[-1, body] == approx(expected, rel=0.01)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("body", [VESSEL, BOAT], ids=["vessel", "boat"])
def test_hull_halves_its_speed_in_the_time_of_the_closed_form(law, axis, body):
    params, speed, _, speeds = coasting(law, axis)
    hull = (params.vessel, params.boat)[body]
    expected = coasting_time(resisted(hull, axis), *drag_of(hull, axis), speed, share=0.5)
    seconds = np.arange(len(speeds)) / params.clock.control
    assert np.interp(-speed / 2, -speeds[:, body], seconds) == approx(expected, rel=0.01)


def test_quadratic_drag_is_exact_in_time():
    params, speed, _, speeds = coasting("quadratic", "surge")
    mass, quadratic = params.boat.total_mass, params.boat.surge[1]
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
    motion = World(params, bodies((), *pushers)).run(60, AHEAD)
    drag = np.add(drag_of(params.vessel, "sway"), np.multiply(2, params.boat.surge))
    assert -motion[VESSEL, 4] == approx(terminal(4 * params.boat.thrust, *drag), rel=0.01)


@pytest.mark.parametrize("law", LAWS)
def test_vessel_reaches_its_terminal_speed_lengthwise(law):
    params = law_params(law, control=1)
    pushers = [(-0.26, y, 0) for y in (-0.037, 0.037)]
    motion = World(params, bodies((), *pushers)).run(60, AHEAD)
    drag = np.add(drag_of(params.vessel, "surge"), np.multiply(2, params.boat.surge))
    assert motion[VESSEL, 3] == approx(terminal(4 * params.boat.thrust, *drag), rel=0.01)


@given(
    speed=st.floats(-5, 5),
    linear=st.floats(1e-6, 1e3),
    quadratic=st.floats(0, 1e3),
    dt_per_mass=st.floats(1e-6, 1e4),
)
def test_terminal_speed_is_kept_whatever_the_step(speed, linear, quadratic, dt_per_mass):
    push = (linear + quadratic * abs(speed)) * speed
    softened = water.softening(np.array(linear), np.array(dt_per_mass))
    given = (np.full(3, value) for value in (push, speed, linear, quadratic, dt_per_mass, softened))
    assert np.abs(water.damped(*given) * dt_per_mass).max() <= 1e-12 * abs(speed)


@given(
    speed=st.floats(-1e3, 1e3),
    linear=st.floats(0, 1e9),
    quadratic=st.floats(0, 1e9),
    dt_per_mass=st.floats(0, 1e6),
)
def test_drag_alone_never_reverses_nor_speeds_up_a_motion(speed, linear, quadratic, dt_per_mass):
    softened = water.softening(np.array(linear), np.array(dt_per_mass))
    given = (np.full(3, value) for value in (0.0, speed, linear, quadratic, dt_per_mass, softened))
    share = (speed + dt_per_mass * water.damped(*given)) / (speed or 1.0)
    assert np.all(share >= -1e-15)
    assert np.all(share <= 1.0)


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


# ------------------------------------------------------------------ motors


@pytest.mark.parametrize(("left", "right"), [(1.0, 0.0), (1.0, 0.5), (-0.5, 1.0)])
def test_differential_thrust_gives_the_steady_turn_of_the_equations(left, right):
    params = open_water(control=1)
    boat = params.boat
    motion = World(params, bodies((), (0, 2), (0, -2))).run(40, [(left, right), OFF])[BOAT]
    port, starboard = (boat.thrust * (c if c > 0 else boat.astern * c) for c in (left, right))

    def balance(velocity):
        u, v, r = velocity
        resist = [(a + b * abs(s)) * s for (a, b), s in zip(drags, velocity, strict=True)]
        return (
            port + starboard + boat.total_mass * r * v - resist[0],
            -boat.total_mass * r * u - resist[1],
            boat.lever_arm * (starboard - port) - resist[2],
        )

    drags = [getattr(boat, axis) for axis in AXES]
    u, v, r = fsolve(balance, [0.1, 0.0, np.sign(right - left)])
    assert motion[5] == approx(r, rel=1e-4)
    assert np.hypot(*motion[3:5]) == approx(np.hypot(u, v), rel=0.01)


@pytest.mark.parametrize("lag", [0.05, 0.1, 0.3])
def test_thrust_follows_a_step_with_its_lag(lag):
    world = World(open_water(), bodies((), (0, 2), (0, -2)), lag=lag)
    thrust = []
    for _ in range(25):
        world.step([AHEAD, OFF])
        thrust.append(world.thrust[0, 0])
    seconds = np.arange(1, 26) * world.params.clock.dt
    np.testing.assert_allclose(thrust, 0.010 * -np.expm1(-seconds / lag), rtol=1e-9)


@pytest.mark.parametrize(
    ("command", "thrust"),
    [(1.0, 0.010), (0.5, 0.005), (0.0, 0.0), (-0.5, -0.003), (-1.0, -0.006), (7.0, 0.010)],
)
def test_thrust_is_linear_in_the_command_and_weaker_astern(command, thrust):
    world = World(open_water(control=1), bodies((), (0, 2), (0, -2)))
    world.run(5, command)
    np.testing.assert_allclose(world.thrust, thrust, atol=1e-12)


@pytest.mark.parametrize("mode", ["thrusters", "tracking"])
def test_thrust_saturates_whatever_is_asked(mode):
    world = World(open_water(control=10, action_mode=mode), bodies((), (0, 2), (0, -2)))
    rng = np.random.default_rng(0)
    thrusts = []
    for _ in range(200):
        world.step(np.sign(rng.uniform(-1, 1, (2, 2))))
        thrusts.append(world.thrust.copy())
    assert np.max(thrusts) <= 0.010
    assert np.min(thrusts) >= -0.006
    assert np.max(thrusts) > 0.009


def test_gain_of_a_motor_scales_its_thrust():
    gain = np.array([[1.1, 0.9], [1.0, 1.0]])
    world = World(open_water(control=1), bodies((), (0, 2), (0, -2)), thrust_gain=gain)
    world.run(5, AHEAD)
    np.testing.assert_allclose(world.thrust, 0.010 * gain, rtol=1e-9)


@pytest.mark.parametrize(
    ("action", "column", "expected"),
    [((0.5, 0), 3, 0.1), ((-0.3, 0), 3, -0.06), ((0, 0.4), 5, 0.48), ((0, -1), 5, -1.2)],
)
def test_tracking_reaches_the_speed_and_the_yaw_rate_asked_for(action, column, expected):
    world = World(open_water(control=1, action_mode="tracking"), bodies((), (0, 2), (0, -2)))
    assert world.run(10, [action, OFF])[BOAT, column] == approx(expected, rel=0.01)


# ------------------------------------------------------------------ currents


def current_water(kind, speed=0.05, **fields):
    return {"current": kind, "current_speed": speed, **fields}


def test_free_hulls_drift_with_a_uniform_current():
    params = open_water(control=1, water=current_water("uniform", current_heading=0.6))
    start = bodies((0, 0, 1), (0, 3, -2), (0, -3, 0.2, 0.1, 0.2, 0.4))
    motion = World(params, start).run(90)
    expected = 0.05 * np.array([np.cos(0.6), np.sin(0.6)])
    np.testing.assert_allclose(motion[:, 3:5], np.tile(expected, (3, 1)), atol=0.01 * 0.05)


def test_pushing_looks_the_same_from_a_raft_that_drifts_along():
    start = bodies((), (-0.08, 0.14, DOWN), (0.05, 0.14, DOWN))
    drifting = start.copy()
    drifting[:, 3] += 0.05
    push = [(0.9, 0.7), (0.6, 0.8)]
    still = World(open_water(control=1), start).run(6, push)
    moved = World(open_water(control=1, water=current_water("uniform")), drifting).run(6, push)
    moved[:, 0] -= 0.05 * 6
    moved[:, 3] -= 0.05
    np.testing.assert_allclose(moved, still, atol=1e-6)


def test_current_pulls_a_hull_at_rest_as_the_drag_of_its_relative_motion():
    params = open_water(rate=1000, control=100, water=current_water("uniform"))
    motion = World(params, bodies((), (0, 2), (0, -2))).run(0.02)
    pull = 0.05 * (params.boat.surge[0] + 0.05 * params.boat.surge[1])
    assert motion[BOAT, 3] == approx(0.02 * pull / params.boat.total_mass, rel=0.01)


def flow_of(kind, points):
    return Simulation(open_water(water=current_water(kind, gyre_size=1.2))).current(points)


@pytest.mark.parametrize("kind", ["gyre", "double_gyre"])
def test_gyres_are_free_of_divergence(kind):
    points = np.random.default_rng(0).uniform(-3, 3, (500, 2))
    h = 1e-5
    dx, dy = np.array([h, 0]), np.array([0, h])
    across = (flow_of(kind, points + dx) - flow_of(kind, points - dx))[:, 0]
    along = (flow_of(kind, points + dy) - flow_of(kind, points - dy))[:, 1]
    assert np.abs(across + along).max() / (2 * h) < 1e-8
    assert np.abs(across).max() / (2 * h) > 0.05


@pytest.mark.parametrize("kind", ["gyre", "double_gyre"])
def test_gyres_peak_at_the_speed_asked_for(kind):
    axis = np.linspace(-1.2, 1.2, 241)
    flow = flow_of(kind, np.stack(np.meshgrid(axis, axis), axis=-1))
    assert np.hypot(flow[..., 0], flow[..., 1]).max() == approx(0.05, rel=1e-9)


@pytest.mark.parametrize(("kind", "edge"), [("gyre", 0.6), ("double_gyre", 0.0)])
def test_nothing_flows_out_of_a_gyre(kind, edge):
    along = np.linspace(-0.6, 0.6, 50)
    side = flow_of(kind, np.stack([np.full(50, edge), along], axis=-1))
    ends = flow_of(kind, np.stack([along, np.full(50, 0.6)], axis=-1))
    assert np.abs(side[:, 0]).max() < 1e-12
    assert np.abs(ends[:, 1]).max() < 1e-12


def test_single_gyre_turns_round_the_origin_and_double_gyre_jets_through_it():
    ring = 0.3 * np.stack([np.cos(np.arange(8)), np.sin(np.arange(8))], axis=-1)
    flow = flow_of("gyre", ring)
    moments = ring[:, 0] * flow[:, 1] - ring[:, 1] * flow[:, 0]
    assert np.all(moments < 0) or np.all(moments > 0)
    np.testing.assert_allclose(flow_of("double_gyre", np.zeros(2)), [0, 0.05], atol=1e-12)


def test_hull_at_the_eye_of_a_gyre_stays_there():
    params = open_water(control=1, water=current_water("gyre"))
    motion = World(params, bodies((), (0, 2), (0, -2))).run(20)
    assert np.abs(motion[VESSEL, :2]).max() < 1e-9


# ------------------------------------------------------------------ contact


def dragless(**options):
    return open_water(**{"boat": NO_DRAG, "vessel": NO_VESSEL_DRAG, **options})


def test_boat_that_rams_the_vessel_shares_its_momentum_and_does_not_bounce():
    params = dragless()
    motion = World(params, bodies((), (0, 0.2, DOWN, 0, -0.2), (-2,))).run(3)
    mass = masses(params)[0]
    together = -0.2 * mass[BOAT] / (mass[BOAT] + mass[VESSEL])
    assert motion[VESSEL, 4] == approx(together, rel=0.01)
    assert abs(motion[BOAT, 4] - motion[VESSEL, 4]) < 0.01 * 0.2


def test_collision_gives_the_vessel_what_it_takes_from_the_boat():
    params = dragless()
    motions = World(params, bodies((), (0.1, 0.2, DOWN + 0.3, 0, -0.2), (-2,))).record(2)
    boat, vessel = (
        masses(params)[0][row] * (motions[:, row, 3:5] - motions[0, row, 3:5])
        for row in (BOAT, VESSEL)
    )
    assert np.abs(vessel).max() > 1e-3
    np.testing.assert_allclose(boat, -vessel, atol=1e-12)


def test_off_centre_collision_keeps_the_angular_momentum():
    params = dragless()
    motions = World(params, bodies((), (0.12, 0.2, DOWN, 0, -0.2), (-2,))).record(2)
    mass, inertia = masses(params)
    x, y, _, vx, vy, spin = np.moveaxis(motions, -1, 0)
    angular = (mass * (x * vy - y * vx) + inertia * spin).sum(axis=-1)
    assert motions[-1, VESSEL, 5] < -0.01
    np.testing.assert_allclose(angular, angular[0], rtol=0.01)


def test_pushing_hands_on_the_impulse_of_the_motors():
    params = dragless()
    world = World(params, bodies((), (-0.08, 0.135, DOWN), (0.05, 0.135, DOWN)))
    impulse = np.zeros(2)
    for _ in range(100):
        heading = world.motion[1:, 2]
        world.step([(1.0, 0.8), (0.7, 0.9)])
        ahead = np.stack([np.cos(heading), np.sin(heading)], axis=-1)
        impulse += params.clock.dt * (world.thrust.sum(axis=-1)[:, None] * ahead).sum(axis=0)
    np.testing.assert_allclose(momentum(params, world.motion), impulse, atol=1e-12)
    assert world.motion[VESSEL, 4] < -0.05


speeds = st.floats(-0.3, 0.3)
spins = st.floats(-2, 2)
motions = st.tuples(speeds, speeds, spins)


@settings(max_examples=40)
@given(vessel=motions, boats=st.tuples(motions, motions, motions), friction=st.floats(0, 1))
@pytest.mark.parametrize("drag", [True, False])
def test_motors_off_energy_never_grows_in_contact(drag, vessel, boats, friction):
    options = {"num_boats": 3, "water": {"contact_friction": friction}}
    params = open_water(**options) if drag else dragless(**options)
    places = ((-0.06, 0.135, DOWN), (0.01, 0.135, DOWN), (0.08, 0.135, DOWN))
    start = bodies(
        (0, 0, 0, *vessel), *(place + boat for place, boat in zip(places, boats, strict=True))
    )
    energy = kinetic_energy(params, World(params, start).record(0.6))
    assert np.all(np.diff(energy) <= 1e-12 * energy[0])
    assert energy[-1] <= energy[0] * (1 + 1e-12)


@settings(max_examples=15)
@given(vessel=motions, boats=st.tuples(motions, motions))
def test_momentum_is_kept_without_drag_whatever_the_hulls_do_to_each_other(vessel, boats):
    params = dragless()
    places = ((-0.05, 0.135, DOWN), (0.05, 0.135, DOWN))
    start = bodies(
        (0, 0, 0, *vessel), *(place + boat for place, boat in zip(places, boats, strict=True))
    )
    total = momentum(params, World(params, start).record(0.6))
    np.testing.assert_allclose(total, np.broadcast_to(total[0], total.shape), atol=1e-12)


HEAVY = {"mass": 1e6, "inertia": 1e6}


def sliding_friction(params, start):
    """Friction coefficient with which a boat that is pressed down slows down in sliding."""
    world = World(params, start)
    pressed = 0.0
    for _ in range(50):
        world.step([AHEAD, OFF])
        pressed += params.clock.dt * world.thrust[0].sum()
    assert world.motion[BOAT, 3] > 0.005
    return params.boat.total_mass * (start[BOAT, 3] - world.motion[BOAT, 3]) / pressed


@pytest.mark.parametrize("friction", [0.1, 0.3, 0.6])
def test_friction_between_hulls_is_what_was_asked_for(friction):
    params = dragless(
        boat={**NO_DRAG, "added_inertia": 1e6},
        vessel={**NO_VESSEL_DRAG, **HEAVY},
        water={"contact_friction": friction},
    )
    start = bodies((), (-0.15, 0.135, DOWN, 0.1), (-2,))
    assert sliding_friction(params, start) == approx(friction, rel=0.01)


@pytest.mark.parametrize("friction", [0.1, 0.3, 0.6])
def test_friction_against_a_wall_is_what_was_asked_for(friction):
    params = dragless(
        arena=1.5,
        goal=(1, 1, 0),
        boat={**NO_DRAG, "added_inertia": 1e6},
        water={"walls": 1.5, "contact_friction": friction},
    )
    start = bodies((), (-0.15, -1.44, DOWN, 0.1), (-1,))
    assert sliding_friction(params, start) == approx(friction, rel=0.01)


def test_drawn_friction_is_the_one_that_acts():
    params = dragless(variation={"friction": (0.5, 0.5)})
    assert params.water.contact_friction == 0.3
    boat, vessel = {**NO_DRAG, "added_inertia": 1e6}, {**NO_VESSEL_DRAG, **HEAVY}
    params = dragless(boat=boat, vessel=vessel, variation={"friction": (0.5, 0.5)})
    start = bodies((), (-0.15, 0.135, DOWN, 0.1), (-2,))
    assert sliding_friction(params, start) == approx(0.5, rel=0.01)


def test_hulls_touch_where_their_outlines_meet():
    """Bow on the long side, flank on the end, stern on the long side: 1 mm off, 0.1 mm in."""
    params = open_water(num_boats=3)
    reach = np.array([0.135, 0.2325, -0.135])
    for gap, touching in ((1e-3, False), (-1e-4, True)):
        x, y, z = reach + gap * np.sign(reach)
        start = bodies((), (0, y * 0 + x, DOWN), (y, 0, DOWN), (0.05, z, DOWN))
        world = World(params, start)
        world.step()
        assert world.sim.state.touching[0, :, 0].tolist() == [touching] * 3
        assert not world.sim.state.touching[0, :, 1].any()


def test_boats_that_touch_each_other_say_so_and_not_the_vessel():
    world = World(open_water(3), bodies((), (1, 0), (1, 0.064), (-1, 0)))
    world.step()
    assert world.sim.state.touching[0].tolist() == [[False, True], [False, True], [False, False]]


# ------------------------------------------------------------------ mass and shape


@pytest.mark.parametrize(
    ("hull", "size", "mass", "inertia"),
    [
        (BoatParams(), (0.12, 0.065), (0.10, 0.02), (1.55e-4, 0.66e-4)),
        (VesselParams(), (0.40, 0.15), (0.60, 0.08), (9.1e-3, 0.8e-3)),
    ],
    ids=["boat", "vessel"],
)
def test_hulls_are_those_of_the_design(hull, size, mass, inertia):
    assert (hull.length, hull.width) == size
    assert (hull.mass, hull.added_mass) == mass
    assert (hull.inertia, hull.added_inertia) == inertia
    assert hull.total_mass == approx(sum(mass))
    assert hull.total_inertia == approx(sum(inertia))


def test_drag_and_thrust_are_those_of_the_design():
    vessel, boat = make_params().hulls()
    assert (boat.surge, boat.sway, boat.yaw) == ((0.03, 0.25), (0.08, 0.67), (1e-4, 3.6e-5))
    assert vessel.surge == approx((0.20, 4.35))
    assert (vessel.sway, vessel.yaw) == ((0.10, 2.0), (1.5e-3, 4e-3))
    assert (boat.thrust, boat.astern, boat.lever_arm, boat.lag) == (0.010, 0.6, 0.02, 0.1)
    assert make_params().water.contact_friction == 0.3


def quadrature(outline):
    """Area and mean square distance from the origin of a convex polygon, by thin slices."""
    x = np.linspace(-0.5, 0.5, 20001)
    x = 0.5 * (x[1:] + x[:-1]) * 2 * max(abs(p[0]) for p in outline)
    corners = sorted((px, abs(py)) for px, py in outline)
    half = np.interp(x, [c[0] for c in corners], [c[1] for c in corners])
    area, second = 2 * half, 2 * half * x**2 + 2 * half**3 / 3
    return area.sum() * (x[1] - x[0]), second.sum() / area.sum()


@pytest.mark.parametrize("hull", [BoatParams(), VesselParams(), BoatParams(length=0.2, bow=0.04)])
def test_moment_of_inertia_follows_from_the_outline_unless_given(hull):
    area, gyration = quadrature(hull.outline)
    assert geometry.polygon_gyration(hull.outline) == approx(gyration, rel=1e-5)
    uniform = replace(hull, inertia=None)
    assert uniform.total_inertia - uniform.added_inertia == approx(hull.mass * gyration, rel=1e-5)
    assert 0 < area <= hull.length * hull.width * (1 + 1e-9)


@pytest.mark.parametrize("hull", [BoatParams(), VesselParams()], ids=["boat", "vessel"])
def test_outline_is_convex_and_fills_its_length_and_width(hull):
    corners = np.array(hull.outline)
    edges = np.roll(corners, -1, axis=0) - corners
    following = np.roll(edges, -1, axis=0)
    assert np.all(edges[:, 0] * following[:, 1] - edges[:, 1] * following[:, 0] >= 0)
    np.testing.assert_allclose(np.ptp(corners, axis=0), [hull.length, hull.width])


def test_boat_has_a_flat_bow_of_two_centimetres_ahead():
    corners = np.array(BoatParams().outline)
    bow = corners[corners[:, 0] > 0.06 - 1e-9]
    assert sorted(bow[:, 1]) == approx([-0.01, 0.01])


def test_vessel_given_nothing_about_its_inertia_has_nearly_that_of_a_plank():
    assert VesselParams(inertia=None).total_inertia == approx(
        VesselParams().total_inertia, rel=0.01
    )


def test_motors_accelerate_the_effective_mass_and_inertia():
    params = dragless()
    motions = World(params, bodies((), (0, 2), (0, -2)), lag=1e-6).record(1, [AHEAD, (0, 1)])
    ahead, turning = motions[-1, 1], motions[-1, 2]
    assert ahead[3] == approx(0.02 / 0.12, rel=1e-6)
    assert turning[5] == approx(0.02 * 0.010 / 2.21e-4, rel=1e-6)


def test_drawn_mass_and_drag_scale_the_hull():
    gains = {"mass_gain": np.array([1, 1.2, 1]), "drag_gain": np.array([1, 1, 1.3])}
    params = dragless()
    for column, action in ((3, AHEAD), (5, (0.0, 1.0))):
        start = bodies((), (0, 2), (0, -2))
        light, heavy = World(params, start, lag=1e-6, **gains).run(0.02, action)[[2, 1], column]
        assert light / heavy == approx(1.2, rel=1e-6)
    params = open_water(control=1)
    dragged = World(params, bodies((), (0, 2), (0, -2)), **gains).run(60, AHEAD)
    linear, quadratic = np.multiply(1.3, params.boat.surge)
    assert dragged[2, 3] == approx(terminal(0.02, linear, quadratic), rel=1e-4)


# ------------------------------------------------------------------ calibration


def test_two_pushers_bring_the_vessel_to_ten_centimetres_a_second():
    pushers = [(x, 0.135, DOWN) for x in (-0.067, 0.067)]
    motion = World(open_water(control=1), bodies((), *pushers)).run(40, AHEAD)
    assert -motion[VESSEL, 4] == approx(0.10, abs=0.005)


def test_vessel_comes_to_rest_from_4_centimetres_a_second_in_20_centimetres():
    start = bodies((0, 0, 0, 0, -0.04), (2, 2), (-2, 2))
    motion = World(open_water(control=1), start).run(60)
    assert -motion[VESSEL, 1] == approx(0.20, rel=0.02)
    assert np.abs(motion[VESSEL, 3:]).max() < 1e-3


# ------------------------------------------------------------------ the numerical scheme


def pushed(rate, push, gap=0.0, seconds=5):
    y = 0.135 + gap
    start = bodies((), (-0.08, y, DOWN), (0.08, y, DOWN))
    return World(open_water(rate=rate, control=1), start).run(seconds, push)[VESSEL, :3]


@pytest.mark.parametrize("push", [1.0, ((0.9, 0.8), (0.6, 0.7))], ids=["straight", "slipping"])
def test_push_converges_as_the_step_shrinks(push):
    rates = np.array([50, 100, 200, 400])
    reference = pushed(6400, push)
    errors = [np.abs(pushed(rate, push) - reference).max() for rate in rates]
    order = -np.polyfit(np.log(rates), np.log(errors), 1)[0]
    assert order > 0.95
    assert errors[0] < 0.01 * np.abs(reference).max()


def test_first_touch_costs_a_coarse_step_less_than_a_hundredth_of_the_way():
    push = ((0.9, 0.8), (0.6, 0.7))
    reference = pushed(3200, push, gap=1e-3)
    error = np.abs(pushed(50, push, gap=1e-3) - reference).max()
    assert error < 0.01 * np.abs(reference).max()


def test_control_rate_does_not_change_the_physics():
    start = bodies((), (-0.08, 0.136, DOWN), (0.05, 0.136, DOWN))
    often, seldom = (World(open_water(control=hz), start).run(4, (0.9, 0.7)) for hz in (50, 1))
    np.testing.assert_array_equal(often, seldom)


def test_nothing_moves_where_nothing_acts():
    start = bodies((0, 0, 0.4), (1, 0, 2), (0, 1, -3))
    motion = World(open_water(control=1), start).run(30)
    np.testing.assert_allclose(motion, start, rtol=0, atol=1e-15)


def test_headings_stay_wrapped():
    world = World(open_water(control=10), bodies((), (0, 2), (0, -2, 3)))
    headings = [world.step([(-1.0, 1.0), (1.0, -1.0)])[:, 2].copy() for _ in range(300)]
    assert np.max(headings) <= np.pi
    assert np.min(headings) > -np.pi
    assert np.ptp(headings) > 6


# ------------------------------------------------------------------ walls and worlds


@pytest.mark.parametrize("heading", [0.0, 0.7, np.pi / 4, np.pi / 2, np.pi, DOWN])
def test_walls_of_the_tank_hold_a_boat_at_full_thrust(heading):
    params = make_params("transport", 2, preset="tank", action_mode="thrusters", time_limit=1e4)
    world = World(params, bodies((), (1, 0.5, heading), (-1, -0.5, heading + 3)))
    motions = world.record(25, AHEAD)
    assert np.abs(motions[..., :2]).max() < 1.5
    assert not world.sim.ending.strayed.any()
    assert world.sim.state.touching[0, :, 1].all()


def test_walls_of_the_tank_hold_a_vessel_that_is_pushed_against_them():
    params = make_params("push", 2, preset="tank", action_mode="thrusters", goal=(1, 1, 0))
    motion = World(params, bodies((), (-0.07, 0.136, DOWN), (0.07, 0.136, DOWN))).run(30, AHEAD)
    assert motion[VESSEL, 1] == approx(-1.5 + 0.075, abs=0.002)


def worlds_after(params, starts, pushes, worlds_per_space, seconds=4):
    sim = Simulation(params, len(starts), worlds_per_space)
    begin_at(sim, starts)
    for _ in range(round(seconds * params.clock.control)):
        sim.step(actions(sim, np.array(pushes)[:, None, None]))
    return sim.state.motion


def test_what_other_worlds_do_changes_nothing_in_a_world():
    params = open_water(control=10, arena=3.0, goal=(2.5, 2.5, 0))
    start = bodies((), (-0.08, 0.136, DOWN), (0.05, 0.136, DOWN))
    busy = worlds_after(params, [start] * 4, [0.3, 1.0, -0.5, 0.7], worlds_per_space=4)
    idle = worlds_after(params, [start] * 4, [0.0, 1.0, 0.0, 0.0], worlds_per_space=4)
    np.testing.assert_array_equal(busy[1], idle[1])
    assert np.abs(busy[0] - idle[0]).max() > 0.01


def test_hulls_at_the_edges_of_neighbouring_worlds_do_not_touch():
    params = open_water(control=10, arena=3.0, goal=(2.5, 2.5, 0))
    edge = 2.99
    starts = [
        bodies((s * edge, 0, np.pi / 2), (0, s * edge), (s * edge, s * edge))
        for s in (1, -1, 1, -1)
    ]
    after = worlds_after(params, starts, [0.0] * 4, worlds_per_space=4, seconds=1)
    np.testing.assert_allclose(after, starts, atol=1e-12)


def test_world_in_a_space_of_its_own_does_the_same_as_in_a_shared_one():
    params = open_water(control=10, arena=3.0, goal=(2.5, 2.5, 0))
    start = bodies((), (-0.08, 0.136, DOWN), (0.05, 0.136, DOWN))
    pushes = [0.3, 1.0, 0.7]
    alone = worlds_after(params, [start] * 3, pushes, worlds_per_space=1)
    shared = worlds_after(params, [start] * 3, pushes, worlds_per_space=3)
    np.testing.assert_array_equal(alone[0], shared[0])
    np.testing.assert_allclose(alone, shared, atol=1e-9)


def test_world_begun_again_does_what_a_new_one_does():
    params = open_water(control=10)
    start = bodies((), (-0.08, 0.136, DOWN), (0.05, 0.136, DOWN))
    used, fresh = World(params, start), World(params, start)
    used.run(5, (1.0, 0.4))
    begin_at(used.sim, [start])
    np.testing.assert_array_equal(used.run(5, (0.8, 0.9)), fresh.run(5, (0.8, 0.9)))
