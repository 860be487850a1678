"""Differential drive: two motors, their law of thrust, limits and lag, and the wrench they make.

A motor has a signal in [-1, 1], which follows the one that is wanted with a first-order lag. By
the linear law its thrust is proportional to the signal; by the quadratic law, that of a propeller
whose signal is its speed, to the signal's square. Astern it is weaker.
"""

import math
from typing import NamedTuple

import numpy as np

from asv_env.compiled import compiled
from asv_env.params import THRUST_LAWS, BoatParams
from asv_env.types import Float

QUADRATIC = THRUST_LAWS.index("quadratic")


class Drive(NamedTuple):
    """The motors of a kind of boat, as compiled code takes them."""

    ahead: float  #: thrust of one motor at full signal ahead, N
    astern: float  #: thrust of one motor at full signal astern, N
    law: int  #: index in ``THRUST_LAWS``
    lever_arm: float  #: distance of each motor from the centre line, m
    per_ahead: float  #: one over ``ahead``, 1/N, or 0
    per_astern: float  #: one over ``astern``, 1/N, or 0
    per_arm: float  #: one over ``lever_arm``, 1/m


class Motors(NamedTuple):
    """The motors of all teams: their state, and what varies between them."""

    signal: Float  #: (W, A, 2) present signal of the left and right motor
    thrust: Float  #: (W, A, 2) present thrust of the left and right motor, N
    gain: Float  #: (W, A, 2) factor on the thrust
    arm_gain: Float  #: (W, A) factor on the distance of the motors from the centre line
    keep: Float  #: (W,) share of a signal's distance from the wanted one that a step leaves


def drive(boat: BoatParams) -> Drive:
    """Returns the motors of this boat."""
    law = THRUST_LAWS.index(boat.thrust_law)
    ahead, astern, arm = boat.thrust, boat.astern * boat.thrust, boat.lever_arm
    inverse = (1.0 / number if number > 0.0 else 0.0 for number in (ahead, astern, arm))
    return Drive(ahead, astern, law, arm, *inverse)


def motors(num_worlds: int, num_boats: int) -> Motors:
    """Returns motors that are off, without lag."""
    shape = (num_worlds, num_boats, 2)
    thrust, gain = np.zeros(shape), (np.ones(shape), np.ones(shape[:2]))
    return Motors(np.zeros(shape), thrust, *gain, np.zeros(num_worlds))


@compiled
def thrust_of(signal: float, drive: Drive) -> float:
    """Returns the thrust of a motor at a signal in [-1, 1], N."""
    size = abs(signal)
    if drive.law == QUADRATIC:
        size *= size
    return drive.ahead * size if signal > 0.0 else -drive.astern * size


@compiled
def signal_for(thrust: float, drive: Drive) -> float:
    """Returns the signal at which a motor gives a thrust, N, clipped to [-1, 1]."""
    share = min(abs(thrust) * (drive.per_ahead if thrust > 0.0 else drive.per_astern), 1.0)
    if drive.law == QUADRATIC:
        share = math.sqrt(share)
    return share if thrust > 0.0 else -share


@compiled
def allocated(force: float, moment: float, drive: Drive) -> tuple[float, float]:
    """Returns the thrusts of both motors, N, for a surge force, N, and a yaw moment, N m.

    Where the motors cannot give both, the moment comes first: a boat that cannot turn cannot
    steer, one that is slow for a moment comes later.
    """
    half = 0.5 * (drive.ahead + drive.astern)  # largest half of the difference
    difference = min(max(0.5 * moment * drive.per_arm, -half), half)
    room = abs(difference)
    mean = min(max(0.5 * force, room - drive.astern), drive.ahead - room)
    return mean - difference, mean + difference


@compiled
def driven(
    motors: Motors, drive: Drive, world: int, boat: int, left: float, right: float
) -> tuple[float, float, float]:
    """Advances both motors of a boat by a step towards two signals; returns their wrench.

    It is the surge force, N, the sway force, which is 0, and the yaw moment, N m. The lag is
    integrated exactly for a signal that is wanted for the whole step.
    """
    keep, gain = motors.keep[world], motors.gain
    port = keep * motors.signal[world, boat, 0] + (1.0 - keep) * left
    starboard = keep * motors.signal[world, boat, 1] + (1.0 - keep) * right
    motors.signal[world, boat, 0], motors.signal[world, boat, 1] = port, starboard
    port = gain[world, boat, 0] * thrust_of(port, drive)
    starboard = gain[world, boat, 1] * thrust_of(starboard, drive)
    motors.thrust[world, boat, 0], motors.thrust[world, boat, 1] = port, starboard
    arm = drive.lever_arm * motors.arm_gain[world, boat]
    return port + starboard, 0.0, arm * (starboard - port)


@compiled
def _fill_signals(efforts: Float, drive: Drive, signals: Float) -> None:
    for i in range(len(efforts)):
        left, right = allocated(efforts[i, 0], efforts[i, 1], drive)
        signals[i, 0], signals[i, 1] = signal_for(left, drive), signal_for(right, drive)


def signals(efforts: Float, boat: BoatParams) -> Float:
    """Returns the signals (..., 2) of left and right motor for forces and moments (..., 2)."""
    flat = np.ascontiguousarray(efforts).reshape(-1, 2)
    result = np.zeros_like(flat)
    _fill_signals(flat, drive(boat), result)
    return result.reshape(efforts.shape)
