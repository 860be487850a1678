"""The steering law round a target, Eqs (1) and (3), and an approach that clears the vessel.

Corrections to the printed Eq (3): its phase + D pi - (2 D - 1) phi sends the boats of one
direction away from the target whatever the sign of beta; the phase is (2 D - 1) phi, beta > 0,
and arctan means arctan2. The printed rule keeps D for ever, so that a boat that crosses above its
target is led once round the vessel; see `signed_direction`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asv_env.geometry import wrap
from baselines.arcs import Array, finite, positive
from baselines.spiral import angular_distance, arc_length, exact_bearing_offset

RAMP = 0.05  # m below the circle over which a boat turns from round to straight outwards
CIRCLE_MARGIN = 0.03  # m between the inflated hull's corners and the circle


def direction(x: ArrayLike, target_x: ArrayLike) -> NDArray[np.int_]:
    """Sense D in which a boat goes round its target: 1 counter-clockwise if x >= target_x, else 0.

    The shorter way to the side above the target. Arguments (...) m, result (...).
    """
    return np.where(finite("x", x) >= finite("target_x", target_x), 1, 0)


def signed_direction(
    position: ArrayLike, target: ArrayLike, latched: ArrayLike
) -> NDArray[np.int_]:
    """Sense D, looked up anew above the target and kept at `latched` below it.

    Not in the paper. Continuous, as the offset phi is 0 where D changes.

    Args:
        position: (..., 2) m.
        target: (..., 2) m.
        latched: (...) 0 or 1, from `direction` at the start.

    Returns:
        (...) 0 or 1.
    """
    position, target = finite("position", position), finite("target", target)
    above = position[..., 1] > target[..., 1]
    return np.where(above, direction(position[..., 0], target[..., 0]), _senses(latched))


def desired_heading(alpha: ArrayLike, direction: ArrayLike, phi: ArrayLike) -> Array:
    """Heading that the law steers to: alpha + pi - (2 D - 1) phi, not wrapped (Eqs 1 and 3).

    Args:
        alpha: (...) rad, direction in which the target sees the boat, arctan2(y - Ty, x - Tx).
        direction: (...) D, 0 clockwise or 1 counter-clockwise.
        phi: (...) rad, angle between the heading and the target.

    Returns:
        (...) rad.

    Raises:
        ValueError: a number is not finite, or a direction is neither 0 nor 1.
    """
    return finite("alpha", alpha) + np.pi - (2 * _senses(direction) - 1) * finite("phi", phi)


def wheel_speeds(
    heading: ArrayLike,
    alpha: ArrayLike,
    direction: ArrayLike,
    phi: ArrayLike,
    speed: ArrayLike,
    beta: ArrayLike,
) -> tuple[Array, Array]:
    """Wheel speeds of the law (Eq 3, corrected; direction 0 gives Eq 1 itself, for any phi).

    The turn rate (right - left) / track is -K sin(heading - desired heading), K = 2 beta / track.
    Stable for K dt < 1 with the one-step delay of the printed law; no wheel reverses if beta <= S.

    Args:
        heading: (...) rad.
        alpha: (...) rad, direction in which the target sees the boat.
        direction: (...) D, 0 clockwise or 1 counter-clockwise.
        phi: (...) rad, angle between the heading and the target.
        speed: (...) m/s, S_1.
        beta: (...) m/s, gain.

    Returns:
        Left and right wheel speed, each (...) m/s.

    Raises:
        ValueError: a number is not finite, a direction is neither 0 nor 1, or beta <= 0.
    """
    error = finite("heading", heading) - desired_heading(alpha, direction, phi)
    difference = positive("beta", beta) * np.sin(error)
    speed = finite("speed", speed)
    return speed + difference, speed - difference


def approach_heading(
    position: ArrayLike,
    slot: ArrayLike,
    vessel_length: ArrayLike,
    vessel_width: ArrayLike,
    clearance: ArrayLike,
    sigma: ArrayLike,
    *,
    direction: ArrayLike | None = None,
    tangent: bool = False,
    capture_radius: ArrayLike = 0.04,
    turn_radius: ArrayLike = 0.1,
) -> tuple[Array, Array]:
    """Heading of a boat on its way to a slot, clear of the hull, and the path length that is left.

    The paper's targets lie inside the hull, which also blocks the spirals of boats that start
    beyond it. Here a boat that is not yet above the hull goes round the vessel's centre (phi =
    pi/2, the paper's pure rotation, and outwards where it is too near); then the spiral leads it
    to the gate, a point above its slot; from there it descends straight, which also brings it
    beside the ends. The heading jumps only where the spiral begins, by less than 0.3 rad (1 rad
    with `tangent`), and where the shorter way round changes sides.

    Args:
        position: (..., 2) m, boat in the vessel's frame (length along x, boats come from y > 0).
        slot: (..., 2) m, where the boat's centre arrives with heading -pi/2; y >= 0.
        vessel_length: (...) m.
        vessel_width: (...) m.
        clearance: (...) m, distance of the boat's centre from the hull, kept until the descent.
        sigma: (...) rad, of the spiral.
        direction: (...) D round the vessel, kept from `approach_direction`; None: looked up anew.
        tangent: go to the circle that clears the hull straight along its tangent, which is
            shorter than keeping the starting radius but brings boats closer together.
        capture_radius: (...) m, distance from the gate and from the line below it within which a
            boat steers for the line and not for a point; at least 2 S/K (speed, heading gain).
        turn_radius: (...) m, room to turn in between the circle and the gate.

    Returns:
        Desired heading (...) rad in (-pi, pi], and length (...) m of the path to the slot (exact
        for a boat that follows the heading, to within about capture_radius).

    Raises:
        ValueError: a number is not finite, a size or sigma not positive, or a direction neither 0
            nor 1.
    """
    position, sigma = finite("position", position), positive("sigma", sigma)
    berth = _berth(slot, vessel_length, vessel_width, clearance, capture_radius, turn_radius)
    ways = _ways_round(position, berth, sigma, tangent)
    sense = np.where(ways[1] <= ways[0], 1, 0) if direction is None else _senses(direction)
    heading, length = _landing(position, berth, sigma)
    landing = _may_land(position, berth)
    round_heading = _heading_round(position, berth, sense, tangent)
    round_length = np.where(sense == 1, ways[1], ways[0])
    return wrap(np.where(landing, heading, round_heading)), np.where(landing, length, round_length)


def approach_direction(
    position: ArrayLike,
    slot: ArrayLike,
    vessel_length: ArrayLike,
    vessel_width: ArrayLike,
    clearance: ArrayLike,
    sigma: ArrayLike,
    *,
    tangent: bool = False,
    capture_radius: ArrayLike = 0.04,
    turn_radius: ArrayLike = 0.1,
) -> NDArray[np.int_]:
    """Sense D (...) of the shorter way round the vessel; arguments as for `approach_heading`."""
    berth = _berth(slot, vessel_length, vessel_width, clearance, capture_radius, turn_radius)
    position, sigma = finite("position", position), positive("sigma", sigma)
    ways = _ways_round(position, berth, sigma, tangent)
    return np.where(ways[1] <= ways[0], 1, 0)


@dataclass(frozen=True)
class _Berth:
    """Where a boat goes and what it keeps clear of, in the vessel's frame.

    Attributes:
        slot: (..., 2) m.
        top: (...) m, height above which the hull is clear.
        gate: (...) m, height of the point above the slot where the straight descent begins.
        circle: (...) m, radius about the vessel's centre that clears the hull.
        capture: (...) m, see `approach_heading`.
    """

    slot: Array
    top: Array
    gate: Array
    circle: Array
    capture: Array


def _berth(
    slot: ArrayLike,
    vessel_length: ArrayLike,
    vessel_width: ArrayLike,
    clearance: ArrayLike,
    capture_radius: ArrayLike,
    turn_radius: ArrayLike,
) -> _Berth:
    slot, capture = finite("slot", slot), positive("capture_radius", capture_radius)
    half_length = positive("vessel_length", vessel_length) / 2
    half_width = positive("vessel_width", vessel_width) / 2
    margin, turn = positive("clearance", clearance), positive("turn_radius", turn_radius)
    top = half_width + margin
    gate = np.maximum(slot[..., 1], top + capture)
    corner = np.hypot(half_length + margin, half_width + margin) + CIRCLE_MARGIN
    circle = np.maximum(corner, np.hypot(np.abs(slot[..., 0]) + turn, gate))
    return _Berth(slot, top, gate, circle, capture)


def _may_land(position: Array, berth: _Berth) -> NDArray[np.bool_]:
    """Above the gate, close above the hull, or in the funnel that narrows down to the slot."""
    across, above = np.moveaxis(position - berth.slot, -1, 0)
    inside = np.hypot(position[..., 0], position[..., 1]) < berth.circle
    clear = position[..., 1] >= np.where(inside, berth.top, berth.gate)
    return clear | (2 * np.abs(across) <= berth.capture + above)


def _landing(position: Array, berth: _Berth, sigma: Array) -> tuple[Array, Array]:
    """Heading and length left on the spiral to the gate and the descent below it.

    The spiral's target is the gate. It sinks with a boat that is lower, a little in front of one
    within the capture radius, and farther in front of one beside the hull. So its bearing never
    becomes singular, a boat off the line returns to it before it descends, and beside the hull it
    hardly turns.
    """
    anchor = np.minimum(position[..., 1], berth.gate)
    across, above = position[..., 0] - berth.slot[..., 0], position[..., 1] - anchor
    near = np.maximum(berth.capture - np.hypot(across, above), 0.0)
    ahead = near + np.maximum(berth.top - position[..., 1], 0.0)
    alpha = np.arctan2(above + ahead, across)
    theta = angular_distance(alpha, np.pi / 2)
    phi = exact_bearing_offset(alpha, sigma)
    heading = desired_heading(alpha, direction(across, 0.0), phi)
    spiral = arc_length(np.hypot(across, above + ahead), theta, sigma) - ahead
    return heading, np.maximum(spiral + anchor - berth.slot[..., 1], 0.0)


def _heading_round(position: Array, berth: _Berth, sense: ArrayLike, tangent: bool) -> Array:
    """Heading round the vessel's centre, turned straight outwards well inside the circle."""
    radius = np.hypot(position[..., 0], position[..., 1])
    alpha = np.arctan2(position[..., 1], position[..., 0])
    outwards = np.clip((berth.circle - radius) / RAMP, 0.0, 1.0)
    phi = np.pi / 2 * (1 + outwards)
    if tangent:
        phi -= np.arccos(np.minimum(berth.circle / np.maximum(radius, berth.circle), 1.0))
    return desired_heading(alpha, sense, phi)


def _ways_round(position: Array, berth: _Berth, sigma: Array, tangent: bool) -> Array:
    """(2, ...) m: lengths of the way to the slot clockwise and counter-clockwise.

    The clockwise way is the counter-clockwise one of the mirror image.
    """
    mirror = np.array([-1.0, 1.0]).reshape((2,) + (1,) * np.ndim(berth.gate + position[..., 0]))
    x, y, slot_x = mirror * position[..., 0], position[..., 1], mirror * berth.slot[..., 0]
    radius = np.maximum(np.hypot(x, y), berth.circle)
    alpha = np.pi / 2 - np.mod(np.pi / 2 - np.arctan2(y, x), 2 * np.pi)
    ring = berth.circle if tangent else radius
    lead = np.arccos(ring / radius)
    angle = np.arcsin(berth.gate / ring) - alpha - lead
    rising_x = np.sqrt(ring**2 - berth.gate**2)
    length = radius - np.hypot(x, y) + np.sqrt(radius**2 - ring**2) + ring * np.maximum(angle, 0)
    if tangent:
        course = alpha + np.pi / 2 + lead
        early = (angle < 0) & (np.hypot(x, y) > ring)
        rise = np.where(early, (berth.gate - y) / np.where(early, np.sin(course), 1.0), 0.0)
        length = np.where(early, rise, length)
        rising_x = np.where(early, x + rise * np.cos(course), rising_x)
    spiral = (rising_x - slot_x) * arc_length(1.0, np.pi / 2, sigma)
    return length + spiral + berth.gate - berth.slot[..., 1]


def _senses(direction: ArrayLike) -> NDArray[np.int_]:
    senses = np.asarray(direction)
    if not np.isin(senses, (0, 1)).all():
        raise ValueError(f"direction must be 0 (clockwise) or 1, got {direction!r}")
    return senses.astype(np.int_)
