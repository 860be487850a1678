"""What a team that allocates forces remembers from tick to tick."""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from asv_env.types import Bool, Complex, Float, Int
from baselines.allocation.team_plan import TeamPlan, empty_plan
from baselines.scripted.observer import VesselMemory


@dataclass
class Memory(TeamPlan):
    """What the team remembers from tick to tick."""

    wanted: Float  #: (W, A, 2) speeds and yaw rates that the boats are to have, m/s and rad/s
    reference: Float  #: (W, A, 2) of the boats' autopilots, m/s and rad/s
    vessel: VesselMemory
    astern: Bool  #: (W, A) boats that have missed their points and go astern to try again
    recoil: Int  #: (W, A) ticks for which boats that were kept from their places go astern
    via: Complex  #: (W, A) next corners of boats' routes among obstacles, world frame, m
    left: Float  #: (W, A) length of the routes from there, m
    end: Complex  #: (W, A) ends of the routes, world frame, m
    scripted: Any  #: memory of the scripted policy in the worlds ``lacking``; None before it acts

    @classmethod
    def empty(cls, worlds: int, team: int) -> Self:
        """Returns memory to be filled when episodes begin."""
        boats = (worlds, team)
        return cls(
            **empty_plan(worlds, team),
            wanted=np.zeros((*boats, 2)),
            reference=np.zeros((*boats, 2)),
            vessel=VesselMemory.empty(worlds, team),
            astern=np.zeros(boats, dtype=np.bool_),
            recoil=np.zeros(boats, dtype=np.int64),
            via=np.zeros(boats, dtype=np.complex128),
            left=np.zeros(boats),
            end=np.full(boats, np.nan, dtype=np.complex128),
            scripted=None,
        )

    def of_script(self, which: Bool) -> Any:
        """Returns the memory of the scripted policy in the worlds ``which`` (W,), which it gets.

        That of worlds in which it begins is void.
        """
        if self.scripted is None or (which == self.lacking).all():
            return self.scripted
        before = np.maximum(np.cumsum(self.lacking) - 1, 0)
        return picked(self.scripted, before[which])


def picked(record: Any, index: Int) -> Any:
    """Returns the worlds ``index`` (n,) of a record of arrays, of such records, and of None."""
    if record is None:
        return None
    if isinstance(record, np.ndarray):
        return record[index]
    parts = {name: picked(part, index) for name, part in vars(record).items()}
    return type(record)(**parts)
