"""What an outline of a hull may be, and the outlines of the named hulls."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from asv_env import geometry, polygons
from asv_env.checks import numbers, plain
from asv_env.registry import ReadOnlyDict
from asv_env.text import shown

MOST_CORNERS = 64  #: most corners of an outline: each costs time in a search for near points
SMALLEST, LARGEST = 1e-3, 1e4  #: extents of an outline, m
SHORTEST = 1e-3  #: shortest edge of an outline, largest extents
THINNEST = 0.01  #: smallest area of an outline, squares of its larger extent
CENTRED = 1e-12  #: distance of a centroid from the origin that counts as none, largest extents

Corners = tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class Outline:
    """The corners of a simple polygon, in either direction."""

    def checked(self, name: str, value: Any) -> Corners:
        """Returns the corners as floats, counter-clockwise and with the centroid at the origin.

        Raises:
            ValueError: no such polygon; the message says why, and what would be one.
        """
        corners = _corners(name, value)
        left, right, bottom, top = polygons.extents(corners)
        small, large = sorted((right - left, top - bottom))
        given = f"{name} = {shown(corners)}"
        if not SMALLEST <= small <= large <= LARGEST:
            raise ValueError(
                f"{given}: it is {right - left:.3g} m long and {top - bottom:.3g} m wide; both "
                f"must lie in [{SMALLEST:g}, {LARGEST:g}] m"
            )
        for k in range(len(corners)):
            near = math.dist(corners[k - 1], corners[k])
            if near < SHORTEST * large:
                raise ValueError(
                    f"{given}: corners {corners[k - 1]!r} and {corners[k]!r} follow each other and "
                    f"are {near:.3g} m apart; leave one of them out (the outline closes by itself)"
                )
        if not polygons.is_simple(corners):
            raise ValueError(
                f"{given}: it crosses or touches itself; give the corners in their order round "
                "the hull"
            )
        area = polygons.area(corners)
        if abs(area) < THINNEST * large * large:
            raise ValueError(
                f"{given}: too thin, with an area of {abs(area):.3g} m^2 at an extent of "
                f"{large:.3g} m; make it at least {THINNEST * large * large:.3g} m^2"
            )
        corners = corners if area > 0 else corners[::-1]
        x, y = polygons.centroid(corners)
        if math.hypot(x, y) <= CENTRED * large:
            return corners
        return tuple((corner[0] - x, corner[1] - y) for corner in corners)


def _corners(name: str, value: Any) -> Corners:
    """Returns pairs of floats.

    Raises:
        ValueError: something else, or too few or too many.
    """
    items = plain(value)
    listed = isinstance(items, Sequence) and not isinstance(items, str | bytes)
    pairs = [numbers(item, 2) for item in items[: MOST_CORNERS + 1]] if listed else []
    found = tuple((pair[0], pair[1]) for pair in pairs if pair is not None)
    if len(found) < len(pairs) or not 3 <= len(found) <= MOST_CORNERS:
        count = f" ({len(items)} corners)" if listed and len(items) > MOST_CORNERS else ""
        raise ValueError(
            f"{name} = {shown(value)}{count}: give from 3 to {MOST_CORNERS} corners (x, y), "
            "finite numbers, m"
        )
    return found


def _ring(count: int, turn: float = 0.0) -> Corners:
    """Returns the corners of a regular polygon of the nominal area; the first one at an angle."""
    radius = math.sqrt(2 * NOMINAL_AREA / (count * math.sin(2 * math.pi / count)))
    angles = [turn + 2 * math.pi * k / count for k in range(count)]
    return tuple((radius * math.cos(a), radius * math.sin(a)) for a in angles)


NOMINAL_AREA = 0.06  #: of the nominal plank, and of the named hulls but the barge, m^2
SHAPES = ReadOnlyDict(
    {
        "square": tuple(geometry.rectangle(*[math.sqrt(NOMINAL_AREA)] * 2)),
        "disc": _ring(48),
        "triangle": _ring(3, math.pi / 6),
        "hexagon": _ring(6),
        # Square aft, and a blunt bow.
        "barge": (
            (-0.24, -0.08), (0.15, -0.08), (0.24, -0.04), (0.24, 0.04), (0.15, 0.08), (-0.24, 0.08),
        ),
        # A bar on the +n side, from which a leg stands off aft, or in the middle.
        "L": ((0.0, 0.1), (0.0, -0.24), (0.1, -0.24), (0.1, 0.0), (0.36, 0.0), (0.36, 0.1)),
        "T": (
            (-0.18, 0.1), (-0.18, 0.0), (-0.05, 0.0), (-0.05, -0.24), (0.05, -0.24), (0.05, 0.0),
            (0.18, 0.0), (0.18, 0.1),
        ),
    }
)  # fmt: skip
"""Outlines of named hulls at the nominal size, m; sides that are flat face +n."""
