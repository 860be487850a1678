"""What a team that allocates forces remembers from tick to tick."""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from asv_env.types import Bool, Complex, Float, Int, zeros
from baselines.allocation.direct_path import Course, Limits
from baselines.allocation.manoeuvres import ManoeuvreMemory
from baselines.allocation.waypoints import Way
from baselines.scripted.observer import VesselMemory


@dataclass
class Memory:
    """What the team remembers from tick to tick."""

    wanted: Float  #: (W, A, 2) speeds and yaw rates that the boats are to have, m/s and rad/s
    reference: Float  #: (W, A, 2) of the boats' autopilots, m/s and rad/s
    vessel: VesselMemory
    course: Course
    limits: Limits
    place: Complex  #: (W, A) where boats touch the hull, vessel frame, m
    inward: Complex  #: (W, A) how they point there
    number: Int  #: (W, A) numbers of their points in the formation
    working: Bool  #: (W, A) boats that worked
    in_place: Bool  #: (W, A)
    astern: Bool  #: (W, A) boats that have missed their points and go astern to try again
    recoil: Int  #: (W, A) ticks for which boats that were kept from their places go astern
    grasped: Bool  #: (W,) whether boats have pushed since points were assigned
    waiting: Int  #: (W,) ticks for which a boat has been missing
    pair: Bool  #: (W,) whether the team is one of two boats, which go by manoeuvres
    manoeuvre: ManoeuvreMemory
    way: Way  #: of the vessel among obstacles
    via: Complex  #: (W, A) next corners of boats' routes among obstacles, world frame, m
    left: Float  #: (W, A) length of the routes from there, m
    end: Complex  #: (W, A) ends of the routes, world frame, m
    by_script: Bool  #: (W,) worlds in which the scripted policy acts
    scripted: Any  #: its memory of these worlds alone; None as long as it has not acted

    @classmethod
    def empty(cls, worlds: int, team: int) -> Self:
        """Returns memory to be filled when episodes begin."""
        world, boats = (worlds,), (worlds, team)
        course = zeros(Course, *[world] * 8)
        course.axis[:] = 1.0
        return cls(
            wanted=np.zeros((*boats, 2)),
            reference=np.zeros((*boats, 2)),
            vessel=VesselMemory.empty(worlds, team),
            course=course,
            limits=zeros(Limits, *[world] * 4),
            place=np.zeros(boats, dtype=np.complex128),
            inward=np.ones(boats, dtype=np.complex128),
            number=np.zeros(boats, dtype=np.int64),
            working=np.zeros(boats, dtype=np.bool_),
            in_place=np.zeros(boats, dtype=np.bool_),
            astern=np.zeros(boats, dtype=np.bool_),
            recoil=np.zeros(boats, dtype=np.int64),
            grasped=np.zeros(world, dtype=np.bool_),
            waiting=np.zeros(world, dtype=np.int64),
            pair=np.zeros(world, dtype=np.bool_),
            manoeuvre=ManoeuvreMemory.empty(worlds, team),
            way=Way.empty(worlds),
            via=np.zeros(boats, dtype=np.complex128),
            left=np.zeros(boats),
            end=np.full(boats, np.nan, dtype=np.complex128),
            by_script=np.zeros(world, dtype=np.bool_),
            scripted=None,
        )

    def of_script(self, which: Bool) -> Any:
        """Returns the memory of the scripted policy in the worlds ``which`` (W,), which it gets.

        That of worlds in which it begins is void.
        """
        if self.scripted is None or (which == self.by_script).all():
            return self.scripted
        before = np.maximum(np.cumsum(self.by_script) - 1, 0)
        return picked(self.scripted, before[which])


def picked(record: Any, index: Int) -> Any:
    """Returns the worlds ``index`` (n,) of a record of arrays, of such records, and of None."""
    if record is None:
        return None
    if isinstance(record, np.ndarray):
        return record[index]
    parts = {name: picked(part, index) for name, part in vars(record).items()}
    return type(record)(**parts)
