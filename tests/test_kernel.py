"""The compiled loop: worlds that do not depend on each other, forces of contact, late commands."""

import numpy as np
import pytest
from helpers import (
    AHEAD,
    BOAT,
    DOWN,
    VESSEL,
    World,
    actions,
    begin_at,
    bodies,
    open_water,
    terminal,
)

from asv_env import Simulation, make_params

WORLDS, STEPS = 64, 400
PARAMS = make_params("push", scenario="harsh", time_limit=30.0)


def commands(steps=STEPS):
    """Actions (steps, W, A, 2) by which boats press on the vessel, each in its own way."""
    rng = np.random.default_rng(0)
    held = rng.uniform((-0.3, -0.4), (1.0, 0.4), (-(-steps // 20), WORLDS, PARAMS.num_boats, 2))
    return np.repeat(held, 20, axis=0)[:steps]


def played(given, rows, num_threads=1):
    """All that happens in the worlds of these rows, (n, T, bytes), and their ticks in contact."""
    simulation = Simulation(PARAMS, len(rows), num_threads)
    simulation.reset(seeds=[int(row) for row in rows])
    seen, contact = [], np.zeros(len(rows))
    for action in given:
        step, state = simulation.step(action[rows]), simulation.state
        arrays = (state.motion, state.thrust, state.contact_force, step.observation, step.reward)
        flat = [np.ascontiguousarray(array).reshape(len(rows), -1) for array in arrays]
        seen.append(np.concatenate([array.view(np.uint8) for array in flat], axis=1))
        contact += state.touching[..., 0].any(axis=1)
        over = step.ending.terminated | step.ending.truncated
        if over.any():
            simulation.reset(over)
    return np.stack(seen, axis=1), contact


def test_64_of_64_worlds_do_the_same_in_any_order_on_any_number_of_threads():
    given, rows = commands(), np.arange(WORLDS)
    expected, contact = played(given, rows)
    assert contact.min() > 40
    assert len({world.tobytes() for world in expected}) == WORLDS
    order = np.random.default_rng(1).permutation(rows)
    found, _ = played(given, order, num_threads=5)
    assert [
        row for row, world in zip(order, found, strict=True) if (world == expected[row]).all()
    ] == [*order]


def test_a_world_does_alone_what_it_does_among_64():
    given, rows, some = commands(100), np.arange(WORLDS), np.arange(0, WORLDS, 8)
    expected, contact = played(given, rows, num_threads=2)
    assert contact.min() > 20
    alone = np.concatenate([played(given, rows[[row]])[0] for row in some])
    np.testing.assert_array_equal(alone, expected[some])


def test_more_threads_than_worlds_do_no_harm():
    given, rows = commands(20), np.arange(3)
    many, one = played(given, rows, 256), played(given, rows, 1)
    np.testing.assert_array_equal(many[0], one[0])


# ------------------------------------------------------------------ commands that arrive late


@pytest.mark.parametrize("mode", ["tracking", "thrusters"])
@pytest.mark.parametrize("ticks", [1, 3])
def test_commands_arrive_as_many_ticks_late_as_asked_for(mode, ticks):
    options = {"action_mode": mode, "time_limit": 60.0}
    late = Simulation(make_params("push", variation={"actuation_delay": ticks / 10}, **options), 3)
    prompt = Simulation(make_params("push", **options), 3)
    given = np.random.default_rng(0).uniform(-0.3, 1.0, (40, *late.state.thrust.shape))
    for _ in range(2):  # A second episode begins without the commands of the first.
        late.reset(seeds=[1, 2, 3])
        prompt.reset(seeds=[1, 2, 3])
        for tick, action in enumerate(given):
            late.step(action)
            prompt.step(given[tick - ticks] if tick >= ticks else np.zeros_like(action))
            np.testing.assert_array_equal(late.state.motion, prompt.state.motion)
            np.testing.assert_array_equal(late.state.thrust, prompt.state.thrust)


# ------------------------------------------------------------------ forces of contact


def test_contact_forces_on_a_vessel_in_steady_motion_are_its_drag():
    pushers = [(x, 0.135, DOWN) for x in (-0.08, 0.08)]
    world = World(open_water(rate=400, control=10), bodies((), *pushers))
    motion = world.run(25, AHEAD)
    (vessel, boat), speed = world.params.hulls(), -motion[VESSEL, 4]
    drag = (vessel.sway[0] + vessel.sway[1] * speed) * speed
    force = world.sim.state.contact_force[0]
    assert force.sum() == pytest.approx(drag, rel=0.005)
    left = 2 * boat.thrust - (boat.surge[0] + boat.surge[1] * speed) * speed
    np.testing.assert_allclose(force, left, rtol=0.02)


def test_boats_that_touch_nothing_or_each_other_feel_no_force_of_the_vessel():
    world = World(open_water(3, control=10), bodies((), (1, 0), (1, 0.064), (-1, 0)))
    for _ in range(20):
        world.step()
        assert not world.sim.state.contact_force.any()
    assert world.sim.state.touching[0, :2, 1].all() or world.motion[BOAT, 1] < 0


def test_force_of_contact_is_a_mean_over_the_tick_and_hands_on_the_momentum():
    """A boat rams a vessel without drag: force times time is the vessel's momentum.

    The force is a mean of sizes, so what rubs to and fro adds a little.
    """
    free = {"surge": (0.0, 0.0), "sway": (0.0, 0.0), "yaw": (0.0, 0.0)}
    params = open_water(control=10, boat=free, vessel={**free, "fins": 0.0})
    world = World(params, bodies((), (0, 0.16, DOWN, 0, -0.2), (-2,)))
    impulse = 0.0
    for _ in range(20):
        world.step()
        impulse += 0.1 * world.sim.state.contact_force[0, 0]
    assert impulse == pytest.approx(params.vessel.masses[1] * -world.motion[VESSEL, 4], rel=1e-3)
    assert impulse > 0.01


# ------------------------------------------------------------------ motors that fail


@pytest.mark.parametrize("mode", ["tracking", "thrusters"])
def test_motors_of_a_failed_boat_stop_with_their_lag(mode):
    params = open_water(control=10, action_mode=mode)
    simulation = Simulation(params)
    start = bodies((), (0, 2), (0, -2))
    begin_at(simulation, [start], failure_tick=np.array([5, -1]))
    thrust = []
    for _ in range(25):
        simulation.step(actions(simulation, (1.0, 0.8)))
        thrust.append(simulation.state.thrust[0].copy())
    assert simulation.state.working[0].tolist() == [False, True]
    failed, sound = np.array(thrust)[:, 0], np.array(thrust)[:, 1]
    np.testing.assert_allclose(
        failed[6:], failed[5] * np.exp(-np.arange(1, 20) * 0.1 / params.boat.lag)[:, None]
    )
    assert np.abs(failed[-1]).max() < 1e-8 < np.abs(sound[-1]).min()


def test_boat_whose_motors_fail_coasts_while_the_other_reaches_its_terminal_speed():
    params = open_water(control=10)
    simulation = Simulation(params)
    begin_at(simulation, [bodies((), (0, 2), (0, -2))], failure_tick=np.array([0, -1]))
    for _ in range(300):
        simulation.step(actions(simulation, AHEAD))
    speeds = simulation.state.motion[0, 1:, 3]
    assert speeds[0] < 1e-3
    assert speeds[1] == pytest.approx(
        terminal(2 * params.boat.thrust, *params.boat.surge), rel=1e-4
    )
