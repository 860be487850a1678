"""Steady-state Kalman filter of a motion of which poses and rates are measured, axis by axis."""

import numpy as np
from scipy.linalg import solve_discrete_are

from asv_env.compiled import compiled
from asv_env.geometry import wrapped
from asv_env.types import Float, given

NO_NOISE = 1e-6
"""Standard deviation that stands for an exact measurement, as a share of what the acceleration does
in a tick, so that it is the same in worlds of every size."""


@compiled
def predict(motion: Float, dt: float, after: Float) -> None:
    """Writes a motion (6,) after ``dt`` s at its rates; the heading is not wrapped."""
    for axis in range(3):
        after[axis] = motion[axis] + dt * motion[axis + 3]
        after[axis + 3] = motion[axis + 3]


@compiled
def correct(
    prediction: Float, measured: Float, gain: Float, motion: Float, innovation: Float
) -> None:
    """Writes a predicted motion (6,), corrected by its measurement (6,), and the innovation (6,).

    The gain (2, 2, 3) is that of (pose, rate) to the innovation of (pose, rate), by axis. The
    corrected motion may take the place of the prediction.
    """
    for k in range(6):
        innovation[k] = measured[k] - prediction[k]
    innovation[2] = wrapped(innovation[2])
    for kind in range(2):
        for axis in range(3):
            by_pose, by_rate = gain[kind, 0, axis], gain[kind, 1, axis]
            after = prediction[3 * kind + axis] + by_pose * innovation[axis]
            motion[3 * kind + axis] = after + by_rate * innovation[axis + 3]
    motion[2] = wrapped(motion[2])


def predicted(motion: Float, dt: float) -> Float:
    """Returns motions (..., 6) after ``dt`` s at their rates; the headings are not wrapped."""
    after = np.empty(motion.shape)
    _predict_all(given(motion).reshape(-1, 6), dt, after.reshape(-1, 6))
    return after


def corrected(prediction: Float, measured: Float, gain: Float) -> tuple[Float, Float]:
    """Returns predicted motions (..., 6), corrected, and the innovations; see ``correct``."""
    motion, innovation = np.empty(prediction.shape), np.empty(prediction.shape)
    known = given(prediction).reshape(-1, 6), given(measured).reshape(-1, 6), given(gain)
    _correct_all(*known, motion.reshape(-1, 6), innovation.reshape(-1, 6))
    return motion, innovation


@compiled
def _predict_all(motion: Float, dt: float, after: Float) -> None:
    for row in range(len(motion)):
        predict(motion[row], dt, after[row])


@compiled
def _correct_all(
    prediction: Float, measured: Float, gain: Float, motion: Float, innovation: Float
) -> None:
    for row in range(len(motion)):
        correct(prediction[row], measured[row], gain, motion[row], innovation[row])


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
