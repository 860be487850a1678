"""The forces of the water on a hull: drag of the motion relative to the current.

Per axis of the hull (surge, sway, yaw) the drag is (linear + quadratic |v|) v. It is integrated
so that it can never reverse a motion, whatever the coefficients: with effective mass m and step
dt the speed becomes

    v' = (s v + dt F / m) / (s + dt (linear + quadratic |v|) / m)

where F is the sum of all other forces. With s = 1 this is an implicit step; s = l / (exp(l) - 1),
l = dt linear / m, makes the decay of the speed exact for linear and quadratic drag together. The
terminal speed under a constant force is exact for any dt.
"""

from collections.abc import Sequence

import numpy as np

from asv_env.params import HullParams, WaterParams
from asv_env.types import Complex, Float


def coefficients(hulls: Sequence[HullParams]) -> tuple[Float, Float]:
    """Returns the linear and quadratic drag coefficients, each (B, 3), of hulls (B,)."""
    table = np.array([(hull.surge, hull.sway, hull.yaw) for hull in hulls], dtype=np.float64)
    return table[..., 0], table[..., 1]


def softening(linear: Float, dt_per_mass: Float) -> Float:
    """Returns s = l / (exp(l) - 1) with l = linear * dt_per_mass; 1 without linear drag."""
    decay = np.minimum(linear * dt_per_mass, 700.0)  # exp overflows soon after
    return np.where(decay > 0, decay / np.where(decay > 0, np.expm1(decay), 1.0), 1.0)


def damped(
    wrench: Float,
    velocity: Float,
    linear: Float,
    quadratic: Float,
    dt_per_mass: Float,
    softening: Float,
    out: Float | None = None,
) -> Float:
    """Returns the total wrench whose explicit step has the effect of ``wrench`` and drag.

    Args:
        wrench: (..., 3) surge N, sway N, yaw N m of all other forces.
        velocity: (..., 3) surge m/s, sway m/s, yaw rate rad/s relative to the water.
        linear: (..., 3) linear drag coefficients.
        quadratic: (..., 3) quadratic drag coefficients.
        dt_per_mass: (..., 3) physics step over effective mass, mass and inertia.
        softening: (..., 3) result of the function of that name.
        out: (..., 3) receives the result, if given.
    """
    coefficient = np.abs(velocity)
    coefficient *= quadratic
    coefficient += linear
    total = np.multiply(coefficient, velocity, out=out)
    np.subtract(wrench, total, out=total)
    coefficient *= dt_per_mass
    coefficient += softening
    total /= coefficient
    return total


def current(params: WaterParams, position: Complex) -> Complex:
    """Returns the velocity of the water (...,) at positions x + iy (...,), m/s.

    The gyres are steady and free of divergence, with stream functions proportional to
    cos(pi x/s) cos(pi y/s) (one vortex round the origin) and sin(pi x/s) cos(pi y/s) (two
    vortices with a jet along +y through the origin between them), where s is the cell size. The
    peak speed is ``current_speed``.
    """
    flow = np.zeros(position.shape, dtype=np.complex128)
    if params.current == "uniform":
        flow += params.current_speed * np.exp(1j * params.current_heading)
    elif params.current != "still":
        k = np.pi / params.gyre_size
        shift = 0.0 if params.current == "double_gyre" else np.pi / 2
        x, y = k * position.real + shift, k * position.imag
        flow.real = params.current_speed * np.sin(x) * np.sin(y)
        flow.imag = params.current_speed * np.cos(x) * np.cos(y)
    return flow
