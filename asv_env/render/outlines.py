"""Outlines of hulls, in their own frame and in the world."""

from collections.abc import Sequence

import numpy as np

from asv_env.geometry import xy
from asv_env.params import HullParams
from asv_env.types import Complex, Float


def placed(shape: Complex | Float, pose: Float) -> Complex:
    """Returns the points (..., n) in the world of points (n,) of bodies with poses (..., >= 3)."""
    turn = np.exp(1j * pose[..., 2])
    return (pose[..., 0] + 1j * pose[..., 1])[..., None] + shape * turn[..., None]


def outline(hull: HullParams, pose: Float) -> Float:
    """Returns the corners (..., n, 2) of hulls at poses (..., 3), m."""
    return xy(placed(vertices(hull.outline), pose))


def vertices(corners: Sequence[tuple[float, float]]) -> Complex:
    """Returns corners (n,) as complex numbers x + iy."""
    array = np.array(corners)
    return array[:, 0] + 1j * array[:, 1]


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
