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

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from asv_env.compiled import compiled
from asv_env.geometry import cos_sin
from asv_env.params import HullParams
from asv_env.physics.water import damped, softening
from asv_env.types import Float


class Hulls(NamedTuple):
    """How all hulls answer to forces and to the water, (W, B, 3) each: surge, sway, yaw.

    What a step divides by is divided by beforehand.
    """

    mass: Float  #: masses and inertia with what the water adds, kg, kg, kg m^2
    linear: Float  #: linear drag coefficients
    quadratic: Float  #: quadratic drag coefficients
    soft: Float  #: ``water.softening`` of half a step
    per_mass: Float  #: half a step over ``mass``
    coupling: Float  #: m_v / m_u, m_u / m_v and half a step times (m_u - m_v) / I


def hulls(num_worlds: int, bodies: int) -> Hulls:
    """Returns hulls of which ``equip`` makes those of the worlds."""
    return Hulls(*np.ones((len(Hulls._fields), num_worlds, bodies, 3)))


class Kinds(NamedTuple):
    """The hulls of the parameters, of which those of a world differ by factors."""

    mass: Float  #: (B, 3) effective masses and inertia
    contact_mass: Float  #: (B,) mass that Pymunk knows, kg
    drag: Float  #: (B, 3, 2) linear and quadratic coefficients


def kinds(hulls: Sequence[HullParams]) -> Kinds:
    """Returns these hulls as compiled code takes them."""
    return Kinds(
        mass=np.array([hull.masses for hull in hulls]),
        contact_mass=np.array([hull.contact_mass for hull in hulls]),
        drag=np.array([(hull.surge, hull.sway, hull.yaw) for hull in hulls]),
    )


@compiled
def equip(
    hulls: Hulls,
    world: int,
    kinds: Kinds,
    mass_gain: Float,
    drag_gain: Float,
    size: Float,
    dt: float,
) -> None:
    """Gives the hulls of a world their masses and drag.

    A hull of other lengths has masses that grow with the third power of them and an inertia that
    grows with the fifth; drag by its wetted area, and its moment by the fourth (linear) and the
    fifth power (quadratic).

    Args:
        hulls: all hulls, in place.
        world: number of the world.
        kinds: what they are without factors.
        mass_gain: (B,) factors on masses and inertia.
        drag_gain: (B,) factors on drag.
        size: (B,) factors on lengths.
        dt: duration of a step, s.
    """
    half = 0.5 * dt
    for body in range(len(mass_gain)):
        for axis in range(3):
            turning = axis == 2
            mass = kinds.mass[body, axis] * mass_gain[body] * size[body] ** (5 if turning else 3)
            linear = (
                kinds.drag[body, axis, 0] * drag_gain[body] * size[body] ** (4 if turning else 2)
            )
            quadratic = kinds.drag[body, axis, 1] * drag_gain[body]
            hulls.mass[world, body, axis] = mass
            hulls.linear[world, body, axis] = linear
            hulls.quadratic[world, body, axis] = quadratic * size[body] ** (5 if turning else 2)
            hulls.soft[world, body, axis] = softening(half * linear / mass)
            hulls.per_mass[world, body, axis] = half / mass
        mass_u, mass_v = hulls.mass[world, body, 0], hulls.mass[world, body, 1]
        inertia = hulls.mass[world, body, 2]
        hulls.coupling[world, body, 0] = mass_v / mass_u
        hulls.coupling[world, body, 1] = mass_u / mass_v
        hulls.coupling[world, body, 2] = half * (mass_u - mass_v) / inertia


@compiled
def coupled(
    u: float, v: float, r: float, hulls: Hulls, world: int, body: int, dt: float
) -> tuple[float, float, float, float, float]:
    """Returns the velocity after a step of ``dt`` s without force or drag.

    The momentum keeps its direction exactly; the Munk moment acts half before and half after.
    This conserves energy as long as the step is short. The other two numbers are cosine and sine
    of the turn in the step.
    """
    munk = hulls.coupling[world, body, 2]
    r += munk * u * v
    cos, sin = cos_sin(r * dt)
    u, v = (
        cos * u + sin * hulls.coupling[world, body, 0] * v,
        cos * v - sin * hulls.coupling[world, body, 1] * u,
    )
    r += munk * u * v
    return u, v, r, cos, sin


@compiled
def resisted_along(
    axis: int, speed: float, force: float, hulls: Hulls, world: int, body: int, shelter: float
) -> float:
    """Returns the speed along an axis after half a step under a force and drag."""
    return damped(
        speed,
        force,
        hulls.per_mass[world, body, axis],
        shelter * hulls.linear[world, body, axis],
        shelter * hulls.quadratic[world, body, axis],
        hulls.soft[world, body, axis],
    )


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
) -> tuple[float, float, float]:
    """Returns the velocity after half a step under a force and drag, each axis by itself."""
    return (
        resisted_along(0, u, force[0], hulls, world, body, shelter[0]),
        resisted_along(1, v, force[1], hulls, world, body, shelter[1]),
        resisted_along(2, r, force[2], hulls, world, body, 1.0),
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
) -> tuple[float, float, float, float, float]:
    """Returns the velocity of a hull after a step without contact.

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

    Returns:
        The velocity after it, and cosine and sine of the turn in it.
    """
    u, v, r = resisted(u, v, r, force, hulls, world, body, shelter)
    u, v, r, cos, sin = coupled(u, v, r, hulls, world, body, dt)
    u, v, r = resisted(u, v, r, force, hulls, world, body, shelter)
    return u, v, r, cos, sin
