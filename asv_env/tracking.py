"""The loops on board: they make a boat follow a forward speed and a yaw rate.

Each is a proportional loop with the drag of the wanted motion fed forward. A policy that asks
for a yaw rate proportional to its heading error closes the paper's PD loop on the heading
round it. The gains follow from the lag T of the thrusters: a proportional loop of bandwidth
1/(2 T) round a first-order lag is a second-order system with damping ratio 1/sqrt(2).

Demands are given as what both motors share and what they differ by, see ``thrusters``.
"""

from __future__ import annotations

import numpy as np

from asv_env.params import BoatParams
from asv_env.types import Float

FULL_SPEED = 0.2
"""Forward speed of a full tracking action, m/s."""
FULL_YAW_RATE = 1.2
"""Yaw rate of a full tracking action, rad/s."""
SCALE = np.array([FULL_SPEED, FULL_YAW_RATE])


def per_motor(boat: BoatParams) -> Float:
    """Motor thrust (2,) per N of surge force and per N m of yaw moment."""
    return np.array([0.5, 0.5 / boat.lever_arm])


def gains(boat: BoatParams) -> Float:
    """Proportional gains (2,): demand in N per m/s and per rad/s of error."""
    bandwidth = 1.0 / (2.0 * boat.lag)
    return per_motor(boat) * bandwidth * np.array([boat.total_mass, boat.total_inertia])


def feedforward(target: Float, boat: BoatParams) -> Float:
    """Demand (..., 2), N, that balances the drag at the wanted motion.

    Args:
        target: (..., 2) forward speed m/s and yaw rate rad/s.
        boat: with the drag coefficients to be balanced.
    """
    linear = np.array([boat.surge[0], boat.yaw[0]])
    quadratic = np.array([boat.surge[1], boat.yaw[1]])
    return per_motor(boat) * (linear + quadratic * np.abs(target)) * target
