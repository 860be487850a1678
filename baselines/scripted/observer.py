"""What the boats make of the measurement: the vessel's motion, and the drift of its water.

The boats know what force they exert on the vessel and how water and inertia answer. A Kalman
filter that predicts the vessel's motion from it can trust a single measurement far less than the
shared filter of the sensors, which knows nothing of forces: rates come out two to three times as
quiet. What the free vessel does beyond the prediction is laid to the water that carries it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_discrete_are

from asv_env.geometry import plane
from asv_env.params import NOMINAL_LENGTH, EnvParams
from asv_env.sensing.sensors import corrected, steady_gain
from asv_env.types import Bool, Complex, Float, Sensed

ACCELERATION = 0.01
"""Standard deviation of what the prediction misses, m/s^2, and
``YAW_ACCELERATION``, rad/s^2 for a vessel of 0.40 m."""
YAW_ACCELERATION = 0.012
FREE_ACCELERATION = 0.002
"""The same for a vessel that no boat touches, m/s^2."""
DRIFT_WALK = 0.001
"""Random walk that is expected of the current, m/s per root second."""
NO_NOISE = 1e-6
"""Least noise of a measurement that is reckoned with."""
SLIP = 0.02
"""Speed through the water at which the drag is linearised for the gain, m/s."""


@dataclass
class VesselMemory:
    """What is known of the vessel.

    Attributes:
        motion: (W, 6) its estimated motion, world frame.
        drift: (W,) estimated velocity of the water, m/s, world frame.
        acceleration: (W, 3) that the boats' forces and the water are expected to cause.
    """

    motion: Float
    drift: Complex
    acceleration: Float


class Observer:
    """Kalman filter of the vessel's motion, driven by the forces of the boats.

    Args:
        params: of the environment.
    """

    def __init__(self, params: EnvParams) -> None:
        self._vessel, _ = params.hulls()
        self._dt = 1.0 / params.clock.control
        noise, scale = params.sensors, self._vessel.length / NOMINAL_LENGTH
        linear = noise.position_noise, noise.speed_noise
        angular = noise.heading_noise, noise.yaw_rate_noise
        moved = steady_gain(ACCELERATION, *linear, self._dt)
        turned = steady_gain(YAW_ACCELERATION / scale, *angular, self._dt)
        self._gains = np.stack([moved, moved, turned], axis=-1)
        hull = self._vessel.linearised(SLIP, 0.0)
        decay = (hull.sway[0] + hull.surge[0]) / 2 / self._vessel.total_mass
        self._drift_gain = drift_gain(FREE_ACCELERATION, decay, *linear, self._dt)

    def fresh(self, worlds: int) -> VesselMemory:
        """Memory to be filled by ``begin``."""
        return VesselMemory(
            motion=np.zeros((worlds, 6)),
            drift=np.zeros(worlds, dtype=np.complex128),
            acceleration=np.zeros((worlds, 3)),
        )

    def begin(self, sensed: Sensed, memory: VesselMemory, which: Bool) -> None:
        """Starts some worlds from the first measurement, in still water."""
        memory.motion[which] = sensed.measured[which, 0]
        memory.motion[which, 3:] = 0.0
        memory.drift[which] = 0.0
        memory.acceleration[which] = 0.0

    def update(self, sensed: Sensed, memory: VesselMemory, pushing: Bool) -> None:
        """Carries the estimate on by one tick and corrects it by the measurement.

        The drift is learnt only where the team does not push (``pushing``, (W,)) and no boat
        touches the vessel: contact is modelled too roughly to tell a current from it.
        """
        dt = self._dt
        rate = memory.motion[:, 3:] + dt * memory.acceleration
        pose = memory.motion[:, :3] + dt / 2 * (memory.motion[:, 3:] + rate)
        predicted = np.concatenate([pose, rate], axis=-1)
        memory.motion, lacks = corrected(predicted, sensed.measured[:, 0], self._gains)
        free = ~(pushing | sensed.touching[..., 0].any(axis=1))
        by_pose, by_rate = self._drift_gain
        learnt = by_pose * plane(lacks) + by_rate * plane(lacks, 3)
        memory.drift = memory.drift + free * learnt

    def expect(self, memory: VesselMemory, force: Complex, moment: Float) -> None:
        """Predicts what comes of the boats' force (W,) N, vessel frame, and moment (W,) N m."""
        vessel, motion = self._vessel, memory.motion
        heading = np.exp(1j * motion[:, 2])
        slip, yaw_rate = (plane(motion, 3) - memory.drift) * heading.conj(), motion[:, 5]
        drag = _drag(vessel.surge, slip.real) + 1j * _drag(vessel.sway, slip.imag)
        linear = heading * (force - drag) / vessel.total_mass
        angular = (moment - _drag(vessel.yaw, yaw_rate)) / vessel.total_inertia
        memory.acceleration = np.stack([linear.real, linear.imag, angular], axis=-1)


def _drag(coefficients: tuple[float, float], velocity: Float) -> Float:
    return (coefficients[0] + coefficients[1] * np.abs(velocity)) * velocity


def drift_gain(
    acceleration: float, decay: float, pose_noise: float, rate_noise: float, dt: float
) -> Float:
    """What the drift takes of the innovations of pose and rate, (2,), in the steady state.

    The Kalman filter of three states: pose, rate, and the drift to which the rate decays.

    Args:
        acceleration: standard deviation of what else changes the rate, m/s^2.
        decay: of the rate towards the drift, 1/s.
        pose_noise: standard deviation of the measured pose, m.
        rate_noise: standard deviation of the measured rate, m/s.
        dt: s, a tick.
    """
    transition = np.array([[1.0, dt, 0.0], [0.0, 1 - decay * dt, decay * dt], [0.0, 0.0, 1.0]])
    walk = np.diag([0.0, (acceleration * dt) ** 2, DRIFT_WALK**2 * dt])
    seen = np.eye(3)[:2]
    error = np.diag(np.maximum([pose_noise, rate_noise], NO_NOISE) ** 2)
    predicted = solve_discrete_are(transition.T, seen.T, walk, error)
    gain: Float = np.linalg.solve(predicted[:2, :2] + error, predicted[:2, 2])
    return gain
