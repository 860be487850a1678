"""Linear-quadratic control of a vessel on a path, with preview of the path's curvature.

A vessel that turns skids outwards, and it takes up a new yaw rate only within seconds. So it is
steered by what is to come: the force along the hull and the moment that keep it on the path at
the least cost, given the path's curvature over the next seconds. With x = (cross-track error,
heading error, velocity along the hull, yaw rate), u = (force along the hull, moment), speed v and
curvature k(t) of the path ahead,

    x' = A x + B u - (0, v k(t), 0, 0),

the cost-minimal u is - K x - integral of G(tau) k(tau), with K = R^-1 B' P, P from the Riccati
equation, and G(tau) = - R^-1 B' exp((A - B K)' tau) P (0, v, 0, 0).
"""

import numpy as np
from scipy.linalg import expm, solve_continuous_are

from asv_env.params import NOMINAL_LENGTH, VesselParams
from asv_env.types import Float
from baselines.scripted.gains import Tolerances

PREVIEW_STEP = 0.25  #: time between two preview points of a vessel of 0.40 m, s
PREVIEW_POINTS = 24  #: number of points at which the curvature of the path ahead is taken
SPEEDS = np.array([0.003, 0.005, 0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.08, 0.1])
"""Speeds of the vessel for which gains are computed, m/s; between them they are interpolated."""
SLIP = 0.01  #: velocity along the hull at which the surge drag is linearised, m/s
YAW_RATE = 0.1  #: yaw rate at which the yaw drag is linearised, rad/s


class PreviewLqr:
    """Feedback and preview gains, scheduled over the vessel's speed.

    Raises:
        ValueError: the vessel has no surge drag, so that it slides freely along its length.
    """

    def __init__(self, vessel: VesselParams, tolerances: Tolerances) -> None:
        if max(vessel.surge) <= 0:
            raise ValueError(
                f"vessel.surge = {vessel.surge} without fins: the scripted policy cannot hold a "
                "vessel that slides freely along its length; give some drag"
            )
        scale = vessel.size / NOMINAL_LENGTH
        state_cost = np.diag([tolerances.cross_track**-2, tolerances.heading**-2, 0.0, 0.0])
        efforts = np.array([tolerances.force or 1.0, scale**2 * tolerances.moment])
        control_cost = np.diag(efforts**-2)
        control = np.zeros((4, 2))
        control[2, 0] = (tolerances.force > 0) / vessel.masses[0]
        control[3, 1] = 1.0 / vessel.total_inertia
        step = scale * PREVIEW_STEP
        self.preview_times: Float = step * (np.arange(PREVIEW_POINTS) + 0.5)  # from now, s
        self._feedback = np.zeros((len(SPEEDS), 2, 4))
        self._preview = np.zeros((len(SPEEDS), 2, PREVIEW_POINTS))
        weighted = np.linalg.solve(control_cost, control.T)
        hull = vessel.linearised(SLIP, YAW_RATE)
        (m_surge, m_sway, inertia), munk = vessel.masses, vessel.masses[0] - vessel.masses[1]
        surge, yaw = hull.surge[0] / m_surge, hull.yaw[0] / inertia
        for i, speed in enumerate(SPEEDS):
            position = [0.0, speed, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]
            skid, turn = -m_sway / m_surge * speed, -munk * speed / inertia
            velocity = [0.0, 0.0, -surge, skid], [0.0, 0.0, turn, -yaw]
            dynamics = np.array([*position, *velocity])
            cost = solve_continuous_are(dynamics, control, state_cost, control_cost)
            self._feedback[i] = weighted @ cost
            closed_loop = (dynamics - control @ self._feedback[i]).T
            turning = cost @ np.array([0.0, -speed, 0.0, 0.0])
            ahead = [weighted @ expm(closed_loop * time) @ turning for time in self.preview_times]
            self._preview[i] = step * np.stack(ahead, axis=-1)

    def wrench(self, speed: Float, deviation: Float, curvature: Float) -> Float:
        """Returns force along the hull, N, and moment, N m, (W, 2) that keep a vessel on its path.

        Args:
            speed: (W,) of the vessel, m/s.
            deviation: (W, 4) cross-track error along the hull, m; heading error, rad;
                velocity along the hull, m/s; yaw rate, rad/s.
            curvature: (W, PREVIEW_POINTS) of the path at ``preview_times``, 1/m.
        """
        place = np.interp(speed, SPEEDS, np.arange(len(SPEEDS)))
        low = np.minimum(place.astype(np.int64), len(SPEEDS) - 2)
        weight = (place - low)[:, None, None]
        feedback = self._feedback[low] * (1 - weight) + self._feedback[low + 1] * weight
        preview = self._preview[low] * (1 - weight) + self._preview[low + 1] * weight
        return -(feedback @ deviation[..., None] + preview @ curvature[..., None])[..., 0]
