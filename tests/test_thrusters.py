"""Thrusters and autopilot against closed forms."""

import numpy as np
import pytest
from helpers import (
    AHEAD,
    BOAT,
    OFF,
    World,
    bodies,
    open_water,
)
from scipy.optimize import fsolve

from asv_env.params import BoatParams

approx = pytest.approx


@pytest.mark.parametrize(("left", "right"), [(1.0, 0.0), (1.0, 0.5), (-0.5, 1.0)])
def test_differential_thrust_gives_the_steady_turn_of_the_equations(left, right):
    params = open_water(control=1)
    boat = params.boat
    surge, sway, _ = boat.masses
    motion = World(params, bodies((), (0, 2), (0, -2))).run(40, [(left, right), OFF])[BOAT]
    port, starboard = (boat.thrust * (c if c > 0 else boat.astern * c) for c in (left, right))

    def balance(velocity):
        u, v, r = velocity
        resist = [(a + b * abs(s)) * s for (a, b), s in zip(drags, velocity, strict=True)]
        return (
            port + starboard + sway * r * v - resist[0],
            -surge * u * r - resist[1],
            boat.lever_arm * (starboard - port) + (surge - sway) * u * v - resist[2],
        )

    drags = [getattr(boat, axis) for axis in ("surge", "sway", "yaw")]
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
    [((0.5, 0), 3, 0.5), ((-0.3, 0), 3, -0.3), ((0, 0.4), 5, 0.4), ((0, -1), 5, -1.0)],
)
def test_tracking_reaches_the_speed_and_the_yaw_rate_asked_for(action, column, expected):
    full = BoatParams().full_speed if column == 3 else BoatParams().full_yaw_rate
    world = World(open_water(control=1, action_mode="tracking"), bodies((), (0, 2), (0, -2)))
    assert world.run(10, [action, OFF])[BOAT, column] == approx(expected * full, rel=0.01)
