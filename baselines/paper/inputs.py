"""Checks of arrays that a caller hands in: errors name the value and the remedy."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asv_env.types import Bool, Float


def numbers(name: str, value: ArrayLike) -> Float:
    """Returns `value` as float64 array, NaN and infinity included; TypeError if it is none."""
    try:
        return np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise TypeError(f"{name} must be real numbers in a regular array: {error}") from error


def finite(name: str, value: ArrayLike) -> Float:
    """Returns `value` as float64 array; ValueError if an element is NaN or infinite."""
    array = numbers(name, value)
    _require(array, np.isfinite(array), name, "must be finite", "replace NaN and infinity")
    return array


def positive(name: str, value: ArrayLike) -> Float:
    """Returns `value` as float64 array; ValueError unless every element is finite and > 0."""
    array = finite(name, value)
    _require(array, array > 0, name, "must be positive", "use a value above 0")
    return array


def not_negative(name: str, value: ArrayLike) -> Float:
    """Returns `value` as float64 array; ValueError unless every element is finite and >= 0."""
    array = finite(name, value)
    _require(array, array >= 0, name, "must not be negative", "use 0 or a value above it")
    return array


def turn_directions(name: str, value: ArrayLike) -> NDArray[np.int_]:
    """Returns turn directions D as integers; ValueError unless each is 0 or 1."""
    array = numbers(name, value)
    rule = "must be 0 (clockwise) or 1 (counter-clockwise)"
    _require(array, (array == 0) | (array == 1), name, rule, "see turn_direction")
    return array.astype(np.int_)


def finite_points(name: str, value: ArrayLike) -> Float:
    """Returns `value` as finite points (..., 2): x, y in m."""
    return _rows(name, finite(name, value), "x, y")


def finite_poses(name: str, value: ArrayLike) -> Float:
    """Returns `value` as finite poses (..., 3): x, y in m, heading in rad."""
    return _rows(name, finite(name, value), "x, y, heading")


def _require(array: Float, good: Bool, name: str, rule: str, remedy: str) -> None:
    """Raises ValueError with the rule, the first bad element and the remedy, if one is bad."""
    if not good.all():
        raise ValueError(f"{name} {rule}, got {array[~good][0]}: {remedy}")


def _rows(name: str, array: Float, columns: str) -> Float:
    size = columns.count(",") + 1
    if array.shape[-1:] != (size,):
        raise ValueError(f"{name} must have shape (..., {size}) as {columns}, got {array.shape}")
    return array
