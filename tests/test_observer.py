"""The team's own filter of the vessel's motion, against the physics that it is a model of."""

from collections import deque
from dataclasses import replace

import numpy as np
import pytest
from helpers import begin_at, bodies, open_water
from hypothesis import given
from hypothesis import strategies as st

from asv_env import Simulation, make_params
from asv_env.geometry import wrap
from baselines.rollout.loop import rollout
from baselines.scripted import PathGains, ScriptedPolicy, observer
from baselines.scripted.observer import VesselMemory, VesselObserver

FAR = [(5.0, 5.0), (-5.0, -5.0)]
"""Where two boats leave the vessel alone."""
NOISE = ["nominal", "noisy"]


def watch(params, ticks, worlds=8, motions=None):
    """Errors (T, W, 6) of observer and sensors' filter, and drifts (T, W); the boats are off."""
    sim, kalman = Simulation(params, worlds), VesselObserver(params)
    sim.reset(seeds=range(worlds)) if motions is None else begin_at(sim, motions)
    memory, idle = VesselMemory.empty(worlds, params.num_boats), np.zeros(worlds, dtype=bool)
    kalman.restart(sim.sensed, memory, ~idle)
    own, filtered, drifts = [], [], []
    for _ in range(ticks):
        sim.step(np.zeros_like(sim.state.thrust))
        kalman.update(sim.sensed, memory, idle)
        own.append(errors(memory.motion, sim))
        filtered.append(errors(sim.sensed.estimate[:, 0], sim))
        drifts.append(memory.drift)
    return np.array(own), np.array(filtered), np.array(drifts)


def errors(motion, sim):
    """Errors (W, 6) of an estimate of the vessel's motion."""
    error = motion - sim.state.motion[:, 0]
    error[:, 2] = wrap(error[:, 2])
    return error


def push(scenario, worlds, seconds):
    """Errors (T, W, 6) of observer and sensors' filter while the scripted policy pushes."""
    params = make_params("push", scenario=scenario, goal=(0.8, -2.0, 0.5))
    sim, policy, own, filtered = Simulation(params, worlds), ScriptedPolicy(params), [], []

    def act(sensed, observation, memory, fresh):
        action, memory = policy.act(sensed, observation, memory, fresh)
        own.append(errors(memory.vessel.motion, sim))
        filtered.append(errors(sensed.estimate[:, 0], sim))
        return action, memory

    deque(rollout(sim, act, range(worlds), round(seconds * params.clock.control)), maxlen=0)
    return np.array(own), np.array(filtered)


def rms(values, axis=(0, 1)):
    return np.sqrt((np.abs(values) ** 2).mean(axis=axis))


# ---------------------------------------------------------------------- motion


def test_exact_measurements_give_the_exact_motion():
    own, _ = push("nominal", worlds=4, seconds=10)
    assert np.abs(own).max() < 1e-5


def test_pushing_team_knows_the_motion_better_than_the_sensors_filter():
    own, filtered = push("noisy", worlds=32, seconds=20)
    better = rms(own[20:]) / rms(filtered[20:])
    assert (better[3:] < 0.7).all()
    assert (better[:3] < 1.0).all()


def test_free_vessel_is_known_better_than_by_the_sensors_filter():
    params = make_params(scenario="noisy", action_mode="thrusters")
    own, filtered, _ = watch(params, ticks=300)
    assert (rms(own[100:]) < rms(filtered[100:])).all()


def test_heading_is_known_where_its_measurement_jumps_by_a_turn():
    params = open_water(2, control=10, scenario="noisy")
    begun = bodies((0, 0, np.pi - 0.01, 0, 0, 0), *FAR)
    own, _, _ = watch(params, ticks=50, motions=[begun] * 8)
    assert np.abs(own[..., 2]).max() < 3 * params.sensors.heading_noise


def test_episode_begins_at_rest_from_its_first_measurement():
    params = make_params("push", scenario="noisy")
    sim = Simulation(params, 3)
    sim.reset(seeds=range(3))
    kalman = VesselObserver(params)
    memory = VesselMemory.empty(3, params.num_boats)
    memory.motion[:], memory.drift[:], memory.force[:] = 9.0, 9.0, 9.0
    kalman.restart(sim.sensed, memory, np.array([True, False, True]))
    for world in (0, 2):
        np.testing.assert_array_equal(memory.motion[world, :3], sim.sensed.measured[world, 0, :3])
        np.testing.assert_array_equal(memory.motion[world, 3:], 0.0)
    np.testing.assert_array_equal(memory.drift, [0, 9, 0])
    np.testing.assert_array_equal(memory.force, [0, 9, 0])
    np.testing.assert_array_equal(memory.motion[1], 9.0)


def kalman_gain(acceleration, noise, dt):
    """Gain (2, 2) of a pose and its rate once the textbook recursion has settled.

    The acceleration is white; its mean over a tick has this standard deviation.
    """
    fine, error, seen = 100, np.eye(2), np.diag(np.square(noise))
    transition = np.array([[1.0, dt / fine], [0.0, 1.0]])
    walk = np.diag([0.0, acceleration**2 * dt**2 / fine])
    for _ in range(400):
        for _ in range(fine):
            error = transition @ error @ transition.T + walk
        gain = error @ np.linalg.inv(error + seen)
        error = (np.eye(2) - gain) @ error
    return gain


def test_corrections_are_those_of_the_kalman_filter():
    params = make_params("push", scenario="noisy")
    sim, touch, noise = Simulation(params), 1e-3, params.sensors
    sim.reset(seeds=[0])
    kalman = VesselObserver(params)
    linear = kalman_gain(
        observer.ACCELERATION, [noise.position_noise, noise.speed_noise], 1 / params.clock.control
    )
    angular = kalman_gain(
        observer.YAW_ACCELERATION,
        [noise.heading_noise, noise.yaw_rate_noise],
        1 / params.clock.control,
    )
    for axis, expected in enumerate((linear, linear, angular)):
        for column, entry in enumerate((axis, 3 + axis)):
            memory, measured = VesselMemory.empty(1, 4), np.zeros_like(sim.sensed.measured)
            measured[0, 0, entry] = touch
            kalman.update(replace(sim.sensed, measured=measured), memory, np.ones(1, dtype=bool))
            corrections = memory.motion[0, [axis, 3 + axis]] / touch
            np.testing.assert_allclose(corrections, expected[:, column], rtol=2e-2)


# ---------------------------------------------------------------------- expectation


@pytest.mark.parametrize("drag", ["quadratic", "linear"])
def test_expected_acceleration_is_that_of_the_physics(drag):
    """Of vessels that coast and turn through a current, over a step of half a millisecond."""
    hz, heading = 2000, 2.1
    stream = {"current": "uniform", "current_speed": 0.012, "current_heading": heading}
    params = open_water(2, rate=hz, water={**stream, "drag": drag})
    rng, worlds = np.random.default_rng(0), 20
    motions = np.array([bodies((), *FAR)] * worlds)
    motions[:, 0] = rng.uniform(-1, 1, (worlds, 6)) * [1, 1, np.pi, 0.1, 0.1, 0.5]
    sim = Simulation(params, worlds)
    begin_at(sim, list(motions))
    sim.step(np.zeros_like(sim.state.thrust))
    acceleration = hz * (sim.state.motion[:, 0, 3:] - motions[:, 0, 3:])
    kalman = VesselObserver(params)
    memory = VesselMemory.empty(worlds, 2)
    memory.motion[:], memory.drift[:] = motions[:, 0], 0.012 * np.exp(1j * heading)
    np.testing.assert_allclose(kalman.acceleration(memory), acceleration, atol=2e-4)
    assert (rms(acceleration, 0) > 0.01).all()


@given(st.floats(-np.pi, np.pi), *[st.floats(-0.2, 0.2)] * 4, st.floats(-1.0, 1.0))
def test_wrench_that_balances_drag_and_coupling_keeps_the_velocity(
    heading, surge, sway, east, north, yaw_rate
):
    params = make_params()
    vessel = params.hulls()[0]
    through_water = np.array([surge, sway, yaw_rate])
    linear, quadratic = np.transpose([vessel.surge, vessel.sway, vessel.yaw])
    drag = (linear + quadratic * np.abs(through_water)) * through_water
    surge_mass, sway_mass, inertia = vessel.masses
    drag -= [
        sway_mass * sway * yaw_rate,
        -surge_mass * surge * yaw_rate,
        (surge_mass - sway_mass) * surge * sway,
    ]
    kalman = VesselObserver(params)
    memory = VesselMemory.empty(1, params.num_boats)
    memory.drift[:] = east + 1j * north
    velocity = memory.drift[0] + (surge + 1j * sway) * np.exp(1j * heading)
    memory.motion[0] = [1.0, -2.0, heading, velocity.real, velocity.imag, yaw_rate]
    memory.force[:], memory.moment[:] = drag[0] + 1j * drag[1], drag[2]
    # In its own frame the velocity stays, so over ground it turns with the hull.
    turning = 1j * yaw_rate * (velocity - memory.drift[0])
    expected = np.array([turning.real, turning.imag, 0.0])
    np.testing.assert_allclose(kalman.acceleration(memory)[0], expected, atol=1e-12)
    memory.force += 0.01 + 0.02j
    memory.moment += 0.002
    more = (0.01 / surge_mass + 0.02j / sway_mass) * np.exp(1j * heading)
    expected += [more.real, more.imag, 0.002 / inertia]
    np.testing.assert_allclose(kalman.acceleration(memory)[0], expected, atol=1e-12)


# ---------------------------------------------------------------------- drift


@pytest.mark.parametrize("scenario", NOISE)
@pytest.mark.parametrize(("speed", "heading"), [(0.0, 0.0), (0.01, 0.0), (0.02, 2.1)])
def test_drift_of_a_free_vessel_becomes_the_current(scenario, heading, speed):
    """Boats that are off drift with the vessel, and do not come near it."""
    stream = {"current": "uniform", "current_speed": speed, "current_heading": heading}
    params = make_params(scenario=scenario, action_mode="thrusters", water=stream)
    _, _, drift = watch(params, ticks=600, worlds=16)
    error = drift[-100:] - speed * np.exp(1j * heading)
    if params.sensors.exact:
        assert np.abs(error).max() < 1e-4
    else:
        assert rms(error) < 0.003
        assert abs(error.mean()) < 0.0015


def test_noise_is_not_taken_for_a_current():
    params = make_params(scenario="noisy", action_mode="thrusters")
    _, _, drift = watch(params, ticks=600, worlds=64)
    assert np.abs(drift).max() < PathGains().still_water


def test_a_boat_that_lies_at_the_vessel_is_not_taken_for_a_current():
    """Its thrust is known only from the push on."""
    params = make_params("push", 2, "current")
    sim, kalman = Simulation(params, 3), VesselObserver(params)
    sim.reset(seeds=range(3))
    memory = VesselMemory.empty(3, 2)
    kalman.restart(sim.sensed, memory, np.ones(3, dtype=bool))
    pushing = np.zeros(3, dtype=bool)
    touching = np.zeros((3, 2, 2), dtype=bool)
    touching[:2, 1, 0] = True
    for _ in range(20):
        moved = sim.sensed.measured.copy()
        moved[:, 0, 0] += 0.01
        moved[:, 0, 3] += 0.01
        kalman.update(replace(sim.sensed, measured=moved, touching=touching), memory, pushing)
    np.testing.assert_array_equal(memory.drift[:2], 0)
    assert memory.drift[2].real > 0


@pytest.mark.parametrize("speed", [0.0, 0.01])
def test_pushing_team_learns_the_current_by_its_thrust(speed):
    """Where it knows that the water moves: as it slows down, to a good part in ten seconds."""
    stream = {"current": "uniform", "current_speed": speed, "current_heading": 2.1}
    params = make_params("push", goal=(0.0, -0.9, 0.0), water=stream, delivery="passing")
    sim, policy, drifts = Simulation(params, 4), ScriptedPolicy(params), []

    def act(sensed, observation, memory, fresh):
        action, memory = policy.act(sensed, observation, memory, fresh)
        memory.vessel.moves[:] = True
        drifts.append(memory.vessel.drift)
        return action, memory

    deque(rollout(sim, act, range(4), 30 * params.clock.control), maxlen=0)
    error = np.array(drifts)[-50:] - speed * np.exp(2.1j)
    assert rms(error) < 0.002 + 0.5 * speed


def test_drift_in_contact_is_followed_only_where_water_was_found_to_move():
    """Whatever is known in the other worlds."""
    params = make_params("push", 2, "current")
    sim, kalman = Simulation(params, 2), VesselObserver(params, by_thrust=True)
    sim.reset(seeds=range(2))
    memory, pushing = VesselMemory.empty(2, 2), np.ones(2, dtype=bool)
    kalman.restart(sim.sensed, memory, pushing)
    memory.moves[:] = [True, False]
    moved = sim.sensed.measured.copy()
    moved[:, 0, 3] += 0.01
    kalman.update(replace(sim.sensed, measured=moved), memory, pushing)
    assert memory.drift[0] != 0
    assert memory.drift[1] == 0


def test_other_boats_that_touch_each_other_do_not_matter():
    params = make_params("push", 2, "current")
    sim, kalman = Simulation(params, 1), VesselObserver(params)
    sim.reset(seeds=[0])
    memory = VesselMemory.empty(1, 2)
    kalman.restart(sim.sensed, memory, np.ones(1, dtype=bool))
    touching = np.zeros((1, 2, 2), dtype=bool)
    touching[..., 1] = True
    moved = sim.sensed.measured + 0.01
    kalman.update(replace(sim.sensed, measured=moved, touching=touching), memory, touching[:, 0, 0])
    assert memory.drift[0] != 0


def test_what_is_lost_corrects_nothing():
    """A measurement that has not come again leaves the prediction as it is."""
    params = make_params("push", scenario="noisy")
    sim, kalman = Simulation(params, 2), VesselObserver(params)
    sim.reset(seeds=range(2))
    idle = np.zeros(2, dtype=bool)
    memory = VesselMemory.empty(2, 4)
    kalman.restart(sim.sensed, memory, ~idle)
    memory.motion[:, 3:] = [0.02, -0.01, 0.1]
    before = memory.motion.copy()
    received = np.zeros_like(sim.sensed.received)
    received[1] = True
    sensed = replace(sim.sensed, received=received)
    kalman.update(sensed, memory, idle)
    rates = (before[0, 3:] + memory.motion[0, 3:]) / 2
    np.testing.assert_allclose(memory.motion[0, :3], before[0, :3] + rates / 10, atol=1e-9)
    assert memory.drift[0] == 0
    assert memory.drift[1] != 0
