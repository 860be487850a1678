"""Mass, inertia and shape of the hulls."""

from dataclasses import replace

import numpy as np
import pytest
from helpers import (
    AHEAD,
    World,
    bodies,
    dragless,
    open_water,
    terminal,
)

from asv_env import polygons
from asv_env.params import BoatParams, VesselParams

approx = pytest.approx


def test_effective_masses_are_those_of_hull_and_water():
    boat, vessel = BoatParams(), VesselParams()
    assert boat.masses == approx((0.10 + 0.014, 0.10 + 0.042, 1.55e-4 + 2e-5))
    assert vessel.masses == approx((0.60 + 0.022, 0.60 + 0.12, 9.1e-3 + 1.1e-3))
    assert (boat.contact_mass, vessel.contact_mass) == (boat.masses[0], vessel.masses[1])


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
    area, gyration = quadrature(hull.corners)
    assert polygons.gyration(hull.corners) == approx(gyration, rel=1e-5)
    uniform = replace(hull, inertia=None)
    assert uniform.total_inertia - uniform.added_inertia == approx(hull.mass * gyration, rel=1e-5)
    assert 0 < area <= hull.length * hull.width * (1 + 1e-9)


@pytest.mark.parametrize("hull", [BoatParams(), VesselParams()], ids=["boat", "vessel"])
def test_outline_is_convex_and_fills_its_length_and_width(hull):
    corners = np.array(hull.corners)
    edges = np.roll(corners, -1, axis=0) - corners
    following = np.roll(edges, -1, axis=0)
    assert np.all(edges[:, 0] * following[:, 1] - edges[:, 1] * following[:, 0] >= 0)
    np.testing.assert_allclose(np.ptp(corners, axis=0), [hull.length, hull.width])


def test_boat_has_a_flat_bow_of_two_centimetres_ahead():
    corners = np.array(BoatParams().corners)
    bow = corners[corners[:, 0] > 0.06 - 1e-9]
    assert sorted(bow[:, 1]) == approx([-0.01, 0.01])


def test_vessel_given_nothing_about_its_inertia_has_nearly_that_of_a_plank():
    assert VesselParams(inertia=None).total_inertia == approx(
        VesselParams().total_inertia, rel=0.01
    )


def test_motors_accelerate_the_effective_mass_and_inertia():
    params = dragless()
    motions = World(params, bodies((), (0, 2), (0, -2)), lag=1e-6).record(1, [AHEAD, (-1, 0.6)])
    ahead, turning = motions[-1, 1], motions[-1, 2]
    surge, _, yaw = params.boat.masses
    assert ahead[3] == approx(2 * 0.010 / surge, rel=1e-6)
    assert turning[5] == approx(2 * 0.024 * 0.006 / yaw, rel=1e-6)


def test_drawn_mass_and_drag_scale_the_hull():
    gains = {"mass_gain": np.array([1, 1.2, 1]), "drag_gain": np.array([1, 1, 1.3])}
    params = dragless()
    for column, action in ((3, AHEAD), (5, (-1.0, 0.6))):
        start = bodies((), (0, 2), (0, -2))
        light, heavy = World(params, start, lag=1e-6, **gains).run(0.02, action)[[2, 1], column]
        assert light / heavy == approx(1.2, rel=1e-6)
    params = open_water(control=1)
    dragged = World(params, bodies((), (0, 2), (0, -2)), **gains).run(60, AHEAD)
    linear, quadratic = np.multiply(1.3, params.boat.surge)
    assert dragged[2, 3] == approx(terminal(0.02, linear, quadratic), rel=1e-4)
