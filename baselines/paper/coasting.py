"""The drag of the water along one axis of a hull, and how a hull that nobody pushes comes to rest.

With drag (Y + Yv |v|) v and mass m, a hull that moves sideways at a speed v comes to rest after
the distance m / Yv ln(1 + v Yv / Y).
"""

from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from asv_env.params import HullParams
from asv_env.types import Float

LARGEST_EXPONENT = 100.0  #: bound of the exponent, so that speeds are finite for any distance
Velocity = TypeVar("Velocity", float, Float)


def drag(coefficients: tuple[float, float], velocity: Velocity) -> Velocity:
    """Returns the drag at velocities (...), from its linear and its quadratic coefficient."""
    linear, quadratic = coefficients
    return (linear + quadratic * abs(velocity)) * velocity


def terminal_speed(coefficients: tuple[float, float], force: Float) -> Float:
    """Returns the velocities (...) at which the drag is as large as forces (...), N."""
    linear, quadratic = coefficients
    if quadratic == 0:
        return force / linear
    size = np.sqrt(linear**2 + 4 * quadratic * np.abs(force)) - linear
    return np.sign(force) * size / (2 * quadratic)


def coasting_speed(hull: HullParams, distance: ArrayLike) -> Float:
    """Returns the sideways speeds (...) m/s from which a hull coasts distances (...) m to rest."""
    return coasting_rate((*hull.sway, hull.masses[1]), np.asarray(distance, dtype=np.float64))


def coasting_rate(numbers: ArrayLike, distance: Float) -> Float:
    """Returns the rates (...) from which a motion along one axis coasts distances (...) to rest.

    Args:
        numbers: (3, ...) linear and quadratic drag coefficient, and mass; or those of a rotation.
        distance: m, or rad.
    """
    linear, quadratic, mass = np.asarray(numbers, dtype=np.float64)
    curved = np.where(quadratic > 0, quadratic, 1.0)
    exponent = np.minimum(distance * quadratic / mass, LARGEST_EXPONENT)
    bent = linear / curved * np.expm1(exponent)
    return np.where(quadratic > 0, bent, distance * linear / mass)


def coasting_time(hull: HullParams, speed: float, last: float) -> float:
    """Returns the time, s, in which a hull that moves sideways slows down between speeds, m/s."""
    linear, quadratic = hull.sway
    if last >= speed:
        return 0.0
    ratio = speed / last * (linear + quadratic * last) / (linear + quadratic * speed)
    return float(hull.masses[1] / linear * np.log(ratio))


def coasting_distance(hull: HullParams, speed: ArrayLike) -> Float:
    """Returns the distances (...) m that a hull coasts to rest from sideways speeds (...) m/s."""
    linear, quadratic = hull.sway
    speed = np.asarray(speed, dtype=np.float64)
    if quadratic == 0:
        return speed * hull.masses[1] / linear
    return hull.masses[1] / quadratic * np.log1p(speed * quadratic / linear)
