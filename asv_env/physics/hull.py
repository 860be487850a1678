"""The manoeuvring model of a hull in three degrees of freedom: surge, sway, yaw.

With the velocity relative to the water (u, v, r) in the hull's frame, effective masses
m_u = m + A11 and m_v = m + A22, and effective inertia I = I_z + A66 (Fossen, Handbook of Marine
Craft Hydrodynamics and Motion Control, 2nd ed., ch. 6; centre of gravity amidships):

    m_u u' = X + m_v v r - d_u(u) u
    m_v v' = Y - m_u u r - d_v(v) v
    I   r' = N + (m_u - m_v) u v - d_r(r) r

The term with u v is the Munk moment. The terms with r say that the momentum (m_u u, m_v v) keeps
its direction over ground while the hull turns under it.
"""

import math
from typing import NamedTuple

from asv_env.compiled import compiled
from asv_env.physics.water import damped
from asv_env.types import Float


class Hulls(NamedTuple):
    """Effective masses and drag of all hulls, each (W, B, 3): surge, sway, yaw."""

    mass: Float  #: masses and inertia with what the water adds, kg, kg, kg m^2
    linear: Float  #: linear drag coefficients
    quadratic: Float  #: quadratic drag coefficients
    soft: Float  #: ``water.softening`` of half a step


@compiled
def munk_moment(u: float, v: float, mass_u: float, mass_v: float) -> float:
    """Returns the moment of the water on a hull that moves obliquely, N m."""
    return (mass_u - mass_v) * u * v


@compiled
def coupled(
    u: float, v: float, r: float, mass: Float, dt: float
) -> tuple[float, float, float, float]:
    """Returns the velocity after a step of ``dt`` s without force or drag, and the turn in it, rad.

    The momentum keeps its direction exactly; the Munk moment acts half before and half after.
    This conserves energy as long as the step is short.
    """
    mass_u, mass_v, inertia = mass[0], mass[1], mass[2]
    r += 0.5 * dt * munk_moment(u, v, mass_u, mass_v) / inertia
    turn = r * dt
    cos, sin = math.cos(turn), math.sin(turn)
    p, q = mass_u * u, mass_v * v
    u, v = (cos * p + sin * q) / mass_u, (cos * q - sin * p) / mass_v
    r += 0.5 * dt * munk_moment(u, v, mass_u, mass_v) / inertia
    return u, v, r, turn


@compiled
def resisted(
    u: float,
    v: float,
    r: float,
    force: tuple[float, float, float],
    hulls: Hulls,
    world: int,
    body: int,
    shelter: tuple[float, float],
    dt: float,
) -> tuple[float, float, float]:
    """Returns the velocity after half a step under a force and drag, each axis by itself."""
    mass, soft = hulls.mass[world, body], hulls.soft[world, body]
    linear, quadratic = hulls.linear[world, body], hulls.quadratic[world, body]
    a, b = shelter
    return (
        damped(u, force[0], dt / mass[0], a * linear[0], a * quadratic[0], soft[0]),
        damped(v, force[1], dt / mass[1], b * linear[1], b * quadratic[1], soft[1]),
        damped(r, force[2], dt / mass[2], linear[2], quadratic[2], soft[2]),
    )


@compiled
def advanced(
    u: float,
    v: float,
    r: float,
    force: tuple[float, float, float],
    hulls: Hulls,
    world: int,
    body: int,
    shelter: tuple[float, float],
    dt: float,
) -> tuple[float, float, float, float]:
    """Returns the velocity of a hull after a step without contact, and the turn in it, rad.

    Drag, the coupling of the axes, and drag again act for half a step, a step and half a step
    (Strang's splitting).

    Args:
        u: surge speed relative to the water, m/s.
        v: sway speed relative to the water, m/s.
        r: yaw rate, rad/s.
        force: surge N, sway N, yaw N m of all but the water.
        hulls: masses and drag.
        world: row of the world in ``hulls``.
        body: row of the hull in ``hulls``.
        shelter: factors on the drag in surge and in sway.
        dt: duration of the step, s.
    """
    half = 0.5 * dt
    u, v, r = resisted(u, v, r, force, hulls, world, body, shelter, half)
    u, v, r, turn = coupled(u, v, r, hulls.mass[world, body], dt)
    u, v, r = resisted(u, v, r, force, hulls, world, body, shelter, half)
    return u, v, r, turn
