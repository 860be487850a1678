"""The descent of the team from the waypoints to the slots, like cars that park.

The team GATHERs at the waypoints above the slots. It DESCENDs once all boats are aligned there,
or some are late, and GATHERs again when too many have missed their slots, or when they jam and it
takes too long. A boat near the line of its slot DOCKs: it goes down the line. One that gets too low
outside the funnel above its slot goes ASTERN until it is inside the funnel, and high enough for
another try.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from asv_env.params import EnvParams
from asv_env.tasks.formation import Relations
from asv_env.types import Bool, Complex, Float, Int, Sensed, zeros
from baselines.scripted.gains import GraspGains

MAX_SLOPE = 1.0  #: largest slope of a docking boat's path to the line of its slot
ASTERN_ALIGNMENT = 0.5  #: cosine of the heading error within which a boat may go astern
ALIGNED = 0.9  #: cosine of the heading error within which a boat at its waypoint is aligned
BELOW = 0.05  #: depth below its slot to which a boat still docks, m
FUNNEL_WIDTH = 0.9  #: half-width of the funnel at the slot, fraction of the slot's tolerance
MISSING = 1 / 3  #: fraction of boats that may miss their slots before all retry


@dataclass
class GraspMemory:
    """What the boats remember on the approach."""

    slot: Complex  #: (W, A) slots that the approach leads to, m
    turn_direction: Int  #: (W, A) in which each boat goes round the vessel, 0 or 1
    due: Float  #: (W,) tick at which all boats are to be at their waypoints, or began to descend
    descending: Bool  #: (W,) team state: DESCEND where true, GATHER otherwise
    astern: Bool  #: (W, A) boats that have missed their slots and go astern to try again
    detours: Bool  #: (W, A) boats that leave their paths because of obstacles
    #: (W, A) next corner of each boat's route round obstacles, world frame, m; see ``routes``
    via: Complex
    left: Float  #: (W, A) length of the route from there to its end, m
    end: Complex  #: (W, A) end of the route, world frame, m

    @classmethod
    def empty(cls, worlds: int, team: int) -> Self:
        """Returns memory to be filled when an approach begins."""
        boats = worlds, team
        return zeros(cls, boats, boats, (worlds,), (worlds,), *[boats] * 5)


class Docking:
    """State transitions and velocities of the descent."""

    def __init__(self, params: EnvParams, gains: GraspGains) -> None:
        self._tolerance, self._hz = params.task.slot_distance, params.clock.control
        self._gains = gains

    def update_team(
        self, relations: Relations, waypoint: Complex, sensed: Sensed, memory: GraspMemory
    ) -> None:
        """Updates the team's state; a failed boat, which may lie in the way, rules out GATHER."""
        gains, working, offset = self._gains, sensed.working, relations.boat - waypoint
        near = (np.abs(offset.real) < self._tolerance) & (offset.imag < gains.retry_height)
        ready = near & (relations.alignment.real > ALIGNED) | ~working
        missing = memory.descending[:, None] & memory.astern & (offset.imag < 0.0) & working
        late = self.late(sensed, memory)
        failed = (missing.mean(axis=1) > MISSING) | (memory.descending & late)
        gather = working.all(axis=1) & failed
        descend = ~memory.descending & (ready.all(axis=1) | late)
        memory.due = np.where(gather | descend, sensed.tick, memory.due)
        memory.descending = (memory.descending & ~gather) | descend

    def late(self, sensed: Sensed, memory: GraspMemory) -> Bool:
        """Returns which teams (W,) have been in their state for too long."""
        descent, gathering = self._gains.descent_patience, self._gains.patience
        patience = np.where(memory.descending, descent, gathering)
        return np.asarray(sensed.tick - memory.due > patience * self._hz)

    def update_boats(
        self, relations: Relations, gap: Complex, slot: Complex, memory: GraspMemory, sees: Bool
    ) -> Bool:
        """Returns which boats (W, A) dock, given the gaps (W, A) m to their targets.

        Those that dock see the way to their slots (W, A).
        """
        now = relations.boat, relations.alignment.real, gap, slot
        docks, astern = self.update(*now, memory.astern)
        memory.astern = astern & sees
        return docks & sees

    def update(
        self, boat: Complex, alignment: Float, gap: Complex, slot: Complex, astern: Bool
    ) -> tuple[Bool, Bool]:
        """Returns which boats (W, A) dock, and which of them go astern.

        Args:
            boat: (W, A) positions, in a frame in which boats come to their slots from +w, m.
            alignment: (W, A) cosines of their heading errors.
            gap: (W, A) from them to their targets, m.
            slot: (W, A) their slots, m.
            astern: (W, A) boats that went astern.
        """
        gains, height, offset = self._gains, -gap.imag, boat - slot
        docks = np.abs(gap.real) < gains.docking_half_width
        docks &= (height < gains.docking_height) & (offset.imag > -BELOW)
        slack = gains.funnel_slope * np.maximum(height, 0.0)
        outside = ~(np.abs(offset.real) < FUNNEL_WIDTH * self._tolerance + slack)
        low = height < gains.retry_height
        retries = (low & outside) | (astern & (low | outside))
        return docks, docks & retries & (alignment > ASTERN_ALIGNMENT)

    def velocity(self, gap: Complex, astern: Bool) -> Complex:
        """Returns velocities (W, A) m/s of docking boats: down their slot's line and towards it."""
        gains, limit = self._gains, self._gains.descent_speed
        down = np.where(astern, -limit, np.clip(-gains.descent_gain * gap.imag, -limit, limit))
        slope = gap.real / (gains.lookahead + gains.lookahead_time * np.abs(down))
        slope = np.clip(slope, -MAX_SLOPE, MAX_SLOPE)
        return (np.abs(down) * slope - 1j * down) / np.hypot(1.0, slope)
