"""The part of the world that a picture shows, and the trails of the bodies in it.

Points are complex numbers x + iy in m, pixels floats (column, row) from the top left corner.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from asv_env.geometry import xy
from asv_env.params import EnvParams
from asv_env.params.obstacle_params import grouping
from asv_env.types import Complex, Float

Box = tuple[complex, complex]  #: lower left and upper right corner, m

ROOM = 0.4  #: clearance round the bodies when an episode begins, vessel lengths
MARGIN = 0.15  #: clearance round bodies that leave the view, vessel lengths
NARROWEST = 2.0  #: half the width of the closest view, vessel lengths
BESIDE = 2.0  #: how far beyond the bodies obstacles are in view, vessel lengths
WIDEST_WALLS = 5.0  #: walls within this half-width are always in view, vessel lengths


@dataclass(frozen=True)
class Camera:
    """A view from straight above, +x to the right and +y up."""

    centre: complex  #: point of the world in the middle of the view, m
    scale: float  #: pixels per metre
    middle: complex  #: position of that point in the frame, column + i row, px

    @classmethod
    def covering(cls, box: Box, left: float, top: float, width: float, height: float) -> Self:
        """Returns the camera that shows a box of the world in a rectangle of the frame, px."""
        span = box[1] - box[0]
        scale = min(width / span.real, height / span.imag)
        return cls((box[0] + box[1]) / 2, scale, complex(left + width / 2, top + height / 2))

    def pixels(self, points: Complex) -> Float:
        """Returns the pixels (..., 2) of points (...) of the world."""
        return xy(((points - self.centre) * self.scale).conj() + self.middle)

    def points(self, pixels: Float) -> Complex:
        """Returns the points (...) of the world at pixels (..., 2)."""
        offset = pixels[..., 0] + 1j * pixels[..., 1] - self.middle
        return offset.conj() / self.scale + self.centre


def first_box(params: EnvParams, motion: Float, goal: Float | None, obstacle: Float) -> Box:
    """Returns the square that an episode begins with: bodies, goal, walls nearby, clearance.

    Obstacles are in it as far as they are not much farther away than all others.

    Args:
        params: parameters of the simulation.
        motion: (B, 6) of one world.
        goal: pose (3,), or None where it does not matter.
        obstacle: (M, 5) of the world, as in ``State``.
    """
    length = params.vessel.size
    low, high = _bounds(params, motion, goal, ROOM * length)
    rows = obstacle[: len(obstacle) - grouping(params).walls]
    if len(rows):
        ends = np.concatenate([rows[:, :2], rows[:, 2:4]]) @ np.array([1, 1j])
        reach = (np.tile(rows[:, 4], 2) + MARGIN * length) * (1 + 1j)
        first, last = _around(*(ends - reach), *(ends + reach))
        room = BESIDE * length * (1 + 1j)
        first, last = (
            _within(first, low - room, high + room),
            _within(last, low - room, high + room),
        )
        low, high = _around(low, high, first, last)
    walls = params.water.walls
    if walls is not None and walls <= WIDEST_WALLS * length:
        corner = (walls + MARGIN * length) * (1 + 1j)
        low, high = _around(low, high, -corner, corner)
    half = max((high - low).real / 2, (high - low).imag / 2, NARROWEST * length) * (1 + 1j)
    middle = (low + high) / 2
    return middle - half, middle + half


def next_box(box: Box, params: EnvParams, motion: Float, goal: Float | None) -> Box:
    """Returns the box, widened if a body of ``motion`` (B, 6) or the goal (3,) leaves it."""
    return _around(*box, *_bounds(params, motion, goal, MARGIN * params.vessel.size))


def _bounds(params: EnvParams, motion: Float, goal: Float | None, margin: float) -> Box:
    """Returns the box that contains all bodies and the goal, and a margin, m."""
    places, hulls = list(motion[:, :2]), [params.vessel] + [params.boat] * params.num_boats
    if goal is not None:
        places, hulls = [*places, goal[:2]], [*hulls, params.vessel]
    radii = np.array([hull.reach for hull in hulls])
    centres, reach = np.array(places) @ np.array([1, 1j]), (radii + margin) * (1 + 1j)
    return _around(*(centres - reach), *(centres + reach))


def _within(point: complex, low: complex, high: complex) -> complex:
    """Returns the point of a box that is nearest to a point."""
    x = min(max(point.real, low.real), high.real)
    return complex(x, min(max(point.imag, low.imag), high.imag))


def _around(*points: complex) -> Box:
    """Returns the smallest box that contains points."""
    x, y = [point.real for point in points], [point.imag for point in points]
    return complex(min(x), min(y)), complex(max(x), max(y))


class Trail:
    """Past positions of the bodies in an episode, thinned so that they stay quick to draw.

    A new point is kept once some body has moved by ``spacing`` m; at ``limit`` points every other
    one is dropped.
    """

    def __init__(self, spacing: float, limit: int) -> None:
        self._spacing, self._limit = spacing, limit
        self.ticks: list[int] = []  #: control ticks of the points, the oldest first
        self.points: list[Complex] = []  #: positions (B,) of the bodies at these ticks, m

    def record(self, tick: int, position: Complex) -> None:
        """Keeps the positions (B,) at a control tick."""
        if self.points and np.abs(position - self.points[-1]).max() < self._spacing:
            return
        if len(self.points) == self._limit:
            del self.ticks[1::2], self.points[1::2]
        self.ticks.append(tick)
        self.points.append(position.copy())
