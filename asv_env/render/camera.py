"""What part of the world a picture shows, where its points lie, and where bodies have been.

Points are complex numbers x + iy in m, pixels floats (column, row) from the top left corner.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from asv_env.geometry import xy
from asv_env.params import EnvParams, HullParams
from asv_env.types import Complex, Float, Int

Box = tuple[complex, complex]
"""Lower left and upper right corner, m."""

ROOM = 0.4
"""What is free round the bodies when an episode begins, vessel lengths."""
MARGIN = 0.15
"""What is kept free round them when they wander out, vessel lengths."""
NARROWEST = 2.0
"""Half the width of the closest view, vessel lengths."""
WIDEST_WALLS = 5.0
"""Walls within this half-width are always in view, vessel lengths."""


@dataclass(frozen=True)
class Camera:
    """A view from straight above, +x to the right and +y up.

    Attributes:
        centre: the point of the world that is seen in the middle, m.
        scale: pixels per metre.
        middle: where in the frame that point is, column + i row, px.
    """

    centre: complex
    scale: float
    middle: complex

    @classmethod
    def covering(cls, box: Box, left: float, top: float, width: float, height: float) -> Camera:
        """The camera that shows a whole box of the world in a rectangle of the frame, px."""
        span = box[1] - box[0]
        scale = min(width / span.real, height / span.imag)
        return cls((box[0] + box[1]) / 2, scale, complex(left + width / 2, top + height / 2))

    def pixels(self, points: Complex) -> Float:
        """Pixels (..., 2) of points (...) of the world."""
        seen = ((points - self.centre) * self.scale).conj() + self.middle
        return xy(seen)

    def points(self, pixels: Float) -> Complex:
        """Points (...) of the world behind pixels (..., 2)."""
        seen = pixels[..., 0] + 1j * pixels[..., 1] - self.middle
        return seen.conj() / self.scale + self.centre


def first_box(params: EnvParams, motion: Float, goal: Float | None) -> Box:
    """The square that an episode begins with: bodies and goal, and room round them.

    Args:
        params: the environment's; walls that are near are taken in.
        motion: (B, 6) of one world.
        goal: (3,) pose, or None where it does not matter.
    """
    length = params.vessel.length
    low, high = _bounds(params, motion, goal, ROOM * length)
    walls = params.water.walls
    if walls is not None and walls <= WIDEST_WALLS * length:
        corner = (walls + MARGIN * length) * (1 + 1j)
        low, high = _union((low, high), (-corner, corner))
    half = max((high - low).real / 2, (high - low).imag / 2, NARROWEST * length) * (1 + 1j)
    middle = (low + high) / 2
    return middle - half, middle + half


def next_box(box: Box, params: EnvParams, motion: Float, goal: Float | None) -> Box:
    """The same box, widened if a body of ``motion`` (B, 6) or the goal (3,) leaves it."""
    return _union(box, _bounds(params, motion, goal, MARGIN * params.vessel.length))


def _bounds(params: EnvParams, motion: Float, goal: Float | None, margin: float) -> Box:
    centres = motion[:, 0] + 1j * motion[:, 1]
    radii = np.full(len(centres), _radius(params.boat))
    radii[0] = _radius(params.vessel)
    if goal is not None:
        centres = np.append(centres, goal[0] + 1j * goal[1])
        radii = np.append(radii, radii[0])
    reach = (radii + margin) * (1 + 1j)
    low, high = centres - reach, centres + reach
    return (
        complex(low.real.min(), low.imag.min()),
        complex(high.real.max(), high.imag.max()),
    )


def _radius(hull: HullParams) -> float:
    return math.hypot(hull.length, hull.width) / 2


def _union(one: Box, other: Box) -> Box:
    return (
        complex(min(one[0].real, other[0].real), min(one[0].imag, other[0].imag)),
        complex(max(one[1].real, other[1].real), max(one[1].imag, other[1].imag)),
    )


class Trail:
    """Where the bodies have been in an episode, thinned so that it stays quick to draw.

    Args:
        bodies: B.
        spacing: m that some body has to move before a new point is kept.
        limit: number of points at which every other one is dropped.
    """

    def __init__(self, bodies: int, spacing: float, limit: int) -> None:
        self._spacing = spacing
        self._ticks = np.zeros(limit, dtype=np.int64)
        self._points = np.zeros((limit, bodies), dtype=np.complex128)
        self._count = 0

    @property
    def ticks(self) -> Int:
        """(n,) control ticks of the points."""
        return self._ticks[: self._count]

    @property
    def points(self) -> Complex:
        """(n, B) positions, the oldest first, m."""
        return self._points[: self._count]

    def record(self, tick: int, position: Complex) -> None:
        """Takes note of the positions (B,) at a control tick."""
        if self._count and np.abs(position - self.points[-1]).max() < self._spacing:
            return
        if self._count == len(self._ticks):
            self._count = (self._count + 1) // 2
            self._ticks[: self._count] = self._ticks[::2].copy()
            self._points[: self._count] = self._points[::2].copy()
        self._ticks[self._count] = tick
        self._points[self._count] = position
        self._count += 1
