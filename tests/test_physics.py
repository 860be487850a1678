"""The numerical scheme, and the independence of worlds."""

import numpy as np
import pytest
from helpers import (
    DOWN,
    VESSEL,
    World,
    actions,
    begin_at,
    bodies,
    open_water,
)

from asv_env.simulation import Simulation


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


def worlds_after(params, starts, pushes, seconds=4):
    sim = Simulation(params, len(starts))
    begin_at(sim, starts)
    for _ in range(round(seconds * params.clock.control)):
        sim.step(actions(sim, np.array(pushes)[:, None, None]))
    return sim.state.motion


def test_what_other_worlds_do_changes_nothing_in_a_world():
    params = open_water(control=10, arena=3.0, goal=(2.5, 2.5, 0))
    start = bodies((), (-0.08, 0.136, DOWN), (0.05, 0.136, DOWN))
    busy = worlds_after(params, [start] * 4, [0.3, 1.0, -0.5, 0.7])
    idle = worlds_after(params, [start] * 4, [0.0, 1.0, 0.0, 0.0])
    np.testing.assert_array_equal(busy[1], idle[1])
    assert np.abs(busy[0] - idle[0]).max() > 0.01


def test_world_begun_again_does_what_a_new_one_does():
    params = open_water(control=10)
    start = bodies((), (-0.08, 0.136, DOWN), (0.05, 0.136, DOWN))
    used, fresh = World(params, start), World(params, start)
    used.run(5, (1.0, 0.4))
    begin_at(used.sim, [start])
    np.testing.assert_array_equal(used.run(5, (0.8, 0.9)), fresh.run(5, (0.8, 0.9)))
