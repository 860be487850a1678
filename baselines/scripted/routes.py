"""Routes of boats round obstacles and the vessel: shortest ways between points that stay clear.

Obstacles are rows of ``asv_env.capsules``; the vessel adds the edges of its outline. Boats are
points that keep a clearance from all rows. A route is a shortest way in the visibility graph of the
corners of octagons round the ends of the rows. Only the next corner is kept, and how long the route
is from there; a new route is looked for when a boat gets to its corner, or no longer sees it.
"""

import math
from typing import NamedTuple

import numpy as np

from asv_env.capsules import crosses, offset, segment_distance
from asv_env.compiled import allocating, compiled
from asv_env.geometry import xy
from asv_env.types import Bool, Complex, Float

CORNERS = 8  #: corners round an end of a row
SLACK = 0.98  #: clearance of what counts as free, fraction of that of the corners
START = 0.95  #: the same for the way out of where there is less, fraction of what there is
ARRIVED = 1.0  #: distance to a corner at which a boat looks for the next one, clearances
NEAR = 0.9  #: distance to the vessel at which a boat leaves it before all else, clearances
TINY = 1e-9  #: margin for rounding, m
AWAY = complex(math.inf, 0.0)  #: target of a boat that leaves the vessel


class Routes(NamedTuple):
    """Where boats are heading; positions in the world, m."""

    via: Complex  #: (W, A) next corner, or the target
    left: Float  #: (W, A) length of the route from there to the target, m
    target: Complex  #: (W, A) to which the route leads


def edge_rows(corners: Complex) -> Float:
    """Returns the edges of outlines with corners (W, n) as rows (W, n, 5)."""
    ends = xy(corners), xy(np.roll(corners, -1, axis=1)), np.zeros((*corners.shape, 1))
    return np.concatenate(ends, axis=-1)


@compiled
def apart(one: complex, other: complex, row: Float) -> float:
    """Returns the distance between the segment from point to point and a row, m."""
    ax, ay, bx, by = one.real, one.imag, other.real, other.imag
    if crosses(ax, ay, bx, by, row[0], row[1], row[2], row[3]):
        return -row[4]
    nearest = min(
        segment_distance(row[0], row[1], row[2], row[3], ax, ay),
        segment_distance(row[0], row[1], row[2], row[3], bx, by),
    )
    nearest = min(nearest, segment_distance(ax, ay, bx, by, row[0], row[1]))
    return min(nearest, segment_distance(ax, ay, bx, by, row[2], row[3])) - row[4]


@compiled
def is_clear(one: complex, other: complex, rows: Float, clearance: float) -> bool:
    """Returns whether the segment from point to point keeps a clearance from all rows, m."""
    left, right = min(one.real, other.real), max(one.real, other.real)
    bottom, top = min(one.imag, other.imag), max(one.imag, other.imag)
    for k in range(len(rows)):
        row = rows[k]
        # Most rows are so far away that the boxes round the segments tell.
        beside = max(min(row[0], row[2]) - right, left - max(row[0], row[2]))
        above = max(min(row[1], row[3]) - top, bottom - max(row[1], row[3]))
        if max(beside, above) > row[4] + clearance + TINY:
            continue
        if apart(one, other, row) < clearance:
            return False
    return True


@allocating
def corners(rows: Float, clearance: float) -> Complex:
    """Returns the points (n,), m, at which routes can bend."""
    found, count = np.empty(2 * CORNERS * len(rows), np.complex128), 0
    for k in range(len(rows)):
        row = rows[k]
        ends = 1 if row[0] == row[2] and row[1] == row[3] else 2
        along = math.atan2(row[3] - row[1], row[2] - row[0])
        radius = (row[4] + clearance) / math.cos(math.pi / CORNERS)
        for end in range(ends):
            for n in range(CORNERS):
                angle = along + 2 * math.pi * (n + 0.5) / CORNERS
                point = complex(row[2 * end], row[2 * end + 1])
                point += radius * complex(math.cos(angle), math.sin(angle))
                if is_clear(point, point, rows, SLACK * clearance):
                    found[count] = point
                    count += 1
    return found[:count]


@allocating
def shortest(
    start: complex, target: complex, bends: Complex, rows: Float, clearance: float
) -> tuple[complex, float]:
    """Returns the first corner of the shortest route, m, and the length of the rest of it, m.

    This is the algorithm A*. Where there is no route they are the target and 0.
    """
    count, free = len(bends), SLACK * clearance
    leaves = min(free, START * max(apart_from_all(start, rows), 0.0))
    arrives = min(free, START * max(apart_from_all(target, rows), 0.0))
    way, first = np.full(count, np.inf), np.full(count, -1)
    done = np.zeros(count, np.bool_)
    for n in range(count):
        if is_clear(start, bends[n], rows, leaves):
            way[n], first[n] = abs(bends[n] - start), n
    while True:
        best, least = -1, math.inf
        for n in range(count):
            estimate = way[n] + abs(target - bends[n])
            if not done[n] and estimate < least:
                best, least = n, estimate
        if best < 0:
            return target, 0.0
        done[best] = True
        if is_clear(bends[best], target, rows, arrives):
            bend = bends[first[best]]
            return bend, least - abs(bend - start)
        for n in range(count):
            length = way[best] + abs(bends[n] - bends[best])
            if not done[n] and length < way[n] and is_clear(bends[best], bends[n], rows, free):
                way[n], first[n] = length, first[best]


@compiled
def repelled(point: complex, rows: Float, clearance: float) -> complex:
    """Returns the sum of directions away from rows within the clearance, of sizes from 0 to 1."""
    total = complex(0.0, 0.0)
    for k in range(len(rows)):
        row = rows[k]
        dx, dy = offset(row[0], row[1], row[2], row[3], point.real, point.imag)
        distance = math.sqrt(dx * dx + dy * dy)
        nearness = 1.0 - max(distance - row[4], 0.0) / clearance
        if nearness > 0.0 and distance > 0.0:
            total -= nearness * complex(dx, dy) / distance
    return total


@compiled
def apart_from_all(point: complex, rows: Float) -> float:
    """Returns the distance of a point to the nearest row, m."""
    nearest = math.inf
    for k in range(len(rows)):
        nearest = min(nearest, apart(point, point, rows[k]))
    return nearest


@compiled
def room_between(start: complex, end: complex, rows: Float, free: float) -> float:
    """Returns the clearance of a way whose ends may be nearer to rows than what is free, m."""
    nearest = min(apart_from_all(start, rows), apart_from_all(end, rows))
    return min(free, START * max(nearest, 0.0))


@allocating
def follow(
    boat: Complex, target: Complex, obstacle: Float, hull: Float, clearance: float, wide: float,
    routes: Routes, now: Bool,
) -> tuple[Bool, Complex]:  # fmt: skip
    """Updates the routes of boats to targets.

    Args:
        boat: (W, A) positions, m.
        target: (W, A) m.
        obstacle: (W, M, 5) rows.
        hull: (W, N, 5) edges of the vessel.
        clearance: that boats keep, m.
        wide: clearance that they keep from the vessel where there is room for it, m.
        routes: updated.
        now: (W,) worlds whose routes are all checked. Elsewhere a boat keeps its route until it
            gets to the next corner, or its target has moved by a clearance.

    Returns:
        Whether no obstacle is between boat and target (W, A). Directions (W, A) away from obstacles
        nearer than the clearance, of a size that grows from 0 to 1 at the obstacle.
    """
    sees, away = np.zeros(boat.shape, np.bool_), np.zeros(boat.shape, np.complex128)
    free = SLACK * clearance
    for w in range(boat.shape[0]):
        near, far = np.concatenate((obstacle[w], hull[w])), np.concatenate((obstacle[w], hull[w]))
        far[len(obstacle[w]) :, 4] += wide - clearance
        near_bends: Complex = np.empty(0, np.complex128)
        far_bends: Complex = near_bends
        for a in range(boat.shape[1]):
            start, end, via = boat[w, a], target[w, a], routes.via[w, a]
            away[w, a] = repelled(start, obstacle[w], clearance)
            sees[w, a] = is_clear(start, end, obstacle[w], free)
            room = free
            if not sees[w, a]:  # Both ends may be nearer to something.
                room = room_between(start, end, near, free)
                sees[w, a] = is_clear(start, end, obstacle[w], room)
            moved = not abs(routes.target[w, a] - end) <= clearance
            arrived = routes.left[w, a] > 0.0 and abs(via - start) < ARRIVED * clearance
            if not (now[w] or moved or arrived):
                if routes.left[w, a] == 0.0:
                    routes.via[w, a] = end
                continue
            if room == free:
                room = room_between(start, end, near, free)
            outside = apart_from_all(start, far[len(obstacle[w]) :]) > free
            if is_clear(start, end, far if outside else near, room):
                routes.via[w, a], routes.left[w, a], routes.target[w, a] = end, 0.0, end
                continue
            beside, out = apart_from_all(start, hull[w]), repelled(start, hull[w], 2 * clearance)
            leaves = routes.target[w, a] == AWAY and beside < clearance
            if (beside < NEAR * clearance or leaves) and abs(out) > 0.0:
                routes.via[w, a] = start + 2 * clearance * out / abs(out)
                routes.left[w, a], routes.target[w, a] = abs(end - start), AWAY
                continue
            room = START * max(apart_from_all(start, near), 0.0)
            lost = not is_clear(start, via, near, min(free, room))
            if lost or moved or abs(via - start) < ARRIVED * clearance:
                bend, left = end, 0.0
                if outside:
                    if not len(far_bends):
                        far_bends = corners(far, clearance)
                    bend, left = shortest(start, end, far_bends, far, clearance)
                if left == 0.0:
                    if not len(near_bends):
                        near_bends = corners(near, clearance)
                    bend, left = shortest(start, end, near_bends, near, clearance)
                routes.via[w, a], routes.left[w, a], routes.target[w, a] = bend, left, end
    return sees, away


@allocating
def are_clear(points: Complex, obstacle: Float, clearance: float) -> Bool:
    """Returns which ways (W, A) through points (W, A, N), m, keep a clearance from obstacles, m.

    A way that begins nearer to them may stay as near.
    """
    clear = np.ones(points.shape[:2], np.bool_)
    for w in range(points.shape[0]):
        for a in range(points.shape[1]):
            way = points[w, a]
            room = START * max(apart_from_all(way[0], obstacle[w]), 0.0)
            for n in range(len(way) - 1):
                if not is_clear(way[n], way[n + 1], obstacle[w], min(SLACK * clearance, room)):
                    clear[w, a] = False
                    break
    return clear
