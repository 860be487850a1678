"""Mirror images of worlds, and the side of the vessel from which a team pushes.

What holds for a team that pushes from one side of the vessel holds for the other side in the
mirror image. So a policy that can push from the +n side alone, towards goals ahead of it, serves
all goals: where the goal lies on the +n side itself, the policy sees the mirror image.
"""

from dataclasses import dataclass, replace

import numpy as np

from asv_env import geometry
from asv_env.geometry import plane
from asv_env.params import EnvParams
from asv_env.tasks import formation
from asv_env.types import Bool, Complex, Float, Sensed


def mirror_image(sensed: Sensed, side: Float) -> Sensed:
    """Returns what is sensed, mirrored at the world's x axis where ``side`` (W,) is -1.

    A team that pushes from the -n side pushes from the +n side in the mirror image.
    """
    return replace(
        sensed,
        measured=geometry.mirrored(sensed.measured, side),
        estimate=geometry.mirrored(sensed.estimate, side),
        goal=geometry.mirrored(sensed.goal, side),
        slot=sensed.slot.real + 1j * sensed.slot.imag * side[:, None],
    )


def goal_lateral_offset(sensed: Sensed) -> Float:
    """Returns how far the goal lies to the +n side of the estimated vessel (W,), m."""
    vessel = sensed.estimate[:, 0]
    return ((plane(sensed.goal) - plane(vessel)) * np.exp(-1j * vessel[:, 2])).imag


@dataclass
class PushSide:
    """The side from which each team pushes, and its slots in the view from there."""

    side: Float  #: (W,) +1 for the vessel's +n side, -1 for the other
    slot: Complex  #: (W, A) slots of the boats, m; of the mirror image where the side is -1
    working: Bool  #: (W, A) whether each boat worked when the slots were assigned
    closed: Bool  #: (W,) whether the vessel is in closure, by these slots


def view(
    params: EnvParams, sensed: Sensed, memory: PushSide | None, fresh: Bool
) -> tuple[Sensed, PushSide]:
    """Returns the world as a team that pushes from the +n side would sense it, and the sides.

    The goal lies ahead of the team when its side is selected: at the first call, where the
    memory is None, and again in the worlds ``fresh`` (W,). Where the task prescribes that side,
    slots and closure are the environment's; elsewhere they follow from the estimate by its rules.
    """
    away = np.where(goal_lateral_offset(sensed) > 0, -1.0, 1.0)
    if memory is None:
        fresh = np.ones_like(fresh)
        memory = PushSide(away, sensed.slot, sensed.working, np.zeros_like(fresh))
    side = np.where(fresh, away, memory.side)
    prescribed = side == sensed.side
    seen = mirror_image(sensed, side)
    closed, misassigned = _closure(params, seen, memory)
    closed = np.where(prescribed, sensed.closed, closed & ~fresh)
    fails = (sensed.working != memory.working).any(axis=1)
    slot = np.where(prescribed[:, None], seen.slot, memory.slot)
    for world in map(int, np.flatnonzero(~prescribed & (fresh | fails | misassigned))):
        boats = seen.estimate[world], seen.working[world]
        slot[world] = formation.assign_slots(params, *boats, 1.0)
    seen = replace(seen, slot=slot, side=np.ones_like(side), closed=closed)
    return seen, PushSide(side, slot, sensed.working.copy(), closed)


def _closure(params: EnvParams, seen: Sensed, memory: PushSide) -> tuple[Bool, Bool]:
    """Returns (W,) whether the vessel is in closure, and (W,) whether slots are misassigned."""
    task, working = params.task, memory.working
    relations = formation.relate(seen.estimate, seen.goal, memory.slot, np.ones(len(working)))
    formed = formation.everyone(formation.occupied(relations, task), working)
    closed = formation.closure(relations, formed, memory.closed, working, task)
    return closed, formation.misassigned(relations, closed, working, task)
