"""Boats of other sizes in one team: their motion, their hulls, and what a reset leaves of them."""

import pickle

import numpy as np
import pytest
from helpers import BOAT, DOWN, World, bodies, open_water, terminal

from asv_env.presets import make_params
from asv_env.simulation import Simulation

UNLIKE = {"variation": {"boat_size": 0.2, "thrust": 0.3}}


@pytest.mark.parametrize("size", [0.8, 1.0, 1.25])
def test_boats_of_another_size_have_the_terminal_speeds_of_scaled_drag(size):
    params = open_water(action_mode="thrusters", time_limit=1e4, arena=1e3)
    boat, sizes = params.boat, np.array([size, 1.0])
    world = World(params, bodies((), (0, 3), (0, -3)), boat_size=sizes)
    motion = world.run(40, 1.0)
    linear, quadratic = np.array(boat.surge) * size**2
    expected = terminal(2 * boat.thrust, linear, quadratic)
    assert np.hypot(*motion[BOAT, 3:5]) == pytest.approx(expected, rel=1e-6)

    spun = World(params, bodies((), (0, 3), (0, -3)), boat_size=sizes)
    motion = spun.run(40, (-1.0, boat.astern))  # The same thrust astern and ahead.
    moment = 2 * boat.lever_arm * size * boat.astern * boat.thrust
    expected = terminal(moment, boat.yaw[0] * size**4, boat.yaw[1] * size**5)
    assert motion[BOAT, 5] == pytest.approx(expected, rel=1e-6)


def test_hull_of_a_larger_boat_reaches_farther():
    params = open_water(control=50)
    gap = 0.004
    place = (params.vessel.width + params.boat.length) / 2 + gap
    longer = 1.0 + 2 * (gap + 0.001) / params.boat.length
    start = bodies((), (-0.1, place, DOWN), (0.1, place, DOWN))
    world = World(params, start, boat_size=np.array([longer, 1.0]))
    world.step()
    np.testing.assert_array_equal(world.sim.state.touching[0, :, 0], [True, False])


@pytest.mark.parametrize("side", ["+n", "-n"])
def test_boats_of_all_sizes_begin_as_near_to_the_vessel(side):
    params = make_params("push", 6, scenario=UNLIKE, side=side)
    sim = Simulation(params, 20)
    sim.reset(seeds=range(20))
    size = sim.state.boat_size
    assert 0.8 <= size.min() < 0.83
    assert 1.17 < size.max() <= 1.2
    sim.step(np.zeros((20, 6, 2)))
    assert not sim.state.touching.any()
    ahead = np.full((20, 6, 2), (0.2, 0.0))
    for _ in range(12):
        sim.step(ahead)
    assert sim.state.touching[..., 0].any(axis=1).all()


def test_reset_leaves_nothing_of_the_sizes_before():
    params = make_params("push", scenario=UNLIKE)
    used, fresh = Simulation(params, 2), Simulation(params, 2)
    used.reset(seeds=[1, 2])
    act = np.full((2, 4, 2), 0.4)
    for _ in range(10):
        used.step(act)
    for sim in (used, fresh):
        sim.reset(seeds=[3, 4])
        for _ in range(20):
            sim.step(act)
    np.testing.assert_array_equal(used.state.motion, fresh.state.motion)
    copy, past = pickle.loads(pickle.dumps(used)), used.snapshot()
    used.reset(seeds=[8, 9])
    used.restore(past)
    for sim in (used, copy, fresh):
        for _ in range(20):
            sim.step(act)
    for sim in (used, copy):
        np.testing.assert_array_equal(sim.state.motion, fresh.state.motion)
        np.testing.assert_array_equal(sim.state.boat_size, fresh.state.boat_size)


def test_sizes_change_nothing_else_of_an_episode():
    plain = make_params("transport", scenario="mismatch")
    sized = make_params("transport", scenario="mismatch", variation={"boat_size": 0.2})
    for seed in range(5):
        one, other = (
            each.definition.initial_states(each, np.random.default_rng(seed), None)
            for each in (plain, sized)
        )
        np.testing.assert_array_equal(one.motion, other.motion)
        np.testing.assert_array_equal(one.mass_gain, other.mass_gain)
        assert one.boat_size is None
        assert other.boat_size.shape == (4,)


def test_boats_that_may_not_fit_are_refused():
    with pytest.raises(ValueError, match=r"boats of width 0\.078 m do not fit"):
        make_params("push", 12, vessel={"length": 0.75}, scenario=UNLIKE)
