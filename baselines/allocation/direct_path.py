"""The direct path: the vessel turns, is driven straight to its goal, and turns to its heading.

It is driven along or against the axis of the formation, whichever takes less turning. Speeds are
those from which the team can still brake in time (Helm's law for turns, here for both), so nothing
is coasted. The path is followed by its state and not by a clock: what is left to go decides.
"""

from dataclasses import dataclass

import numpy as np

from asv_env.geometry import wrap
from asv_env.params import EnvParams, HullParams
from asv_env.types import Bool, Complex, Float
from baselines.allocation.allocation_gains import AllocationGains
from baselines.allocation.contact_points import Formation
from baselines.paper.coasting import drag, terminal_speed

CAPTURE = 1.5  #: distance of the goal from which the vessel turns to its heading, tolerances
NEAR = 2.0  #: distance below which it no longer turns towards a goal that lies aside, tolerances
ASIDE = 0.5  #: slope beyond which the goal lies aside
AGAIN = 3.0  #: distance from the goal at which the vessel is driven again, tolerances
HOLDS = 0.45  #: error of the pose at which the team holds the vessel, tolerances
LETS_GO = 0.8  #: error of the pose at which it moves the vessel again, tolerances
SLOW = (0.005, 0.03)  #: reference speed, m/s, and yaw rate, rad/s, below which it may hold


@dataclass(frozen=True)
class Limits:
    """What a team can do with a vessel; each (...)."""

    speed: Float  #: m/s
    acceleration: Float  #: m/s^2
    yaw_rate: Float  #: rad/s
    yaw_acceleration: Float  #: rad/s^2


@dataclass
class Course:
    """Where a vessel is on its direct path, and its reference motion."""

    axis: Complex  #: (W,) direction in which it is driven, vessel frame
    arrived: Bool  #: (W,) whether it turns to the goal's heading, and no longer towards the goal
    holds: Bool  #: (W,) whether the team holds the vessel where it is
    speed: Float  #: (W,) along the axis, m/s
    slide: Float  #: (W,) across the axis, to its left, m/s
    yaw_rate: Float  #: (W,) rad/s
    acceleration: Float  #: (W,) of the speed, m/s^2
    yaw_acceleration: Float  #: (W,) rad/s^2

    @property
    def velocity(self) -> Complex:
        """Velocity (W,) of the vessel's centre in its frame, m/s."""
        velocity: Complex = self.axis * (self.speed + 1j * self.slide)
        return velocity


class DirectPath:
    """Reference motion of vessels on their direct paths."""

    def __init__(self, params: EnvParams, gains: AllocationGains) -> None:
        self._vessel, self._boat = params.hulls()
        self._gains, self._dt = gains, 1.0 / params.clock.control
        self._position, self._heading = (
            params.task.position_tolerance,
            params.task.heading_tolerance,
        )

    def limits(self, formation: Formation) -> Limits:
        """Returns what a team in a formation can do."""
        gains, boat, vessel, axis = self._gains, self._boat, self._vessel, formation.axis
        thrust = 2 * boat.thrust
        along = (formation.inward * np.conj(axis)).real
        force = gains.max_force * thrust * min(along.clip(0).sum(), -along.clip(None, 0).sum())
        mass = axial(vessel, axis) + boat.masses[0] * (along**2).sum()
        coefficients = axial_drag(vessel, axis)
        speed = terminal_speed(coefficients, np.asarray(gains.drive_share * force))
        lever = (formation.place.conj() * formation.inward).imag
        moment = gains.max_force * thrust * min(lever.clip(0).sum(), -lever.clip(None, 0).sum())
        inertia = vessel.masses[2] + boat.masses[0] * (lever**2).sum()
        sideways = terminal_speed(boat.sway, np.asarray(gains.turn_share * thrust))
        depth = np.abs((formation.place.conj() * formation.inward).real).max()
        yaw_rate = min(sideways / depth, gains.max_speed / np.abs(lever).max())
        return Limits(
            np.minimum(speed, gains.max_speed),
            np.asarray(force / mass),
            np.asarray(yaw_rate),
            np.asarray(gains.turn_braking * moment / inertia),
        )

    def begin(self, course: Course, which: Bool, goal: Complex, turn: Float) -> None:
        """Chooses the way in which vessels are driven, where paths begin (W,)."""
        bearing = np.angle(goal / course.axis)
        opposite = wrap(bearing + np.pi)
        turning = np.abs(bearing) + np.abs(wrap(turn - bearing))
        other = np.abs(opposite) + np.abs(wrap(turn - opposite))
        course.axis = np.where(which & (other < turning), -course.axis, course.axis)
        course.arrived &= ~which

    def arrive(self, course: Course, goal: Complex, turn: Float, moves: Bool, last: Bool) -> None:
        """Decides which vessels have arrived, in place, and drives those again that have left.

        Args:
            course: updated in place.
            goal: (W,) position of the goal, vessel frame, m.
            turn: (W,) heading of the goal in that frame, rad.
            moves: (W,) worlds whose teams move the vessel.
            last: (W,) whether vessels stay there, and turn.
        """
        missed = np.abs(goal) > AGAIN * self._position
        self.begin(course, moves & course.arrived & missed, goal, turn)
        along, aside = (goal / course.axis).real, (goal / course.axis).imag
        distance = np.abs(goal)
        lies_aside = (distance < NEAR * self._position) & (np.abs(aside) > ASIDE * along)
        course.arrived |= moves & last & ((distance < CAPTURE * self._position) | lies_aside)

    def advance(
        self,
        course: Course,
        limits: Limits,
        goal: Complex,
        turn: Float,
        moves: Bool,
        share: Float,
    ) -> None:
        """Advances courses by a tick.

        Args:
            course: advanced in place.
            limits: of each world.
            goal: (W,) position of the goal, vessel frame, m.
            turn: (W,) heading of the goal in that frame, rad.
            moves: (W,) worlds whose teams move the vessel; it is to rest elsewhere.
            share: (W,) fraction of the speeds that is asked for.
        """
        gains = self._gains
        along, aside = (goal / course.axis).real, (goal / course.axis).imag
        distance, ahead = np.abs(goal), gains.lookahead * self._vessel.size
        steered = np.where(distance < ahead, np.maximum(along, ahead), along)
        bearing = np.arctan2(aside, steered)
        self._hold(course, moves, distance, turn)
        free = moves & ~course.holds
        to_turn = np.where(course.arrived, turn, bearing)
        braking = limits.yaw_acceleration
        yaw_rate = towards(to_turn, gains.yaw_gain, braking, limits.yaw_rate)
        room = gains.turn_bearing - gains.full_bearing
        aligned = np.clip((gains.turn_bearing - np.abs(bearing)) / room, 0.0, 1.0)
        to_go = np.where(course.arrived, along, np.maximum(along, 0.0))
        speed = towards(to_go, gains.speed_gain, limits.acceleration, limits.speed)
        speed = speed * np.where(course.arrived, 1.0, aligned)
        slide = np.clip(gains.slide_gain * aside, -gains.slide_speed, gains.slide_speed)
        course.slide = np.where(free & course.arrived, slide, 0.0)
        wanted = np.where(free, speed * share, 0.0), np.where(free, yaw_rate * share, 0.0)
        before = course.speed, course.yaw_rate
        steps = self._dt * limits.acceleration, self._dt * limits.yaw_acceleration
        course.speed, course.yaw_rate = (
            np.where(course.holds, 0.0, was + np.clip(to - was, -step, step))
            for was, to, step in zip(before, wanted, steps, strict=True)
        )
        course.acceleration = (course.speed - before[0]) / self._dt
        course.yaw_acceleration = (course.yaw_rate - before[1]) / self._dt

    def _hold(self, course: Course, moves: Bool, distance: Float, turn: Float) -> None:
        """Decides where the team holds the vessel, whose reference is at rest then."""
        error = np.maximum(distance / self._position, np.abs(turn) / self._heading)
        slow = (np.abs(course.speed) < SLOW[0]) & (np.abs(course.yaw_rate) < SLOW[1])
        good = np.where(course.holds, error < LETS_GO, slow & (error < HOLDS))
        course.holds = moves & course.arrived & good

    def wrench(self, course: Course, water: Complex) -> tuple[Complex, Float]:
        """Returns the force (W,) N, vessel frame, and the moment (W,) N m of reference motions.

        They make up for drag in the ``water`` (W,), m/s, vessel frame, and accelerate the vessel.
        """
        vessel, push = self._vessel, course.axis * course.acceleration
        through = course.axis * course.speed - water
        along = drag(vessel.surge, through.real) + vessel.masses[0] * push.real
        across = drag(vessel.sway, through.imag) + vessel.masses[1] * push.imag
        moment = drag(vessel.yaw, course.yaw_rate) + vessel.masses[2] * course.yaw_acceleration
        return along + 1j * across, moment


def towards(error: Float, gain: float, braking: Float, limit: Float) -> Float:
    """Returns rates (...) at which errors (...) vanish without overshoot.

    Near the goal a rate is proportional to the error, farther away it is that from which the
    constant deceleration ``braking`` ends there, but for the ``limit``.
    """
    size, linear = np.abs(error), braking / gain**2
    fast = np.sqrt(2 * braking * np.maximum(size - linear / 2, linear / 2))
    return np.sign(error) * np.minimum(np.where(size < linear, gain * size, fast), limit)


def axial(hull: HullParams, axis: complex) -> float:
    """Returns the effective mass of a hull that is pushed along an axis and moves along it, kg."""
    surge, sway, _ = hull.masses
    return float(surge * axis.real**2 + sway * axis.imag**2)


def axial_drag(hull: HullParams, axis: complex) -> tuple[float, float]:
    """Returns the coefficients of the drag along an axis of a hull that moves along it."""
    u, w = abs(axis.real), abs(axis.imag)
    linear, quadratic = (
        along * u ** (2 + power) + across * w ** (2 + power)
        for power, (along, across) in enumerate(zip(hull.surge, hull.sway, strict=True))
    )
    return linear, quadratic
