"""Outlines of hulls: polygons of corners (n, 2) m, or of complex corners (n,) x + iy.

They are simple, and counter-clockwise unless something else is said.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.spatial import ConvexHull

from asv_env.compiled import compiled
from asv_env.types import Complex, Float

Corners = Sequence[tuple[float, float]]
LEVEL = 1e-9  #: largest slant of an edge that counts as along an axis, extents


def complex_corners(corners: Corners) -> Complex:
    """Returns corners as complex numbers x + iy (n,)."""
    return np.array(corners, dtype=np.float64).view(np.complex128)[:, 0]


def edges(corners: Corners) -> tuple[Float, Float]:
    """Returns the first corner (n, 2) of each edge, and the vector (n, 2) along it, m."""
    points = np.array(corners, dtype=np.float64)
    return points, np.roll(points, -1, axis=0) - points


def _cross(one: Float, other: Float) -> Float:
    crossed: Float = one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]
    return crossed


def area(corners: Corners) -> float:
    """Returns the area, m^2; negative of a clockwise polygon."""
    points, along = edges(corners)
    return float(_cross(points - points[0], along).sum() / 2)


def centroid(corners: Corners) -> tuple[float, float]:
    """Returns the centroid of the area, m."""
    points, along = edges(corners)
    first = points[0]
    cross = _cross(points - first, along)
    x, y = first + (cross[:, None] * (2 * (points - first) + along)).sum(axis=0) / (3 * cross.sum())
    return float(x), float(y)


def second_moments(corners: Corners) -> tuple[float, float]:
    """Returns the integrals of x^2 and of y^2 over the area, m^4."""
    points, along = edges(corners)
    following = points + along
    squares = points**2 + points * following + following**2
    x, y = (_cross(points, following)[:, None] * squares).sum(axis=0) / 12
    return float(x), float(y)


def gyration(corners: Corners) -> float:
    """Returns the squared radius of gyration of a uniform polygon about the origin, m^2.

    It is the area integral over the triangles that the edges span with the origin.
    """
    points = np.array(corners)
    following = np.roll(points, -1, axis=0)
    cross = points[:, 0] * following[:, 1] - points[:, 1] * following[:, 0]
    squares = (points**2 + points * following + following**2).sum(axis=1)
    return float((cross * squares).sum() / (6 * cross.sum()))


def extents(corners: Corners) -> tuple[float, float, float, float]:
    """Returns the least and the largest x, and the least and the largest y, m."""
    x, y = zip(*corners, strict=True)
    return min(x), max(x), min(y), max(y)


def reach(corners: Corners) -> float:
    """Returns the distance of the farthest corner from the origin, m."""
    return max(math.hypot(x, y) for x, y in corners)


def is_simple(corners: Corners) -> bool:
    """Returns whether no edge meets another one but at their common corner."""
    return bool(_is_simple(complex_corners(corners)))


@compiled
def _is_simple(corners: Complex) -> bool:
    count = len(corners)
    for i in range(count):
        a, b = corners[i], corners[(i + 1) % count]
        for k in range(i + 1, count):
            c, d = corners[k], corners[(k + 1) % count]
            if k == i + 1:
                meets = _folds(a, b, d)
            elif k - i == count - 1:
                meets = _folds(c, d, b)
            else:
                meets = _meet(a, b, c, d)
            if meets:
                return False
    return True


@compiled
def _cross_sign(one: complex, other: complex) -> int:
    cross = one.real * other.imag - one.imag * other.real
    return int(cross > 0.0) - int(cross < 0.0)


@compiled
def _meet(a: complex, b: complex, c: complex, d: complex) -> bool:
    """Returns whether the edges from a to b and from c to d have a point in common."""
    if _cross_sign(b - a, c - a) * _cross_sign(b - a, d - a) > 0:
        return False
    if _cross_sign(d - c, a - c) * _cross_sign(d - c, b - c) > 0:
        return False
    # Edges on one line meet where their boxes do.
    along_x = min(c.real, d.real) <= max(a.real, b.real)
    along_x &= max(c.real, d.real) >= min(a.real, b.real)
    along_y = min(c.imag, d.imag) <= max(a.imag, b.imag)
    along_y &= max(c.imag, d.imag) >= min(a.imag, b.imag)
    return along_x and along_y


@compiled
def _folds(a: complex, b: complex, c: complex) -> bool:
    """Returns whether the edge from b to c goes straight back on the one from a to b."""
    one, other = b - a, c - b
    ahead = one.real * other.real + one.imag * other.imag
    return ahead < 0.0 and _cross_sign(one, other) == 0


def is_convex(corners: Corners) -> bool:
    """Returns whether no corner points inwards."""
    _, along = edges(corners)
    return bool((_cross(along, np.roll(along, -1, axis=0)) >= 0).all())


def convex_hull(corners: Corners) -> list[tuple[float, float]]:
    """Returns the corners of the convex hull, counter-clockwise; of a convex polygon its own."""
    if is_convex(corners):
        return list(corners)
    return [corners[index] for index in ConvexHull(np.array(corners)).vertices]


def upper_side(corners: Corners) -> tuple[Float, Float]:
    """Returns x and y of the corners of the convex hull's upper side, from the least x on, m."""
    hull = np.array(convex_hull(corners))
    x, y = hull.T
    ends = LEVEL * np.ptp(x)
    right, left = np.flatnonzero(x >= x.max() - ends), np.flatnonzero(x <= x.min() + ends)
    start, end = right[y[right].argmax()], left[y[left].argmax()]
    chain = np.arange(start, start + (end - start) % len(hull) + 1) % len(hull)
    return x[chain][::-1], y[chain][::-1]


def end_height(corners: Corners, end: float) -> float:
    """Returns the mean y of a polygon's edge or corner at an end, whose x is ``end``, m."""
    points = np.array(corners)
    y = points[abs(points[:, 0] - end) <= LEVEL * np.ptp(points[:, 0]), 1]
    return float(y.max() + y.min()) / 2


def crossings(corners: Corners, height: float) -> Float:
    """Returns the x at which the outline crosses a line y = ``height``, in order, m."""
    points, along = edges(corners)
    below = points[:, 1] < height
    crosses = below != np.roll(below, -1)
    start, step = points[crosses], along[crosses]
    return np.sort(start[:, 0] + (height - start[:, 1]) / step[:, 1] * step[:, 0])


def turned(corners: Corners) -> list[tuple[float, float]]:
    """Returns a polygon turned by a right angle, clockwise: what was y becomes x."""
    return [(y, -x) for x, y in corners]


def inset(corners: Complex, margin: float) -> Complex:
    """Returns a polygon (n,) whose edges lie ``margin`` m further inside; for small margins."""
    along = np.roll(corners, -1) - corners
    inwards = 1j * along / np.abs(along)
    before = np.roll(inwards, 1)
    # The corner's shift has the component ``margin`` along both edges' normals.
    shift = (before + inwards) / (1 + (before * inwards.conj()).real)
    shifted: Complex = corners + margin * shift
    return shifted


@compiled
def contains(corners: Complex, point: complex) -> bool:
    """Returns whether a point lies within a polygon (n,)."""
    inside, before = False, corners[len(corners) - 1]
    for corner in corners:
        if (corner.imag > point.imag) != (before.imag > point.imag):
            share = (point.imag - corner.imag) / (before.imag - corner.imag)
            inside ^= point.real < corner.real + share * (before.real - corner.real)
        before = corner
    return inside


class Outline(NamedTuple):
    """Edges of a polygon, which end at its corners in order."""

    end: Complex  #: (n,) m
    edge: Complex  #: (n,) vector along each, m
    square: Float  #: (n,) of its length, m^2
    normal: Complex  #: (n,) of length 1


def outline(corners: Complex) -> Outline:
    """Returns the edges of a polygon (n,)."""
    edge = corners - np.roll(corners, 1)
    length = np.hypot(edge.real, edge.imag)
    return Outline(corners, edge, length * length, edge.imag / length - 1j * (edge.real / length))


@compiled
def to_outline(outline: Outline, point: complex) -> complex:
    """Returns the vector from a point to the nearest point of a polygon's outline, m."""
    nearest, least = outline.end[0] - point, math.inf
    to_start = outline.end[len(outline.end) - 1] - point
    for k in range(len(outline.end)):
        edge, normal, to_end = outline.edge[k], outline.normal[k], outline.end[k] - point
        along = -(to_start.real * edge.real + to_start.imag * edge.imag)
        # The part of the way to a corner that is across the edge, or a corner where it is nearer.
        gap = to_start.real * normal.real + to_start.imag * normal.imag
        x, y = gap * normal.real, gap * normal.imag
        if along <= 0.0:
            x, y = to_start.real, to_start.imag
        elif along >= outline.square[k]:
            x, y = to_end.real, to_end.imag
        square = x * x + y * y
        if square < least:
            nearest, least = complex(x, y), square
        to_start = to_end
    return nearest


def gap_to(outline: Outline, point: complex) -> float:
    """Returns the distance of a point from a polygon, m; 0 within it."""
    return 0.0 if contains(outline.end, point) else abs(to_outline(outline, point))


def roomiest(corners: Corners, steps: int = 24) -> tuple[float, float, float]:
    """Returns where the most of a polygon is round a point: x, y and the radius there, m.

    It is the centroid where hardly any other place has more room, found on a coarse grid.
    """
    around, (left, right, bottom, top) = outline(complex_corners(corners)), extents(corners)
    x, y = centroid(corners)
    grid = [
        complex(left + (right - left) * i / steps, bottom + (top - bottom) * k / steps)
        for i in range(1, steps)
        for k in range(1, steps)
    ]
    middle = complex(x, y)
    rooms = [
        (abs(to_outline(around, point)), -abs(point - middle), point)
        for point in [middle, *grid]
        if contains(around.end, point)
    ]
    most = 0.97 * max(room for room, _, _ in rooms)
    room, _, point = max((one for one in rooms if one[0] >= most), key=lambda one: one[1])
    return point.real, point.imag, room
