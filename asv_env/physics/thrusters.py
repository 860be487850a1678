"""Differential drive: two motors, their limits and lag, and the wrench that they make."""

import numpy as np

from asv_env.params import BoatParams
from asv_env.types import Bool, Float

MIX = 1 + 1j
"""Factor that turns a demand a + ib into the thrust l + ir of the left and right motor, N.

a is the mean thrust, half the surge force; b is half the difference, the yaw moment over twice
the lever arm: l + ir = a - b + i (a + b) = (1 + i) (a + ib).
"""


def from_command(command: Float, boat: BoatParams) -> Float:
    """Returns the thrust (...), N, for commands (...) in [-1, 1]: linear, weaker astern."""
    return boat.thrust * np.where(command < 0, boat.astern * command, command)


def limited(thrust: Float, boat: BoatParams) -> Float:
    """Returns thrusts (...), N, clipped to what a motor can give."""
    return np.minimum(np.maximum(thrust, -boat.astern * boat.thrust), boat.thrust)


class Motors:
    """The motors of ``num_worlds`` teams: first-order lag, and a gain for each motor."""

    def __init__(self, boat: BoatParams, num_worlds: int, num_boats: int) -> None:
        self._lever_arm = boat.lever_arm
        #: (W, A, 2) present thrust of the left and right motor, N
        self.thrust = np.zeros((num_worlds, num_boats, 2))
        self._left, self._right = self.thrust[..., 0], self.thrust[..., 1]
        self._gain, self._response = np.ones((2, *self.thrust.shape))
        self._keep = np.ones((num_worlds, 1, 1))

    def changing(self) -> tuple[Float, ...]:
        """Returns the arrays that change from step to step, or from episode to episode."""
        return self.thrust, self._gain, self._response, self._keep

    def reset(self, world: int, gain: Float, dt_per_lag: float) -> None:
        """Stops the motors of one world and sets their gains (A, 2) and physics step over lag.

        The lag is integrated exactly for a thrust that is wanted for a whole step.
        """
        self.thrust[world] = 0.0
        self._gain[world] = gain
        self._keep[world] = np.exp(-dt_per_lag)

    def enable(self, working: Bool) -> None:
        """Lets only the boats (W, A) whose thrusters work respond from now on."""
        self._response[...] = self._gain * working[..., None] * (1.0 - self._keep)

    def drive(self, wanted: Float, surge: Float, yaw: Float) -> None:
        """Advances the thrusts, N, by one physics step towards those wanted (W, A, 2).

        ``surge`` and ``yaw``, each (W, A), receive the surge force, N, and the yaw moment, N m.
        """
        self.thrust *= self._keep
        self.thrust += self._response * wanted
        np.add(self._left, self._right, out=surge)
        np.subtract(self._right, self._left, out=yaw)
        yaw *= self._lever_arm
