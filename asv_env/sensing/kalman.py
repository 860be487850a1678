"""Steady-state Kalman filter of a motion of which poses and rates are measured, axis by axis."""

import numpy as np
from scipy.linalg import solve_discrete_are

from asv_env.geometry import wrap
from asv_env.types import Float

NO_NOISE = 1e-6
"""Standard deviation that stands for an exact measurement, as a share of what the acceleration does
in a tick, so that it is the same in worlds of every size."""


def predicted(motion: Float, dt: float) -> Float:
    """Returns a motion (..., 6) after ``dt`` s at its rates; the heading is not wrapped."""
    after = motion.copy()
    after[..., :3] += dt * motion[..., 3:]
    return after


def corrected(prediction: Float, measured: Float, gain: Float) -> tuple[Float, Float]:
    """Returns a predicted motion, corrected by its measurement, and the innovation.

    Motions and innovation are (..., 6); the gain (..., 2, 2, 3) is that of (pose, rate) to the
    innovation of (pose, rate), by axis.
    """
    innovation = measured - prediction
    innovation[..., 2] = wrap(innovation[..., 2])
    pairs = (*innovation.shape[:-1], 2, 3)
    pose, rate = innovation[..., None, :3], innovation[..., None, 3:]
    motion = prediction.reshape(pairs) + gain[..., 0, :] * pose + gain[..., 1, :] * rate
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
    least = NO_NOISE * acceleration * dt * np.array([dt, 1.0])
    measured = np.diag(np.square(np.maximum([pose_noise, rate_noise], least)))
    drift = (acceleration * dt) ** 2 * np.array([[dt**2 / 3, dt / 2], [dt / 2, 1.0]])
    try:
        variance = solve_discrete_are(transition.T, np.eye(2), drift, measured)
        gain: Float = np.linalg.solve(variance + measured, variance).T
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
