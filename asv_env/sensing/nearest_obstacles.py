"""The nearest obstacles as they are observed: their nearest points, in a hull's frame."""

import numpy as np

from asv_env.capsules import gap_to
from asv_env.compiled import allocating, compiled
from asv_env.tasks.laws import direction_of
from asv_env.types import Complex, Float, Int

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
    point: Complex,
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
        gap: (``OBSTACLES``,) memory for the search.
        point: (``OBSTACLES``,) memory for the search.
        row: receives ``OF_OBSTACLE`` of each, one after the other.
    """
    found = 0
    for group in range(len(groups) - 1):
        distance, vector = gap_to(obstacle, groups, group, x, y)
        place = found
        while place > 0 and gap[place - 1] > distance:
            place -= 1
        if place == OBSTACLES:
            continue
        found = min(found + 1, OBSTACLES)
        for k in range(found - 1, place, -1):
            gap[k], point[k] = gap[k - 1], point[k - 1]
        gap[place], point[place] = distance, vector
    for k in range(found):
        seen = point[k] * to_hull
        row[3 * k], row[3 * k + 1], row[3 * k + 2] = seen.real, seen.imag, 1.0


@allocating
def fill_obstacles(obstacle: Float, groups: Int, motion: Float, columns: Float) -> None:
    """Writes the columns (W, n) of the nearest obstacles (W, M, 5) to hulls with motions (W, 6)."""
    gap, point = np.zeros(OBSTACLES), np.zeros(OBSTACLES, np.complex128)
    for w in range(len(motion)):
        x, y, to_hull = motion[w, 0], motion[w, 1], direction_of(motion[w, 2]).conjugate()
        put_obstacles(obstacle[w], groups, x, y, to_hull, gap, point, columns[w])
