"""The autopilot of a boat: it follows set-points of forward speed and yaw rate.

As real autopilots do, it follows a reference model: the reference approaches the set-point with a
time constant and a bounded acceleration, so that a set-point that jumps makes no blow. The motors
get what the reference's motion takes by the nominal hull (mass times acceleration, and drag), plus
a correction proportional to the error of the motion.

The gain of the correction follows from the lag T of the thrusters: a proportional loop of
bandwidth 1/(2 T) round a first-order lag is a second-order system with damping ratio 1/sqrt(2). A
policy that commands a yaw rate proportional to its heading error closes the paper's PD loop on the
heading round it.
"""

from typing import NamedTuple

import numpy as np

from asv_env.compiled import compiled
from asv_env.params import BoatParams
from asv_env.types import Float


class Axis(NamedTuple):
    """The control of one axis, surge or yaw."""

    full: float  #: set-point of a full action, m/s or rad/s
    response: float  #: time constant of the reference model, s
    acceleration: float  #: largest acceleration of the reference, m/s^2 or rad/s^2
    mass: float  #: nominal effective mass or inertia
    linear: float  #: nominal linear drag coefficient
    quadratic: float  #: nominal quadratic drag coefficient
    gain: float  #: N per m/s or N m per rad/s of error


def bandwidth(boat: BoatParams) -> float:
    """Returns the bandwidth of the inner-loop controllers, 1/s."""
    return 1.0 / (2.0 * boat.lag)


def axes(boat: BoatParams) -> tuple[Axis, Axis]:
    """Returns the control of surge and of yaw of this boat."""
    surge, _, yaw = boat.masses
    gain = bandwidth(boat)
    return (
        Axis(
            boat.full_speed,
            boat.response[0],
            boat.acceleration[0],
            surge,
            *boat.surge,
            gain * surge,
        ),
        Axis(
            boat.full_yaw_rate, boat.response[1], boat.acceleration[1], yaw, *boat.yaw, gain * yaw
        ),
    )


def scale(boat: BoatParams) -> Float:
    """Returns the motion (2,) of a full tracking action, m/s and rad/s."""
    return np.array([boat.full_speed, boat.full_yaw_rate])


@compiled
def referred(reference: float, action: float, axis: Axis, dt: float) -> tuple[float, float]:
    """Returns the reference after a step towards an action in [-1, 1], and its acceleration."""
    wanted = (axis.full * action - reference) / max(axis.response, dt)
    acceleration = min(max(wanted, -axis.acceleration), axis.acceleration)
    return reference + dt * acceleration, acceleration


@compiled
def effort(motion: float, reference: float, acceleration: float, axis: Axis) -> float:
    """Returns the force, N, or moment, N m, with which a hull's motion follows a reference."""
    drag = (axis.linear + axis.quadratic * abs(reference)) * reference
    return axis.mass * acceleration + drag + axis.gain * (reference - motion)


@compiled
def _steady_efforts(motion: Float, reference: Float, axis: Axis, efforts: Float) -> None:
    for i in range(len(efforts)):
        efforts[i] = effort(motion[i], reference[i], 0.0, axis)


def efforts(motion: Float, reference: Float, boat: BoatParams) -> Float:
    """Returns surge forces, N, and yaw moments, N m, with which boats follow a steady reference.

    Args:
        motion: (..., 2) forward speeds, m/s, and yaw rates, rad/s.
        reference: (..., 2) those wanted.
        boat: the kind of boat.

    Returns:
        Efforts (..., 2).
    """
    rows = [np.ascontiguousarray(each).reshape(-1, 2).T.copy() for each in (motion, reference)]
    result = np.zeros_like(rows[0])
    for axis, own, wanted, column in zip(axes(boat), *rows, result, strict=True):
        _steady_efforts(own, wanted, axis, column)
    return result.T.reshape(motion.shape)


def coasting(motion: Float, boat: BoatParams) -> Float:
    """Returns set-points (..., 2), m/s and rad/s, by which the motors of moving boats hardly run.

    The reference then slows down as the boat's ``motion`` (..., 2) does under drag alone.
    """
    surge, _, yaw = boat.masses
    linear, quadratic = np.transpose([boat.surge, boat.yaw])
    drag = (linear + quadratic * np.abs(motion)) * motion
    return motion - np.array(boat.response) * drag / np.array([surge, yaw])
