"""The judge's loops over the worlds: slots, closure, delivery, and errors of the vessel."""

from typing import NamedTuple

import numpy as np

from asv_env.compiled import compiled
from asv_env.tasks.laws import (
    Rules,
    aim,
    around,
    at_goal,
    direction_of,
    heading_error_of,
    occupies,
    rests,
)
from asv_env.types import Bool, Complex, Float, Int, Situation, given


class Team(NamedTuple):
    """What the standing of teams depends on: a motion and fields of ``Situation``, read-only."""

    motion: Float  #: (W, B, 6)
    goal: Float  #: (W, 3)
    slot: Complex  #: (W, A)
    side: Float  #: (W,)
    working: Bool  #: (W, A)
    closed: Bool  #: (W,) before the tick


class Standings(NamedTuple):
    """How teams stand after a tick."""

    occupied: Bool  #: (W, A)
    closed: Bool  #: (W,)
    formed: Bool  #: (W,) whether every working boat occupies its slot
    #: (W,) whether all boats rest on the hull without closure, so that slots are assigned again
    misassigned: Bool


class Counts(NamedTuple):
    """Control ticks for which something has been true without a break, each (W,)."""

    occupied: Int  #: every slot was occupied
    delivered: Int  #: the vessel was at its goal


def team(situation: Situation, motion: Float) -> Team:
    """Returns what the standing of teams depends on, for a motion (W, B, 6)."""
    return Team(
        given(motion),
        given(situation.goal),
        given(situation.slot, np.complex128),
        given(situation.side),
        given(situation.working, np.bool_),
        given(situation.closed, np.bool_),
    )


def standings(team: Team) -> Standings:
    """Returns memory for how these teams stand."""
    of_world = len(team.side)
    each = (np.empty(of_world, dtype=np.bool_) for _ in range(3))
    return Standings(np.empty(team.slot.shape, dtype=np.bool_), *each)


@compiled
def stand(world: int, team: Team, rules: Rules, found: Standings) -> None:
    """Judges the slots and the closure of a world.

    Closure is formed when all slots are occupied, and lost when one of the working boats is far
    from its slot.
    """
    motion, side = team.motion[world], team.side[world]
    to_vessel = direction_of(motion[0, 2]).conjugate()
    formed, near, rest = True, True, True
    for boat in range(team.slot.shape[1]):
        slot = team.slot[world, boat]
        _, gap, alignment, slip = around(motion, boat + 1, to_vessel, slot, side)
        distance = abs(gap)
        occupied = occupies(distance, alignment, slip, rules)
        found.occupied[world, boat] = occupied
        if team.working[world, boat]:
            formed = formed and occupied
            near = near and distance <= rules.closure_lost
            rest = rest and rests(alignment, slip, rules)
    closed = formed or (team.closed[world] and near)
    found.formed[world], found.closed[world] = formed, closed
    found.misassigned[world] = rest and not closed


@compiled
def stand_all(first: int, last: int, team: Team, rules: Rules, found: Standings) -> None:
    """Judges slots and closure of the worlds ``first`` to ``last - 1``."""
    for world in range(first, last):
        stand(world, team, rules, found)


@compiled
def judge(
    first: int,
    last: int,
    team: Team,
    anchored: Bool,
    before: Counts,
    water: Complex,
    arena: float,
    rules: Rules,
    found: Standings,
    counts: Counts,
    strayed: Bool,
) -> None:
    """Judges a tick of the worlds ``first`` to ``last - 1``.

    Args:
        first: first world.
        last: world after the last one.
        team: the true motion and situation.
        anchored: (W,) whether goals are final.
        before: counts before the tick.
        water: (W,) velocity of the water at the vessels, m/s.
        arena: half the side of the square that no body may leave, m.
        rules: numbers by which it is judged.
        found: receives how the teams stand.
        counts: receives the counts after the tick.
        strayed: (W,) receives whether a body has left the arena.
    """
    for world in range(first, last):
        stand(world, team, rules, found)
        motion = team.motion[world]
        there = anchored[world] and at_goal(motion, team.goal[world], water[world], rules)
        counts.occupied[world] = before.occupied[world] + 1 if found.formed[world] else 0
        counts.delivered[world] = before.delivered[world] + 1 if there else 0
        farthest = 0.0
        for body in range(motion.shape[0]):
            farthest = max(farthest, abs(motion[body, 0]), abs(motion[body, 1]))
        strayed[world] = farthest > arena


@compiled
def goal_errors(motion: Float, goal: Float) -> tuple[complex, float]:
    """Returns the goal (3,) in the vessel's frame, m, and the vessel's heading error, rad."""
    position, turn = aim(motion, goal, direction_of(motion[0, 2]).conjugate())
    return position, heading_error_of(turn)
