"""The steering law round a target, Eqs (1) and (3).

Arguments are arrays (...) that broadcast: ``alpha`` rad, the direction in which the target sees the
boat, arctan2(y - Ty, x - Tx); ``turn_direction`` D, 0 clockwise or 1 counter-clockwise; ``phi``
rad, the angle between the heading and the target. A number that is not finite, or another D,
raises ValueError.

Corrections to the printed Eq (3): its phase + D pi - (2 D - 1) phi sends the boats of one turn
direction D away from the target whatever the sign of beta. The phase is (2 D - 1) phi, beta > 0,
and arctan means arctan2. The printed rule keeps D for ever, so that a boat that crosses above its
target is led once round the vessel; see `updated_turn_direction`.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asv_env.types import Float
from baselines.paper.inputs import finite, finite_points, positive, turn_directions


def turn_direction(x: ArrayLike, target_x: ArrayLike) -> NDArray[np.int_]:
    """Turn direction D (...) with the shorter path to the side above the target, 1 on its right."""
    return np.where(finite("x", x) >= finite("target_x", target_x), 1, 0)


def updated_turn_direction(
    position: ArrayLike, target: ArrayLike, latched: ArrayLike
) -> NDArray[np.int_]:
    """Turn direction D (...), determined again above the target and `latched` (...) below it.

    Not in the paper. The heading stays continuous, as the offset phi is 0 where D changes.
    Position and target are (..., 2) m.
    """
    position, target = finite_points("position", position), finite_points("target", target)
    above = position[..., 1] > target[..., 1]
    latched = turn_directions("latched", latched)
    return np.where(above, turn_direction(position[..., 0], target[..., 0]), latched)


def desired_heading(alpha: ArrayLike, turn_direction: ArrayLike, phi: ArrayLike) -> Float:
    """Heading (...) rad that the law steers to: alpha + pi - (2 D - 1) phi, not wrapped."""
    sign = 2 * turn_directions("turn_direction", turn_direction) - 1
    return finite("alpha", alpha) + np.pi - sign * finite("phi", phi)


def wheel_speeds(
    heading: ArrayLike,
    alpha: ArrayLike,
    turn_direction: ArrayLike,
    phi: ArrayLike,
    speed: ArrayLike,
    beta: ArrayLike,
) -> tuple[Float, Float]:
    """Left and right wheel speeds (...) m/s of Eq (3), corrected; D = 0 gives Eq (1), for any phi.

    The turn rate (right - left) / log is -K sin(heading - desired heading), K = 2 beta / log, where
    ``speed`` is S_1, m/s, and ``beta`` > 0 a gain, m/s. Stable for K dt < 1 with the one-step delay
    of the printed law; no wheel reverses if beta <= S_1.
    """
    error = finite("heading", heading) - desired_heading(alpha, turn_direction, phi)
    difference = positive("beta", beta) * np.sin(error)
    speed = finite("speed", speed)
    return speed + difference, speed - difference
