"""The layout of a frame: which pixels a world, its bodies and the captions take."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from asv_env.geometry import xy
from asv_env.params import EnvParams, HullParams
from asv_env.render.camera import Camera
from asv_env.types import Complex, Float

DESIGN = 800.0
"""Side of the frame for which widths of lines and sizes of text are given, px."""
SMALLEST_BOAT = 9.0
"""Length below which boats are drawn enlarged, px."""


@dataclass(frozen=True)
class Layout:
    """One world as a camera sees it.

    Attributes:
        params: parameters of the simulation.
        camera: the position of the world in the frame.
        size: (width, height) of the frame, px.
        band: height of the bands for captions above and below the water, px.
    """

    params: EnvParams
    camera: Camera
    size: tuple[int, int]
    band: float

    @cached_property
    def unit(self) -> float:
        """Scale of widths and text: 1 for a frame of ``DESIGN`` pixels."""
        return min(self.size) / DESIGN

    @cached_property
    def bar(self) -> float:
        """Length of the scale bar and spacing of the grid, m."""
        return round_number(min(self.size) / 4.5 / self.camera.scale)

    @cached_property
    def flows(self) -> bool:
        """Whether the water moves."""
        return self.params.water.current != "still" and self.params.water.current_speed > 0

    @cached_property
    def vessel(self) -> Complex:
        """Corners (n,) of the vessel in its own frame, m."""
        return vertices(self.params.vessel.outline)

    @cached_property
    def enlarged(self) -> float:
        """Factor by which boats are drawn larger than they are, at least 1."""
        drawn = self.params.boat.length * self.camera.scale
        return max(1.0, SMALLEST_BOAT * self.unit / drawn)

    @cached_property
    def boat(self) -> Complex:
        """Corners (n,) of a boat as it is drawn, in its own frame, m.

        It grows backwards, so that the bow of a boat that pushes stays outside the vessel.
        """
        shift = (self.enlarged - 1) * self.params.boat.length / 2
        return self.enlarged * vertices(self.params.boat.outline) - shift

    @cached_property
    def detailed(self) -> bool:
        """Whether boats are large enough for an edge round the hull."""
        return self.params.boat.length * self.camera.scale > 1.6 * SMALLEST_BOAT * self.unit

    def pixels(self, shape: Complex | Float, pose: Float) -> Float:
        """Returns the pixels (..., n, 2) of a shape (n,) of bodies with poses (..., >= 3)."""
        return self.camera.pixels(placed(shape, pose))


def round_number(limit: float) -> float:
    """Returns the largest of 1, 2, 5 times a power of ten that is at most ``limit`` > 0."""
    decade = 10.0 ** math.floor(math.log10(limit) + 1e-9)
    return next(k * decade for k in (5.0, 2.0, 1.0) if k * decade <= limit * (1 + 1e-9))


def placed(shape: Complex | Float, pose: Float) -> Complex:
    """Returns the points (..., n) in the world of points (n,) of bodies with poses (..., >= 3)."""
    turn = np.exp(1j * pose[..., 2])
    return (pose[..., 0] + 1j * pose[..., 1])[..., None] + shape * turn[..., None]


def outline(hull: HullParams, pose: Float) -> Float:
    """Returns the corners (..., n, 2) of hulls at poses (..., 3), m."""
    return xy(placed(vertices(hull.outline), pose))


def vertices(corners: Sequence[tuple[float, float]]) -> Complex:
    """Returns corners (n,) as complex numbers x + iy."""
    return np.array(corners, dtype=np.float64).view(np.complex128)[:, 0]


def inset(shape: Complex, margin: float) -> Complex:
    """Returns a hull (n,) that is about ``margin`` m smaller on all sides."""
    middle = (shape.real.max() + shape.real.min()) / 2
    x, y = np.ptp(shape.real) / 2, np.ptp(shape.imag) / 2
    along = middle + (shape.real - middle) * (1 - margin / x)
    smaller: Complex = along + 1j * shape.imag * (1 - margin / y)
    return smaller


def bow(shape: Complex, taper: float) -> Complex:
    """Returns the front ``taper`` m of a hull whose corners are ordered as ``boat_hull`` does."""
    shoulder, tip = shape[4], shape[3]
    corners = np.array([tip.real - taper + 1j * shoulder.imag, shoulder, tip])
    return np.concatenate([corners, corners[::-1].conj()])
