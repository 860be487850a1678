"""The path of a boat to its target: round the vessel, a spiral, and a straight descent.

The paper's targets lie inside the hull, which also blocks the spirals of boats that start beyond
it. Here a boat that is not yet above the hull first goes round the vessel's centre (the paper's
pure rotation, phi = pi/2) on a circle that clears the hull, which it joins along a tangent. Then
the spiral leads it to the entry point above its target, from where it descends straight, also past
the vessel's ends.

All positions are complex numbers u + iw in the vessel's frame: u along its length, boats come
from w > 0.
"""

import math

import numpy as np

from asv_env.geometry import direction
from asv_env.types import Bool, Complex, Float, Int
from baselines.paper import braitenberg, spiral
from baselines.paper.inputs import positive

OUTWARD_DEPTH = 0.05  #: depth inside the circle from which on a boat heads straight outwards, m
CIRCLE_MARGIN = 0.03  #: gap from the corners of the hull and its clearance to the circle, m
CAPTURE = 0.04  #: distance at which a boat joins the line below its entry point, m
TURNING_ROOM = 0.1  #: room to turn in between the entry points and the circle, m
ARC_POINTS = 12  #: points of a path on the circle


class ApproachPath:
    """Direction and remaining length of the paths of all boats; leading axes are free.

    Args:
        length: length of the vessel, m.
        width: width of the vessel, m.
        clearance: distance of boats' centres from the hull until they descend, m.
        reach: largest distance of a target from the middle of the vessel along it, m.
        sigma: decay of the spiral (Eq 2), rad.

    Raises:
        ValueError: a size or sigma is not positive and finite.
    """

    def __init__(
        self, length: float, width: float, clearance: float, reach: float, sigma: float
    ) -> None:
        self.clearance = margin = float(positive("clearance", clearance))
        half_length, half_width = positive("length", length) / 2, positive("width", width) / 2
        self._sigma = float(positive("sigma", sigma))
        self._clear = half_width + margin
        #: height above the vessel's middle from which boats descend to their targets, m
        self.entry = self._clear + CAPTURE
        corner = math.hypot(half_length + margin, self._clear) + CIRCLE_MARGIN
        outermost = math.hypot(positive("reach", reach) + TURNING_ROOM, self.entry)
        self._circle = max(corner, outermost)

    def turn_direction(self, boat: Complex, target: Complex) -> Int:
        """Returns D (...) of the shorter path round: 0 clockwise, 1 counter-clockwise."""
        clockwise = self._length_round(-boat.conj(), -target.conj())
        return np.where(self._length_round(boat, target) <= clockwise, 1, 0)

    def course(self, boat: Complex, target: Complex, turn_direction: Int) -> tuple[Complex, Float]:
        """Returns the direction in which a boat goes to its target, and the path length left, m.

        Boats arrive with direction -i. ``turn_direction`` (...) is what the method of this name
        chose when the approach began. The direction jumps only where the spiral begins, by less
        than 1 rad. The length is exact, to within about ``CAPTURE``, for a boat that follows the
        path from outside the circle.
        """
        descends = self._can_descend(boat, target)
        down, descent = self._spiral_down(boat, target)
        # The clockwise path is the mirror image of the counter-clockwise one.
        flip = np.where(turn_direction == 1, 1.0, -1.0)
        image, image_target = _mirrored(boat, flip), _mirrored(target, flip)
        around = _mirrored(self._round(image), flip)
        circuit = self._length_round(image, image_target)
        return np.where(descends, down, around), np.where(descends, descent, circuit)

    def points(self, boat: Complex, target: Complex, turn_direction: Int) -> Complex:
        """Returns points (..., n) of the paths of boats to above their targets, m.

        Straight lines take the place of the spirals.
        """
        flip = np.where(turn_direction == 1, 1.0, -1.0)
        image, image_target = _mirrored(boat, flip), _mirrored(target, flip)
        circle = self._circle
        alpha = np.pi / 2 - np.mod(np.arctan2(image.real, image.imag), 2 * np.pi)
        first = alpha + np.arccos(circle / np.maximum(np.abs(image), circle))
        arc = np.maximum(math.asin(self.entry / circle) - first, 0.0)
        angles = first[..., None] + arc[..., None] * np.linspace(0.0, 1.0, ARC_POINTS)
        straight = self._can_descend(boat, target) | (arc == 0.0)
        around = np.where(straight[..., None], image[..., None], circle * direction(angles))
        above = image_target.real + 1j * np.maximum(image_target.imag, self.entry)
        way = np.concatenate([image[..., None], around, above[..., None]], axis=-1)
        return _mirrored(way, flip[..., None])

    def _can_descend(self, boat: Complex, target: Complex) -> Bool:
        """Returns which boats are above the entry point, close above the hull, or in the funnel."""
        offset = boat - target
        near = np.abs(boat) < self._circle
        above = boat.imag >= np.where(near, self._clear, self.entry)
        return above | (2 * np.abs(offset.real) <= CAPTURE + offset.imag)

    def _spiral_down(self, boat: Complex, target: Complex) -> tuple[Complex, Float]:
        """Returns direction and length of the spiral to the entry point and the descent below."""
        height = np.minimum(boat.imag, self.entry)
        offset = boat - target.real - 1j * height
        # The entry point stays in front of a boat, so that its bearing is never singular.
        ahead = np.maximum(CAPTURE - np.abs(offset), 0.0) + np.maximum(self._clear - boat.imag, 0.0)
        offset = offset + 1j * ahead
        alpha = np.arctan2(offset.imag, offset.real)
        theta = spiral.angular_distance(alpha, np.pi / 2)
        phi = spiral.exact_bearing_offset(alpha, self._sigma)
        turn_direction = braitenberg.turn_direction(offset.real, 0.0)
        heading = braitenberg.desired_heading(alpha, turn_direction, phi)
        length = spiral.arc_length(np.abs(offset), theta, self._sigma) - ahead
        return direction(heading), np.maximum(length + height - target.imag, 0.0)

    def _round(self, boat: Complex) -> Complex:
        """Returns the direction on the circle or its tangent, outwards well inside the circle."""
        radius = np.abs(boat)
        outwards = np.clip((self._circle - radius) / OUTWARD_DEPTH, 0.0, 1.0)
        tangent = np.arccos(np.minimum(self._circle / np.maximum(radius, self._circle), 1.0))
        alpha = np.arctan2(boat.imag, boat.real)
        phi = np.pi / 2 * (1 + outwards) - tangent
        return direction(braitenberg.desired_heading(alpha, 1, phi))

    def _length_round(self, boat: Complex, target: Complex) -> Float:
        """Returns the length of the counter-clockwise path, m: tangent, circle, spiral, descent."""
        circle, entry = self._circle, self.entry
        radius = np.maximum(np.abs(boat), circle)
        alpha = np.pi / 2 - np.mod(np.arctan2(boat.real, boat.imag), 2 * np.pi)
        tangent = np.arccos(circle / radius)
        arc = math.asin(entry / circle) - alpha - tangent
        early = (arc < 0) & (radius > circle)  # The tangent reaches the entry points' height.
        course = alpha + np.pi / 2 + tangent
        rise = np.where(early, (entry - boat.imag) / np.where(early, np.sin(course), 1.0), 0.0)
        to_circle = radius - np.abs(boat) + np.sqrt(radius**2 - circle**2)
        length = np.where(early, rise, to_circle + circle * np.maximum(arc, 0.0))
        on_circle = math.sqrt(circle**2 - entry**2)
        leaves = np.where(early, boat.real + rise * np.cos(course), on_circle)
        swing = (leaves - target.real) * spiral.arc_length(1.0, np.pi / 2, self._sigma)
        return np.maximum(length + swing + entry - target.imag, 0.0)


def _mirrored(point: Complex, flip: Float) -> Complex:
    """Returns points u + iw, or -u + iw where ``flip`` is -1."""
    return flip * point.real + 1j * point.imag
