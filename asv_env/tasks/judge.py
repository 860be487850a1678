"""Judgement of slots and closure, for the true motion and for the estimate alike."""

from typing import NamedTuple

import numpy as np

from asv_env.compiled import compiled
from asv_env.tasks.laws import (
    Rules,
    around,
    direction_of,
    occupies,
    rests,
    size_of,
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


def team(situation: Situation, motion: Float) -> Team:
    """Returns what the standing of teams depends on, for a motion (W, B, 6).

    The fields of a situation that is not read-only are wrapped.
    """
    if not situation.goal.flags.writeable and not motion.flags.writeable:
        fixed = situation.goal, situation.slot, situation.side, situation.working
        return Team(motion, *fixed, situation.closed)
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
def stand(world: int, team: Team, rules: Rules, found: Standings) -> float:
    """Judges the slots and the closure of a world.

    Closure is formed when all slots are occupied, and lost when one of the working boats is far
    from its slot.

    Returns:
        Mean distance of the working boats to their slots, m.
    """
    motion, side = team.motion[world], team.side[world]
    to_vessel = direction_of(motion[0, 2]).conjugate()
    formed, near, rest = True, True, True
    total, working = 0.0, 0
    for boat in range(team.slot.shape[1]):
        slot = team.slot[world, boat]
        heading = direction_of(motion[boat + 1, 2])
        _, gap, alignment, slip = around(motion, boat + 1, heading, to_vessel, slot, side)
        distance = size_of(gap)
        occupied = occupies(distance, alignment, slip, rules)
        found.occupied[world, boat] = occupied
        if team.working[world, boat]:
            total += distance
            working += 1
            formed = formed and occupied
            near = near and distance <= rules.closure_lost
            rest = rest and rests(alignment, slip, rules)
    closed = formed or (team.closed[world] and near)
    found.formed[world], found.closed[world] = formed, closed
    found.misassigned[world] = rest and not closed
    return total / working


@compiled
def stand_some(worlds: Int, team: Team, rules: Rules, found: Standings) -> None:
    """Judges slots and closure of some worlds (n,)."""
    for number in range(len(worlds)):
        stand(worlds[number], team, rules, found)
