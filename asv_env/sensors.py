"""What the boats measure: the true motion with white noise, and a filtered estimate of it.

The team shares one measurement, as the paper's boats share one motion-capture system. The
filter is a steady-state Kalman filter on each axis: velocities as random walks driven by the
accelerations expected of a hull, poses carried on by the filtered velocities.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from asv_env.geometry import wrap
from asv_env.params import EnvParams
from asv_env.types import Float

BLOCK = 64
"""Ticks of noise drawn from a world's Generator at a time."""


class Sensors:
    """Measurement and filter of ``num_worlds`` worlds, each with a Generator for its noise.

    Attributes:
        measured: (W, B, 6) the latest measurement.
        estimate: (W, B, 6) the filtered motion.
    """

    def __init__(self, params: EnvParams, num_worlds: int) -> None:
        p = params.sensors
        self._exact = p.exact
        self._dt = 1.0 / params.clock.sensing
        self._noise = np.array(
            [p.position_noise] * 2 + [p.heading_noise] + [p.speed_noise] * 2 + [p.yaw_rate_noise]
        )
        expected = np.array([p.acceleration] * 2 + [p.yaw_acceleration]) * self._dt
        self._velocity_gain = steady_gain(expected, self._noise[3:])
        drift = self._dt * (np.sqrt(self._velocity_gain) * self._noise[3:] + expected / 2)
        self._pose_gain = steady_gain(drift, self._noise[:3])
        shape = (num_worlds, 1 + params.num_boats, 6)
        self.measured: Float = np.zeros(shape)
        self.estimate: Float = np.zeros(shape)
        if not self._exact:
            self._block = np.zeros((num_worlds, BLOCK, *shape[1:]))
            self._drawn = np.full(num_worlds, BLOCK)
            self._rngs: dict[int, np.random.Generator] = {}

    def reset(
        self, index: np.ndarray, motion: Float, rngs: Mapping[int, np.random.Generator]
    ) -> None:
        """Starts the worlds ``index`` (n,) afresh from their motion (n, B, 6).

        The noise of an episode has a Generator of its own, spawned from the world's, so that
        what the world draws next does not depend on how long the episode was.
        """
        if not self._exact:
            self._drawn[index] = BLOCK
            self._rngs.update((int(world), rngs[int(world)].spawn(1)[0]) for world in index)
        noisy = self._noisy(index, motion)
        self.measured, self.estimate = self.measured.copy(), self.estimate.copy()
        self.measured[index] = noisy
        self.estimate[index] = noisy

    def sense(self, motion: Float) -> None:
        """Measures the motion (W, B, 6) and carries the estimate on by one sensing tick."""
        if self._exact:
            self.measured = self.estimate = motion
            return
        self.measured = self._noisy(np.arange(len(motion)), motion)
        k, previous = self._velocity_gain, self.estimate
        velocity = (1 - k) * previous[..., 3:] + k * self.measured[..., 3:]
        predicted = previous[..., :3] + self._dt * velocity
        innovation = self.measured[..., :3] - predicted
        innovation[..., 2] = wrap(innovation[..., 2])
        pose = predicted + self._pose_gain * innovation
        pose[..., 2] = wrap(pose[..., 2])
        self.estimate = np.concatenate([pose, velocity], axis=-1)

    def _noisy(self, index: np.ndarray, motion: Float) -> Float:
        if self._exact:
            return motion
        for world in index[self._drawn[index] == BLOCK]:
            self._block[world] = self._rngs[int(world)].standard_normal(self._block.shape[1:])
            self._drawn[world] = 0
        noisy = motion + self._noise * self._block[index, self._drawn[index]]
        self._drawn[index] += 1
        noisy[..., 2] = wrap(noisy[..., 2])
        return noisy


def steady_gain(drift: Float, noise: Float) -> Float:
    """Gain of the steady-state scalar Kalman filter of a random walk.

    Args:
        drift: standard deviation of the walk's step.
        noise: standard deviation of the measurement.

    Returns:
        p / (p + r) with p the positive root of p^2 - q p - q r = 0, q and r the variances;
        1 where there is no noise.
    """
    q, r = drift**2, noise**2
    p = (q + np.sqrt(q**2 + 4 * q * r)) / 2
    return p / (p + r)
