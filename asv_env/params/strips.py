"""Hydrodynamic coefficients of a flat-bottomed hull of any outline, by strip theory.

A strip of the hull's side, of unit length and normal n, resists the part of its velocity that
points along n: with the added mass of a rectangular section and the drag of a sharp-edged prism.
Skin friction is that of the bottom, by strips along the flow. For a rectangle these are the sums
from which the nominal vessel's coefficients come; docs/physics.md explains them.

The free surface is a rigid lid (the low-frequency limit), so that a hull of draft T has half the
added mass of the double body of height 2 T.
"""

import math
from typing import Any

import numpy as np
from scipy.special import elliprd

from asv_env import polygons

DENSITY = 1000.0  #: of fresh water, kg/m^3
PRISM_DRAG = 0.9
"""Drag coefficient of sharp-edged sides.

Rectangular prisms that are long in the flow: 0.9 at six heights (White, table 7.2); ends 0.87 to
0.99 at four to eight diameters (table 7.3).
"""
RECTANGLE = (
    (0.1, 2.23), (0.2, 1.98), (0.5, 1.70), (1.0, 1.51), (2.0, 1.36), (5.0, 1.21), (10.0, 1.14),
)  # fmt: skip
"""Height over length in the flow of a rectangle, and its added mass over pi rho (height / 2)^2.

DNV-RP-C205, appendix D, table D-1; Newman, Marine Hydrodynamics, table 4.3.
"""


def interpolated(table: tuple[tuple[float, float], ...], ratio: float) -> float:
    """Returns a value of a table, linear in the logarithm of its first column."""
    ratios, values = np.transpose(table)
    return float(np.interp(math.log(ratio), np.log(ratios), values))


def rectangle_sway(beam: float, draft: float) -> float:
    """Returns the added mass in sway of a rectangular section, kg/m."""
    return DENSITY * math.pi / 2 * draft**2 * interpolated(RECTANGLE, 2 * draft / beam)


def end_factors(length: float, beam: float, draft: float) -> tuple[float, float, float]:
    """Returns what the flow round the ends does to strip theory.

    It is taken from the ellipsoid with the axes of the double body (Lamb, Hydrodynamics,
    articles 114 and 115), as Lewis and Taylor did.

    Returns:
        Added mass in surge over the displaced mass, and added mass in sway and added inertia in
        yaw over those of strips.
    """
    a, b, c = length / 2, beam / 2, draft
    alpha = 2 / 3 * a * b * c * float(elliprd(b * b, c * c, a * a))
    beta = 2 / 3 * a * b * c * float(elliprd(a * a, c * c, b * b))
    surge, sway = alpha / (2 - alpha), beta / (2 - beta)
    difference, total = a * a - b * b, a * a + b * b
    per = 2 * difference + total * (alpha - beta)
    turn = difference**2 * (beta - alpha) / per if per else 0.0
    # Displaced masses over those of strips, both of the ellipsoid.
    return surge, sway * b / c, turn * b / (c * a * a)


def coefficients(corners: polygons.Corners, mass: float, friction: float) -> dict[str, Any]:
    """Returns added masses and drag of a hull, by the names of ``HullParams``.

    Args:
        corners: counter-clockwise, the centroid at the origin, m.
        mass: kg; the draft follows from it by Archimedes.
        friction: linear friction of the bottom per area, times the root of its length in the
            flow, kg/(s m^1.5).
    """
    area = polygons.area(corners)
    draft = mass / (DENSITY * area)
    left, right, bottom, top = polygons.extents(corners)
    length, beam = right - left, top - bottom
    surge, sway, yaw = (_along(corners, axis) for axis in range(3))
    ahead = end_factors(beam, length, draft)[1] * rectangle_sway(area / beam, draft)
    across = end_factors(length, beam, draft)[1] * rectangle_sway(area / length, draft)
    # The ellipsoid has added inertia in so far as one of its axes is longer than the other.
    turning = end_factors(max(length, beam), min(length, beam), draft)[2]
    turning *= rectangle_sway(area / max(length, beam), draft)
    drag = 0.5 * DENSITY * PRISM_DRAG * draft
    along_x, along_y = friction * math.sqrt(beam * area), friction * math.sqrt(length * area)
    over_x, over_y = polygons.second_moments(corners)
    return {
        "added_mass": (ahead * surge[0], across * sway[0]),
        "added_inertia": turning * yaw[0],
        "surge": (along_x, drag * surge[1]),
        "sway": (along_y, drag * sway[1]),
        "yaw": ((along_y * over_x + along_x * over_y) / area, drag * yaw[1]),
    }


def _along(corners: polygons.Corners, axis: int) -> tuple[float, float]:
    """Returns the integrals of the squares and cubes of normal velocities along both sides.

    The velocities are those of a motion of 1 m/s along an axis, or of 1 rad/s in yaw (axis 2).
    Front and back count half each, so that for a rectangle they are the integrals along it.
    """
    points, along = polygons.edges(corners)
    size = np.hypot(*along.T)
    normal = np.stack([along[:, 1], -along[:, 0]], axis=1) / size[:, None]
    if axis < 2:
        velocity = np.abs(normal[:, axis])
        return float((velocity**2 * size).sum() / 2), float((velocity**3 * size).sum() / 2)
    # The lever of the normal force is the distance along the edge from the foot of the origin.
    first = (points * along).sum(axis=1) / size
    last = first + size
    square = (last**3 - first**3) / 3
    cube = (np.abs(last) ** 3 * last - np.abs(first) ** 3 * first) / 4
    return float(square.sum() / 2), float(cube.sum() / 2)
