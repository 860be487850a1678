"""The LQR with preview against optimal control that is computed another way."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm

from asv_env import make_params
from asv_env.params import NOMINAL_LENGTH
from baselines.scripted import Tolerances, lqr
from baselines.scripted.lqr import PREVIEW_POINTS, SPEEDS, PreviewLqr

CAGED = Tolerances(cross_track=0.03, heading=0.07, force=4e-3, moment=3e-4)
UNCAGED = replace(CAGED, force=0.0)
TEAMS = [4, 12]
"""Their vessels are of nominal and of twice that length."""


def vessel_of(team, **options):
    return make_params(num_boats=team, **options).hulls()[0]


def drags(coefficients, velocity):
    return (coefficients[0] + coefficients[1] * abs(velocity)) * velocity


def rates(vessel, speed, state, wrench, curvature):
    """Rates (4,) of a vessel's deviation from a path, pushed at a constant speed along -n.

    From plane motion: the pose of the path that lies abreast is the frame.
    """
    offset, turned, sideways, yaw_rate = state
    velocity = (sideways - 1j * speed) * np.exp(1j * turned)
    abreast = -velocity.imag / (1 - curvature * offset)
    surge_mass, sway_mass, inertia = vessel.masses
    force = wrench[0] - drags(vessel.surge, sideways) - sway_mass * speed * yaw_rate
    moment = wrench[1] - drags(vessel.yaw, yaw_rate)
    moment -= (surge_mass - sway_mass) * sideways * speed  # the Munk moment
    turning = yaw_rate - curvature * abreast
    return np.array([velocity.real, turning, force / surge_mass, moment / inertia])


def jacobian(vessel, speed):
    """(4, 7) of the rates, at rest on a straight path, by the deviation, wrench and curvature."""
    linear = vessel.linearised(lqr.SLIP, lqr.YAW_RATE)
    step = 1e-6 * np.eye(7)
    moved = [
        rates(linear, speed, d[:4], d[4:6], d[6]) - rates(linear, speed, -d[:4], -d[4:6], -d[6])
        for d in step
    ]
    return np.stack(moved, axis=-1) / 2e-6


def efforts(vessel, tolerances):
    """Force and moment (2,) that cost as much as the tolerated deviations, N and N m."""
    moment = tolerances.moment * (vessel.length / NOMINAL_LENGTH) ** 2
    return np.array([tolerances.force, moment])


def best_wrench(vessel, tolerances, speed, deviation, curvature, cells):
    """First wrench (2,) of the sequence that costs least, by least squares over all of it.

    Args:
        vessel: that is controlled.
        tolerances: what the cost is made of.
        speed: m/s.
        deviation: (4,) now.
        curvature: (PREVIEW_POINTS,) of the path ahead, straight behind that.
        cells: time steps for each look ahead.
    """
    look = lqr.PREVIEW_STEP * vessel.length / NOMINAL_LENGTH
    ahead = np.repeat(np.concatenate([curvature, np.zeros(7 * PREVIEW_POINTS)]), cells)
    extended = np.zeros((7, 7))
    extended[:4] = jacobian(vessel, speed) * look / cells
    system = expm(extended)[:4]
    weights = np.array([1 / tolerances.cross_track, 1 / tolerances.heading])
    effort = efforts(vessel, tolerances)
    used = effort > 0
    steps, controls = len(ahead), used.sum()
    free, forced = deviation, np.zeros((4, steps * controls))
    deviations, influences = [], []
    for step, bend in enumerate(ahead):
        free, forced = system[:, :4] @ free + system[:, 6] * bend, system[:, :4] @ forced
        forced[:, step * controls : (step + 1) * controls] += system[:, 4:6][:, used]
        deviations.append(weights * free[:2])
        influences.append(weights[:, None] * forced[:2])
    influence = np.concatenate(influences)
    normal = influence.T @ influence + np.diag(np.tile(effort[used] ** -2, steps))
    wrench = np.zeros(2)
    wrench[used] = np.linalg.solve(normal, -influence.T @ np.concatenate(deviations))[:controls]
    return wrench


def feedback(controller, speed):
    """Gains (2, 4) of the deviation at one speed."""
    straight = np.zeros((4, PREVIEW_POINTS))
    return -controller.wrench(np.full(4, speed), np.eye(4), straight).T


def follow(vessel, controller, speed, bends, looks=True, seconds=60.0, dt=0.02):
    """Deviations (T, 4) and wrenches (T, 2) of a vessel that enters a bend after 20 s.

    One that does not look ahead expects the path to stay as it is.
    """
    entry, state, states, wrenches = 20.0, np.zeros(4), [], []
    for time in np.arange(0.0, seconds, dt):
        seen = np.where(time + looks * controller.preview_times >= entry, bends, 0.0)
        wrenches.append(controller.wrench(np.array([speed]), state[None], seen[None])[0])
        states.append(state)
        state = state + dt * rates(vessel, speed, state, wrenches[-1], bends * (time >= entry))
    return np.array(states), np.array(wrenches)


@pytest.mark.parametrize("team", TEAMS)
@pytest.mark.parametrize("tolerances", [CAGED, UNCAGED], ids=["caged", "uncaged"])
@pytest.mark.parametrize("speed", [0.03, 0.055, 0.07])
def test_wrench_is_the_first_of_the_cheapest_sequence(team, tolerances, speed):
    """At speeds of the table and between them, on paths of any bends."""
    rng, vessel = np.random.default_rng(team), vessel_of(team)
    controller = PreviewLqr(vessel, tolerances)
    for _ in range(2):
        deviation = rng.uniform(-1, 1, 4) * [0.05, 0.2, 0.01, 0.05]
        curvature = np.repeat(rng.uniform(-2, 2, PREVIEW_POINTS // 4), 4) / vessel.length
        coarse, fine = (
            best_wrench(vessel, tolerances, speed, deviation, curvature, cells) for cells in (1, 2)
        )
        expected = 2 * fine - coarse  # The error of the first order in the step is gone.
        wrench = controller.wrench(np.array([speed]), deviation[None], curvature[None])[0]
        error = np.abs(wrench - expected)
        assert (error <= 0.03 * (np.abs(expected) + efforts(vessel, tolerances))).all()


def test_no_force_is_asked_where_none_can_be_exerted():
    rng = np.random.default_rng(0)
    controller = PreviewLqr(vessel_of(2), UNCAGED)
    arguments = (
        rng.uniform(0, 0.1, 50),
        rng.normal(size=(50, 4)),
        rng.normal(size=(50, PREVIEW_POINTS)),
    )
    wrench = controller.wrench(*arguments)
    np.testing.assert_array_equal(wrench[:, 0], 0.0)
    assert (wrench[:, 1] != 0).all()


@pytest.mark.parametrize("tolerances", [CAGED, UNCAGED], ids=["caged", "uncaged"])
def test_mirror_image(tolerances):
    rng = np.random.default_rng(0)
    controller = PreviewLqr(vessel_of(4), tolerances)
    speed = rng.uniform(0, 0.1, 20)
    deviation, curvature = rng.normal(size=(20, 4)), rng.normal(size=(20, PREVIEW_POINTS))
    wrench = controller.wrench(speed, deviation, curvature)
    np.testing.assert_array_equal(controller.wrench(speed, -deviation, -curvature), -wrench)


def test_wrench_changes_steadily_with_the_speed():
    """No jump at a speed of the table, and the same beyond its ends."""
    controller = PreviewLqr(vessel_of(4), CAGED)
    deviation, curvature = np.array([0.03, 0.1, 0.01, 0.05]), np.full(PREVIEW_POINTS, 2.0)

    def at(speeds):
        speeds = np.asarray(speeds)
        shape = (len(speeds), 1)
        return controller.wrench(speeds, np.tile(deviation, shape), np.tile(curvature, shape))

    np.testing.assert_allclose(at(SPEEDS - 1e-12), at(SPEEDS + 1e-12), rtol=1e-6)
    below, above = at([-0.05, 0.0, SPEEDS[0]]), at([SPEEDS[-1], 1.0])
    np.testing.assert_array_equal(below, below[[2, 2, 2]])
    np.testing.assert_array_equal(above, above[[0, 0]])


@pytest.mark.parametrize("team", [2, 8, 30, 100])
@pytest.mark.parametrize("drag", ["quadratic", "linear"])
@pytest.mark.parametrize("tolerances", [CAGED, UNCAGED], ids=["caged", "uncaged"])
def test_every_vessel_is_stable_at_every_speed(team, drag, tolerances):
    vessel = vessel_of(team, water={"drag": drag})
    controller = PreviewLqr(vessel, tolerances)
    exerts = np.array([tolerances.force > 0, 1.0])
    for speed in np.geomspace(SPEEDS[0], SPEEDS[-1], 25):
        system = jacobian(vessel, speed)
        closed = system[:, :4] - system[:, 4:6] * exerts @ feedback(controller, speed)
        assert np.linalg.eigvals(closed).real.max() < 0


@pytest.mark.parametrize("team", TEAMS)
@pytest.mark.parametrize("tolerances", [CAGED, UNCAGED], ids=["caged", "uncaged"])
def test_vessel_settles_near_a_circle(team, tolerances):
    """With the whole of its drag, on a circle of two and a half half-lengths."""
    vessel = vessel_of(team)
    bends = 1 / (2.5 * vessel.length / 2)
    states, _ = follow(vessel, PreviewLqr(vessel, tolerances), 0.06, bends, seconds=100.0)
    assert np.abs(states[-1] - states[-500]).max() < 1e-5
    assert np.abs(states[:, 0]).max() < 0.2 * vessel.length


@pytest.mark.parametrize("team", TEAMS)
@pytest.mark.parametrize("tolerances", [CAGED, UNCAGED], ids=["caged", "uncaged"])
def test_looking_ahead_pays_in_a_bend(team, tolerances):
    vessel = vessel_of(team)
    controller, bends = PreviewLqr(vessel, tolerances), 1.5 / vessel.length
    used = efforts(vessel, tolerances) > 0

    def cost(looks):
        states, wrenches = follow(vessel, controller, 0.06, bends, looks)
        deviations = states[:, :2] / [tolerances.cross_track, tolerances.heading]
        exerted = wrenches[:, used] / efforts(vessel, tolerances)[used]
        costs = (deviations**2).sum(axis=1) + (exerted**2).sum(axis=1)
        return costs.mean()

    assert cost(looks=True) < 0.95 * cost(looks=False)
