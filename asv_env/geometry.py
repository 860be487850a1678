"""Planar geometry of vectors, poses and hulls; leading axes are free.

A planar vector is a complex number x + iy and a direction is e = exp(ih), so that turning a
vector into the frame of a body with heading h is a multiplication by conj(e).
"""

import math

import numpy as np
from numpy.typing import ArrayLike

from asv_env.compiled import compiled
from asv_env.types import Complex, Float

TURN = 2 * math.pi
SMALL = 0.1  #: largest angle whose cosine and sine come from short series, rad


@compiled
def wrapped(angle: float) -> float:
    """Returns an angle, rad, wrapped to (-pi, pi]; an angle in there stays as it is."""
    return angle - TURN * np.ceil((angle - math.pi) / TURN)


@compiled
def cos_sin(angle: float) -> tuple[float, float]:
    """Returns cosine and sine of an angle, rad.

    Those of a small angle, as a hull turns by in a step, come from series whose next terms are
    below the rounding error.
    """
    if abs(angle) > SMALL:
        return math.cos(angle), math.sin(angle)
    s = angle * angle
    cos = 1.0 - s * (1 / 2 - s * (1 / 24 - s * (1 / 720 - s * (1 / 40320))))
    sin = angle - angle * s * (1 / 6 - s * (1 / 120 - s * (1 / 5040 - s * (1 / 362880))))
    return cos, sin


def wrap(angle: ArrayLike) -> Float:
    """Returns angles (...) ``wrapped``."""
    array = np.asarray(angle, dtype=np.float64)
    return array - TURN * np.ceil((array - np.pi) / TURN)


def direction(heading: Float) -> Complex:
    """Returns the unit vectors (...,) of headings (...,), rad."""
    e = np.empty(heading.shape, dtype=np.complex128)
    np.cos(heading, out=e.real)
    np.sin(heading, out=e.imag)
    return e


def plane(array: Float, first: int = 0) -> Complex:
    """Returns a view of two neighbouring columns of a float array as complex numbers x + iy.

    Args:
        array: (..., n) with a contiguous last axis.
        first: column of x; y is the next.
    """
    pair: Complex = array[..., first : first + 2].view(np.complex128)[..., 0]
    return pair


def xy(points: Complex) -> Float:
    """Returns complex numbers x + iy (...) as x, y (..., 2): the inverse of ``plane``."""
    return np.stack([points.real, points.imag], axis=-1)


def mirrored(pose: Float, side: Float) -> Float:
    """Returns poses (W, 3) or motions (W, B, 6), mirrored at the x axis where ``side`` is -1."""
    signs = np.ones((len(side), pose.shape[-1]))
    signs[:, 1:3] = signs[:, 4:] = side[:, None]
    return pose * (signs if pose.ndim == 2 else signs[:, None])


def mirrored_rows(obstacle: Float, side: Float) -> Float:
    """Returns obstacles (W, M, 5), mirrored at the x axis where ``side`` (W,) is -1."""
    signs = np.ones((len(side), 1, 5))
    signs[:, 0, 1] = signs[:, 0, 3] = side
    return obstacle * signs


def rectangle(length: float, width: float) -> list[tuple[float, float]]:
    """Returns the corners of a rectangle round the origin, counter-clockwise, m."""
    x, y = length / 2, width / 2
    return [(-x, -y), (x, -y), (x, y), (-x, y)]


def boat_hull(length: float, width: float, bow: float) -> list[tuple[float, float]]:
    """Returns the corners of a convex boat hull that narrows to a flat bow towards +x, m.

    The shoulders lie one bow width behind the bow; the origin is amidships.
    """
    x, y, b = length / 2, width / 2, bow / 2
    return [(-x, -y), (x - bow, -y), (x, -b), (x, b), (x - bow, y), (-x, y)]
