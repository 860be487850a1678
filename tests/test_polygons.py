"""Geometry of outlines against closed forms, and invariants of random polygons."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from asv_env import polygons
from asv_env.geometry import boat_hull, rectangle

approx = pytest.approx
TRIANGLE = [(0.0, 0.0), (0.3, 0.0), (0.0, 0.6)]
COMB = [
    (0, 0),
    (5, 0),
    (5, 3),
    (4, 3),
    (4, 1),
    (3, 1),
    (3, 3),
    (2, 3),
    (2, 1),
    (1, 1),
    (1, 3),
    (0, 3),
]


def star(radii):
    """A simple polygon round the origin, whose corners lie at equal angles."""
    angles = 2 * math.pi * np.arange(len(radii)) / len(radii)
    return [(r * math.cos(a), r * math.sin(a)) for r, a in zip(radii, angles, strict=True)]


stars = st.lists(st.floats(0.1, 1.0), min_size=3, max_size=20).map(star)
angles = st.floats(-3.0, 3.0)


def rotated(corners, angle, shift=0j):
    points = polygons.complex_corners(corners) * np.exp(1j * angle) + shift
    return list(zip(points.real.tolist(), points.imag.tolist(), strict=True))


def test_triangle_has_its_area_centroid_and_moments():
    assert polygons.area(TRIANGLE) == approx(0.09)
    assert polygons.centroid(TRIANGLE) == approx((0.1, 0.2))
    assert polygons.second_moments(TRIANGLE) == approx((0.6 * 0.3**3 / 12, 0.3 * 0.6**3 / 12))
    assert polygons.area(TRIANGLE[::-1]) == approx(-0.09)


def test_ring_of_many_corners_is_nearly_a_disc():
    disc = star([0.2] * 1000)
    assert polygons.area(disc) == approx(math.pi * 0.04, rel=1e-4)
    assert polygons.gyration(disc) == approx(0.02, rel=1e-4)
    assert polygons.second_moments(disc) == approx([math.pi * 0.2**4 / 4] * 2, rel=1e-4)


@settings(max_examples=30, deadline=None)
@given(corners=stars, angle=angles, x=st.floats(-2, 2), y=st.floats(-2, 2))
def test_a_polygon_that_is_moved_keeps_what_is_its_own(corners, angle, x, y):
    moved = rotated(corners, angle, complex(x, y))
    mirrored = [(u, -w) for u, w in corners][::-1]
    assert polygons.area(moved) == approx(polygons.area(corners))
    assert polygons.area(mirrored) == approx(polygons.area(corners))
    centre = complex(*polygons.centroid(corners)) * np.exp(1j * angle) + complex(x, y)
    assert polygons.centroid(moved) == approx((centre.real, centre.imag), abs=1e-9)
    assert sum(polygons.second_moments(rotated(corners, angle))) == approx(
        polygons.gyration(corners) * polygons.area(corners)
    )
    assert polygons.is_simple(moved)


@pytest.mark.parametrize("corners", [TRIANGLE, rectangle(2, 1), boat_hull(0.12, 0.065, 0.02), COMB])
def test_simple_polygons_are(corners):
    assert polygons.is_simple(corners)
    assert polygons.is_simple(corners[::-1])


@pytest.mark.parametrize("corners", [
    [(0, 0), (1, 1), (1, 0), (0, 1)],  # a bow tie
    [(0, 0), (2, 0), (2, 2), (1, 0), (0, 2)],  # touches an edge of its own
    [(0, 0), (2, 0), (1, 0), (1, 1)],  # goes back on itself
    [(0, 0), (2, 0), (2, 1), (1, 1), (0, 0), (0, 2)],  # meets a corner twice
    star([1.0] * 5)[::2] + star([1.0] * 5)[1::2],  # a pentagram
])  # fmt: skip
def test_polygons_that_meet_themselves_are_not_simple(corners):
    assert not polygons.is_simple(corners)


@settings(max_examples=30, deadline=None)
@given(corners=stars, x=st.floats(-1.5, 1.5), y=st.floats(-1.5, 1.5))
def test_nearest_point_of_an_outline_is_that_of_many_points_on_it(corners, x, y):
    outline, point = polygons.complex_corners(corners), complex(x, y)
    along = np.linspace(0, 1, 400)[:, None]
    sampled = outline + along * (np.roll(outline, -1) - outline)
    edges = polygons.outline(outline)
    offset = polygons.to_outline(edges, point)
    assert abs(offset) == approx(np.abs(sampled - point).min(), abs=1e-2)
    assert abs(polygons.to_outline(edges, point + offset)) < 1e-9
    inside = polygons.contains(outline, point)
    turns = np.angle((np.roll(outline, -1) - point) / (outline - point)).sum() / (2 * math.pi)
    assert abs(offset) < 1e-6 or inside == (round(turns) == 1)


@settings(max_examples=30, deadline=None)
@given(corners=stars)
def test_hull_and_its_upper_side_lie_round_the_polygon(corners):
    hull = polygons.convex_hull(corners)
    assert polygons.is_convex(hull)
    assert polygons.area(hull) >= polygons.area(corners) - 1e-12
    u, w = polygons.upper_side(corners)
    points = np.array(corners)
    assert (np.diff(u) > 0).all()
    assert (points[:, 1] <= np.interp(points[:, 0], u, w) + 1e-9).all()
    slopes = np.diff(w) / np.diff(u)
    assert (np.diff(slopes) <= 1e-9).all()
    assert (u[0], u[-1]) == approx((points[:, 0].min(), points[:, 0].max()), abs=1e-8)


def test_crossings_are_where_a_line_enters_and_leaves():
    assert polygons.crossings(COMB, 2.0).tolist() == [0, 1, 2, 3, 4, 5]
    assert polygons.crossings(COMB, 0.5).tolist() == [0, 5]
    assert polygons.crossings(COMB, 4.0).tolist() == []


def test_inset_polygon_has_its_edges_at_the_margin():
    inner = polygons.inset(polygons.complex_corners(boat_hull(0.12, 0.065, 0.02)), 0.002)
    outer = polygons.outline(polygons.complex_corners(boat_hull(0.12, 0.065, 0.02)))
    middles = (inner + np.roll(inner, -1)) / 2
    assert [abs(polygons.to_outline(outer, point)) for point in middles] == approx([0.002] * 6)


@pytest.mark.parametrize(("corners", "place"), [
    (rectangle(4.0, 1.0), (0.0, 0.0, 0.5)),
    (star([1.0] * 40), (0.0, 0.0, math.cos(math.pi / 40))),
    ([(0, 0), (4, 0), (4, 4), (3, 4), (3, 1), (0, 1)], (2.7, 0.5, 0.5)),
])  # fmt: skip
def test_roomiest_place_is_far_from_the_outline(corners, place):
    assert polygons.roomiest(corners) == approx(place, abs=0.25)
