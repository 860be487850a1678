"""The water: its current, and the drag on a hull that moves through it.

Per axis of the hull (surge, sway, yaw) the drag is (linear + quadratic |v|) v of the velocity
relative to the water. It is integrated so that it can never reverse a motion, whatever the
coefficients: with effective mass m and step dt the speed becomes

    v' = (s v + dt F / m) / (s + dt (linear + quadratic |v|) / m)

where F is the sum of all other forces. With s = 1 this is an implicit step; s = l / (exp(l) - 1),
l = dt linear / m, makes the decay of the speed exact for linear and quadratic drag together. The
terminal speed under a constant force is exact for any dt.
"""

import math
from typing import NamedTuple

import numpy as np

from asv_env.compiled import compiled
from asv_env.params import WaterParams
from asv_env.params.surroundings import CURRENTS
from asv_env.types import Complex

STILL, UNIFORM, GYRE, DOUBLE_GYRE = map(CURRENTS.index, ("still", "uniform", "gyre", "double_gyre"))


class Flow(NamedTuple):
    """A current as compiled code takes it."""

    kind: int  #: index in ``CURRENTS``
    x: float  #: velocity of a uniform current, m/s
    y: float
    peak: float  #: peak speed of the gyres, m/s
    wave_number: float  #: of the gyres, rad/m
    phase: float  #: of the gyres along x, rad


def flow(params: WaterParams) -> Flow:
    """Returns the current of these parameters."""
    speed, heading = params.current_speed, params.current_heading
    phase = params.gyre_phase + (0.0 if params.current == "double_gyre" else math.pi / 2)
    return Flow(
        CURRENTS.index(params.current),
        *(speed * math.cos(heading), speed * math.sin(heading)),
        *(speed, math.pi / params.gyre_size, phase),
    )


@compiled
def velocity(flow: Flow, x: float, y: float) -> tuple[float, float]:
    """Returns the velocity of the water at a point, m/s.

    The gyres are steady and free of divergence, with stream functions proportional to
    cos(pi x/s) cos(pi y/s) (one vortex round the origin) and sin(pi x/s) cos(pi y/s) (two
    vortices with a jet along +y through the origin between them), where s is the cell size. The
    peak speed is ``current_speed``.
    """
    if flow.kind == STILL:
        return 0.0, 0.0
    if flow.kind == UNIFORM:
        return flow.x, flow.y
    a, b = flow.wave_number * x + flow.phase, flow.wave_number * y
    return flow.peak * math.sin(a) * math.sin(b), flow.peak * math.cos(a) * math.cos(b)


@compiled
def _fill(flow: Flow, positions: Complex, velocities: Complex) -> None:
    for i in range(len(positions)):
        x, y = velocity(flow, positions[i].real, positions[i].imag)
        velocities[i] = complex(x, y)


def current(params: WaterParams, position: Complex) -> Complex:
    """Returns the velocity of the water (...,) at positions x + iy (...,), m/s."""
    velocities = np.zeros(position.shape, dtype=np.complex128)
    if params.current != "still":
        points = np.ascontiguousarray(position, dtype=np.complex128).reshape(-1)
        _fill(flow(params), points, velocities.reshape(-1))
    return velocities


@compiled
def softening(decay: float) -> float:
    """Returns s = l / (exp(l) - 1) of l = dt linear / m; 1 without linear drag."""
    if decay <= 0.0:
        return 1.0
    decay = min(decay, 700.0)  # exp overflows soon after
    return decay / math.expm1(decay)


@compiled
def damped(
    speed: float, force: float, dt_per_mass: float, linear: float, quadratic: float, soft: float
) -> float:
    """Returns a speed along one axis after a step under drag and all other forces.

    Args:
        speed: relative to the water, m/s or rad/s.
        force: sum of all other forces, N or N m.
        dt_per_mass: duration of the step over effective mass, s/kg, or inertia, s/(kg m^2).
        linear: linear drag coefficient.
        quadratic: quadratic drag coefficient.
        soft: ``softening(dt_per_mass * linear)``.
    """
    drag = dt_per_mass * (linear + quadratic * abs(speed))
    return (soft * speed + dt_per_mass * force) / (soft + drag)
