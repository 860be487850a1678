"""Gusts: an Ornstein-Uhlenbeck process beside the current; and failures that wait for closure."""

import pickle

import numpy as np
import pytest
from helpers import World, begin_at, bodies, open_water

from asv_env.presets import make_params
from asv_env.simulation import Simulation

GUSTY = {"gust_speed": 0.02, "gust_time": 4.0}


def blown(params, worlds, ticks):
    """Returns the gusts (ticks + 1, W, 2) of as many worlds, motors off."""
    sim = Simulation(params, worlds)
    sim.reset(seeds=range(worlds))
    found = [sim.state.gust]
    for _ in range(ticks):
        sim.step(np.zeros((worlds, params.num_boats, 2)))
        found.append(sim.state.gust)
    return np.array(found)


def test_gusts_are_steady_noise_that_decays_with_their_time_constant():
    params = open_water(control=2, rate=2, water=GUSTY, time_limit=1e6, arena=1e5)
    gust = blown(params, 1000, 24)
    # 2,000 components each: the standard deviation of an estimated one is 1.6 %.
    np.testing.assert_allclose(gust.std(axis=(1, 2)), 0.02, rtol=0.08)
    np.testing.assert_allclose(gust.mean(axis=(1, 2)), 0.0, atol=0.02 / 10)
    for lag in (1, 8, 24):
        product = (gust[lag:] * gust[: len(gust) - lag]).mean()
        assert product / 0.02**2 == pytest.approx(np.exp(-0.5 * lag / 4.0), abs=0.06)


def test_gust_that_hardly_changes_is_a_uniform_current():
    lasting = {"gust_speed": 0.05, "gust_time": 1e9}
    params = open_water(water=lasting)
    start = bodies((0, 0, 1), (0, 1.3, -2), (0, -1.3, 0.2, 0.1, 0.2, 0.4))
    world = World(params, start)
    motion = world.run(5).copy()
    x, y = world.sim.state.gust[0]
    stream = {
        "current": "uniform",
        "current_speed": float(np.hypot(x, y)),
        "current_heading": float(np.arctan2(y, x)),
    }
    carried = World(open_water(water=stream), start).run(5)
    # In 5 s such gusts still walk by 0.05 m/s sqrt(2 * 5 s / 1e9 s) = 5e-6 m/s.
    np.testing.assert_allclose(motion, carried, atol=5 * 5e-6)
    assert np.hypot(x, y) > 0.005


def test_gusts_add_to_a_gyre_also_for_the_judge():
    gyre = {"current": "gyre", "current_speed": 0.03}
    params = open_water(water={**gyre, **GUSTY})
    sim = Simulation(params, 3)
    sim.reset(seeds=[4, 5, 6])
    sim.step(np.zeros((3, params.num_boats, 2)))
    vessel = sim.state.motion[:, 0, :2]
    flow = Simulation(open_water(water=gyre)).current(vessel)
    expected = (flow + sim.state.gust) @ [1, 1j]
    np.testing.assert_allclose(sim._dynamics.water(), expected, rtol=1e-12)


def test_gusts_of_a_world_do_not_depend_on_the_batch_or_on_the_episode_before():
    params = make_params("push", water=GUSTY, scenario="noisy")
    alone, among = Simulation(params), Simulation(params, 3)
    alone.reset(seeds=[7])
    among.reset(seeds=[1, 7, 3])
    idle = np.zeros((3, 4, 2))
    for _ in range(70):  # more than a block of numbers
        alone.step(idle[:1])
        among.step(idle)
    np.testing.assert_array_equal(alone.state.gust[0], among.state.gust[1])
    np.testing.assert_array_equal(alone.state.motion[0], among.state.motion[1])
    fresh = Simulation(params)
    fresh.reset(seeds=[9])
    alone.reset(seeds=[9])
    np.testing.assert_array_equal(alone.state.gust, fresh.state.gust)


def test_copy_of_a_gusty_world_continues_to_the_bit():
    params = make_params("push", water=GUSTY)
    sim = Simulation(params, 2)
    sim.reset(seeds=[0, 1])
    act = np.full((2, 4, 2), 0.3)
    sim.step(act)
    other, past = pickle.loads(pickle.dumps(sim)), sim.snapshot()
    futures = []
    for each in (sim, other):
        for _ in range(66):
            each.step(act)
        futures.append(each.state)
    sim.restore(past)
    for _ in range(66):
        sim.step(act)
    for future in (futures[1], sim.state):
        np.testing.assert_array_equal(future.motion, futures[0].motion)
        np.testing.assert_array_equal(future.gust, futures[0].gust)


def test_noise_is_the_same_with_and_without_gusts():
    seen = []
    for water in ({}, GUSTY):
        sim = Simulation(make_params("push", scenario="noisy", water=water))
        sim.reset(seeds=[11])
        seen.append(sim.sensed.measured - sim.state.motion)
    np.testing.assert_allclose(seen[0], seen[1], atol=1e-12)


@pytest.mark.parametrize(
    ("water", "words"),
    [({"gust_speed": -1.0}, "gust_speed"), ({"gust_time": 0.0}, "gust_time")],
)
def test_gusts_that_cannot_be(water, words):
    with pytest.raises(ValueError, match=words):
        make_params(water=water)


def test_failure_waits_for_closure():
    params = make_params(
        scenario={"variation": {"failures": 1, "failure_clock": "closure"}}, num_boats=4
    )
    sim = Simulation(params)
    sim.reset(seeds=[0])
    scattered = sim.state.motion
    begin_at(sim, scattered, failure_tick=np.array([-1, 3, -1, -1]))
    for _ in range(6):
        sim.step(np.zeros((1, 4, 2)))
    assert sim.state.working.all()

    push = make_params("push", scenario={"variation": {"failures": 1, "failure_clock": "closure"}})
    sim = Simulation(push)
    sim.reset(seeds=[0])
    begin_at(sim, sim.state.motion, failure_tick=np.array([-1, 3, -1, -1]))
    working = []
    for _ in range(6):
        sim.step(np.zeros((1, 4, 2)))
        working.append(sim.state.working[0, 1])
    # In closure from the first tick on, so that it fails three ticks after that.
    assert working == [True, True, True, False, False, False]


def test_load_changes_the_mass_of_the_vessel_alone():
    params = make_params(scenario={"variation": {"load": (2.0, 3.0)}})
    plain = make_params()
    for seed in range(20):
        one, other = (
            each.definition.initial_states(each, np.random.default_rng(seed), None)
            for each in (params, plain)
        )
        assert 2.0 <= one.mass_gain[0] <= 3.0
        np.testing.assert_array_equal(one.mass_gain[1:], other.mass_gain[1:])
        np.testing.assert_array_equal(one.motion, other.motion)


def test_gyre_is_shifted_by_its_phase():
    gyre = {"current": "double_gyre", "current_speed": 0.02, "gyre_size": 1.5}
    points = np.random.default_rng(0).uniform(-3, 3, (50, 2))
    shifted = Simulation(open_water(water={**gyre, "gyre_phase": 0.5})).current(points)
    moved = Simulation(open_water(water=gyre)).current(points + np.array([0.5 * 1.5 / np.pi, 0.0]))
    np.testing.assert_allclose(shifted, moved, atol=1e-12)
