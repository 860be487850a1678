"""How teams stand round their vessels: who occupies which slot, closure, and where the goal is.

One set of rules, applied to one motion: to the true one for the task's judge, to the estimate for
the boats. So nothing that a policy is given depends on a motion that nobody has measured.
"""

from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from asv_env.geometry import wrap
from asv_env.params import EnvParams, TaskParams
from asv_env.tasks import formation
from asv_env.tasks.formation import Relations, relate
from asv_env.types import Bool, Float, Situation, copied, frozen, put_rows

Record = TypeVar("Record", bound=Situation)


@dataclass(frozen=True)
class Events:
    """What changes the roles of a team at the end of a tick, whatever motion is looked at."""

    assigns: Bool  #: (W,) whether slots are to be assigned again
    working: Bool  #: (W, A) boats whose thrusters work from now on
    anchors: Bool  #: (W,) whether the team has formed closure, by which its goal becomes final
    goal: Float  #: (W, 3) such goals in the frame of the vessel; m, m, rad


def advanced(
    before: Situation, motion: Float, task: TaskParams
) -> tuple[Relations, Bool, dict[str, Bool]]:
    """Advances a standing by a tick, after which the motion is (W, B, 6).

    Returns:
        Relations of the motion, (W,) whether every working boat occupies its slot, and the fields
        ``occupied`` and ``closed``.
    """
    relations = frozen(relate(motion, before.goal, before.slot, before.side))
    occupied = formation.occupied(relations, task)
    formed = formation.everyone(occupied, before.working)
    closed = formation.closure(relations, formed, before.closed, before.working, task)
    return relations, formed, {"occupied": occupied, "closed": closed}


def changed(
    record: Record, relations: Relations, motion: Float, events: Events | None, params: EnvParams
) -> tuple[Record, Relations, np.ndarray]:
    """Returns the record and its relations after changes of roles, and the worlds (n,) concerned.

    Slots are also assigned again where all boats rest on the hull and are not in closure. The
    motion is (W, B, 6).
    """
    assigns = formation.misassigned(relations, record.closed, record.working, params.task)
    concerned = assigns
    if events is not None:
        assigns = assigns | events.assigns
        concerned = assigns | events.anchors
    index = np.flatnonzero(concerned)
    if not len(index):
        return record, relations, index
    record = copied(record)
    if events is not None:
        record.working[...] = events.working
        np.logical_or(record.anchored, events.anchors, out=record.anchored)
        for world in np.flatnonzero(events.anchors):
            record.goal[world] = anchored(events.goal[world], motion[world, 0])
    relations = _related(record, relations, motion, index, np.flatnonzero(assigns), params)
    return frozen(record), relations, index


def begun(
    record: Situation, relations: Relations, motion: Float, index: np.ndarray, params: EnvParams
) -> Relations:
    """Begins episodes in the worlds ``index`` (n,) of a record, in place; returns its relations.

    Closure and slots, with what follows from them, are those of the motion (W, B, 6).
    """
    record.closed[index] = params.definition.starts_grasped
    return _related(record, relations, motion, index, index, params)


def _related(
    record: Situation,
    relations: Relations,
    motion: Float,
    index: np.ndarray,
    assigns: np.ndarray,
    params: EnvParams,
) -> Relations:
    """Assigns slots in some worlds (m,) of a record, in place; returns relations.

    What depends on slots and goals is derived again in the worlds ``index`` (n,).
    """
    for world in map(int, assigns):
        boats = motion[world], record.working[world], record.side[world]
        record.slot[world] = formation.assign_slots(params, *boats)
    relations = copied(relations)
    renewed = relate(motion[index], record.goal[index], record.slot[index], record.side[index])
    put_rows(relations, index, renewed)
    record.occupied[index] = formation.occupied(renewed, params.task)
    return frozen(relations)


def anchored(relative: Float, vessel: Float) -> Float:
    """Returns a goal (3,) that is given in the frame of the vessel's motion (6,), in the world."""
    turn = np.exp(1j * vessel[2])
    point = vessel[0] + 1j * vessel[1] + turn * (relative[0] + 1j * relative[1])
    return np.array([point.real, point.imag, float(wrap(vessel[2] + relative[2]))])
