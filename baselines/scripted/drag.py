"""The drag of the water along one axis of a hull."""

from typing import TypeVar

from asv_env.types import Float

Velocity = TypeVar("Velocity", float, Float)


def drag(coefficients: tuple[float, float], velocity: Velocity) -> Velocity:
    """Returns the drag at velocities (...), from its linear and its quadratic coefficient."""
    linear, quadratic = coefficients
    return (linear + quadratic * abs(velocity)) * velocity
