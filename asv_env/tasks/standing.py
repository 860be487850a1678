"""How teams stand round their vessels: who has and occupies which slot, and closure.

One set of rules, applied to one motion: to the true one for the task's judge, to the estimate for
the boats. So nothing that a policy is given depends on a motion that nobody has measured.
"""

from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from asv_env.geometry import wrap
from asv_env.params import EnvParams
from asv_env.tasks import formation
from asv_env.tasks.judge import Standings, stand_some, standings, team
from asv_env.tasks.laws import rules
from asv_env.threads import spread
from asv_env.types import Bool, Float, Situation, copied, frozen, given

Record = TypeVar("Record", bound=Situation)
NOWHERE = np.empty(0, dtype=np.int64)  #: numbers of no worlds
NOWHERE.setflags(write=False)


@dataclass(frozen=True)
class Events:
    """What changes the roles of a team at the end of a tick, for judge and boats alike."""

    assigns: Bool  #: (W,) whether slots are to be assigned again
    working: Bool  #: (W, A) boats whose thrusters work from now on
    anchored: Bool  #: (W,) whether the goal is final from now on
    goal: Float  #: (W, 3) goal pose from now on; m, m, rad
    moved: Bool  #: (W,) whether the goal has moved


def advanced(before: Situation, motion: Float, params: EnvParams, num_threads: int) -> Standings:
    """Advances a standing by a tick, after which the motion is (W, B, 6)."""
    teams, numbers = team(before, motion), rules(params)
    found, worlds = standings(teams), given(np.arange(len(motion)), np.int64)

    def run(first: int, last: int, thread: int) -> None:
        stand_some(worlds[first:last], teams, numbers, found)

    spread(run, len(motion), num_threads)
    return found


def changed(
    record: Record, motion: Float, misassigned: Bool, events: Events | None, params: EnvParams
) -> tuple[Record, np.ndarray]:
    """Returns the record after changes of roles, and the worlds (n,) concerned.

    Slots are also assigned again where all boats rest on the hull and are not in closure, in the
    worlds ``misassigned`` (W,). The motion is (W, B, 6).
    """
    if events is None and not misassigned.any():
        return record, NOWHERE
    concerned, slot = np.zeros_like(misassigned), record.slot
    working = record.working if events is None else events.working
    if events is not None:
        concerned |= events.assigns | events.moved
        misassigned = misassigned | events.assigns
    assigns = np.flatnonzero(misassigned)
    if len(assigns):
        slot = slot.copy()
        known = params, motion, working, record.side
        concerned[assigns] |= formation.assign_slots(*known, slot, assigns)
    index = np.flatnonzero(concerned)
    if not len(index):
        return record, index
    record = copied(record)
    record.slot[index] = slot[index]
    if events is not None:
        record.working[...] = events.working
        record.anchored[...], record.goal[...] = events.anchored, events.goal
    _occupy(record, motion, index, params)
    return frozen(record), index


def begun(record: Situation, motion: Float, index: np.ndarray, params: EnvParams) -> None:
    """Begins episodes in the worlds ``index`` (n,) of a record, in place.

    Closure and slots, with what follows from them, are those of the motion (W, B, 6).
    """
    record.closed[index] = params.definition.starts_grasped
    known = params, motion, record.working, record.side
    formation.assign_slots(*known, record.slot, index)
    _occupy(record, motion, index, params)


def _occupy(record: Situation, motion: Float, index: np.ndarray, params: EnvParams) -> None:
    """Decides again who occupies slots in the worlds ``index`` (n,) of a record, in place."""
    teams = team(record, motion)
    found = standings(teams)
    stand_some(given(index, np.int64), teams, rules(params), found)
    record.occupied[index] = found.occupied[index]


def anchored(relative: Float, vessel: Float) -> Float:
    """Returns a goal (3,) that is given in the frame of the vessel's motion (6,), in the world."""
    turn = np.exp(1j * vessel[2])
    point = vessel[0] + 1j * vessel[1] + turn * (relative[0] + 1j * relative[1])
    return np.array([point.real, point.imag, float(wrap(vessel[2] + relative[2]))])
