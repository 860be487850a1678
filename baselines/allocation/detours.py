"""Shortest paths of boats round the hull to the waypoints in front of their contact points.

Boats keep a distance from the hull at which they also pass the sterns of those that have docked.
What they go round is the hull, grown by this distance with its corners cut. Round such a convex
polygon a shortest path is straight, or leads over some of its corners.
"""

import math

import numpy as np

from asv_env.compiled import allocating
from asv_env.types import Complex, Float, Int

Tables = tuple[Complex, Float, Complex, Complex, Float]
"""Normals and offsets of what is gone round, its corners, the waypoints, and from each to each."""
GRAZES = 1e-9  #: part of a straight line that may lie inside, because of rounding
CUT = 0.5  #: turn of the outline at a corner above which the grown corner is cut, rad
TOUCH = 0.01  #: how much less is gone round than the clearance, fraction of it


class Detours:
    """Paths to the waypoints (n,) of a formation, vessel frame."""

    def __init__(self, hull: Complex, clearance: float, waypoint: Complex) -> None:
        """Finds the shortest paths from all corners of what is gone round.

        Args:
            hull: (m,) corners of the convex hull, counter-clockwise, m.
            clearance: distance from it that boats keep, m.
            waypoint: (n,) at that distance or beyond, m.
        """
        self._normal, self._offset = _grown(hull, clearance * (1 - TOUCH))
        self._node = _corners(*_grown(hull, clearance))
        self._waypoint = waypoint
        self._rest: Float = np.full((len(self._node), len(waypoint)), np.inf)
        shape = self._normal, self._offset
        for j, point in enumerate(waypoint):
            for k, node in enumerate(self._node):
                if not crosses(*shape, node, point):
                    self._rest[k, j] = abs(point - node)
        sides = np.abs(np.roll(self._node, -1) - self._node)
        for _ in range(len(self._node)):
            ahead = np.roll(self._rest, -1, axis=0) + sides[:, None]
            behind = np.roll(self._rest, 1, axis=0) + np.roll(sides, 1)[:, None]
            self._rest = np.minimum(self._rest, np.minimum(ahead, behind))

    def lengths(self, boat: Complex) -> Float:
        """Returns the path lengths (A, n) of boats (A,) to all waypoints, m."""
        numbers = np.arange(len(self._waypoint))
        target = np.tile(numbers, (len(boat), 1))
        return self.course(np.repeat(boat[:, None], len(numbers), axis=1), target)[1]

    def course(self, boat: Complex, target: Int) -> tuple[Complex, Float]:
        """Returns the directions (...) of boats (...) to waypoints (...), and the lengths."""
        tables = self._normal, self._offset, self._node, self._waypoint, self._rest
        places, targets = np.ascontiguousarray(boat), np.ascontiguousarray(target)
        direction, length = _courses(places.ravel(), targets.ravel(), tables)
        return direction.reshape(boat.shape), length.reshape(boat.shape)


def _grown(hull: Complex, clearance: float) -> tuple[Complex, Float]:
    """Returns normals and offsets of the half-planes whose intersection is the grown hull."""
    edge = np.roll(hull, -1) - hull
    normal = -1j * edge / np.abs(edge)
    normals, offsets = [], []
    for k in range(len(hull)):
        before, after, corner = normal[k - 1], normal[k], hull[k]
        turn = float(np.angle(after * np.conj(before)))
        cuts = int(turn / CUT)
        for cut in range(1, cuts + 1):
            one = before * np.exp(1j * turn * cut / (cuts + 1))
            normals.append(one)
            offsets.append((one * np.conj(corner)).real + clearance)
        normals.append(after)
        offsets.append((after * np.conj(corner)).real + clearance)
    return np.array(normals), np.array(offsets)


def _corners(normal: Complex, offset: Float) -> Complex:
    """Returns where the lines of neighbouring half-planes cross."""
    after, further = np.roll(normal, -1), np.roll(offset, -1)
    cross = (normal.conj() * after).imag
    corner: Complex = 1j * (after * offset - normal * further) / -cross
    return corner


@allocating
def crosses(normal: Complex, offset: Float, start: complex, end: complex) -> bool:
    """Returns whether a straight line leads through the inside of half-planes (m,)."""
    first, last = 0.0, 1.0
    way = end - start
    for k in range(len(normal)):
        height = normal[k].real * start.real + normal[k].imag * start.imag - offset[k]
        rise = normal[k].real * way.real + normal[k].imag * way.imag
        if rise == 0.0:
            if height >= 0.0:
                return False
        elif rise < 0.0:
            first = max(first, -height / rise)
        else:
            last = min(last, -height / rise)
        if last - first <= GRAZES:
            return False
    return True


@allocating
def _courses(boat: Complex, target: Int, tables: Tables) -> tuple[Complex, Float]:
    """Returns directions and lengths (n,) of the paths of boats (n,) to waypoints (n,)."""
    normal, offset, node, waypoint, rest = tables
    direction, length = np.zeros(len(boat), np.complex128), np.zeros(len(boat))
    for b in range(len(boat)):
        start, goal, out, edge = boat[b], target[b], -math.inf, 0
        for k in range(len(normal)):
            height = normal[k].real * start.real + normal[k].imag * start.imag - offset[k]
            if height > out:
                out, edge = height, k
        if out < 0.0:  # Inside: the nearest way out comes first.
            start = start - 1.001 * out * normal[edge]
        best, following = math.inf, waypoint[goal]
        if not crosses(normal, offset, start, waypoint[goal]):
            best = abs(waypoint[goal] - start)
        else:
            for k in range(len(node)):
                total = abs(node[k] - start) + rest[k, goal]
                if total < best and not crosses(normal, offset, start, node[k]):
                    best, following = total, node[k]
        if best == math.inf:  # Rounding hides all corners: the boat is at one.
            best = abs(waypoint[goal] - start)
        way = normal[edge] if out < 0.0 else following - start
        size = abs(way)
        direction[b] = way / size if size > 0.0 else 0j
        length[b] = best + max(-out, 0.0)
    return direction, length
