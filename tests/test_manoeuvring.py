"""The manoeuvring model in the water: closed forms, and an independent integration of it."""

from dataclasses import replace

import numpy as np
import pytest
from helpers import AHEAD, BOAT, DOWN, OFF, VESSEL, World, bodies, open_water
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve

from asv_env.params import BoatParams

approx = pytest.approx
AWAY = ((-20, -20), (20, 20))
STILL = (0.0, 0.0)


def seen(motion, dt=0.0):
    """Velocities (..., 3) surge, sway, yaw of motions (..., 6), from the heading dt/2 later."""
    heading = motion[..., 2] + 0.5 * dt * motion[..., 5]
    velocity = (motion[..., 3] + 1j * motion[..., 4]) * np.exp(-1j * heading)
    return np.stack([velocity.real, velocity.imag, motion[..., 5]], axis=-1)


def energy(hull, motion, dt):
    """Kinetic energy (...,) of hull and water, J."""
    return 0.5 * (np.array(hull.masses) * seen(motion, dt) ** 2).sum(axis=-1)


def resistance(hull, nu):
    """Drag (3,) on a hull at a velocity (3,) through the water."""
    linear, quadratic = np.transpose([hull.surge, hull.sway, hull.yaw])
    return (linear + quadratic * np.abs(nu)) * nu


def inertial(hull, nu):
    """Coriolis forces and Munk moment (3,) at a velocity (3,) through the water."""
    (u, v, r), (m_u, m_v, _) = nu, hull.masses
    return np.array([m_v * v * r, -m_u * u * r, (m_u - m_v) * u * v])


def wrench(hull, signal):
    """Surge force, sway force and yaw moment of motors at signals (2,), by the linear law."""
    left, right = np.where(signal < 0, hull.astern, 1.0) * hull.thrust * signal
    return np.array([left + right, 0.0, hull.lever_arm * (right - left)])


def integrated(hull, command, seconds, current=STILL):
    """Motion (6,) of a boat that starts at rest, by SciPy from the equations as printed."""
    flow = complex(*current)

    def slope(t, state):
        heading, u, v, r, left, right = state[2:]  # u and v relative to the water
        nu = np.array([u, v, r])
        force = wrench(hull, np.array([left, right])) + inertial(hull, nu) - resistance(hull, nu)
        over_ground = (u + 1j * v) * np.exp(1j * heading) + flow
        lag = (np.array(command) - [left, right]) / hull.lag
        return [over_ground.real, over_ground.imag, r, *(force / hull.masses), *lag]

    at_rest = -flow  # heading 0
    start = [0, 0, 0, at_rest.real, at_rest.imag, 0, 0, 0]
    options = {"method": "DOP853", "rtol": 1e-7, "atol": 1e-9}
    end = solve_ivp(slope, (0, seconds), start, **options).y[:, -1]
    over_ground = (end[3] + 1j * end[4]) * np.exp(1j * end[2]) + flow
    return np.array([*end[:3], over_ground.real, over_ground.imag, end[5]])


def water_of(current):
    speed, direction = abs(complex(*current)), np.angle(complex(*current))
    return {"current": "uniform", "current_speed": speed, "current_heading": direction}


def moved(hull, command, seconds, rate, current=STILL):
    """Motion (6,) of such a boat in a simulation, its heading not wrapped."""
    options = {"boat": hull, "water": water_of(current)}
    world = World(open_water(rate=rate, control=10, **options), bodies(AWAY[0], (), AWAY[1]))
    motions = world.record(seconds, [command, OFF])
    return motions[-1, BOAT]


def ratios(low, high):
    return st.floats(np.log(low), np.log(high)).map(np.exp).map(float)


@st.composite
def hulls(draw):
    """Boats with masses, added masses and drag up to three times more or less than nominal."""
    nominal, some = BoatParams(), ratios(1 / 3, 3)

    def pair(given):
        return tuple(number * draw(some) for number in given)

    return replace(
        nominal,
        mass=nominal.mass * draw(some),
        added_mass=pair(nominal.added_mass),
        added_inertia=nominal.added_inertia * draw(ratios(1 / 3, 10)),
        **{axis: pair(getattr(nominal, axis)) for axis in ("surge", "sway", "yaw")},
    )


signals = st.floats(-1, 1)
flows = st.floats(-0.05, 0.05)


@settings(max_examples=25, deadline=None)
@given(hull=hulls(), command=st.tuples(signals, signals), current=st.tuples(flows, flows))
def test_hulls_move_as_an_independent_integration_says(hull, command, current):
    """Within 1e-3 of the way, or of a boat's length where that is longer, and of a radian."""
    expected = integrated(hull, command, 4.0, current)
    found = moved(hull, command, 4.0, rate=800, current=current)
    way = max(np.hypot(*expected[:2]), abs(complex(*current)) * 4.0, hull.length)
    np.testing.assert_allclose(found[:2], expected[:2], rtol=0, atol=1e-3 * way)
    assert found[2] == approx(expected[2], abs=1e-3 * max(1.0, abs(expected[2])))


def test_step_is_of_second_order():
    """Four times as near with half the step, with coupled axes and a lag."""
    hull, command = BoatParams(), (1.0, 0.3)
    expected = integrated(hull, command, 4.0)[:3]
    errors = [np.abs(moved(hull, command, 4.0, rate)[:3] - expected).max() for rate in (50, 100)]
    assert errors[0] < 2e-3
    assert errors[0] / errors[1] == approx(4, rel=0.25)


def test_boat_reaches_its_terminal_speed():
    hull = BoatParams()
    linear, quadratic = hull.surge
    speed = moved(hull, AHEAD, 30.0, rate=50)[3]
    assert (linear + quadratic * speed) * speed == approx(2 * hull.thrust, rel=1e-4)
    assert speed == approx(0.229, abs=1e-3)


def test_vessel_coasts_twenty_centimetres_from_four_centimetres_a_second():
    """The paper's one datum: the boats stop their motors 20 cm before the goal."""
    world = World(open_water(control=1), bodies((0, 0, 0, 0, 0.04), *AWAY))
    motion = world.run(120)
    assert motion[VESSEL, 1] == approx(0.20, rel=0.01)
    assert abs(motion[VESSEL, 4]) < 1e-6


@pytest.mark.parametrize("command", [(1.0, 0.6), (0.4, 0.9), (-0.2, 0.8)])
def test_steady_turn_balances_forces_and_moments(command):
    hull = BoatParams()
    force = wrench(hull, np.array(command))
    motion = moved(hull, command, 40.0, rate=100)
    nu = seen(motion, 0.01)
    expected = fsolve(lambda nu: force + inertial(hull, nu) - resistance(hull, nu), nu)
    assert nu == approx(expected, rel=2e-3)
    assert np.sign(nu[1]) == -np.sign(nu[2])  # the stern swings outwards


def test_free_hull_ends_up_moving_with_the_water():
    current = (0.03, -0.04)
    world = World(
        open_water(control=1, water=water_of(current)), bodies(AWAY[0], (0, 0, 0.7), AWAY[1])
    )
    motion = world.run(200)
    for row in (VESSEL, BOAT):
        assert motion[row, 3:5] == approx(current, abs=1e-4)
        assert abs(motion[row, 5]) < 1e-6


@pytest.mark.parametrize("drift", [0.3, -0.8, 2.0])
def test_held_hull_in_a_current_feels_the_munk_moment(drift):
    """The current turns the bow away from where it comes from, towards broadside."""
    speed, dt = 0.1, 1e-3
    water = {"current": "uniform", "current_speed": speed, "current_heading": drift}
    params = open_water(rate=1000, water=water)
    motion = World(params, bodies(AWAY[0], (), AWAY[1])).run(dt)
    (m_u, m_v, inertia), (u, v) = (
        params.boat.masses,
        -speed * np.array([np.cos(drift), np.sin(drift)]),
    )
    assert motion[BOAT, 5] * inertia / dt == approx((m_u - m_v) * u * v, rel=5e-3)


def test_munk_moment_is_half_of_what_the_motors_can_at_a_drift_of_a_quarter():
    """Which scale it has: 1.4e-4 N m at 10 cm/s ahead and 5 cm/s aside."""
    boat = BoatParams()
    moment = inertial(boat, np.array([0.1, 0.05, 0.0]))[2]
    strongest = (1 + boat.astern) * boat.thrust * boat.lever_arm
    assert moment == approx(-1.4e-4, rel=0.01)
    assert abs(moment) / strongest == approx(0.36, abs=0.01)


def test_pushing_hands_on_the_impulse_of_the_motors():
    """Without drag, straight on: surge mass of the boats and sway mass of the vessel."""
    free = {"surge": STILL, "sway": STILL, "yaw": STILL}
    params = open_water(boat=free, vessel={**free, "fins": 0.0})
    world = World(params, bodies((), (-0.06, 0.135, DOWN), (0.06, 0.135, DOWN)))
    impulse = 0.0
    for _ in range(150):
        world.step(AHEAD)
        impulse += params.clock.dt * world.thrust.sum()
    mass = np.array([params.vessel.masses[1], *[params.boat.masses[0]] * 2])
    momentum = (mass * world.motion[:, 4]).sum()
    assert momentum == approx(-impulse, rel=1e-9)
    assert world.motion[VESSEL, 4] < -0.05


speeds = st.floats(-0.3, 0.3)


@settings(max_examples=25, deadline=None)
@given(hull=hulls(), velocity=st.tuples(speeds, speeds, st.floats(-3, 3)), drag=st.booleans())
def test_motors_off_energy_never_grows_in_still_water(hull, velocity, drag):
    if not drag:
        hull = replace(hull, surge=STILL, sway=STILL, yaw=STILL)
    params = open_water(rate=200, control=50, boat=hull)
    motions = World(params, bodies(AWAY[0], (0, 0, 0.4, *velocity), AWAY[1])).record(4)
    found = energy(hull, motions[:, BOAT], params.clock.dt)
    if drag:
        assert np.all(np.diff(found) <= 1e-12 * found[0])
    else:  # It is kept, but for an error of the scheme that stays bounded.
        np.testing.assert_allclose(found, found[0], rtol=2e-3)
