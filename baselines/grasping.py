"""The approach phase: spirals that bring every boat to its slot, and the last decimetres.

The law of ``braitenberg`` leads a boat round the vessel and down to its slot, at the speed that
brings the team there together. Boats skid, so the last bit is done slowly and along the line of
the slot; a boat that misses it goes astern and tries again. In their slots the boats wait a
little off the hull until the vessel is in conditional closure.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from asv_env.formation import Relations
from asv_env.geometry import wrap
from asv_env.params import EnvParams
from asv_env.types import Bool, Complex, Float, Int, Sensed
from baselines import braitenberg
from baselines.alongside import SLOW, drift, hull_velocity, turn_to
from baselines.spiral import approach_speed

SLOWEST = 0.02
ASTERN = 0.06
FASTEST_DESCENT = 0.06
LARGEST_LEAD = 0.5
ROOM = 0.06
"""Beyond the clearance, within which a boat counts as being at the hull, m."""


@dataclass(frozen=True)
class GraspGains:
    """What the approach may be tuned by.

    Attributes:
        sigma: decay of the spiral (Eq 2), rad.
        cruise: speed of the boat with the longest way, m/s.
        clearance: of boats' centres from the hull while they pass it, m.
        standoff: gap to the hull in which boats wait for closure, m.
        turning: yaw rate for an error of the course, 1/s.
        skid: share of the skid that is steered against under way.
        closing: fall of the speed with the distance left, 1/s.
        docking: descent speed for the height above the slot, 1/s.
        docking_skid: share of the skid that is steered against in the descent.
        sideways: speed along the hull for the distance off the slot's line, 1/s.
        funnel: half-width of the line at the slot, m, and
        funnel_slope: its growth with the height.
        retry: how much farther from the hull a boat goes astern that has missed its slot, m.
    """

    sigma: float = 0.7
    cruise: float = 0.09
    clearance: float = 0.12
    standoff: float = 0.01
    turning: float = 2.0
    skid: float = 0.7
    closing: float = 0.3
    docking: float = 0.25
    docking_skid: float = 0.7
    sideways: float = 0.45
    funnel: float = 0.012
    funnel_slope: float = 0.3
    retry: float = 0.03


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
        gains = self._gains
        gap = self._waiting(slot) - relations.boat
        course, length = braitenberg.approach_heading(
            *self._way(relations, slot), direction=memory.sense
        )
        speed = self._cruising_speed(length, np.abs(gap), sensed, memory)

        docks = self._docking(relations, gap, memory)
        descent, lead = self._descent(relations, slot, gap)
        speed = np.where(docks, descent, np.where(memory.astern, -ASTERN, speed))
        straight = np.where(docks, lead, 0.0) - np.pi / 2
        course = np.where(docks | memory.astern, straight, course)

        under_way = ~(docks | memory.astern)
        error = wrap(turn_to(relations, course) - gains.skid * drift(relations) * under_way)
        # A boat that faces away turns before it drives off.
        ahead = np.where(docks, 1.0, np.clip(1.5 * np.cos(error) - 0.3, 0.0, 1.0))
        return np.stack([speed * ahead, gains.turning * error], axis=-1)

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
        gains = self._gains
        left = (memory.due - sensed.tick)[:, None] / self._hz
        speed = approach_speed(length, left, max_speed=gains.cruise, min_speed=SLOWEST)
        return np.minimum(speed, SLOWEST + gains.closing * distance)

    def _docking(self, relations: Relations, gap: Complex, memory: GraspMemory) -> Bool:
        """(W, A) boats on the line of their slots; those that have missed it go astern."""
        gains, boat = self._gains, relations.boat
        height, aside = -gap.imag, np.abs(gap.real)
        facing = relations.alignment.real > 0.3
        on_line = aside < gains.funnel + gains.funnel_slope * np.maximum(height, 0.0)
        missed = facing & ~on_line & self._at_hull(boat, 0.0)
        memory.astern = missed | (memory.astern & self._at_hull(boat, gains.retry))
        near = (height < 2 * gains.clearance) | self._at_hull(boat, 0.0)
        return facing & on_line & near & ~memory.astern

    def _at_hull(self, boat: Complex, more: float) -> Bool:
        """(W, A) boats beside the pushed side or an end, with ``more`` m of room."""
        vessel, reach = self._vessel, self._gains.clearance + ROOM + more
        beside = np.abs(boat.real) < vessel.length / 2 + reach
        above = boat.imag > -vessel.width / 3
        return beside & above & (boat.imag < vessel.width / 2 + reach)

    def _descent(self, relations: Relations, slot: Complex, gap: Complex) -> tuple[Float, Float]:
        """Speed (W, A) down the line of the slot, and heading off that of the slot."""
        gains = self._gains
        across, along = hull_velocity(relations, slot)
        speed = across + np.clip(-gains.docking * gap.imag, -FASTEST_DESCENT, FASTEST_DESCENT)
        wanted = along + gains.sideways * gap.real
        lead = np.arctan2(wanted, np.maximum(speed, SLOW)) - gains.docking_skid * drift(relations)
        return speed, np.clip(lead, -LARGEST_LEAD, LARGEST_LEAD)
