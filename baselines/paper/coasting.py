"""How a hull that nobody pushes comes to rest.

With drag (Y + Yv |v|) v and mass m a hull that moves sideways at a speed v comes to rest after
the way m / Yv ln(1 + v Yv / Y).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from asv_env.params import HullParams
from asv_env.types import Float

LARGEST_EXPONENT = 100.0
"""Bounds the speeds for ways of any length; they are beyond all reason long before."""


def coasting_speed(hull: HullParams, way: ArrayLike) -> Float:
    """Speed (...) m/s from which a hull that moves sideways comes to rest after ways (...) in m."""
    linear, quadratic = hull.sway
    way = np.asarray(way, dtype=np.float64)
    if quadratic == 0:
        return way * linear / hull.total_mass
    exponent = np.minimum(way * quadratic / hull.total_mass, LARGEST_EXPONENT)
    return linear / quadratic * np.expm1(exponent)


def way_to_rest(hull: HullParams, speed: ArrayLike) -> Float:
    """Inverse of ``coasting_speed``."""
    linear, quadratic = hull.sway
    speed = np.asarray(speed, dtype=np.float64)
    if quadratic == 0:
        return speed * hull.total_mass / linear
    return hull.total_mass / quadratic * np.log1p(speed * quadratic / linear)
