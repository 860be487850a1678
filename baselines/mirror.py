"""Mirror images and models of worlds, and the side of the vessel from which a team pushes.

What holds for a team that pushes from one side of the vessel holds for the other side in the
mirror image. So a policy that can push from the +n side alone serves both sides: where it pushes
from the other one, it sees the mirror image.
"""

from dataclasses import dataclass, replace

import numpy as np

from asv_env import geometry
from asv_env.params import EnvParams
from asv_env.params.scaling import MOTION
from asv_env.tasks import standing
from asv_env.tasks.standing import Events
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
        obstacle=geometry.mirrored_rows(sensed.obstacle, side),
    )


def at_scale(sensed: Sensed, factor: float) -> Sensed:
    """Returns what is sensed in a world ``factor`` times as long, by Froude's law."""
    if factor == 1.0:
        return sensed
    motion = factor ** np.array(MOTION)
    return replace(
        sensed,
        measured=sensed.measured * motion,
        estimate=sensed.estimate * motion,
        goal=sensed.goal * motion[:3],
        slot=sensed.slot * factor,
        obstacle=sensed.obstacle * factor,
    )


@dataclass
class PushSide:
    """The side from which each team pushes, and its slots in the view from there."""

    side: Float  #: (W,) +1 for the vessel's +n side, -1 for the other
    slot: Complex  #: (W, A) slots of the boats, m; of the mirror image where the side is -1
    working: Bool  #: (W, A) whether each boat worked when the slots were assigned
    closed: Bool  #: (W,) whether the vessel is in closure, by these slots


def view_from(
    params: EnvParams, sensed: Sensed, memory: PushSide | None, fresh: Bool, away: Float
) -> tuple[Sensed, PushSide]:
    """Returns the world as a team that pushes from the +n side would sense it, and the sides.

    The sides (W,) are ``away`` at the first call, where the memory is None, and again in the worlds
    ``fresh`` (W,). Where the task prescribes that side, slots and closure are the environment's;
    elsewhere they follow from the estimate by its rules.
    """
    if memory is None:
        fresh = np.ones_like(fresh)
        memory = PushSide(away, sensed.slot, sensed.working, np.zeros_like(fresh))
    side = np.where(fresh, away, memory.side)
    prescribed = side == sensed.side
    seen = replace(mirror_image(sensed, side), side=np.ones_like(side))
    if not prescribed.all():
        own, given = _own_standing(params, seen, memory, fresh, side), prescribed[:, None]
        slot = np.where(given, seen.slot, own.slot)
        occupied = np.where(given, seen.occupied, own.occupied)
        closed = np.where(prescribed, seen.closed, own.closed)
        seen = replace(seen, slot=slot, occupied=occupied, closed=closed)
    return seen, PushSide(side, seen.slot, sensed.working.copy(), seen.closed)


def _own_standing(
    params: EnvParams, seen: Sensed, memory: PushSide, fresh: Bool, side: Float
) -> Sensed:
    """Returns what is seen with standings that follow from the estimate and from what was.

    They are found in the world and not in its mirror image, where the vessel is another one.
    """
    known = replace(seen, slot=memory.slot, closed=memory.closed, working=memory.working)
    before = replace(mirror_image(known, side), side=side)
    now = standing.advanced(before, before.estimate, params, 1)
    closed = now.closed & ~fresh
    fails = (seen.working != memory.working).any(axis=1)
    goal = seen.anchored, before.goal, np.zeros_like(fresh)
    events = Events(fresh | fails, seen.working, *goal)
    after = replace(before, occupied=now.occupied, closed=closed)
    found, _ = standing.changed(after, before.estimate, now.misassigned, events, params)
    return mirror_image(found, side)
