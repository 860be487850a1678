"""The approach phase: spirals that bring every boat above its slot, and a common descent.

Each boat follows the law of ``approach`` to a gate above its slot, at the speed that brings the
team to the gates together (Eq 7). The boats wait there, facing the hull, until all have lined
up; then they descend along the lines of their slots, like cars that park, and wait a little off
the hull until the vessel is in conditional closure. A boat that is too low to reach its line
still goes astern and tries again; when too many miss, all go back to their gates.

Boats skid: the sideways velocity of a hull dies away only within about a second. So every phase
asks for a velocity past the hull and not for a heading, boats point to where that velocity still
lacks, and they lean against the water that drifts past the hull, which they notice because it
carries them along.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from asv_env.params import EnvParams
from asv_env.tasks import formation
from asv_env.tasks.formation import Relations
from asv_env.types import Bool, Complex, Float, Int, Sensed
from baselines.paper.spiral import approach_speed
from baselines.scripted.approach_path import Way

SLOWEST = 0.02
"""Least speed on the way, m/s."""
STEEPEST = 1.0
"""Largest tangent of a boat's lean towards the line of its slot."""
FACING = 0.5
"""Cosine of the angle within which a boat that has missed its slot may go straight astern."""
UPRIGHT = 0.9
"""Cosine of the angle within which a boat is lined up."""
BELOW = 0.05
"""How far below its slot a boat still docks, m."""
IN_PLACE = 0.9
"""Share of the tolerance of a slot within which a boat in it stays there."""
ASIDE = 0.5
"""Share of that tolerance by which a boat stands aside of a failed one."""
MISSING = 1 / 3
"""Share of the boats that may miss their slots before all go back."""
STARBOARD = np.exp(0.8j)
"""By which boats turn their way past each other."""
TINY = 1e-9


@dataclass(frozen=True)
class GraspGains:
    """What the approach may be tuned by.

    Attributes:
        sigma: decay of the spiral (Eq 2), rad.
        cruise: speed for which the boat with the longest way sets the time of arrival, m/s.
        fastest: speed of boats that are late, m/s.
        closing: fall of the speed with the distance left to the gate, 1/s.
        turning: yaw rate for an error of the heading, 1/s.
        skid: share of the lacking velocity that is added to the one that is steered for.
        memory: time over which the drift of the water is averaged, s.
        apart: distance below which boats on their way shun one another, m, and
        shun: speed at which they part where they meet, m/s.
        line: height of the gates above the slots, m.
        patience: time after which the team no longer waits for boats that are late, s.
        column: half-width, m, and
        top: height, m, of the place above its gate or slot where a boat docks.
        docking: speed for the height above them, 1/s, and
        descent: its largest, m/s.
        ahead: height over which a docking boat leans to reach the line of its slot, m, and
        lag: its growth with the speed, s.
        upright: speed for which a slower docking boat leans, m/s: it comes to rest upright, and
            noise turns it little.
        slope: growth of the width of the funnel that leads to a slot with the height above it.
        retry: height below which a boat outside the funnel has missed, and to which it goes
            astern at least, m.
        standoff: gap to the hull in which boats wait for closure, m.
    """

    sigma: float = 0.7
    cruise: float = 0.16
    fastest: float = 0.2
    closing: float = 0.35
    turning: float = 2.5
    skid: float = 0.7
    memory: float = 3.0
    apart: float = 0.2
    shun: float = 0.08
    line: float = 0.1
    patience: float = 10.0
    column: float = 0.1
    top: float = 0.35
    docking: float = 1.0
    descent: float = 0.06
    ahead: float = 0.04
    lag: float = 0.7
    upright: float = 0.09
    slope: float = 0.6
    retry: float = 0.06
    standoff: float = 0.007


@dataclass
class GraspMemory:
    """What the boats remember on the approach.

    Attributes:
        slot: (W, A) slots that the approach leads to, m.
        sense: (W, A) direction in which each boat goes round the vessel, 0 or 1.
        due: (W,) tick at which all boats are to be at their gates.
        descends: (W,) whether the team has left the gates for the slots.
        astern: (W, A) boats that have missed their slots and go astern to try again.
        drift: (W, A) velocity of the water past the hull at each boat, in the vessel's frame, m/s.
    """

    slot: Complex
    sense: Int
    due: Float
    descends: Bool
    astern: Bool
    drift: Complex


class Grasping:
    """Speed and yaw rate of boats that approach their slots and wait there."""

    def __init__(self, params: EnvParams, gains: GraspGains) -> None:
        vessel, boat = params.hulls()
        self._half_length = vessel.length / 2
        self._boat = boat
        self._tolerance = params.task.slot_distance
        self._hz = params.clock.control
        self._gains = gains
        points = formation.slots(params, params.num_boats)
        highest = float(points.imag.max())
        self._way = Way(
            vessel.length,
            vessel.width,
            highest + gains.line - vessel.width / 2,
            float(np.abs(points.real).max()),
            gains.sigma,
        )
        self._row = highest + boat.length
        # A sideways velocity dies away within this time.
        self._skid_time = boat.total_mass / (boat.sway[0] + boat.sway[1] * gains.descent)

    def fresh(self, worlds: int, team: int) -> GraspMemory:
        """Memory to be filled by ``begin``."""
        return GraspMemory(
            slot=np.full((worlds, team), np.nan, dtype=np.complex128),
            sense=np.zeros((worlds, team), dtype=np.int64),
            due=np.zeros(worlds),
            descends=np.zeros(worlds, dtype=np.bool_),
            astern=np.zeros((worlds, team), dtype=np.bool_),
            drift=np.zeros((worlds, team), dtype=np.complex128),
        )

    def begin(
        self,
        relations: Relations,
        slot: Complex,
        sensed: Sensed,
        memory: GraspMemory,
        which: Bool,
    ) -> None:
        """Starts the approach in some worlds, and anew where the slots have changed.

        The boat with the longest way goes at cruising speed; the others slower.
        """
        which = which | (memory.slot != slot).any(axis=1)
        if not which.any():
            return
        boat, gate = relations.boat[which], self._gate(slot[which])
        sense = self._way.sense(boat, gate)
        _, length = self._way.course(boat, gate, sense)
        longest = (length * sensed.working[which]).max(axis=1)
        memory.slot[which], memory.sense[which] = slot[which], sense
        memory.due[which] = sensed.tick[which] + longest / self._gains.cruise * self._hz
        memory.descends[which] = False
        memory.astern[which] = False
        memory.drift[which] = 0.0

    def steer(
        self, relations: Relations, slot: Complex, sensed: Sensed, memory: GraspMemory
    ) -> Float:
        """Speed m/s and yaw rate rad/s (W, A, 2); brings ``memory`` up to date."""
        bow, hull, moves = self._look(relations, memory)
        gate = self._gate(slot)
        course, length = self._way.course(relations.boat, gate, memory.sense)
        self._judge(relations, gate, sensed, memory)
        berth = np.where(memory.descends[:, None], self._berth(slot), gate)
        if not sensed.working.all():
            berth = berth + self._dodge(relations, berth, sensed)
        gap = berth - relations.boat
        docks = self._docking(relations, gap, slot, memory)

        speed = self._cruising_speed(length, np.abs(gap), sensed, memory)
        on_way = speed * course + self._parting(relations)
        wanted = np.where(docks, self._descent(gap, memory), on_way)
        ahead = ((wanted + hull) * bow.conj()).real
        ahead = np.where(docks, ahead, np.maximum(ahead, 0.0))  # Others turn before they go.
        aim = wanted - memory.drift + self._gains.skid * (wanted - moves)
        turn = self._facing(aim, docks, memory.astern) * bow.conj()
        return np.stack([ahead, self._gains.turning * np.arctan2(turn.imag, turn.real)], axis=-1)

    def _gate(self, slot: Complex) -> Complex:
        gate: Complex = slot + 1j * self._gains.line
        return gate

    def _berth(self, slot: Complex) -> Complex:
        """Where boats wait for closure: in their slots, a little off the side or the end."""
        at_side = np.abs(slot.real) < self._half_length
        return slot + self._gains.standoff * np.where(at_side, 1j, np.sign(slot.real))

    def _look(self, relations: Relations, memory: GraspMemory) -> tuple[Complex, Complex, Complex]:
        """Bows of the boats, velocities of the hull at them, and theirs past it, (W, A) each.

        All in the vessel's frame. Brings the drift up to date, of which a boat notices the
        component across its bow. Its own skid in a turn, speed times yaw rate times the time in
        which it dies away, is not taken for drift.
        """
        to_vessel = relations.heading[:, :1].conj()
        bow = relations.heading[:, 1:] * to_vessel
        share = 1.0 / (1.0 + self._gains.memory * self._hz)
        turn = relations.yaw_rate[:, :1]
        hull = relations.velocity[:, :1] * to_vessel + 1j * turn * relations.boat
        moves = relations.velocity[:, 1:] * to_vessel - hull
        skid = self._skid_time * (moves * bow.conj()).real * (relations.yaw_rate[:, 1:] - turn)
        surprise = ((moves - memory.drift) * bow.conj()).imag + skid
        memory.drift = memory.drift + 1j * bow * share * surprise
        return bow, hull, moves

    def _dodge(self, relations: Relations, berth: Complex, sensed: Sensed) -> Complex:
        """How far (W, A) boats stand aside, m, where a failed one lies in the row of the slots."""
        lies_there = ~sensed.working & (relations.boat.imag < self._row)
        aside = berth.real[:, :, None] - relations.boat.real[:, None, :]
        lacks = np.maximum(self._boat.width - np.abs(aside), 0.0) * lies_there[:, None, :]
        most = ASIDE * self._tolerance
        dodge: Complex = np.clip((np.sign(aside) * lacks).sum(axis=2), -most, most) + 0j
        return dodge

    def _docking(
        self, relations: Relations, gap: Complex, slot: Complex, memory: GraspMemory
    ) -> Bool:
        """(W, A) boats above their slots; those too low to reach the line still go astern."""
        gains, height = self._gains, -gap.imag
        above = (relations.boat - slot).imag > -BELOW
        docks = (np.abs(gap.real) < gains.column) & (height < gains.top) & above
        off_line = ~self._in_funnel(relations, slot, height)
        low = height < gains.retry
        retries = (low & off_line) | (memory.astern & (low | off_line))
        memory.astern = docks & retries & (relations.alignment.real > FACING)
        return docks

    def _in_funnel(self, relations: Relations, slot: Complex, height: Float) -> Bool:
        width = IN_PLACE * self._tolerance + self._gains.slope * np.maximum(height, 0.0)
        return np.abs((relations.boat - slot).real) < width

    def _judge(
        self, relations: Relations, gate: Complex, sensed: Sensed, memory: GraspMemory
    ) -> None:
        """Whether the team descends: once all are lined up at their gates, or some are late.

        It goes back when too many miss, but not where a failed boat may lie in the way.
        """
        gains, working, off = self._gains, sensed.working, relations.boat - gate
        near = (np.abs(off.real) < self._tolerance) & (off.imag < gains.retry)
        lined_up = near & (relations.alignment.real > UPRIGHT)
        missing = memory.descends[:, None] & memory.astern & (off.imag < 0.0) & working
        back = working.all(axis=1) & (missing.mean(axis=1) > MISSING)
        memory.due = np.where(back, sensed.tick, memory.due)
        late = sensed.tick > memory.due + gains.patience * self._hz
        memory.descends = (memory.descends & ~back) | (lined_up | ~working).all(axis=1) | late

    def _cruising_speed(
        self, length: Float, distance: Float, sensed: Sensed, memory: GraspMemory
    ) -> Float:
        """Speed (W, A) m/s that brings all boats to their gates when they are due (Eq 7)."""
        gains = self._gains
        left = (memory.due - sensed.tick)[:, None] / self._hz
        speed = approach_speed(length, left, max_speed=gains.fastest, min_speed=SLOWEST)
        return np.minimum(speed, SLOWEST + gains.closing * distance)

    def _parting(self, relations: Relations) -> Complex:
        """Velocity (W, A) m/s away from the boats that are near, in the vessel's frame.

        Turned to starboard, so that no two boats hold each other up.
        """
        away = relations.boat[:, :, None] - relations.boat[:, None, :]
        distance = np.abs(away)
        nearness = np.maximum(1.0 - distance / self._gains.apart, 0.0)
        parting: Complex = (nearness * away / np.maximum(distance, TINY)).sum(axis=2)
        return self._gains.shun * STARBOARD * parting

    def _descent(self, gap: Complex, memory: GraspMemory) -> Complex:
        """Velocity (W, A) m/s of docking boats: along the line of the slot, and towards it."""
        gains = self._gains
        along = np.clip(-gains.docking * gap.imag, -gains.descent, gains.descent)
        along = np.where(memory.astern, -gains.descent, along)
        lean = gap.real / (gains.ahead + gains.lag * np.abs(along))
        lean = np.clip(lean, -STEEPEST, STEEPEST)
        return (np.abs(along) * lean - 1j * along) / np.hypot(1.0, lean)

    def _facing(self, aim: Complex, docks: Bool, astern: Bool) -> Complex:
        """Where boats turn their bows: docking ones towards the hull, also when going astern."""
        aim = np.where(astern, -aim, aim)
        towards = aim.real + 1j * np.minimum(aim.imag, -self._gains.upright)
        return np.where(docks, towards, aim)
