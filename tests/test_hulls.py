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

from asv_env import geometry, make_params
from asv_env.params import BoatParams, VesselParams

approx = pytest.approx


@pytest.mark.parametrize(
    ("hull", "size", "mass", "inertia"),
    [
        (BoatParams(), (0.12, 0.065), (0.10, 0.02), (1.55e-4, 0.66e-4)),
        (VesselParams(), (0.40, 0.15), (0.60, 0.08), (9.1e-3, 0.8e-3)),
    ],
    ids=["boat", "vessel"],
)
def test_hulls_are_those_of_the_design(hull, size, mass, inertia):
    assert (hull.length, hull.width) == size
    assert (hull.mass, hull.added_mass) == mass
    assert (hull.inertia, hull.added_inertia) == inertia
    assert hull.total_mass == approx(sum(mass))
    assert hull.total_inertia == approx(sum(inertia))


def test_drag_and_thrust_are_those_of_the_design():
    vessel, boat = make_params().hulls()
    assert (boat.surge, boat.sway, boat.yaw) == ((0.03, 0.25), (0.08, 0.67), (1e-4, 3.6e-5))
    assert vessel.surge == approx((0.20, 4.35))
    assert (vessel.sway, vessel.yaw) == ((0.10, 2.0), (1.5e-3, 4e-3))
    assert (boat.thrust, boat.astern, boat.lever_arm, boat.lag) == (0.010, 0.6, 0.02, 0.1)
    assert make_params().water.contact_friction == 0.3


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
    area, gyration = quadrature(hull.outline)
    assert geometry.polygon_gyration(hull.outline) == approx(gyration, rel=1e-5)
    uniform = replace(hull, inertia=None)
    assert uniform.total_inertia - uniform.added_inertia == approx(hull.mass * gyration, rel=1e-5)
    assert 0 < area <= hull.length * hull.width * (1 + 1e-9)


@pytest.mark.parametrize("hull", [BoatParams(), VesselParams()], ids=["boat", "vessel"])
def test_outline_is_convex_and_fills_its_length_and_width(hull):
    corners = np.array(hull.outline)
    edges = np.roll(corners, -1, axis=0) - corners
    following = np.roll(edges, -1, axis=0)
    assert np.all(edges[:, 0] * following[:, 1] - edges[:, 1] * following[:, 0] >= 0)
    np.testing.assert_allclose(np.ptp(corners, axis=0), [hull.length, hull.width])


def test_boat_has_a_flat_bow_of_two_centimetres_ahead():
    corners = np.array(BoatParams().outline)
    bow = corners[corners[:, 0] > 0.06 - 1e-9]
    assert sorted(bow[:, 1]) == approx([-0.01, 0.01])


def test_vessel_given_nothing_about_its_inertia_has_nearly_that_of_a_plank():
    assert VesselParams(inertia=None).total_inertia == approx(
        VesselParams().total_inertia, rel=0.01
    )


def test_motors_accelerate_the_effective_mass_and_inertia():
    params = dragless()
    motions = World(params, bodies((), (0, 2), (0, -2)), lag=1e-6).record(1, [AHEAD, (0, 1)])
    ahead, turning = motions[-1, 1], motions[-1, 2]
    assert ahead[3] == approx(0.02 / 0.12, rel=1e-6)
    assert turning[5] == approx(0.02 * 0.010 / 2.21e-4, rel=1e-6)


def test_drawn_mass_and_drag_scale_the_hull():
    gains = {"mass_gain": np.array([1, 1.2, 1]), "drag_gain": np.array([1, 1, 1.3])}
    params = dragless()
    for column, action in ((3, AHEAD), (5, (0.0, 1.0))):
        start = bodies((), (0, 2), (0, -2))
        light, heavy = World(params, start, lag=1e-6, **gains).run(0.02, action)[[2, 1], column]
        assert light / heavy == approx(1.2, rel=1e-6)
    params = open_water(control=1)
    dragged = World(params, bodies((), (0, 2), (0, -2)), **gains).run(60, AHEAD)
    linear, quadratic = np.multiply(1.3, params.boat.surge)
    assert dragged[2, 3] == approx(terminal(0.02, linear, quadratic), rel=1e-4)
