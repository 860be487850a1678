"""The layout of a frame: which pixels a world, its bodies and the captions take."""

import math

import numpy as np

from asv_env.geometry import xy
from asv_env.memo import by_identity
from asv_env.params import EnvParams, HullParams
from asv_env.polygons import complex_corners, roomiest
from asv_env.render.camera import Camera
from asv_env.types import Complex, Float

DESIGN = 800.0  #: side of the frame for which widths of lines and sizes of text are given, px
SMALLEST_BOAT = 9.0  #: length below which boats are drawn enlarged, px


class Layout:
    """One world as a camera sees it.

    Args:
        params: parameters of the simulation.
        camera: the position of the world in the frame.
        size: (width, height) of the frame, px.
        band: height of the bands for captions above and below the water, px.
    """

    def __init__(
        self, params: EnvParams, camera: Camera, size: tuple[int, int], band: float
    ) -> None:
        self.params, self.camera, self.size, self.band = params, camera, size, band
        self.unit = min(size) / DESIGN  #: scale of widths and text, 1 for ``DESIGN`` pixels
        #: length of the scale bar and spacing of the grid, m
        self.bar = round_number(min(size) / 4.5 / camera.scale)
        #: whether the water moves
        self.flows = params.water.current != "still" and params.water.current_speed > 0
        drawn = params.boat.length * camera.scale
        self.enlarged = max(1.0, SMALLEST_BOAT * self.unit / drawn)  #: factor on drawn boats
        self.detailed = drawn > 1.6 * SMALLEST_BOAT * self.unit  #: whether boats have an edge
        self.vessel = complex_corners(params.vessel.corners)  #: corners (n,) in its own frame, m
        #: where most of the vessel is round a point, and the radius there, m
        self.middle, self.room = _roomiest(params)
        # Boats grow backwards, so that the bow of one that pushes stays outside the vessel.
        shift = (self.enlarged - 1) * params.boat.length / 2
        #: corners (n,) of a boat as it is drawn, in its own frame, m
        self.boat = self.enlarged * complex_corners(params.boat.corners) - shift

    def pixels(self, shape: Complex | Float, pose: Float) -> Float:
        """Returns the pixels (..., n, 2) of a shape (n,) of bodies with poses (..., >= 3)."""
        return self.camera.pixels(placed(shape, pose))


@by_identity
def _roomiest(params: EnvParams) -> tuple[complex, float]:
    x, y, room = roomiest(params.vessel.corners)
    return complex(x, y), room


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
    return xy(placed(complex_corners(hull.corners), pose))


def bow(shape: Complex, taper: float) -> Complex:
    """Returns the front ``taper`` m of a hull whose corners are ordered as ``boat_hull`` does."""
    shoulder, tip = shape[4], shape[3]
    corners = np.array([tip.real - taper + 1j * shoulder.imag, shoulder, tip])
    return np.concatenate([corners, corners[::-1].conj()])
