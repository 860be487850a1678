"""Currents: their flow, and hulls that drift with it."""

import numpy as np
import pytest
from helpers import (
    BOAT,
    DOWN,
    VESSEL,
    World,
    bodies,
    open_water,
)

from asv_env.simulation import Simulation

approx = pytest.approx


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
    moved = moved.copy()
    moved[:, 0] -= 0.05 * 6
    moved[:, 3] -= 0.05
    np.testing.assert_allclose(moved, still, atol=1e-6)


def test_current_pulls_a_hull_at_rest_as_the_drag_of_its_relative_motion():
    params = open_water(rate=1000, control=100, water=current_water("uniform"))
    motion = World(params, bodies((), (0, 2), (0, -2))).run(0.02)
    pull = 0.05 * (params.boat.surge[0] + 0.05 * params.boat.surge[1])
    assert motion[BOAT, 3] == approx(0.02 * pull / params.boat.masses[0], rel=0.01)


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
