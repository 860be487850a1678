"""Measurement and estimate: the true motion with white noise, and a Kalman filter of it.

The team shares one measurement, as the paper's boats share one motion-capture system. The
filter is the steady-state Kalman filter of each axis, a pose and its rate, for a hull with random
acceleration of the expected size.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.linalg import solve_discrete_are

from asv_env.geometry import wrap
from asv_env.params import EnvParams
from asv_env.types import Float

BLOCK = 64  #: ticks of noise drawn from a world's Generator at a time
CHANGING = ("measured", "estimate", "_block", "_drawn", "_rngs")  #: names of what changes
NO_NOISE = 1e-9  #: standard deviation that stands for an exact measurement


class Sensors:
    """Measurement and filter of ``num_worlds`` worlds, each with a Generator for its noise."""

    def __init__(self, params: EnvParams, num_worlds: int) -> None:
        p = params.sensors
        self._exact = p.exact
        self._dt = 1.0 / params.clock.sensing
        self._noise = np.array(
            [p.position_noise] * 2 + [p.heading_noise] + [p.speed_noise] * 2 + [p.yaw_rate_noise]
        )
        shape = (num_worlds, 1 + params.num_boats, 6)
        self.measured: Float = np.zeros(shape)  # (W, B, 6) the latest measurement
        self.estimate: Float = np.zeros(shape)  # (W, B, 6) the filtered motion
        if not self._exact:
            vessel = self._axes_gain(p.vessel_acceleration, p.vessel_yaw_acceleration)
            boat = self._axes_gain(p.acceleration, p.yaw_acceleration)
            self._gain = np.stack([vessel] + [boat] * params.num_boats)
            self._block = np.zeros((num_worlds, BLOCK, *shape[1:]))
            self._drawn = np.full(num_worlds, BLOCK)
            self._rngs: dict[int, np.random.Generator] = {}

    def snapshot(self) -> dict[str, Any]:
        """Returns all that changes from tick to tick by name, for the simulation to copy."""
        return {name: vars(self)[name] for name in CHANGING if name in vars(self)}

    def restore(self, memory: dict[str, Any]) -> None:
        """Continues as the sensors did whose ``snapshot`` this is."""
        vars(self).update(memory)
        self._freeze()

    def reset(
        self, index: np.ndarray, motion: Float, rngs: Mapping[int, np.random.Generator]
    ) -> None:
        """Begins episodes of the worlds ``index`` (n,) with their motion (n, B, 6).

        The noise of an episode has a Generator of its own, spawned from the world's, so that
        the next episode does not depend on how long this one was.
        """
        if not self._exact:
            self._drawn[index] = BLOCK
            self._rngs.update((int(world), rngs[int(world)].spawn(1)[0]) for world in index)
        noisy = self._noisy(index, motion)
        self.measured, self.estimate = self.measured.copy(), self.estimate.copy()
        self.measured[index] = noisy
        self.estimate[index] = noisy
        self._freeze()

    def sense(self, motion: Float) -> None:
        """Measures the motion (W, B, 6) and advances the estimate by one sensing tick."""
        if self._exact:
            self.measured = self.estimate = motion
            return
        self.measured = self._noisy(np.arange(len(motion)), motion)
        predicted = self.estimate.copy()
        predicted[..., :3] += self._dt * predicted[..., 3:]
        self.estimate, _ = corrected(predicted, self.measured, self._gain)
        self._freeze()

    def _freeze(self) -> None:
        """Makes measurement and estimate read-only: the next tick makes new ones."""
        self.measured.setflags(write=False)
        self.estimate.setflags(write=False)

    def _axes_gain(self, acceleration: float, yaw_acceleration: float) -> Float:
        """Returns the filter gain (2, 2, 3) of one hull's axes x, y and heading."""
        accelerations = (acceleration, acceleration, yaw_acceleration)
        axes = zip(accelerations, self._noise[:3], self._noise[3:], strict=True)
        return np.stack([steady_gain(*axis, self._dt) for axis in axes], axis=-1)

    def _noisy(self, index: np.ndarray, motion: Float) -> Float:
        """Returns the motion (n, B, 6) of the worlds ``index`` (n,) with the noise of a tick."""
        if self._exact:
            return motion
        for world in index[self._drawn[index] == BLOCK]:
            self._block[world] = self._rngs[int(world)].standard_normal(self._block.shape[1:])
            self._drawn[world] = 0
        noisy = motion + self._noise * self._block[index, self._drawn[index]]
        self._drawn[index] += 1
        noisy[..., 2] = wrap(noisy[..., 2])
        return noisy


def corrected(predicted: Float, measured: Float, gain: Float) -> tuple[Float, Float]:
    """Returns a predicted motion, corrected by its measurement, and the innovation.

    Motions and innovation are (..., 6); the gain (..., 2, 2, 3) is that of (pose, rate) to the
    innovation of (pose, rate), by axis.
    """
    innovation = measured - predicted
    innovation[..., 2] = wrap(innovation[..., 2])
    pairs = (*innovation.shape[:-1], 2, 3)
    pose, rate = innovation[..., None, :3], innovation[..., None, 3:]
    motion = predicted.reshape(pairs) + gain[..., 0, :] * pose + gain[..., 1, :] * rate
    motion = motion.reshape(innovation.shape)
    motion[..., 2] = wrap(motion[..., 2])
    return motion, innovation


def steady_gain(acceleration: float, pose_noise: float, rate_noise: float, dt: float) -> Float:
    """Returns the gain of the steady-state Kalman filter of a pose and its rate, both measured.

    It is (2, 2), of (pose, rate) to the innovation of (pose, rate). Standard deviations are those
    of the measured pose and rate, and of the mean over a tick of ``dt`` s of the acceleration,
    white noise.

    Raises:
        ValueError: the numbers are too far apart.
    """
    transition = np.array([[1.0, dt], [0.0, 1.0]])
    measured = np.diag(np.square(np.maximum([pose_noise, rate_noise], NO_NOISE)))
    drift = (acceleration * dt) ** 2 * np.array([[dt**2 / 3, dt / 2], [dt / 2, 1.0]])
    try:
        predicted = solve_discrete_are(transition.T, np.eye(2), drift, measured)
        gain: Float = np.linalg.solve(predicted + measured, predicted).T
        share = gain.diagonal()
        solved = bool((share >= 0.0).all() and (share < 1.0 + 1e-6).all())
    except (ValueError, np.linalg.LinAlgError):
        solved = False
    if not solved:
        raise ValueError(
            f"sensors: no filter can be computed for an acceleration of {acceleration:g} and noise "
            f"of {pose_noise:g} and {rate_noise:g} at {1 / dt:g} Hz: they are too far apart; "
            "choose a larger acceleration or less noise"
        )
    return gain
