"""Paths of straight legs among obstacles, for a vessel that a team turns on the spot.

The vessel with its team is a box that is driven along its axis, either way. It turns only where
the circle round it is clear of all obstacles, so a turn needs no check of its own. Between two such
places it is driven straight, so that the box sweeps a longer box: the check of a leg is exact, and
cheap. Places are those of a grid round start and goal; the fastest path through them is found by
A*. A start or a goal where the circle is not clear is left, or reached, straight along the axis.
"""

import math
from typing import NamedTuple

import numpy as np

from asv_env.capsules import hull_distance, segment_distance
from asv_env.compiled import allocating, compiled
from asv_env.geometry import wrapped
from asv_env.types import Bool, Complex, Float, Int

WAYS = 2  #: ahead and astern
STRAIGHT = 1e-6  #: turn that is none, rad
UNKNOWN = math.inf  #: clearance of a leg that was not looked at yet, m
LEGS = 8  #: most legs of a path


class Box(NamedTuple):
    """What is driven, about the vessel's centre."""

    along: float  #: how far it reaches along the axis, either way, m
    aside: float  #: how far it reaches across the axis, m
    reach: float  #: radius of the circle round it, m
    axis: float  #: direction of the axis in the vessel's frame, rad


class Times(NamedTuple):
    """What the parts of a path take."""

    speed: float  #: of the vessel on a leg, m/s
    yaw_rate: float  #: of the vessel that turns, rad/s
    #: time for speeding up and braking, of a leg and of the turn before it, s; a leg without any
    #: clearance is avoided at the price of another one
    stop: float


class Room(NamedTuple):
    """How far paths keep from obstacles, and where they are looked for."""

    least: float  #: least clearance, m
    wanted: float  #: clearance beyond which more is worth nothing, m
    spacing: float  #: of the grid, m
    margin: float  #: how far the grid reaches beyond start and goal, m


class Places(NamedTuple):
    """Where legs meet: the start, the goal, and then those of the grid."""

    position: Complex  #: (n,) m
    turns: Bool  #: (n,) whether the vessel can turn there


class Path(NamedTuple):
    """Legs, in order; none where there is no path."""

    point: Complex  #: (n,) where each leg ends, m
    heading: Float  #: (n,) of the vessel on it, rad


@compiled
def swept_clearance(
    start: complex, end: complex, box: Box, obstacle: Float, room: Room, corners: Float
) -> float:
    """Returns the clearance of a box driven from place to place, at most the wanted one, m.

    Where it is less than the least one it is some such number. ``corners`` (4, 2) is memory.
    """
    way = end - start
    distance = abs(way)
    along = way / distance if distance > 0.0 else complex(1.0, 0.0)
    aside, middle = 1j * along * box.aside, (start + end) / 2
    first, last = start - along * box.along, end + along * box.along
    reach, placed, nearest = distance / 2 + box.reach, False, room.wanted
    for k in range(len(obstacle)):
        row = obstacle[k]
        gap = segment_distance(row[0], row[1], row[2], row[3], middle.real, middle.imag) - row[4]
        if gap - reach >= nearest:
            continue
        if not placed:
            for n, corner in enumerate((first - aside, last - aside, last + aside, first + aside)):
                corners[n, 0], corners[n, 1] = corner.real, corner.imag
            placed = True
        nearest = min(nearest, hull_distance(corners, row))
        if nearest < room.least:
            break
    return nearest


@compiled
def can_turn(at: complex, box: Box, obstacle: Float, least: float) -> bool:
    """Returns whether the circle round a box keeps a clearance from obstacles, m."""
    for k in range(len(obstacle)):
        row = obstacle[k]
        gap = segment_distance(row[0], row[1], row[2], row[3], at.real, at.imag) - row[4]
        if gap < box.reach + least:
            return False
    return True


@allocating
def places(start: Float, goal: Float, box: Box, room: Room, obstacle: Float) -> Places:
    """Returns where legs can meet between poses (3,) m, m, rad."""
    ends = start, goal
    middle = complex(start[0] + goal[0], start[1] + goal[1]) / 2
    way = complex(goal[0] - start[0], goal[1] - start[1])
    distance = abs(way)
    frame = way / distance if distance > 0.0 else complex(1.0, 0.0)
    columns = math.ceil((distance / 2 + room.margin) / room.spacing)
    rows = math.ceil(room.margin / room.spacing)
    count = 2 + (2 * columns + 1) * (2 * rows + 1) + 4 * columns
    position, turns = np.empty(count, np.complex128), np.ones(count, np.bool_)
    for k in range(2):
        position[k] = complex(ends[k][0], ends[k][1])
        turns[k] = can_turn(position[k], box, obstacle, room.least)
    n = 2
    for i in range(-columns, columns + 1):
        for j in range(-rows, rows + 1):
            at = middle + frame * room.spacing * complex(i, j)
            if can_turn(at, box, obstacle, room.least):
                position[n] = at
                n += 1
    for k in range(2):
        course = box.axis + ends[k][2]
        along = complex(math.cos(course), math.sin(course))
        for i in range(-columns, columns + 1):
            at = position[k] + i * room.spacing * along
            if not turns[k] and i != 0 and can_turn(at, box, obstacle, room.least):
                position[n] = at
                n += 1
    return Places(position[:n], turns[:n])


@allocating
def search(
    start: Float, goal: Float, box: Box, times: Times, room: Room, obstacle: Float
) -> Path:  # fmt: skip
    """Returns the fastest path from pose to pose, (3,) m, m, rad.

    Args:
        start: where the vessel is.
        goal: where it is to be.
        box: what is driven.
        times: what the parts of a path take.
        room: how far it keeps from obstacles, and where it is looked for.
        obstacle: (M, 5) rows.
    """
    position, turns = places(start, goal, box, room, obstacle)
    count = len(position)
    clear, corners = np.full((count, count), UNKNOWN), np.empty((4, 2))
    time, bound = np.full((count, WAYS), np.inf), np.full((count, WAYS), np.inf)
    course, before = np.empty((count, WAYS)), np.full((count, WAYS), -1)
    done = np.zeros((count, WAYS), np.bool_)
    time[0, 0], course[0, 0], bound[0, 0] = 0.0, start[2], 0.0
    best, final = math.inf, -1
    while True:
        state, least = -1, best
        for s in range(count * WAYS):
            if not done.flat[s] and bound.flat[s] < least:
                state, least = s, bound.flat[s]
        if state < 0:
            return traced(position, course, before, final)
        n, came = state // WAYS, state % WAYS
        done[n, came] = True
        if n == 1:
            turn = abs(wrapped(goal[2] - course[n, came]))
            total = time[n, came] + turn / times.yaw_rate
            if total < best and (turns[n] or turn < STRAIGHT):
                best, final = total, state
        for m in range(1, count):
            way = position[m] - position[n]
            distance, bearing = abs(way), course[n, came] + box.axis
            if distance > 0.0:
                bearing = math.atan2(way.imag, way.real)
            to_go = abs(position[1] - position[m]) / times.speed
            for astern in range(WAYS):
                ahead = bearing - box.axis + math.pi * astern
                turn = abs(wrapped(ahead - course[n, came]))
                if done[m, astern] or not (turns[n] or turn < STRAIGHT):
                    continue
                total = time[n, came] + times.stop + turn / times.yaw_rate + distance / times.speed
                if total >= time[m, astern] or total + to_go >= best:
                    continue
                if clear[n, m] == UNKNOWN:
                    clear[n, m] = clear[m, n] = swept_clearance(
                        position[n], position[m], box, obstacle, room, corners
                    )
                if clear[n, m] < room.least:
                    continue
                total += times.stop * (1.0 - clear[n, m] / room.wanted)
                if total < time[m, astern]:
                    time[m, astern], course[m, astern], before[m, astern] = total, ahead, state
                    bound[m, astern] = total + to_go


@allocating
def traced(position: Complex, course: Float, before: Int, final: int) -> Path:
    """Returns the path to a state, if it has no more than ``LEGS`` legs."""
    point, heading = np.empty(LEGS, np.complex128), np.empty(LEGS)
    legs, state = 0, int(final)
    while state >= WAYS and legs < LEGS:
        legs += 1
        point[-legs], heading[-legs] = position[state // WAYS], course.flat[state]
        state = int(before.flat[state])
    first = LEGS - legs if 0 <= state < WAYS else LEGS
    return Path(point[first:], heading[first:])
