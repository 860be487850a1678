"""From which side a team pushes: the world as it looks from there.

A vessel can be pushed from either side, and what is learned for one holds for the other in a
mirror. A policy that pushes towards -n is given a mirrored world where the goal lies on the other
side of the vessel when the episode begins, so that it always finds the goal ahead of it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from asv_env import geometry
from asv_env.geometry import plane
from asv_env.params import EnvParams
from asv_env.tasks import formation
from asv_env.tasks.formation import relate
from asv_env.types import Bool, Complex, Float, Sensed


def seen_from(sensed: Sensed, side: Float) -> Sensed:
    """What is sensed, mirrored at the world's x axis where ``side`` (W,) is -1.

    There the team pushes from the +n side if it pushed from the other one before.
    """
    return replace(
        sensed,
        measured=geometry.mirrored(sensed.measured, side),
        estimate=geometry.mirrored(sensed.estimate, side),
        goal=geometry.mirrored(sensed.goal, side),
        slot=sensed.slot.real + 1j * sensed.slot.imag * side[:, None],
    )


@dataclass
class SideMemory:
    """What a team remembers of its side.

    Attributes:
        side: (W,) of the vessel from which it pushes, +1 or -1.
        slot: (W, A) of the boats in the world as it looks from there, m.
        working: (W, A) boats that worked when these were assigned.
        closed: (W,) whether the vessel has been in closure there, and not been lost since.
    """

    side: Float
    slot: Complex
    working: Bool
    closed: Bool


class SideAway:
    """Lets teams push from the side away from the goal, whichever side the task has.

    Where that is the task's own, slots and closure are the environment's. On the other side they
    are told in the same way, but from the estimate.

    Args:
        params: of the environment.
    """

    def __init__(self, params: EnvParams) -> None:
        self._params = params

    def see(
        self, sensed: Sensed, memory: SideMemory | None, fresh: Bool
    ) -> tuple[Sensed, SideMemory]:
        """The world with the goal ahead of a team that pushes from the +n side.

        Args:
            sensed: what is measured.
            memory: what the last call returned; None at the first.
            fresh: (W,) worlds that have begun a new episode.
        """
        away = _away(sensed)
        if memory is None:
            fresh, working = np.ones_like(fresh), sensed.working
            memory = SideMemory(away, sensed.slot, working, np.zeros_like(fresh))
        side = np.where(fresh, away, memory.side)
        own = side == sensed.side
        seen = seen_from(sensed, side)
        closed, swapped = self._judged(seen, memory)
        closed = np.where(own, sensed.closed, closed & ~fresh)
        fails = (sensed.working != memory.working).any(axis=1)
        slot = np.where(own[:, None], seen.slot, memory.slot)
        self._assign(slot, seen, ~own & (fresh | fails | swapped))
        seen = replace(seen, slot=slot, side=np.ones_like(side), closed=closed)
        return seen, SideMemory(side, slot, sensed.working.copy(), closed)

    def _assign(self, slot: Complex, seen: Sensed, where: Bool) -> None:
        """Assigns slots anew in some worlds, in place."""
        for world in map(int, np.flatnonzero(where)):
            slot[world] = formation.assign_slots(
                self._params, seen.estimate[world], seen.working[world], 1.0
            )

    def _judged(self, seen: Sensed, memory: SideMemory) -> tuple[Bool, Bool]:
        """Returns (W,) whether the vessel is in closure, and (W,) whether slots are misassigned."""
        task, working = self._params.task, memory.working
        relations = relate(seen.estimate, seen.goal, memory.slot, np.ones(len(working)))
        formed = formation.everyone(formation.occupied(relations, task), working)
        closed = formation.closure(relations, formed, memory.closed, working, task)
        return closed, formation.misassigned(relations, closed, working, task)


def goal_across(sensed: Sensed) -> Float:
    """(W,) how far the goal lies to the +n side of where the vessel is thought to be, m."""
    vessel = sensed.estimate[:, 0]
    goal = (plane(sensed.goal) - plane(vessel)) * np.exp(-1j * vessel[:, 2])
    across: Float = goal.imag
    return across


def _away(sensed: Sensed) -> Float:
    """(W,) the side of the vessel that is turned away from the goal."""
    return np.where(goal_across(sensed) > 0, -1.0, 1.0)
