"""Paths of bounded curvature among obstacles, for a vessel that can only be pushed forward.

A path is made of ``legs`` from pose to pose, and ends with a straight. The cheapest path that keeps
clear is looked for among those of one leg, and of two legs that meet at a pose of a grid round
start and goal. There the team may let go and push on from the other side, which drives the vessel
as if it had turned by half a turn.
"""

import math
from typing import NamedTuple

import numpy as np

from asv_env.compiled import allocating, compiled
from asv_env.geometry import TURN
from asv_env.types import Bool, Complex, Float
from baselines.scripted.legs import (
    Scene,
    Team,
    Terms,
    best_leg,
    clearance_along,
    clearance_at,
    driven,
    penalty,
    room,
    shortest_leg,
    write,
)

SEGMENTS = 8
"""Number of segments of a path: a straight that leads out of where no leg begins, three of each
leg, and the last straight."""
FIRST, SECOND = 1, 4  #: segments at which the legs begin
HEADINGS = 8  #: number of headings of a pose of the grid
BESIDE = (-1j, -1.0 + 0.0j, 1.0 + 0.0j)  #: directions ahead, and along the vessel either way
STEPS = 10  #: number of distances by which the vessel may be moved before its path begins
SIDES = 2  #: this side of the vessel, and the other
UNKNOWN, BLOCKED = -2, -1  #: words of first legs that were not looked for yet, or do not exist


class Ends(NamedTuple):
    """Where the last straights begin, by the side from which the team pushes (2, S)."""

    position: Complex  #: m
    heading: Float  #: (2,) rad
    clearance: Float  #: along the straight, m; -inf if too little
    room: Float  #: (2, S, 2) clear lengths of left and right turns up to there, m


class Places(NamedTuple):
    """The poses (n,) of the grid."""

    position: Complex  #: m
    heading: Float  #: rad
    free: Bool  #: whether they are clear
    gathers: Bool  #: whether a team can gather there on the other side


class Trip(NamedTuple):
    """How paths begin."""

    start: complex  #: m
    heading: float  #: rad, of a vessel that is pushed from this side
    side: int  #: 0 this side, 1 the other
    room: Float  #: (2,) clear lengths of turns to the left and to the right, m
    radius: float  #: of all arcs, m
    cost: float  #: of the radius and of the side, m


class Found(NamedTuple):
    """The cheapest path so far."""

    path: Float  #: (SEGMENTS, 2) curvatures, 1/m, and lengths, m
    outcome: Float  #: (3,) cost, m; whether it begins on the other side, and ends for a switch


@allocating
def grid(start: complex, goal: complex, scene: Scene) -> Places:
    """Returns the poses round start and goal at which legs can meet."""
    way, terms = goal - start, scene.terms
    distance = abs(way)
    frame = way / distance if distance > 0.0 else complex(1.0, 0.0)
    columns = math.ceil((distance / 2 + terms.margin) / terms.spacing)
    rows = math.ceil(terms.margin / terms.spacing)
    count = (2 * columns + 1) * (2 * rows + 1) * HEADINGS
    position, heading = np.empty(count, np.complex128), np.empty(count)
    free, gathers = np.empty(count, np.bool_), np.empty(count, np.bool_)
    axis, n = math.atan2(frame.imag, frame.real), 0
    for i in range(-columns, columns + 1):
        for j in range(-rows, rows + 1):
            for k in range(HEADINGS):
                at = (start + goal) / 2 + frame * terms.spacing * complex(i, j)
                course = axis + TURN * k / HEADINGS
                gap = clearance_at(at, course, scene.team.driving, scene, terms.wanted)
                position[n], heading[n], free[n] = at, course, gap >= terms.least_turning
                gathers[n] = free[n] and gathering_room(at, course + math.pi, scene)
                n += 1
    return Places(position, heading, free, gathers)


@compiled
def gathering_room(position: complex, heading: float, scene: Scene) -> bool:
    """Returns whether there is room at a pose for a team that gathers behind the vessel."""
    terms, team = scene.terms, scene.team
    gap = clearance_at(position, heading, team.gathering, scene, terms.wanted)
    return gap >= terms.least_straight


@allocating
def gathers_at(pose: Float, obstacle: Float, team: Team, terms: Terms) -> tuple[bool, bool]:
    """Returns whether there is room for a team that gathers on this side, and on the other."""
    scene = Scene(team, obstacle, terms, np.empty((len(team.driving.corners), 2)))
    at = complex(pose[0], pose[1])
    return gathering_room(at, pose[2], scene), gathering_room(at, pose[2] + math.pi, scene)


@allocating
def endings(goal: Float, scene: Scene) -> Ends:
    """Returns where the last straights to a goal pose (3,) begin, without the room of turns."""
    straights = scene.terms.straights
    count = len(straights)
    position, heading = np.empty((SIDES, count), np.complex128), np.empty(SIDES)
    clearance = np.empty((SIDES, count))
    for side in range(SIDES):
        heading[side] = goal[2] + math.pi * side
        behind = 1j * complex(math.cos(heading[side]), math.sin(heading[side]))
        for s in range(count):
            at = complex(goal[0], goal[1]) + straights[s] * behind
            position[side, s] = at
            clearance[side, s] = clearance_along(at, heading[side], 0.0, straights[s], scene)
    return Ends(position, heading, clearance, np.empty((SIDES, count, 2)))


@compiled
def put_room(ends: Ends, radius: float, scene: Scene) -> None:
    """Writes the room of turns of a radius, m, up to the last straights."""
    for side in range(SIDES):
        for s in range(ends.position.shape[1]):
            for k in range(2):
                pose = ends.position[side, s], ends.heading[side]
                ends.room[side, s, k] = room(*pose, (1 - 2 * k) / radius, -1.0, scene)


@compiled
def cost_of(trip: Trip, ends: Ends, side: int, s: int, scene: Scene) -> float:
    """Returns what a path costs beside its legs and its switch, m; inf without a last straight."""
    terms = scene.terms
    if ends.clearance[side, s] < 0.0:
        return math.inf
    straight = terms.straight_costs[s] + terms.straights[s]
    return trip.cost + straight + penalty(ends.clearance[side, s], terms)


@compiled
def take(trip: Trip, straight: float, cost: float, switches: bool, found: Found) -> None:
    """Replaces the cheapest path so far by one whose legs are to be written."""
    found.path[:] = 0.0
    found.path[SEGMENTS - 1, 1] = straight
    found.outcome[0], found.outcome[1], found.outcome[2] = cost, trip.side, switches


@allocating
def look_for_one_leg(trip: Trip, ends: Ends, scene: Scene, found: Found) -> None:
    """Looks for paths of one leg."""
    side, last = trip.side, ends.heading[trip.side]
    for s in range(ends.position.shape[1]):
        fixed, end = cost_of(trip, ends, side, s, scene), ends.position[side, s]
        if fixed >= found.outcome[0]:
            continue
        leg = best_leg(
            trip.start, trip.heading, end, last, trip.radius, trip.room, ends.room[side, s], scene,
            found.outcome[0] - fixed,
        )  # fmt: skip
        if leg.word >= 0:
            take(trip, scene.terms.straights[s], fixed + leg.cost, False, found)
            write(found.path, FIRST, trip.start, trip.heading, end, last, trip.radius, leg.word)


@allocating
def look_for_two_legs(
    trip: Trip, ends: Ends, places: Places, scene: Scene, found: Found
) -> None:  # fmt: skip
    """Looks for paths of two legs that meet at a pose of the grid, with and without a switch.

    Poses come in the order of the shortest paths through them, whether clear or not.
    """
    count, anywhere, radius = len(places.position), np.full(2, np.inf), trip.radius
    onwards, bound = np.full(count, np.inf), np.empty(count)
    word, cost = np.full(count, UNKNOWN), np.full(count, np.inf)
    for n in range(count):
        if places.free[n]:
            pose = places.position[n], places.heading[n]
            onwards[n] = shortest_leg(trip.start, trip.heading, *pose, radius, trip.room, anywhere)
    for change in range(SIDES):
        side = (trip.side + change) % SIDES
        last, turned = ends.heading[side], math.pi * change
        for s in range(ends.position.shape[1]):
            fixed, end = cost_of(trip, ends, side, s, scene), ends.position[side, s]
            fixed += scene.team.switch_cost if change else 0.0
            arrives = ends.room[side, s]
            for n in range(count):
                bound[n], at = math.inf, places.position[n]
                least = onwards[n] + abs(end - at) + fixed
                if least < found.outcome[0] and (places.gathers[n] or not change):
                    course = places.heading[n] + turned
                    rest = shortest_leg(at, course, end, last, radius, anywhere, arrives)
                    bound[n] = onwards[n] + fixed + rest
            for n in np.argsort(bound):
                if bound[n] >= found.outcome[0]:
                    break
                at, course = places.position[n], places.heading[n]
                if word[n] == UNKNOWN:
                    first = best_leg(
                        trip.start, trip.heading, at, course, radius, trip.room, anywhere, scene,
                        math.inf,
                    )  # fmt: skip
                    word[n], cost[n] = first.word, first.cost
                left = found.outcome[0] - fixed - cost[n]
                if left <= 0.0 or word[n] == BLOCKED:
                    continue
                second = best_leg(
                    at, course + turned, end, last, radius, anywhere, arrives, scene, left
                )
                if second.word < 0:
                    continue
                straight = 0.0 if change else scene.terms.straights[s]
                take(trip, straight, fixed + cost[n] + second.cost, change == 1, found)
                write(found.path, FIRST, trip.start, trip.heading, at, course, radius, word[n])
                if not change:
                    write(found.path, SECOND, at, course, end, last, radius, second.word)


@allocating
def search(
    pose: Float, goal: Float, obstacle: Float, team: Team, terms: Terms, sides: tuple[float, float]
) -> tuple[Float, bool, bool, float]:
    """Searches the cheapest clear path from pose to pose, (3,) m, m, rad.

    Args:
        pose: where the vessel is.
        goal: where it is to be.
        obstacle: (M, 5) rows.
        team: outlines.
        terms: what is asked of the path.
        sides: costs of beginning on this side and on the other, m; inf rules it out.

    Returns:
        Curvatures and lengths (SEGMENTS, 2) of the segments, 1/m and m, up to where the team has to
        switch to the other side; all 0 where there is no path. Whether it begins on the other side,
        whether the team has to switch at its end, and the cost, m.
    """
    scene = Scene(team, obstacle, terms, np.empty((len(team.driving.corners), 2)))
    found = Found(np.zeros((SEGMENTS, 2)), np.array([np.inf, 0.0, 0.0]))
    start = complex(pose[0], pose[1])
    ends, places = endings(goal, scene), grid(start, complex(goal[0], goal[1]), scene)
    for r in range(len(terms.radii)):
        radius = terms.radii[r]
        put_room(ends, radius, scene)
        for side in range(SIDES):
            heading = pose[2] + math.pi * side
            if sides[side] == math.inf or (side and not gathering_room(start, heading, scene)):
                continue
            turns = np.empty(2)
            for k in range(2):
                turns[k] = room(start, heading, (1 - 2 * k) / radius, 1.0, scene)
            cost = terms.radius_costs[r] + sides[side]
            trip = Trip(start, heading, side, turns, radius, cost)
            look_for_one_leg(trip, ends, scene, found)
            look_for_two_legs(trip, ends, places, scene, found)
    outcome = found.outcome
    return found.path, outcome[1] > 0.0, outcome[2] > 0.0, outcome[0]


@allocating
def path_clearance(pose: Float, path: Float, obstacle: Float, team: Team, terms: Terms) -> float:
    """Returns the least clearance along a path of segments (n, 2) 1/m, m; -inf if too little."""
    scene = Scene(team, obstacle, terms, np.empty((len(team.driving.corners), 2)))
    at, heading, found = complex(pose[0], pose[1]), pose[2], terms.wanted
    for k in range(len(path)):
        curvature, length = path[k, 0], path[k, 1]
        if length > 0.0:
            found = min(found, clearance_along(at, heading, curvature, length, scene))
            at, heading = driven(at, heading, curvature, length), heading + curvature * length
    return found


@allocating
def clearances_beside(pose: Float, obstacle: Float, team: Team, terms: Terms, step: float) -> Float:
    """Returns the clearances (3, n) of a vessel that was moved by 1, 2 ... ``step``, m.

    The rows are those of moves ahead, and along the vessel backwards and forwards. They are -inf
    where the vessel gets nearer to an obstacle than it is, and nearer than ``terms`` ask for on
    straights.
    """
    scene = Scene(team, obstacle, terms, np.empty((len(team.driving.corners), 2)))
    at, along = complex(pose[0], pose[1]), complex(math.cos(pose[2]), math.sin(pose[2]))
    begins = clearance_at(at, pose[2], team.driving, scene, terms.wanted)
    found = np.full((len(BESIDE), STEPS), -np.inf)
    for k in range(len(BESIDE)):
        for n in range(STEPS):
            there = at + BESIDE[k] * (n + 1) * step * along
            clear = clearance_at(there, pose[2], team.driving, scene, terms.wanted)
            if clear < min(begins, terms.least_straight):
                break
            found[k, n] = clear
    return found
