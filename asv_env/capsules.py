"""Capsules: segments with a radius, of which obstacles consist, and how far away they are.

Obstacles are rows (M, 5): x and y of one end, x and y of the other, m, and the radius, m. A round
pillar is a row of no length. A polygon is a group of three or more rows, its edges in order, and
is solid; any other group is one row. ``groups`` (G + 1,) holds the first row of every group, and M.
"""

import math

import numpy as np

from asv_env.compiled import allocating, compiled
from asv_env.polygons import contains
from asv_env.types import Float, Int

POLYGON = 3  #: fewest rows of a group that is a polygon


@compiled
def offset(ax: float, ay: float, bx: float, by: float, x: float, y: float) -> tuple[float, float]:
    """Returns the vector from a point to the nearest one of the segment from a to b, m."""
    dx, dy = bx - ax, by - ay
    square, share = dx * dx + dy * dy, 0.0
    if square > 0.0:
        share = min(max(((x - ax) * dx + (y - ay) * dy) / square, 0.0), 1.0)
    return ax + share * dx - x, ay + share * dy - y


@compiled
def segment_distance(ax: float, ay: float, bx: float, by: float, x: float, y: float) -> float:
    """Returns the distance of a point to the segment from a to b, m."""
    dx, dy = offset(ax, ay, bx, by, x, y)
    return math.sqrt(dx * dx + dy * dy)


@compiled
def encloses(obstacle: Float, first: int, last: int, x: float, y: float) -> bool:
    """Returns whether the polygon of rows ``first`` to ``last - 1`` encloses a point."""
    inside = False
    for k in range(first, last):
        ax, ay, bx, by = obstacle[k, 0], obstacle[k, 1], obstacle[k, 2], obstacle[k, 3]
        if (ay > y) != (by > y) and x < ax + (y - ay) * (bx - ax) / (by - ay):
            inside = not inside
    return inside


@compiled
def gap_to(obstacle: Float, groups: Int, group: int, x: float, y: float) -> tuple[float, complex]:
    """Returns the distance of a point to a group, m, and the vector to its nearest point, m.

    Within the group both are zero.
    """
    first, last = groups[group], groups[group + 1]
    nearest, vector = math.inf, complex(0.0, 0.0)
    for k in range(first, last):
        row = obstacle[k]
        dx, dy = offset(row[0], row[1], row[2], row[3], x, y)
        length = math.sqrt(dx * dx + dy * dy)
        gap = length - row[4]
        if gap < nearest:
            share = gap / length if gap > 0.0 else 0.0
            nearest, vector = gap, complex(share * dx, share * dy)
    if last - first >= POLYGON and encloses(obstacle, first, last, x, y):
        nearest, vector = 0.0, complex(0.0, 0.0)
    return max(nearest, 0.0), vector


@compiled
def nearest_gap(obstacle: Float, groups: Int, x: float, y: float) -> float:
    """Returns the distance of a point to the nearest group, m; 0 within one."""
    nearest = math.inf
    for group in range(len(groups) - 1):
        nearest = min(nearest, gap_to(obstacle, groups, group, x, y)[0])
    return nearest


@compiled
def crosses(
    ax: float, ay: float, bx: float, by: float, cx: float, cy: float, dx: float, dy: float
) -> bool:
    """Returns whether the segments from a to b and from c to d cross."""
    abc = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    abd = (bx - ax) * (dy - ay) - (by - ay) * (dx - ax)
    cda = (dx - cx) * (ay - cy) - (dy - cy) * (ax - cx)
    cdb = (dx - cx) * (by - cy) - (dy - cy) * (bx - cx)
    return abc * abd < 0.0 and cda * cdb < 0.0


@compiled
def hull_distance(corners: Float, row: Float) -> float:
    """Returns the distance of a hull, by its corners (n, 2), to a row, m; 0 or less: overlap."""
    if contains(corners.view(np.complex128)[:, 0], complex(row[0], row[1])):
        return -row[4]
    nearest, last = math.inf, len(corners) - 1
    for k in range(len(corners)):
        ax, ay, bx, by = corners[last, 0], corners[last, 1], corners[k, 0], corners[k, 1]
        if crosses(ax, ay, bx, by, row[0], row[1], row[2], row[3]):
            return -row[4]
        for end in range(2):
            x, y = row[2 * end], row[2 * end + 1]
            nearest = min(nearest, segment_distance(ax, ay, bx, by, x, y))
        nearest = min(nearest, segment_distance(row[0], row[1], row[2], row[3], bx, by))
        last = k
    return nearest - row[4]


@allocating
def clearance(obstacle: Float, groups: Int, corners: Float) -> float:
    """Returns the distance of a hull to the nearest obstacle, m; 0 or less where they overlap.

    Args:
        obstacle: (M, 5) rows.
        groups: (G + 1,) first rows of the groups.
        corners: (n, 2) of the hull in the world, in order, m.
    """
    nearest = math.inf
    for row in range(len(obstacle)):
        nearest = min(nearest, hull_distance(corners, obstacle[row]))
    for group in range(len(groups) - 1):
        first, last = groups[group], groups[group + 1]
        solid = last - first >= POLYGON
        if solid and encloses(obstacle, first, last, corners[0, 0], corners[0, 1]):
            nearest = min(nearest, 0.0)
    return nearest
