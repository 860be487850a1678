"""Paths of boats round the hull: straight or tangent, never through it, shortest."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from asv_env import polygons
from asv_env.params.outlines import SHAPES
from baselines.allocation.detours import Detours

CLEARANCE = 0.2
PLANK = polygons.complex_corners([(-0.2, -0.075), (0.2, -0.075), (0.2, 0.075), (-0.2, 0.075)])


def around(hull=PLANK):
    """Paths to waypoints off the middles of a hull's edges."""
    edge = np.roll(hull, -1) - hull
    return Detours(hull, CLEARANCE, hull + edge / 2 - 1j * edge / abs(edge) * CLEARANCE)


def walked(detours, start, number, step=2e-3):
    """Positions of a boat that follows its path in short steps."""
    places, target = [start], np.array([number])
    while True:
        course, length = detours.course(np.array([places[-1]]), target)
        if length[0] < 2 * step:
            return np.array(places)
        places.append(places[-1] + step * course[0])
        assert len(places) < 5000


def test_what_lies_in_sight_is_reached_straight():
    course, length = around().course(np.array([-0.1 - 0.9j]), np.array([0]))
    gap = -0.275j - (-0.1 - 0.9j)
    np.testing.assert_allclose([course[0], length[0]], [gap / abs(gap), abs(gap)])


@given(st.floats(0.5, 1.5), st.floats(-math.pi, math.pi), st.integers(0, 3))
def test_a_path_is_as_long_as_it_says_and_keeps_clear(radius, bearing, number):
    detours, start = around(), radius * np.exp(1j * bearing)
    places = walked(detours, start, number)
    length = detours.course(np.array([start]), np.array([number]))[1][0]
    assert 2e-3 * len(places) == pytest.approx(length, abs=0.02)
    hull = polygons.outline(PLANK)
    assert min(polygons.gap_to(hull, place) for place in places[::10]) > 0.97 * CLEARANCE


@given(st.floats(0.45, 1.5), st.floats(-math.pi, math.pi))
def test_the_shorter_way_round_is_taken(radius, bearing):
    """The mirror image of a boat has the mirror image's path."""
    start = radius * np.exp(1j * bearing)
    length = around().lengths(np.array([start, start.conjugate()]))
    np.testing.assert_allclose(length[0], length[1, [2, 1, 0, 3]], rtol=1e-9)


@pytest.mark.parametrize("name", SHAPES)
def test_boats_get_round_every_hull_from_outside_and_from_its_side(name):
    hull = polygons.complex_corners(polygons.convex_hull(SHAPES[name]))
    detours = around(hull)
    boats = np.concatenate([1.5 * np.exp(0.3j * np.arange(21)), 1.2 * hull])
    assert np.isfinite(detours.lengths(boats)).all()


def test_a_boat_at_the_hull_goes_away_from_it_first():
    course, _ = around().course(np.array([0.1 - 0.14j]), np.array([2]))
    np.testing.assert_allclose(course, [-1j])
