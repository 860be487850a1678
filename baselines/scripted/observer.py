"""Estimates the vessel's motion and the drift of its water from the shared measurement.

The boats know what force they exert on the vessel and how water and inertia answer. A Kalman
filter that predicts the vessel's motion from it can trust a single measurement far less than the
shared filter of the sensors, which knows nothing of forces: its rates have half to a third of the
noise. What the free vessel does beyond the prediction is put down to the water that carries it.
Of a vessel in contact the same is said of the whole of vessel and boats, whose motors' thrust is
known better than the forces between them: well enough to follow a current that was found before,
and too roughly to find one.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
from scipy.linalg import solve_discrete_are

from asv_env.geometry import mirrored, plane, wrap
from asv_env.params import NOMINAL_LENGTH, EnvParams
from asv_env.physics.autopilot import bandwidth
from asv_env.sensing.kalman import corrected, steady_gain
from asv_env.types import Bool, Complex, Float, Sensed, zeros
from baselines.paper.coasting import drag
from baselines.scripted.gains import PathGains

ACCELERATION = 0.01  #: standard deviation of the acceleration not predicted, m/s^2
YAW_ACCELERATION = 0.012  #: standard deviation of the yaw acceleration, vessel of 0.40 m, rad/s^2
FREE_ACCELERATION = 0.002  #: standard deviation of the acceleration without contact, m/s^2
FREE_YAW_ACCELERATION = 0.004  #: likewise, vessel of 0.40 m, rad/s^2
FAST = 0.03  #: speed from which no drift is learnt in contact, m/s: forces are known less well
MEAN_TIME = 30.0  #: time over which the mean of the drift is taken, s
DRIFT_WALK = 0.0007  #: random walk of the current, m/s per root second
LEAST_NOISE = 1e-6  #: floor of the measurement noise in the filter of the drift, m and m/s
SLIP = 0.02  #: speed through the water at which the drag is linearised for the gain, m/s


@dataclass
class VesselMemory:
    """What is known about the vessel."""

    motion: Float  #: (W, 6) estimated motion, world frame
    drift: Complex  #: (W,) estimated velocity of the water, m/s, world frame
    mean: Complex  #: (W,) of the drift so far, m/s
    age: Float  #: (W,) time over which it is the mean, s
    moves: Bool  #: (W,) whether the water was found to move
    force: Complex  #: (W,) that the boats exert on the vessel until the next tick, its frame, N
    moment: Float  #: (W,) that they exert, N m
    seen: Bool  #: (W,) whether the vessel was in sight
    thrust: Float  #: (W, A) of the boats until the next tick if they stood still, N

    @classmethod
    def empty(cls, worlds: int, team: int) -> Self:
        """Returns memory to be filled by ``VesselObserver.restart``."""
        return zeros(cls, (worlds, 6), *[(worlds,)] * 7, (worlds, team))

    def turn(self, which: Bool) -> None:
        """Takes what is known to the mirror image in the worlds ``which`` (W,)."""
        side = np.where(which, -1.0, 1.0)
        self.motion = mirrored(self.motion, side)
        self.drift = self.drift.real + 1j * side * self.drift.imag
        self.mean = self.mean.real + 1j * side * self.mean.imag
        self.force = self.force.real + 1j * side * self.force.imag
        self.moment = side * self.moment


class VesselObserver:
    """Kalman filter of the vessel's motion, driven by the forces of the boats.

    Args:
        params: parameters of the environment.
        by_thrust: whether ``command`` is called at every tick, so that the drift of a vessel in
            contact can be followed by the thrust of the boats.
    """

    def __init__(self, params: EnvParams, by_thrust: bool = False) -> None:
        self._by_thrust = by_thrust
        self._vessel, self._boat = params.hulls()
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
        self._contact_gains = [
            free_gains(ACCELERATION, decay, *linear_noise, self._dt) for decay in decays
        ]
        self._free_yaw = steady_gain(FREE_YAW_ACCELERATION / scale, *angular_noise, self._dt)

    def restart(self, sensed: Sensed, memory: VesselMemory, which: Bool) -> None:
        """Starts the worlds ``which`` (W,) from their measurement, at rest in still water."""
        memory.motion[which] = sensed.measured[which, 0]
        memory.motion[which, 3:] = 0.0
        memory.mean[which] = memory.age[which] = 0.0
        memory.moves[which] = False
        memory.drift[which] = memory.force[which] = memory.moment[which] = 0.0

    def update(self, sensed: Sensed, memory: VesselMemory, pushing: Bool) -> None:
        """Advances the estimate by one tick and corrects it by the measurement.

        Where the team does not push (``pushing``, (W,)) and no boat touches the vessel, drift and
        motion are corrected together.
        """
        before = memory.motion
        predicted = self._predicted(before, self.acceleration(memory))
        follows = pushing & memory.moves & self._by_thrust
        if follows.any():
            together = self._predicted(before, self._with_boats(sensed, memory))
            measured = np.where(sensed.received[:, :1], sensed.measured[:, 0], together)
            _, seen = corrected(together, measured, self._gains)
            _, drift = self._carried(together, seen, memory.drift, self._contact_gains)
            slow = np.maximum(1.0 - np.abs(plane(before, 3)) / FAST, 0.0)
            drift = memory.drift + slow * (drift - memory.drift)
            memory.drift = np.where(follows, drift, memory.drift)
        measured = np.where(sensed.received[:, :1], sensed.measured[:, 0], predicted)
        memory.motion, innovation = corrected(predicted, measured, self._gains)
        free = ~(pushing | sensed.touching[..., 0].any(axis=1))
        if free.any():
            motion, drift = self._carried(predicted, innovation, memory.drift, self._free_gains)
            memory.motion[free], memory.drift[free] = motion[free], drift[free]
            memory.moves |= free & (np.abs(memory.drift) > PathGains.still_water)
        memory.age = np.minimum(memory.age + self._dt, MEAN_TIME)
        memory.mean = memory.mean + self._dt / memory.age * (memory.drift - memory.mean)

    def _predicted(self, motion: Float, acceleration: Float) -> Float:
        """Returns motions (W, 6) a tick later, under accelerations (W, 3)."""
        rate = motion[:, 3:] + self._dt * acceleration
        pose = motion[:, :3] + self._dt / 2 * (motion[:, 3:] + rate)
        return np.concatenate([pose, rate], axis=-1)

    def _carried(
        self, predicted: Float, innovation: Float, drift: Complex, linear: list[Float]
    ) -> tuple[Float, Complex]:
        """Returns motions (W, 6) and drifts (W,), corrected by innovations with such gains."""
        heading, motion = np.exp(1j * predicted[:, 2]), predicted.copy()
        seen = np.stack([plane(innovation), plane(innovation, 3)]) * heading.conj()
        along, across = (gains @ seen for gains in linear)
        pose, rate, more = heading * (along.real + 1j * across.imag)
        yaw = self._free_yaw @ innovation[:, [2, 5]].T
        motion += np.stack([pose.real, pose.imag, yaw[0], rate.real, rate.imag, yaw[1]], axis=-1)
        motion[:, 2] = wrap(motion[:, 2])
        return motion, drift + more

    def command(self, memory: VesselMemory, before: Float, reference: Float) -> None:
        """Notes the thrust of the boats until the next tick.

        Args:
            memory: ``thrust`` is updated.
            before: (W, A, 2) the references of their autopilots now, m/s and rad/s.
            reference: (W, A, 2) those at the next tick.
        """
        boat, speed = self._boat, reference[..., 0]
        rise = (speed - before[..., 0]) / self._dt
        mass = boat.masses[0]
        memory.thrust = mass * rise + drag(boat.surge, speed) + bandwidth(boat) * mass * speed

    def _with_boats(self, sensed: Sensed, memory: VesselMemory) -> Float:
        """Returns the acceleration (W, 3) of vessels with the boats that touch them.

        That of the yaw is 0: where boats push is known less well than that they do.
        """
        boat, touching = self._boat, sensed.touching[..., 0]
        bow, velocity = np.exp(1j * sensed.estimate[:, 1:, 2]), plane(sensed.estimate[:, 1:], 3)
        through = (velocity - memory.drift[:, None]) * bow.conj()
        thrust = memory.thrust - bandwidth(boat) * boat.masses[0] * (velocity * bow.conj()).real
        thrust = np.clip(thrust, -2 * boat.astern * boat.thrust, 2 * boat.thrust)
        each = thrust - drag(boat.surge, through.real) - 1j * drag(boat.sway, through.imag)
        total = (each * bow * touching).sum(axis=1)
        boats = boat.masses[0] * touching.sum(axis=1)
        linear = self._linear(memory, total, boats)
        return np.stack([linear.real, linear.imag, 0.0 * boats], axis=-1)

    def acceleration(self, memory: VesselMemory) -> Float:
        """Returns the acceleration (W, 3) by the boats' forces and the drag, m/s^2 and rad/s^2."""
        vessel, motion = self._vessel, memory.motion
        heading = np.exp(1j * motion[:, 2])
        velocity, yaw_rate = (plane(motion, 3) - memory.drift) * heading.conj(), motion[:, 5]
        (m_surge, m_sway, inertia), u, v = vessel.masses, velocity.real, velocity.imag
        yaw = memory.moment - drag(vessel.yaw, yaw_rate) + (m_surge - m_sway) * u * v
        linear = self._linear(memory, memory.force * heading, np.zeros(len(heading)))
        return np.stack([linear.real, linear.imag, yaw / inertia], axis=-1)

    def _linear(self, memory: VesselMemory, force: Complex, more: Float) -> Complex:
        """Returns accelerations (W,), m/s^2, under forces (W,) N, with ``more`` (W,) kg of mass.

        The vectors are those of the world.
        """
        vessel, motion = self._vessel, memory.motion
        heading = np.exp(1j * motion[:, 2])
        velocity, yaw_rate = (plane(motion, 3) - memory.drift) * heading.conj(), motion[:, 5]
        (m_surge, m_sway, _), u, v = vessel.masses, velocity.real, velocity.imag
        force = force * heading.conj()
        surge = force.real - drag(vessel.surge, u) + m_sway * v * yaw_rate
        sway = force.imag - drag(vessel.sway, v) - m_surge * u * yaw_rate
        over_ground = 1j * yaw_rate * velocity  # The hull's frame turns with the hull.
        linear = surge / (m_surge + more) + 1j * sway / (m_sway + more)
        return heading * (linear + over_ground)


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
