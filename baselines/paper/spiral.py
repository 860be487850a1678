"""The spiral onto a target: Eqs (2) and (4)-(7).

theta is the angular distance of the boat, as seen from the target, from the direction pi/2 in
which the boats stand off; the spiral is r(theta) = r_pi (1 - exp(-theta / sigma)) (Eq 4).

Arguments are arrays (...) that broadcast: ``alpha`` rad, the direction in which the target sees the
boat, arctan2(y - Ty, x - Tx); ``sigma`` rad > 0, the decay of the offset; ``r0`` m >= 0, the
distance from the target; ``theta0`` rad >= 0. A number out of range or not finite raises
ValueError.
"""

import numpy as np
from numpy.typing import ArrayLike

from asv_env.types import Float
from baselines.paper.inputs import finite, not_negative, numbers, positive

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(40)
# Beyond them sigma^2 leaves the floating-point range; the length has long reached its limits.
_SIGMA_RANGE = 1e-150, 1e150


def angular_distance(a: ArrayLike, b: ArrayLike) -> Float:
    """Smaller angle between two directions (the paper's arcmin); rad in [0, pi]."""
    a, b = finite("a", a), finite("b", b)
    return np.minimum(np.mod(a - b, 2 * np.pi), np.mod(b - a, 2 * np.pi))


def bearing_offset(alpha: ArrayLike, sigma: ArrayLike) -> Float:
    """Angle phi (...) rad between heading and target during the approach, in [0, pi/2) (Eq 2).

    The target lies phi to the right of the heading when circling clockwise, to the left when
    counter-clockwise. The orbit of Eqs (2)-(3) is near the spiral of Eq (4), not equal to it.
    """
    theta = angular_distance(alpha, np.pi / 2)
    return np.multiply(-np.pi / 2, np.expm1(-theta / positive("sigma", sigma)))


def exact_bearing_offset(alpha: ArrayLike, sigma: ArrayLike) -> Float:
    """Angle phi* whose orbit is exactly the spiral of Eq (4): tan phi* = r / (dr/dtheta).

    Not in the paper. It makes the length of Eq (6), and so the speed of Eq (7), exact.
    """
    decay = -angular_distance(alpha, np.pi / 2) / positive("sigma", sigma)
    return np.arctan2(-np.asarray(sigma) * np.expm1(decay), np.exp(decay))


def asymptotic_radius(r0: ArrayLike, theta0: ArrayLike, sigma: ArrayLike) -> Float:
    """Radius r_pi (...) m of the spiral through (r0, theta0) (Eq 5): its limit for large theta.

    It is inf at theta0 = 0 (a straight), 0 at r0 = 0.
    """
    r0, theta0 = not_negative("r0", r0), not_negative("theta0", theta0)
    fraction = -np.expm1(-theta0 / positive("sigma", sigma))
    straight = np.where(r0 > 0, np.inf, 0.0)
    return np.where(fraction > 0, r0 / np.where(fraction > 0, fraction, 1.0), straight)[()]


def arc_length(r0: ArrayLike, theta0: ArrayLike, sigma: ArrayLike) -> Float:
    """Length (...) m of the spiral from (r0, theta0) to the target (Eq 6, in a stable form).

    At theta0 = 0 it is the straight line, r0. The printed form is right, but overflows for
    theta0 / sigma above 355 and loses all digits for small theta0 or large sigma. Here nothing
    grows, and where the terms still cancel the integral of Eq (4) is evaluated by quadrature;
    relative error below 1e-12 throughout.
    """
    r0, theta0 = not_negative("r0", r0), not_negative("theta0", theta0)
    sigma = np.clip(positive("sigma", sigma), *_SIGMA_RANGE)
    theta0, sigma = np.broadcast_arrays(theta0, sigma)
    cancelling = (-np.expm1(-theta0 / sigma) < 1e-2) | (sigma > 5)
    relative = _closed_form(np.where(cancelling, 1.0, theta0), np.where(cancelling, 1.0, sigma))
    if cancelling.any():
        relative = np.array(relative)
        relative[cancelling] = _quadrature(theta0[cancelling], sigma[cancelling])
    return r0 * relative


def approach_speed(
    length: ArrayLike,
    time_left: ArrayLike,
    stop_radius: ArrayLike = 0.0,
    max_speed: ArrayLike = np.inf,
    min_speed: ArrayLike = 0.0,
    min_time: ArrayLike = 0.5,
) -> Float:
    """Speed (...) m/s that ends a path on time (Eq 7), also when asked again and again along it.

    Eq (7) is length / time; with ``stop_radius``, m, the path ends that much earlier. Asked online,
    the quotient is singular at the end: hence bounds of the speed, of which the largest may be
    infinite, and a floor of the time that is left, ``min_time``, s: a control period or more.
    Within the stop radius the speed is the smallest one.
    """
    slowest, fastest = not_negative("min_speed", min_speed), numbers("max_speed", max_speed)
    if not np.all(slowest <= fastest):
        raise ValueError(f"min_speed {min_speed!r} exceeds max_speed {max_speed!r}: lower it")
    distance = not_negative("length", length) - not_negative("stop_radius", stop_radius)
    time = np.maximum(finite("time_left", time_left), positive("min_time", min_time))
    return np.minimum(np.maximum(distance / time, slowest), fastest)


def _closed_form(theta0: Float, s: Float) -> Float:
    """Eq (6) for r0 = 1, with exp(-theta0/s) in place of exp(theta0/s)."""
    e, u, c = np.exp(-theta0 / s), -np.expm1(-theta0 / s), 1 + s**2
    root, q = np.sqrt(c), np.hypot(e, s * u)
    g = (2 * u - c * u**2) / (1 + q)
    # Two forms of one logarithm: the first keeps its digits for small e, the second for large.
    small = s**2 > c * e
    first = s**2 / ((1 + root) * np.where(small, root * q + s**2 - c * e, 1.0))
    second = np.where(small, 0.0, -(c * u + root * g) / (1 + root))
    logarithm = np.where(small, np.log(np.where(small, first, 1.0)), np.log1p(second))
    # u s + q = 1 + u s - g is near 0 for small s, near 1 for small theta0.
    excess = s * u - g
    inner = np.where(excess < -0.5, np.log(s * u + q), np.log1p(np.maximum(excess, -0.5)))
    return np.divide(g + theta0 + s * inner + s**2 / root * logarithm, u)


def _quadrature(theta0: Float, s: Float) -> Float:
    """Eq (6) for r0 = 1 as the integral of sqrt(r^2 + r'^2) by 40-point Gauss-Legendre."""
    theta0, s = theta0[..., None], s[..., None]
    u = -np.expm1(-theta0 / s)
    scale = np.where(u > 0, theta0 / np.where(u > 0, u, 1.0), s)
    decay = -theta0 * (_NODES + 1) / 2 / s
    speed = np.hypot(scale * np.expm1(decay), scale / s * np.exp(decay))
    return np.matmul(speed, _WEIGHTS / 2)
