"""How to push a vessel along a path: linear-quadratic control that looks ahead.

A vessel that turns skids outwards, and it takes up a new yaw rate only within seconds. So it is
steered by what is to come: the force along the hull and the moment that keep it on the path at
the least cost, given all of the path's curvature within some seconds ahead. With x = (offset,
heading error, sideways velocity, yaw rate), speed v and curvature k(t) of the path ahead,

    x' = A x + B u - (0, v k(t), 0, 0),

the cost-minimal u is - K x - integral of G(tau) k(tau), with K from the Riccati equation and
G(tau) = - R^-1 B' exp((A - B K)' tau) P (0, v, 0, 0).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm, solve_continuous_are

from asv_env.params import NOMINAL_LENGTH, VesselParams
from asv_env.types import Float

STEP = 0.25
"""Between two looks at the path ahead of a vessel of 0.40 m, s."""
LOOKS = 24
SPEEDS = np.array([0.003, 0.005, 0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.08, 0.1])
"""Speeds of the vessel for which gains are computed, m/s; between them they are interpolated."""
SLIP = 0.01
"""Sideways velocity, m/s, and
``YAW_RATE``, rad/s, at which the drag is linearised."""
YAW_RATE = 0.1


@dataclass(frozen=True)
class Tolerances:
    """Deviations and efforts that cost the same.

    Attributes:
        offset: from the path, m.
        turn: heading error, rad.
        force: along the hull, N; 0 where no boat can exert one.
        moment: N m, for a vessel of 0.40 m.
    """

    offset: float = 0.04
    turn: float = 0.035
    force: float = 3.9e-3
    moment: float = 3e-4


class PreviewSteering:
    """Gains over the vessel's speed.

    Args:
        vessel: as it is in the water.
        tolerances: what the cost is made of.

    Raises:
        ValueError: nothing hinders the vessel from sliding along its length.
    """

    def __init__(self, vessel: VesselParams, tolerances: Tolerances) -> None:
        if max(vessel.surge) <= 0:
            raise ValueError(
                f"vessel.surge = {vessel.surge} without fins: the scripted policy cannot hold a "
                "vessel that slides freely along its length; give some drag"
            )
        scale = vessel.length / NOMINAL_LENGTH
        state_cost = np.diag([tolerances.offset**-2, tolerances.turn**-2, 0.0, 0.0])
        efforts = np.array([tolerances.force or 1.0, scale**2 * tolerances.moment])
        control_cost = np.diag(efforts**-2)
        control = np.zeros((4, 2))
        control[2, 0] = (tolerances.force > 0) / vessel.total_mass
        control[3, 1] = 1.0 / vessel.total_inertia
        step = scale * STEP
        self.ahead: Float = step * (np.arange(LOOKS) + 0.5)
        """(LOOKS,) s, where the path is looked at."""
        self._feedback = np.zeros((len(SPEEDS), 2, 4))
        self._preview = np.zeros((len(SPEEDS), 2, LOOKS))
        for i, speed in enumerate(SPEEDS):
            dynamics = _dynamics(vessel, speed)
            cost = solve_continuous_are(dynamics, control, state_cost, control_cost)
            weighted = np.linalg.solve(control_cost, control.T)
            self._feedback[i] = weighted @ cost
            closed = (dynamics - control @ self._feedback[i]).T
            turning = cost @ np.array([0.0, -speed, 0.0, 0.0])
            looks = [weighted @ expm(closed * time) @ turning for time in self.ahead]
            self._preview[i] = step * np.stack(looks, axis=-1)

    def wrench(self, speed: Float, deviation: Float, curvature: Float) -> Float:
        """Force along the hull, N, and moment, N m, for the vessel.

        Args:
            speed: (W,) of the vessel, m/s.
            deviation: (W, 4) offset from the path along the hull, m; heading error, rad;
                sideways velocity along the hull, m/s; yaw rate, rad/s.
            curvature: (W, LOOKS) of the path where the vessel will be at times ``ahead``, 1/m.

        Returns:
            (W, 2).
        """
        place = np.interp(speed, SPEEDS, np.arange(len(SPEEDS)))
        low = np.minimum(place.astype(np.int64), len(SPEEDS) - 2)
        part = (place - low)[:, None, None]
        feedback = self._feedback[low] * (1 - part) + self._feedback[low + 1] * part
        preview = self._preview[low] * (1 - part) + self._preview[low + 1] * part
        wrench: Float = -(feedback @ deviation[..., None] + preview @ curvature[..., None])[..., 0]
        return wrench


def _dynamics(vessel: VesselParams, speed: float) -> Float:
    """A (4, 4) of a vessel that moves at a speed (m/s), linearised about the path."""
    linear = vessel.linearised(SLIP, YAW_RATE)
    along, yaw = linear.surge[0] / vessel.total_mass, linear.yaw[0] / vessel.total_inertia
    return np.array(
        [
            [0.0, speed, 1.0, 0.0],
            [0.0, 0.0, 0.0, 1.0],
            [0.0, 0.0, -along, -speed],
            [0.0, 0.0, 0.0, -yaw],
        ]
    )
