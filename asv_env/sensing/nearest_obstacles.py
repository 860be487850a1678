"""The nearest obstacles as they are observed: their nearest points, in a hull's frame."""

import math

import numpy as np

from asv_env.capsules import gap_to
from asv_env.compiled import allocating, compiled
from asv_env.tasks.laws import direction_of
from asv_env.types import Float, Int

OBSTACLES = 3  #: number of obstacles that are observed, near to far
OF_OBSTACLE = ("x", "y", "present")  #: columns of each of them


@compiled
def put_obstacles(
    obstacle: Float,
    groups: Int,
    x: float,
    y: float,
    to_hull: complex,
    gap: Float,
    row: Float,
) -> None:
    """Writes the columns of the nearest obstacles; of equally near ones in order.

    Columns of those that there are not stay as they are.

    Args:
        obstacle: (M, 5) rows of ``asv_env.capsules``.
        groups: (G + 1,) first rows of the obstacles.
        x: position of the hull, m.
        y: likewise.
        to_hull: turns vectors of the world into the hull's frame.
        gap: (G,) memory for the search.
        row: receives ``OF_OBSTACLE`` of each, one after the other.
    """
    for group in range(len(gap)):
        gap[group], _ = gap_to(obstacle, groups, group, x, y)
    for k in range(min(len(gap), OBSTACLES)):
        nearest, least = 0, math.inf
        for group in range(len(gap)):
            if gap[group] < least:
                nearest, least = group, gap[group]
        gap[nearest] = math.inf
        _, vector = gap_to(obstacle, groups, nearest, x, y)
        seen = vector * to_hull
        row[3 * k], row[3 * k + 1], row[3 * k + 2] = seen.real, seen.imag, 1.0


@allocating
def fill_obstacles(obstacle: Float, groups: Int, motion: Float, columns: Float) -> None:
    """Writes the columns (W, n) of the nearest obstacles (W, M, 5) to hulls with motions (W, 6)."""
    gap = np.empty(len(groups) - 1)
    for w in range(len(motion)):
        x, y, to_hull = motion[w, 0], motion[w, 1], direction_of(motion[w, 2]).conjugate()
        put_obstacles(obstacle[w], groups, x, y, to_hull, gap, columns[w])
