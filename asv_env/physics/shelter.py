"""Shelter: hulls that lie close together hide sides of each other from the water.

The drag of a boat's side that faces the vessel falls by a share, and so does that of the part of
the vessel's side that boats cover. The effect is full in contact and ends where the gap between
the hulls is a boat's width. The model is a guess of the right kind, see docs/physics.md.
"""

import math
from typing import NamedTuple

from asv_env.compiled import compiled
from asv_env.params import EnvParams
from asv_env.polygons import Outline, complex_corners, contains, outline, to_outline
from asv_env.types import Float


class Cover(NamedTuple):
    """Sizes that decide how hulls cover each other."""

    share: float  #: by which drag falls in contact
    outline: Outline  #: of the vessel
    stern: float  #: least u of the vessel, m
    bow: float  #: largest u of the vessel, m
    vessel_length: float  #: m
    vessel_width: float  #: m
    boat_length: float  #: m
    boat_width: float  #: m


def cover(params: EnvParams) -> Cover:
    """Returns the sizes of these parameters."""
    vessel, boat = params.vessel, params.boat
    stern, bow, _, _ = vessel.extents
    sizes = vessel.length, vessel.width, boat.length, boat.width
    return Cover(params.water.shelter, outline(complex_corners(vessel.corners)), stern, bow, *sizes)


@compiled
def facing(cover: Cover, x: float, y: float, cos: float, sin: float) -> tuple[float, float, float]:
    """Returns how a boat faces the vessel.

    Args:
        cover: sizes.
        x: position of the boat along the vessel, m.
        y: position of the boat across the vessel, m.
        cos: cosine of the boat's heading relative to the vessel's.
        sin: sine of that.

    Returns:
        Closeness (1 in contact, 0 from a gap of a boat's width on), and the parts of the side
        that faces the vessel in surge and in sway, which sum to 1.
    """
    if contains(cover.outline.end, complex(x, y)):
        return 1.0, 0.0, 0.0
    to_hull = to_outline(cover.outline, complex(x, y))
    dx, dy = -to_hull.real, -to_hull.imag
    distance = math.hypot(dx, dy)
    if distance == 0.0:
        return 1.0, 0.0, 0.0
    along, across = (cos * dx + sin * dy) / distance, (cos * dy - sin * dx) / distance
    reach = 0.5 * (abs(along) * cover.boat_length + abs(across) * cover.boat_width)
    gap = max(distance - reach, 0.0)
    return max(1.0 - gap / cover.boat_width, 0.0), along * along, across * across


@compiled
def shelter(cover: Cover, motion: Float, factors: Float) -> None:
    """Writes the factors on surge and sway drag of a world's hulls.

    Args:
        cover: sizes and share.
        motion: (B, 6) motion of the hulls, the vessel first.
        factors: (B, 2) receives the factors, from 1 - share to 1.
    """
    cos, sin = math.cos(motion[0, 2]), math.sin(motion[0, 2])
    covered_side, covered_end = 0.0, 0.0
    for body in range(1, len(motion)):
        dx, dy = motion[body, 0] - motion[0, 0], motion[body, 1] - motion[0, 1]
        x, y = cos * dx + sin * dy, cos * dy - sin * dx
        turn = motion[body, 2] - motion[0, 2]
        c, s = math.cos(turn), math.sin(turn)
        close, surge, sway = facing(cover, x, y, c, s)
        factors[body, 0] = 1.0 - cover.share * close * surge
        factors[body, 1] = 1.0 - cover.share * close * sway
        if cover.stern <= x <= cover.bow:
            covered_side += close * (abs(s) * cover.boat_width + abs(c) * cover.boat_length)
        else:
            covered_end += close * (abs(c) * cover.boat_width + abs(s) * cover.boat_length)
    factors[0, 0] = 1.0 - cover.share * min(covered_end / cover.vessel_width, 1.0)
    factors[0, 1] = 1.0 - cover.share * min(covered_side / cover.vessel_length, 1.0)
