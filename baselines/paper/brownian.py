"""The approach as a swarm of Brownian agents in polar coordinates: Eq (8).

The printed equation lacks dt, and its claim of constant speed is false: S is the sum of the radial
and the tangential speed, not their Euclidean norm, which falls to S / sqrt(2) in between. With
`unit_speed` both rates are divided by that norm. Either way the orbit is
r ~ (1 - exp(-theta / sigma))^sigma, the spiral of Eq (4) only for sigma = 1.

Arguments are arrays (...) that broadcast: ``r`` m > 0 and ``alpha`` rad, distance and direction
from the target; ``speed`` m/s; ``sigma`` rad > 0; ``turn_direction`` D, 0 clockwise or 1
counter-clockwise. A number out of range or not finite raises ValueError.
"""

import numpy as np
from numpy.typing import ArrayLike

from asv_env.types import Float
from baselines.paper.braitenberg import turn_direction as shorter_turn
from baselines.paper.inputs import finite, not_negative, positive, turn_directions
from baselines.paper.spiral import angular_distance


def drift(
    r: ArrayLike,
    alpha: ArrayLike,
    turn_direction: ArrayLike,
    speed: ArrayLike,
    sigma: ArrayLike,
    unit_speed: bool = False,
) -> tuple[Float, Float]:
    """Rates dr/dt (...) m/s and dalpha/dt (...) rad/s without noise (Eq 8)."""
    exponent = -angular_distance(alpha, np.pi / 2) / positive("sigma", sigma)
    inwards, around = np.exp(exponent), -np.expm1(exponent)
    pace = finite("speed", speed) / (np.hypot(inwards, around) if unit_speed else 1.0)
    sign = 2 * turn_directions("turn_direction", turn_direction) - 1
    rates = np.broadcast_arrays(-pace * inwards, sign * pace * around / positive("r", r))
    dr, dalpha = np.stack(rates)
    return dr, dalpha


def simulate(
    r0: ArrayLike,
    alpha0: ArrayLike,
    speed: ArrayLike,
    sigma: ArrayLike,
    *,
    duration: float,
    dt: float,
    rng: np.random.Generator,
    noise_r: float = 0.0,
    noise_alpha: float = 0.0,
    stop_radius: float = 0.01,
    unit_speed: bool = False,
) -> tuple[Float, Float, Float]:
    """Follows a swarm by the Euler-Maruyama scheme, with white noise on either or both variables.

    An agent within stop_radius has arrived and stays. The turn direction D is that of the shorter
    path to pi/2 from the start; above the target it is determined again at each step, as an agent
    that noise carries across pi/2 would otherwise be led once round. ``noise_r``, m / sqrt(s), and
    ``noise_alpha``, rad / sqrt(s), are the standard deviations after 1 s of noise alone;
    ``duration`` is at least ``dt``, s.

    Returns:
        Times (T,) s, and r (T, ...) m and alpha (T, ...) rad at them, the start included.
    """
    positive("stop_radius", stop_radius)
    if not finite("duration", duration) >= positive("dt", dt):
        raise ValueError(f"duration must be at least dt = {dt}, got {duration}")
    spread_r = not_negative("noise_r", noise_r) * np.sqrt(dt)
    spread_alpha = not_negative("noise_alpha", noise_alpha) * np.sqrt(dt)
    r, alpha = positive("r0", r0), finite("alpha0", alpha0)
    r, alpha, _, _ = np.broadcast_arrays(r, alpha, speed, sigma)
    latched = shorter_turn(np.cos(alpha), 0.0)
    history = [(r, alpha)]
    for _ in range(round(duration / dt)):
        turn = np.where(np.sin(alpha) > 0, shorter_turn(np.cos(alpha), 0.0), latched)
        bounded = np.maximum(r, stop_radius)
        dr, dalpha = drift(bounded, alpha, turn, speed, sigma, unit_speed)
        step_r = dr * dt + spread_r * rng.standard_normal(r.shape)
        step_alpha = dalpha * dt + spread_alpha * rng.standard_normal(r.shape)
        moving = r > stop_radius
        r = np.where(moving, np.maximum(r + step_r, 0.0), r)
        alpha = np.where(moving, alpha + step_alpha, alpha)
        history.append((r, alpha))
    r, alpha = (np.stack(values) for values in zip(*history, strict=True))
    return np.multiply(dt, np.arange(len(r)), dtype=np.float64), r, alpha
