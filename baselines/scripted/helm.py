"""How boats are steered through their autopilots: turns that end in time, and exact set-points.

An autopilot follows a reference that approaches its set-point with a time constant and a bounded
acceleration (``asv_env.physics.autopilot``). A boat knows its own autopilot, so it can ask for a
turn that the reference can still stop, and give the set-point that brings the reference where it
is wanted one tick later.
"""

import numpy as np

from asv_env.params import EnvParams
from asv_env.types import Float

STOPPING = 0.8  #: fraction of the largest yaw acceleration with which a turn is planned to stop


class Helm:
    """Yaw rates of turns, and set-points, of boats of one kind."""

    def __init__(self, params: EnvParams) -> None:
        boat, clock = params.boat, params.clock
        self._full = np.array([boat.full_speed, boat.full_yaw_rate])
        self._dt, self._steps = clock.dt, clock.physics // clock.control
        #: (2,) time constants, s, and largest accelerations, m/s^2 and rad/s^2
        self._response = np.maximum(boat.response, clock.dt)
        self._acceleration = np.array(boat.acceleration)
        self._reached = 1.0 - (1.0 - self._dt / self._response) ** self._steps
        # Round a first-order lag T, a gain 1/(2 T) has the damping ratio 1/sqrt(2).
        self._gain = 1.0 / (2.0 * (self._response[1] + boat.lag))
        self._stopping = STOPPING * self._acceleration[1]

    def turn(self, error: Float) -> Float:
        """Returns yaw rates (...), rad/s, that take angles (...), rad, away.

        Near the wanted heading they are proportional to the angle. Farther from it they are
        those from which a constant deceleration still ends the turn there.
        """
        size = np.abs(error)
        linear = self._stopping / self._gain**2  # angle up to which the law is linear
        braking = np.sqrt(2 * self._stopping * np.maximum(size - linear / 2, linear / 2))
        return np.sign(error) * np.where(size < linear, self._gain * size, braking)

    def angle(self, rate: Float) -> Float:
        """Returns the angles (...), rad, that are taken away with yaw rates (...), rad/s."""
        size = np.abs(rate)
        linear = self._stopping / self._gain**2
        braking = size**2 / (2 * self._stopping) + linear / 2
        return np.sign(rate) * np.where(size < self._gain * linear, size / self._gain, braking)

    def set_points(self, wanted: Float, reference: Float) -> tuple[Float, Float]:
        """Returns set-points that bring the references to wanted motions within a tick.

        Args:
            wanted: (..., 2) forward speeds, m/s, and yaw rates, rad/s.
            reference: (..., 2) those of the reference models now.

        Returns:
            Set-points as actions (..., 2) in [-1, 1], and the references (..., 2) a tick later.
        """
        action = np.clip((reference + (wanted - reference) / self._reached) / self._full, -1.0, 1.0)
        goal, limit = action * self._full, self._acceleration
        for _ in range(self._steps):
            rise = np.clip((goal - reference) / self._response, -limit, limit)
            reference = reference + self._dt * rise
        return action, reference
