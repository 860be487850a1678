"""Routes of boats round obstacles, by geometry alone."""

import itertools

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from baselines.scripted.routes import (
    Routes,
    are_clear,
    corners,
    edge_rows,
    follow,
    repelled,
    shortest,
)

CLEARANCE = 0.08
FAR_HULL = edge_rows(np.array([[50 + 50j, 51 + 50j, 51 + 51j]]))
places = st.floats(-1.0, 1.0)
circles = st.lists(st.tuples(places, places, st.floats(0.03, 0.2)), min_size=1, max_size=4)


def rows_of(circles):
    return np.array([[x, y, x, y, radius] for x, y, radius in circles])


def gaps(points, rows):
    """Distances (n,) of points (n,) to the nearest pillar, m."""
    centre = rows[:, 0] + 1j * rows[:, 1]
    return (np.abs(points[:, None] - centre) - rows[:, 4]).min(axis=1)


def walked(start, target, rows):
    """Points along the whole route, corner by corner."""
    way, bends = [start], corners(rows, CLEARANCE)
    while way[-1] != target and len(way) < 50:
        here = np.array([way[-1]]), np.array([target])
        segment = np.stack([*here], axis=-1)[None]
        if are_clear(segment, rows[None], CLEARANCE)[0, 0]:
            way.append(target)
        else:
            way.append(shortest(way[-1], target, bends, rows, CLEARANCE)[0])
    pairs = itertools.pairwise(way)
    return np.concatenate([np.linspace(a, b, 200) for a, b in pairs]), way


@given(circles)
def test_routes_keep_clear(circles):
    start, target, rows = -1.5 + 0j, 1.5 + 0j, rows_of(circles)
    points, way = walked(start, target, rows)
    _, left = shortest(start, target, corners(rows, CLEARANCE), rows, CLEARANCE)
    assume(left > 0.0)
    assert way[-1] == target
    assert gaps(points, rows).min() > 0.95 * CLEARANCE


def test_route_round_a_pillar_is_hardly_longer_than_the_tangents():
    rows = rows_of([(0.0, 0.0, 0.3)])
    bend, left = shortest(-1.0 + 0j, 1.0 + 0j, corners(rows, CLEARANCE), rows, CLEARANCE)
    radius = 0.3 + CLEARANCE
    tangents = 2 * np.sqrt(1 - radius**2) + radius * (np.pi - 2 * np.arccos(radius))
    assert tangents <= abs(bend + 1) + left < 1.05 * tangents


def test_a_boat_heads_for_a_target_that_it_sees():
    rows = rows_of([(0.0, 0.0, 0.2)])[None]
    boat, target = np.array([[-1 + 0j, -1 + 1j]]), np.array([[1 + 0j, 1 + 1j]])
    routes = Routes(np.zeros((1, 2), complex), np.zeros((1, 2)), np.full((1, 2), np.nan + 0j))
    sees, away = follow(
        boat, target, rows, FAR_HULL, CLEARANCE, 2 * CLEARANCE, routes, np.ones(len(boat), bool)
    )
    np.testing.assert_array_equal(sees, [[False, True]])
    assert routes.via[0, 1] == target[0, 1]
    assert routes.left[0, 0] > 0.0
    assert not away.any()


@pytest.mark.parametrize(("x", "size"), [(0.3, 0.0), (0.2 + CLEARANCE / 2, 0.5), (0.2, 1.0)])
def test_obstacles_repel_within_the_clearance(x, size):
    rows = rows_of([(0.0, 0.0, 0.2)])
    assert repelled(complex(x), rows, CLEARANCE) == pytest.approx(size)
