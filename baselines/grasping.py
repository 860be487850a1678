"""The approach phase: spirals that bring every boat to its slot, and the last decimetres.

The law of ``braitenberg`` leads a boat round the vessel to the line above its slot, at the speed
that brings the team there together. The boat then descends along that line facing the hull, like
a car that parks: it leans towards the line as it moves, ahead or astern, and is upright when it
comes to rest. A boat that is too low to reach the line still goes astern and tries again. In
their slots the boats wait a little off the hull until the vessel is in conditional closure.

Boats skid: the sideways velocity of a hull dies away only within about a second. So every phase
asks for a velocity and not for a heading, and boats point to where that velocity still lacks.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from asv_env.formation import Relations
from asv_env.geometry import direction
from asv_env.params import EnvParams
from asv_env.types import Bool, Complex, Float, Int, Sensed
from baselines import braitenberg
from baselines.spiral import approach_speed

SLOWEST = 0.02
"""Least speed on the way, m/s."""
ASTERN = 0.06
"""Speed of boats that try again, m/s."""
STEEPEST = 1.0
"""Largest tangent of a boat's lean towards the line of its slot."""
FACING = 0.5
"""Cosine of the angle within which a boat is said to face the hull."""
BELOW = 0.05
"""How far below its slot a boat still docks, m."""
TINY = 1e-9


@dataclass(frozen=True)
class GraspGains:
    """What the approach may be tuned by.

    Attributes:
        sigma: decay of the spiral (Eq 2), rad.
        cruise: speed for which the boat with the longest way sets the time of arrival, m/s.
        fastest: speed of boats that are late, m/s.
        clearance: of boats' centres from the hull while they pass it, m.
        standoff: gap to the hull in which boats wait for closure, m.
        closing: fall of the speed with the distance left, 1/s.
        turning: yaw rate for an error of the heading, 1/s.
        skid: share of the lacking velocity that is added to the one that is steered for.
        apart: distance below which boats on their way shun one another, m, and
        shun: speed at which they part where they meet, m/s.
        column: half-width, m, and
        top: height over the boats at the side, m, of the place above a slot where a boat docks.
        docking: descent speed for the height above the slot, 1/s, and
        descent: its largest, m/s.
        ahead: height over which a docking boat leans to reach the line of its slot, m, and
        lag: its growth with the speed, s.
        upright: speed towards the hull that is added when steering a docking boat, m/s: it
            comes to rest upright, and noise turns it little.
        funnel: half-width of the line at the hull, m, and
        slope: its growth with the height over the boats at the side.
        retry: height over them below which a boat off the line has missed it, and to which it
            goes astern at least, m.
    """

    sigma: float = 0.7
    cruise: float = 0.09
    fastest: float = 0.12
    clearance: float = 0.2
    standoff: float = 0.01
    closing: float = 0.3
    turning: float = 2.0
    skid: float = 0.7
    apart: float = 0.2
    shun: float = 0.08
    column: float = 0.1
    top: float = 0.5
    docking: float = 0.5
    descent: float = 0.06
    ahead: float = 0.04
    lag: float = 0.5
    upright: float = 0.04
    funnel: float = 0.02
    slope: float = 0.6
    retry: float = 0.12


@dataclass
class GraspMemory:
    """What the boats remember on the approach.

    Attributes:
        sense: (W, A) direction in which each boat goes round the vessel, 0 or 1.
        astern: (W, A) boats that have missed their slots and go astern to try again.
        due: (W,) tick at which all boats are to arrive.
    """

    sense: Int
    astern: Bool
    due: Float


class Grasping:
    """Speed and yaw rate of boats that approach their slots and wait there."""

    def __init__(self, params: EnvParams, gains: GraspGains) -> None:
        self._vessel = params.vessel
        self._side = (params.vessel.width + params.boat.length) / 2
        self._hz = params.clock.control
        self._gains = gains

    def fresh(self, worlds: int, team: int) -> GraspMemory:
        """Memory to be filled by ``begin``."""
        return GraspMemory(
            sense=np.zeros((worlds, team), dtype=np.int64),
            astern=np.zeros((worlds, team), dtype=np.bool_),
            due=np.zeros(worlds),
        )

    def begin(
        self,
        relations: Relations,
        slot: Complex,
        sensed: Sensed,
        memory: GraspMemory,
        which: Bool,
    ) -> None:
        """Starts the approach in some worlds: ways round, and when all are due.

        The boat with the longest way goes at cruising speed; the others slower.
        """
        way = self._way(relations, slot)
        memory.sense[which] = braitenberg.approach_direction(*way)[which]
        _, length = braitenberg.approach_heading(*way, direction=memory.sense)
        longest = (length * sensed.working).max(axis=1)
        memory.due[which] = (sensed.tick + longest / self._gains.cruise * self._hz)[which]
        memory.astern[which] = False

    def steer(
        self, relations: Relations, slot: Complex, sensed: Sensed, memory: GraspMemory
    ) -> Float:
        """Speed m/s and yaw rate rad/s (W, A, 2); brings ``memory.astern`` up to date."""
        gap = self._waiting(slot) - relations.boat
        course, length = braitenberg.approach_heading(
            *self._way(relations, slot), direction=memory.sense
        )
        speed = self._cruising_speed(length, np.abs(gap), sensed, memory)
        docks = self._docking(relations, gap, memory)
        on_way = speed * direction(course) + self._parting(relations)
        wanted = np.where(docks, self._descent(gap, speed, memory), on_way)
        return self._follow(relations, wanted, docks, memory.astern)

    def _waiting(self, slot: Complex) -> Complex:
        """Where boats wait for closure: a little off the side, or in place beside the ends."""
        at_side = np.abs(slot.real) < self._vessel.length / 2
        return slot + 1j * self._gains.standoff * at_side

    def _way(self, relations: Relations, slot: Complex) -> tuple[Any, ...]:
        """The arguments that the approach laws of ``braitenberg`` share."""
        boat, waiting, vessel = relations.boat, self._waiting(slot), self._vessel
        return (
            np.stack([boat.real, boat.imag], axis=-1),
            np.stack([waiting.real, waiting.imag], axis=-1),
            vessel.length,
            vessel.width,
            self._gains.clearance,
            self._gains.sigma,
        )

    def _cruising_speed(
        self, length: Float, distance: Float, sensed: Sensed, memory: GraspMemory
    ) -> Float:
        """Speed (W, A) m/s that brings all boats to their slots when they are due (Eq 7)."""
        gains = self._gains
        left = (memory.due - sensed.tick)[:, None] / self._hz
        speed = approach_speed(length, left, max_speed=gains.fastest, min_speed=SLOWEST)
        return np.minimum(speed, SLOWEST + gains.closing * distance)

    def _parting(self, relations: Relations) -> Complex:
        """Velocity (W, A) m/s away from the boats that are near, in the vessel's frame."""
        away = relations.boat[:, :, None] - relations.boat[:, None, :]
        distance = np.abs(away)
        nearness = np.maximum(1.0 - distance / self._gains.apart, 0.0)
        parting: Complex = (nearness * away / np.maximum(distance, TINY)).sum(axis=2)
        return self._gains.shun * parting

    def _docking(self, relations: Relations, gap: Complex, memory: GraspMemory) -> Bool:
        """(W, A) boats above their slots; those too low to reach its line still go astern."""
        gains, aside = self._gains, np.abs(gap.real)
        height = relations.boat.imag - self._side
        docks = (aside < gains.column) & (gap.imag < BELOW) & (height < gains.top)
        off_line = aside > gains.funnel + gains.slope * np.maximum(height, 0.0)
        low = height < gains.retry
        retries = (low & off_line) | (memory.astern & (low | off_line))
        memory.astern = docks & retries & (relations.alignment.real > FACING)
        return docks

    def _descent(self, gap: Complex, speed: Float, memory: GraspMemory) -> Complex:
        """Velocity (W, A) m/s of docking boats: along the line of the slot, and towards it."""
        gains = self._gains
        fastest = np.minimum(speed, gains.descent)
        along = np.clip(-gains.docking * gap.imag, -gains.descent, fastest)
        along = np.where(memory.astern, -ASTERN, along)
        lean = gap.real / (gains.ahead + gains.lag * np.abs(along))
        lean = np.clip(lean, -STEEPEST, STEEPEST)
        return (np.abs(along) * lean - 1j * along) / np.hypot(1.0, lean)

    def _follow(self, relations: Relations, wanted: Complex, docks: Bool, astern: Bool) -> Float:
        """Speed and yaw rate (W, A, 2) that bring about a velocity in the vessel's frame.

        Docking boats face the hull and may go astern; others turn before they drive off.
        """
        gains, to_vessel = self._gains, relations.heading[:, :1].conj()
        bow = relations.heading[:, 1:] * to_vessel
        lacking = wanted - relations.velocity[:, 1:] * to_vessel
        aim = (wanted + gains.skid * lacking) * np.where(astern, -1.0, 1.0)
        facing = aim.real + 1j * (np.minimum(aim.imag, 0.0) - gains.upright)
        turn = np.where(docks, facing, aim) * bow.conj()
        speed = (wanted * bow.conj()).real
        speed = np.where(docks, speed, np.maximum(speed, 0.0))
        return np.stack([speed, gains.turning * np.arctan2(turn.imag, turn.real)], axis=-1)
