"""Legs of paths among obstacles: a turn, a straight and a turn from pose to pose, and clearances.

These are Dubins' words of that kind. Clearance is that of an outline, the vessel's with its team,
and is found by steps no longer than the outline can move without touching anything.
"""

import math
from typing import NamedTuple

from asv_env.capsules import hull_distance, segment_distance
from asv_env.compiled import compiled
from asv_env.geometry import TURN
from asv_env.types import Complex, Float

WORDS = ((1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0))
"""Signs of the curvature of the first and the second turn of a leg."""
ROUNDING = 1e-9  #: turns that are nearly full ones are none, rad
SHORTEST_STEP = 0.02  #: shortest step along a path, reaches of the outline


class Outline(NamedTuple):
    """What has to keep clear of the obstacles, in the vessel's frame."""

    corners: Complex  #: (n,) in order, m
    centre: complex  #: of a circle round it, m
    reach: float  #: radius of that circle, m


class Team(NamedTuple):
    """Outlines of a vessel with its team, which drives it forward along -n."""

    driving: Outline  #: of the team in its slots
    gathering: Outline  #: the same with the room behind it in which it gathers
    switch_cost: float  #: of letting go and grasping the other side, as path length in m


class Terms(NamedTuple):
    """What is asked of a path, and what its parts cost, as path length in m."""

    radii: Float  #: (R,) of the arcs, m
    radius_costs: Float  #: (R,)
    straights: Float  #: (S,) lengths of the last straight, m
    straight_costs: Float  #: (S,)
    least_turning: float  #: least clearance on arcs, m
    least_straight: float  #: least clearance on straights, m
    wanted: float  #: clearance beyond which more is worth nothing, m
    clearance_cost: float  #: of a path without any clearance
    spacing: float  #: of the grid, m
    margin: float  #: how far the grid reaches beyond start and goal, m


class Scene(NamedTuple):
    """What a team moves among, and what is asked of its path."""

    team: Team
    obstacle: Float  #: (M, 5) rows of ``asv_env.capsules``
    terms: Terms
    placed: Float  #: (n, 2) memory for the corners of an outline


@compiled
def leg(
    start: complex, heading: float, end: complex, last: float, first: float, second: float,
    radius: float,
) -> tuple[float, float, float]:  # fmt: skip
    """Returns the lengths of turn, straight and turn from pose to pose, m; inf where there is none.

    ``first`` and ``second`` are the signs of the turns' curvatures.
    """
    from_centre = start + first * radius * complex(math.cos(heading), math.sin(heading))
    to_centre = end + second * radius * complex(math.cos(last), math.sin(last))
    between, offset = to_centre - from_centre, (second - first) * radius
    square = between.real**2 + between.imag**2 - offset**2
    if square < 0.0:
        return math.inf, math.inf, math.inf
    straight = math.sqrt(square)
    course = math.atan2(between.imag, between.real) - math.atan2(-straight, offset)
    if square == 0.0 and offset == 0.0:
        course = heading
    turn, turn_back = first * (course - heading) % TURN, second * (last - course) % TURN
    turn = 0.0 if turn > TURN - ROUNDING else turn
    turn_back = 0.0 if turn_back > TURN - ROUNDING else turn_back
    return radius * turn, straight, radius * turn_back


@compiled
def driven(position: complex, heading: float, curvature: float, length: float) -> complex:
    """Returns the position at the end of an arc, m."""
    half = curvature * length / 2
    chord = length * (math.sin(half) / half if half != 0.0 else 1.0)
    middle = heading + half
    return position + chord * complex(math.sin(middle), -math.cos(middle))


@compiled
def clearance_at(
    position: complex, heading: float, outline: Outline, scene: Scene, wanted: float
) -> float:  # fmt: skip
    """Returns the clearance of an outline at a pose, m; of more than ``wanted`` a lower bound."""
    obstacle, placed = scene.obstacle, scene.placed
    turn = complex(math.cos(heading), math.sin(heading))
    centre, nearest, is_placed = position + turn * outline.centre, math.inf, False
    for k in range(len(obstacle)):
        row = obstacle[k]
        gap = segment_distance(row[0], row[1], row[2], row[3], centre.real, centre.imag) - row[4]
        bound = gap - outline.reach
        if bound < min(wanted, nearest):
            if not is_placed:
                for n in range(len(placed)):
                    corner = position + turn * outline.corners[n]
                    placed[n, 0], placed[n, 1] = corner.real, corner.imag
                is_placed = True
            bound = hull_distance(placed, row)
        nearest = min(nearest, bound)
    return nearest


@compiled
def clearance_along(
    position: complex, heading: float, curvature: float, length: float, scene: Scene,
) -> float:  # fmt: skip
    """Returns the least clearance along an arc, m, at most ``terms.wanted``; -inf if too little."""
    terms, outline = scene.terms, scene.team.driving
    least = terms.least_straight if curvature == 0.0 else terms.least_turning
    swing = 1.0 + abs(curvature) * (outline.reach + abs(outline.centre))
    found, s, shortest = terms.wanted, 0.0, SHORTEST_STEP * outline.reach
    while True:
        at, turned = driven(position, heading, curvature, s), heading + curvature * s
        clear = clearance_at(at, turned, outline, scene, terms.wanted)
        if clear < least:
            return -math.inf
        found = min(found, clear)
        if s >= length:
            return found
        s = min(s + max(clear - least, shortest) / swing, length)


@compiled
def leg_clearance(
    start: complex, heading: float, word: int, lengths: tuple[float, float, float], radius: float,
    scene: Scene,
) -> float:  # fmt: skip
    """Returns the least clearance along a leg, m, as ``clearance_along`` does."""
    at, turned, found, sides = start, heading, scene.terms.wanted, WORDS[word]
    bend = driven(start, heading, sides[0] / radius, lengths[0])
    course = heading + sides[0] / radius * lengths[0]
    middle = driven(bend, course, 0.0, lengths[1] / 2)  # Most legs that are blocked are so here.
    if clearance_at(middle, course, scene.team.driving, scene, 0.0) < 0.0:
        return -math.inf
    for part in range(3):
        curvature = 0.0 if part == 1 else sides[part // 2] / radius
        length = lengths[part]
        if length > 0.0:
            clear = clearance_along(at, turned, curvature, length, scene)
            if clear < 0.0:
                return clear
            found = min(found, clear)
            at, turned = driven(at, turned, curvature, length), turned + curvature * length
    return found


@compiled
def room(
    position: complex, heading: float, curvature: float, forward: float, scene: Scene,
) -> float:  # fmt: skip
    """Returns the length of the clear arc from a pose, or up to it if ``forward`` is -1, m."""
    terms, outline = scene.terms, scene.team.driving
    s, whole = 0.0, TURN / abs(curvature)
    swing = 1.0 + abs(curvature) * (outline.reach + abs(outline.centre))
    while s < whole:
        at, turned = driven(position, heading, curvature, forward * s), forward * curvature * s
        clear = clearance_at(at, heading + turned, outline, scene, terms.wanted)
        if clear < terms.least_turning:
            return s
        s += max(clear - terms.least_turning, SHORTEST_STEP * outline.reach) / swing
    return whole


class Leg(NamedTuple):
    """The best clear leg from pose to pose."""

    cost: float  #: length and cost of its clearance, m; inf where there is none
    word: int  #: of ``WORDS``


@compiled
def penalty(clearance: float, terms: Terms) -> float:
    """Returns the cost of the least clearance of a leg, m."""
    return terms.clearance_cost * (1.0 - clearance / terms.wanted)


@compiled
def best_leg(
    start: complex, heading: float, end: complex, last: float, radius: float,
    before: Float, after: Float,
    scene: Scene, most: float,
) -> Leg:  # fmt: skip
    """Returns the cheapest clear leg that costs less than ``most``, m.

    ``before`` and ``after`` (2,) are the lengths of its first and its last turn, to the left and to
    the right, beyond which obstacles are known to be.
    """
    terms, found = scene.terms, Leg(most, -1)
    for word in range(len(WORDS)):
        one, two = WORDS[word]
        lengths = leg(start, heading, end, last, one, two, radius)
        if lengths[0] > before[0 if one > 0 else 1] or lengths[2] > after[0 if two > 0 else 1]:
            continue
        length = lengths[0] + lengths[1] + lengths[2]
        if length < found.cost:
            clear = leg_clearance(start, heading, word, lengths, radius, scene)
            if clear >= 0.0 and length + penalty(clear, terms) < found.cost:
                found = Leg(length + penalty(clear, terms), word)
    return found if found.word >= 0 else Leg(math.inf, -1)


@compiled
def shortest_leg(
    start: complex, heading: float, end: complex, last: float, radius: float,
    before: Float, after: Float,
) -> float:  # fmt: skip
    """Returns the length of the shortest leg from pose to pose, m; see ``best_leg``."""
    shortest = math.inf
    for one, two in WORDS:
        lengths = leg(start, heading, end, last, one, two, radius)
        if lengths[0] <= before[0 if one > 0 else 1] and lengths[2] <= after[0 if two > 0 else 1]:
            shortest = min(shortest, lengths[0] + lengths[1] + lengths[2])
    return shortest


@compiled
def write(
    path: Float, first: int, start: complex, heading: float, end: complex, last: float,
    radius: float, word: int,
) -> None:  # fmt: skip
    """Writes a leg into rows ``first`` to ``first + 2`` of a path."""
    one, two = WORDS[word]
    lengths = leg(start, heading, end, last, one, two, radius)
    path[first, 0], path[first + 1, 0], path[first + 2, 0] = one / radius, 0.0, two / radius
    for part in range(3):
        path[first + part, 1] = lengths[part]
