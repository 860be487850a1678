"""The way of a boat to its slot: round the vessel, and on a spiral to the gate above the slot.

The paper's targets lie inside the hull, which also blocks the spirals of boats that start beyond
it. Here a boat that is not yet above the hull first goes round the vessel's centre (the paper's
pure rotation, phi = pi/2) on a circle that clears the hull, which it joins along a tangent; then
the spiral leads it to the gate, and from there it descends straight, which also brings it beside
the ends.

Everything is given in the vessel's frame as complex numbers u + iw: u along its length, boats
come from w > 0.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from asv_env.geometry import direction
from asv_env.types import Bool, Complex, Float
from baselines.paper import braitenberg, spiral
from baselines.paper.inputs import positive

RAMP = 0.05
"""How far inside the circle a boat heads straight outwards, m."""
CIRCLE_MARGIN = 0.03
"""Between the corners of the hull, inflated by the clearance, and the circle, m."""
CAPTURE = 0.04
"""Distance from the gate, and from the line below it, at which a boat steers for the line, m."""
TURN = 0.1
"""Room to turn in between the circle and the gates, m."""


class Way:
    """Where the ways of all boats of a team lead; every law of it keeps leading axes free.

    Args:
        length: of the vessel, m.
        width: of the vessel, m.
        clearance: of boats' centres from the hull until they descend, m.
        reach: largest distance of a slot from the middle of the vessel along it, m.
        sigma: decay of the spiral (Eq 2), rad.

    Raises:
        ValueError: a size or sigma is not positive and finite.
    """

    def __init__(
        self, length: float, width: float, clearance: float, reach: float, sigma: float
    ) -> None:
        margin = float(positive("clearance", clearance))
        half_length, half_width = positive("length", length) / 2, positive("width", width) / 2
        self._sigma = float(positive("sigma", sigma))
        self._top = half_width + margin
        self._gate = self._top + CAPTURE
        corner = math.hypot(half_length + margin, self._top) + CIRCLE_MARGIN
        self._circle = max(corner, math.hypot(positive("reach", reach) + TURN, self._gate))

    def sense(self, boat: Complex, slot: Complex) -> NDArray[np.int_]:
        """Sense D of the shorter way round: 0 clockwise, 1 counter-clockwise."""
        clockwise = self._length_round(-boat.conj(), -slot.conj())
        return np.where(self._length_round(boat, slot) <= clockwise, 1, 0)

    def course(
        self, boat: Complex, slot: Complex, sense: NDArray[np.int_]
    ) -> tuple[Complex, Float]:
        """Direction in which a boat goes to its slot, and the way that is left, m.

        The direction jumps only where the spiral begins, by less than 1 rad. The length is exact,
        to within about ``CAPTURE``, for a boat that follows it from outside the circle.

        Args:
            boat: (...) positions.
            slot: (...) where boats arrive with direction -i.
            sense: (...) in which they go round, kept from ``sense``.
        """
        lands = self._may_land(boat, slot)
        down, landing = self._landing(boat, slot)
        # The clockwise way is the mirror image of the counter-clockwise one.
        flip = np.where(sense == 1, 1.0, -1.0)
        image, image_slot = _mirrored(boat, flip), _mirrored(slot, flip)
        turn, going_round = (
            _mirrored(self._round(image), flip),
            self._length_round(image, image_slot),
        )
        return np.where(lands, down, turn), np.where(lands, landing, going_round)

    def _may_land(self, boat: Complex, slot: Complex) -> Bool:
        """Above the gate, close above the hull, or in the funnel that narrows to the slot."""
        off = boat - slot
        clear = boat.imag >= np.where(np.abs(boat) < self._circle, self._top, self._gate)
        return clear | (2 * np.abs(off.real) <= CAPTURE + off.imag)

    def _landing(self, boat: Complex, slot: Complex) -> tuple[Complex, Float]:
        """Direction and length on the spiral to the gate and the descent below it.

        The spiral's target is the gate. It sinks with a boat that is lower, a little in front of
        one within the capture radius, and farther in front of one beside the hull. So its bearing
        never becomes singular, a boat off the line returns to it before it descends, and beside
        the hull it hardly turns.
        """
        anchor = np.minimum(boat.imag, self._gate)
        off = boat - slot.real - 1j * anchor
        ahead = np.maximum(CAPTURE - np.abs(off), 0.0) + np.maximum(self._top - boat.imag, 0.0)
        off = off + 1j * ahead
        alpha = np.arctan2(off.imag, off.real)
        theta = spiral.angular_distance(alpha, np.pi / 2)
        phi = spiral.exact_bearing_offset(alpha, self._sigma)
        heading = braitenberg.desired_heading(alpha, braitenberg.turn_direction(off.real, 0.0), phi)
        length = spiral.arc_length(np.abs(off), theta, self._sigma) - ahead
        return direction(heading), np.maximum(length + anchor - slot.imag, 0.0)

    def _round(self, boat: Complex) -> Complex:
        """Direction counter-clockwise on the circle or its tangent, outwards well inside it."""
        radius = np.abs(boat)
        outwards = np.clip((self._circle - radius) / RAMP, 0.0, 1.0)
        lead = np.arccos(np.minimum(self._circle / np.maximum(radius, self._circle), 1.0))
        alpha = np.arctan2(boat.imag, boat.real)
        phi = np.pi / 2 * (1 + outwards) - lead
        return direction(braitenberg.desired_heading(alpha, 1, phi))

    def _length_round(self, boat: Complex, slot: Complex) -> Float:
        """Length of the counter-clockwise way to the slot, m: tangent, circle, spiral, descent.

        A boat beside the vessel may reach the gates' height on the tangent already.
        """
        circle, gate = self._circle, self._gate
        radius = np.maximum(np.abs(boat), circle)
        alpha = np.pi / 2 - np.mod(np.arctan2(boat.real, boat.imag), 2 * np.pi)
        lead = np.arccos(circle / radius)
        angle = math.asin(gate / circle) - alpha - lead
        early = (angle < 0) & (radius > circle)
        course = alpha + np.pi / 2 + lead
        rise = np.where(early, (gate - boat.imag) / np.where(early, np.sin(course), 1.0), 0.0)
        tangent = radius - np.abs(boat) + np.sqrt(radius**2 - circle**2)
        length = np.where(early, rise, tangent + circle * np.maximum(angle, 0.0))
        rising = np.where(early, boat.real + rise * np.cos(course), math.sqrt(circle**2 - gate**2))
        swing = (rising - slot.real) * spiral.arc_length(1.0, np.pi / 2, self._sigma)
        return np.maximum(length + swing + gate - slot.imag, 0.0)


def _mirrored(point: Complex, flip: Float) -> Complex:
    """Points u + iw, or -u + iw where ``flip`` is -1."""
    mirrored: Complex = flip * point.real + 1j * point.imag
    return mirrored
