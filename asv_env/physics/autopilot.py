"""The autopilot of a boat: inner-loop controllers of forward speed and yaw rate.

Each is a proportional controller with the drag of the wanted motion fed forward. A policy that
commands a yaw rate proportional to its heading error closes the paper's PD loop on the heading
round it. The gains follow from the lag T of the thrusters: a proportional loop of bandwidth
1/(2 T) round a first-order lag is a second-order system with damping ratio 1/sqrt(2).

Demands are the mean thrust of both motors and half their difference, see ``thrusters.MIX``.
"""

import numpy as np

from asv_env.params import BoatParams
from asv_env.types import Float

FULL_SPEED = 0.2  #: forward speed of a full tracking action, m/s
FULL_YAW_RATE = 1.2  #: yaw rate of a full tracking action, rad/s
SCALE = np.array([FULL_SPEED, FULL_YAW_RATE])  #: motion of a full tracking action, m/s and rad/s
SCALE.setflags(write=False)


def bandwidth(boat: BoatParams) -> float:
    """Returns the bandwidth of the inner-loop controllers, 1/s."""
    return 1.0 / (2.0 * boat.lag)


class Autopilot:
    """The controllers of boats of one kind."""

    def __init__(self, boat: BoatParams) -> None:
        # Thrust of a motor per N of surge force and per N m of yaw moment.
        per_motor = np.array([0.5, 0.5 / boat.lever_arm])
        #: (2,) demand in N per m/s and per rad/s of error in forward speed and yaw rate
        self.gains = per_motor * bandwidth(boat) * np.array([boat.total_mass, boat.total_inertia])
        self._linear = per_motor * np.array([boat.surge[0], boat.yaw[0]])
        self._quadratic = per_motor * np.array([boat.surge[1], boat.yaw[1]])

    def demand_at_rest(self, action: Float) -> Float:
        """Returns the demand (..., 2), N, of a boat at rest for an action (..., 2) in [-1, 1].

        It is the drag of the wanted motion plus the gain times that motion. The demand of a
        moving boat is less by ``gains`` times its speed and yaw rate.
        """
        target = action * SCALE
        return (self.gains + self._linear + self._quadratic * np.abs(target)) * target
