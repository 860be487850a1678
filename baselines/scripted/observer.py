"""Estimates the vessel's motion and the drift of its water from the shared measurement.

The boats know what force they exert on the vessel and how water and inertia answer. A Kalman
filter that predicts the vessel's motion from it can trust a single measurement far less than the
shared filter of the sensors, which knows nothing of forces: its rates have half to a third of the
noise. What the free vessel does beyond the prediction is put down to the water that carries it.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
from scipy.linalg import solve_discrete_are

from asv_env.geometry import plane, wrap
from asv_env.params import NOMINAL_LENGTH, EnvParams
from asv_env.sensing.kalman import corrected, steady_gain
from asv_env.types import Bool, Complex, Float, Sensed, zeros
from baselines.paper.coasting import drag

ACCELERATION = 0.01  #: standard deviation of the acceleration not predicted, m/s^2
YAW_ACCELERATION = 0.012  #: standard deviation of the yaw acceleration, vessel of 0.40 m, rad/s^2
FREE_ACCELERATION = 0.002  #: standard deviation of the acceleration without contact, m/s^2
FREE_YAW_ACCELERATION = 0.004  #: likewise, vessel of 0.40 m, rad/s^2
DRIFT_WALK = 0.0007  #: random walk of the current, m/s per root second
LEAST_NOISE = 1e-6  #: floor of the measurement noise in the filter of the drift, m and m/s
SLIP = 0.02  #: speed through the water at which the drag is linearised for the gain, m/s


@dataclass
class VesselMemory:
    """What is known about the vessel."""

    motion: Float  #: (W, 6) estimated motion, world frame
    drift: Complex  #: (W,) estimated velocity of the water, m/s, world frame
    force: Complex  #: (W,) that the boats exert on the vessel until the next tick, its frame, N
    moment: Float  #: (W,) that they exert, N m
    seen: Bool  #: (W,) whether the vessel was in sight

    @classmethod
    def empty(cls, worlds: int) -> Self:
        """Returns memory to be filled by ``VesselObserver.restart``."""
        return zeros(cls, (worlds, 6), (worlds,), (worlds,), (worlds,), (worlds,))


class VesselObserver:
    """Kalman filter of the vessel's motion, driven by the forces of the boats."""

    def __init__(self, params: EnvParams) -> None:
        self._vessel, _ = params.hulls()
        self._dt = 1.0 / params.clock.control
        noise, scale = params.sensors, self._vessel.size / NOMINAL_LENGTH
        linear_noise = noise.position_noise, noise.speed_noise
        angular_noise = noise.heading_noise, noise.yaw_rate_noise
        linear = steady_gain(ACCELERATION, *linear_noise, self._dt)
        angular = steady_gain(YAW_ACCELERATION / scale, *angular_noise, self._dt)
        self._gains = np.stack([linear, linear, angular], axis=-1)
        hull = self._vessel.linearised(SLIP, 0.0)
        decays = hull.surge[0] / hull.masses[0], hull.sway[0] / hull.masses[1]
        #: gains of a free vessel along and across the hull, and of its yaw
        self._free_gains = [
            free_gains(FREE_ACCELERATION, decay, *linear_noise, self._dt) for decay in decays
        ]
        self._free_yaw = steady_gain(FREE_YAW_ACCELERATION / scale, *angular_noise, self._dt)

    def restart(self, sensed: Sensed, memory: VesselMemory, which: Bool) -> None:
        """Starts the worlds ``which`` (W,) from their measurement, at rest in still water."""
        memory.motion[which] = sensed.measured[which, 0]
        memory.motion[which, 3:] = 0.0
        memory.drift[which] = memory.force[which] = memory.moment[which] = 0.0

    def update(self, sensed: Sensed, memory: VesselMemory, pushing: Bool) -> None:
        """Advances the estimate by one tick and corrects it by the measurement.

        The drift is learnt only where the team does not push (``pushing``, (W,)) and no boat
        touches the vessel: contact is modelled too roughly to tell a current from it.
        """
        dt = self._dt
        rate = memory.motion[:, 3:] + dt * self.acceleration(memory)
        pose = memory.motion[:, :3] + dt / 2 * (memory.motion[:, 3:] + rate)
        predicted = np.concatenate([pose, rate], axis=-1)
        measured = np.where(sensed.received[:, :1], sensed.measured[:, 0], predicted)
        memory.motion, innovation = corrected(predicted, measured, self._gains)
        free = ~(pushing | sensed.touching[..., 0].any(axis=1))
        if free.any():
            motion, drift = self._free(predicted, innovation, memory.drift)
            memory.motion[free], memory.drift[free] = motion[free], drift[free]

    def _free(self, predicted: Float, innovation: Float, drift: Complex) -> tuple[Float, Complex]:
        """Returns motions (W, 6) and drifts (W,) of free vessels, corrected by innovations."""
        heading, motion = np.exp(1j * predicted[:, 2]), predicted.copy()
        seen = np.stack([plane(innovation), plane(innovation, 3)]) * heading.conj()
        along, across = (gains @ seen for gains in self._free_gains)
        pose, rate, more = heading * (along.real + 1j * across.imag)
        yaw = self._free_yaw @ innovation[:, [2, 5]].T
        motion += np.stack([pose.real, pose.imag, yaw[0], rate.real, rate.imag, yaw[1]], axis=-1)
        motion[:, 2] = wrap(motion[:, 2])
        return motion, drift + more

    def acceleration(self, memory: VesselMemory) -> Float:
        """Returns the acceleration (W, 3) by the boats' forces and the drag, m/s^2 and rad/s^2."""
        vessel, motion = self._vessel, memory.motion
        heading = np.exp(1j * motion[:, 2])
        velocity, yaw_rate = (plane(motion, 3) - memory.drift) * heading.conj(), motion[:, 5]
        (m_surge, m_sway, inertia), u, v = vessel.masses, velocity.real, velocity.imag
        surge = memory.force.real - drag(vessel.surge, u) + m_sway * v * yaw_rate
        sway = memory.force.imag - drag(vessel.sway, v) - m_surge * u * yaw_rate
        yaw = memory.moment - drag(vessel.yaw, yaw_rate) + (m_surge - m_sway) * u * v
        over_ground = 1j * yaw_rate * velocity  # The hull's frame turns with the hull.
        linear = heading * (surge / m_surge + 1j * sway / m_sway + over_ground)
        angular = yaw / inertia
        return np.stack([linear.real, linear.imag, angular], axis=-1)


def free_gains(
    acceleration: float, decay: float, pose_noise: float, rate_noise: float, dt: float
) -> Float:
    """Returns the steady-state gains (3, 2) of a free vessel on the innovations of pose and rate.

    The Kalman filter has three states: pose, m, rate, m/s, and the drift to which the rate decays
    with ``decay``, 1/s. ``acceleration``, m/s^2, is the standard deviation of what else changes
    the rate, ``dt`` the duration of a tick, s.
    """
    transition = np.array([[1.0, dt, 0.0], [0.0, 1 - decay * dt, decay * dt], [0.0, 0.0, 1.0]])
    process_noise = np.diag([0.0, (acceleration * dt) ** 2, DRIFT_WALK**2 * dt])
    measured = np.eye(3)[:2]
    noise = np.diag(np.maximum([pose_noise, rate_noise], LEAST_NOISE) ** 2)
    covariance = solve_discrete_are(transition.T, measured.T, process_noise, noise)
    gains: Float = np.linalg.solve(covariance[:2, :2] + noise, covariance[:2]).T
    return gains
