"""The reference motion of a vessel that two boats push, and when they let go of it.

Speeds are a fraction of those from which the vessel would coast to the end of the manoeuvre, so
that its boats always push. They let go when it will come to rest there.
"""

import numpy as np

from asv_env.params import EnvParams
from asv_env.types import Bool, Complex, Float
from baselines.allocation.allocation_gains import AllocationGains, ManoeuvreGains
from baselines.allocation.direct_path import Course, axial, axial_drag
from baselines.allocation.manoeuvres import (
    REST,
    SLIDE,
    TURN,
    ManoeuvreMemory,
    Manoeuvres,
    Pose,
)
from baselines.paper.coasting import coasting_rate, terminal_speed

WAYS = np.array([1.0, -1.0, 1.0, 1.0, 1j, -1j])
"""Direction of the reference speed in each manoeuvre, relative to the axis."""
SLOWEST = 0.3  #: least fraction of its speed with which a vessel is driven that has to turn
LEAST_LEVER = 1e-9  #: floor of a divisor, m


class Pushes:
    """Reference motion of vessels in manoeuvres."""

    def __init__(
        self,
        params: EnvParams,
        gains: AllocationGains,
        pair_gains: ManoeuvreGains,
        manoeuvres: Manoeuvres,
    ) -> None:
        self._vessel, boat = params.hulls()
        self._gains, self._pair_gains, self._manoeuvres = gains, pair_gains, manoeuvres
        self._dt = 1.0 / params.clock.control
        self._position = params.task.position_tolerance
        self._heading = params.task.heading_tolerance
        vessel, points = self._vessel, manoeuvres.pairs
        self._way = WAYS * points.axis
        drags = [axial_drag(vessel, way) for way in self._way.tolist()]
        masses = [axial(vessel, way) for way in self._way.tolist()]
        #: (3, 6) linear and quadratic drag, and mass, along the way of each manoeuvre
        self._surge = np.array([*zip(*drags, strict=True), masses])
        self._yaw = (*vessel.yaw, vessel.masses[2])
        thrust = gains.max_force * 2 * boat.thrust
        lever = (points.place.conj() * points.inward).imag
        force = thrust * (points.inward / self._way[:, None]).real.clip(0).sum(axis=1)
        speed = [
            terminal_speed(drag, np.asarray(gains.drive_share * most))
            for drag, most in zip(drags, force, strict=True)
        ]
        self._max_speed = np.minimum(speed, gains.max_speed)
        self._acceleration = force / (self._surge[2] + 2 * boat.masses[0])
        sideways = terminal_speed(boat.sway, np.asarray(gains.turn_share * 2 * boat.thrust))
        depth = np.abs((points.place.conj() * points.inward).real).max(axis=1)
        farthest = np.maximum(np.abs(lever).max(axis=1), LEAST_LEVER)
        self._max_yaw_rate = np.minimum(sideways / depth, gains.max_speed / farthest)
        inertia = vessel.masses[2] + boat.masses[0] * (lever**2).sum(axis=1)
        self._yaw_acceleration = gains.turn_braking * thrust * np.abs(lever).sum(axis=1) / inertia

    def advance(
        self,
        course: Course,
        memory: ManoeuvreMemory,
        pose: Pose,
        rest: Pose,
        velocity: Complex,
        moves: Bool,
    ) -> None:
        """Advances courses by a tick.

        Args:
            course: advanced in place; its axis is the way of the manoeuvre.
            memory: with the manoeuvres.
            pose: of the goal.
            rest: the same when the vessel has come to rest, if boats let go now.
            velocity: (W,) of the vessel in its frame, m/s.
            moves: (W,) worlds whose boats push; elsewhere the reference comes to rest.
        """
        kind = np.minimum(memory.kind, REST - 1)
        slide = (velocity / course.axis).imag
        wanted = self._rates(kind, course.axis, pose, rest[0], slide)
        before = course.speed, course.yaw_rate
        steps = self._dt * self._acceleration[kind], self._dt * self._yaw_acceleration[kind]
        course.speed, course.yaw_rate = (
            was + np.clip(np.where(moves, to, 0.0) - was, -step, step)
            for was, to, step in zip(before, wanted, steps, strict=True)
        )
        course.acceleration = (course.speed - before[0]) / self._dt
        course.yaw_acceleration = (course.yaw_rate - before[1]) / self._dt
        course.slide = np.where(moves, slide, 0.0)  # Boats go along where the vessel slides.

    def way(self, memory: ManoeuvreMemory) -> Complex:
        """Returns the directions (W,) of the reference speeds of manoeuvres, vessel frame."""
        return np.asarray(self._way[np.minimum(memory.kind, REST - 1)])

    def _rates(
        self, kind: Float, axis: Complex, pose: Pose, rest: Complex, slide: Float
    ) -> tuple[Float, Float]:
        """Returns speeds along axes (W,), m/s, and yaw rates (W,), rad/s, that are wanted."""
        gains, own = self._gains, self._pair_gains
        (goal, turn), far = pose, self._manoeuvres.far(rest)
        turning, approaching = (kind >= TURN) & (kind < SLIDE), far & (kind < TURN)
        along, aside = (goal / axis).real, (goal / axis).imag
        speed = own.braking * coasting_rate(self._surge[:, kind], np.maximum(along, 0.0))
        # A vessel that slides does not go where it points.
        beside = aside - own.slide_time * slide
        steer = np.arctan2(beside, np.maximum(along, gains.lookahead * self._vessel.size))
        room = own.turn_bearing - gains.full_bearing
        aligned = np.clip((own.turn_bearing - np.abs(steer)) / room, SLOWEST, 1.0)
        speed = np.where(turning, 0.0, speed * np.where(approaching, aligned, 1.0))
        bearing, _ = self._manoeuvres.bearing(pose)
        angle = np.where(far & turning, bearing, turn)
        yaw_rate = np.sign(angle) * own.turn_braking * coasting_rate(self._yaw, np.abs(angle))
        way = np.where(kind == TURN, 1.0, -1.0)  # Boats at opposite corners turn it one way only.
        yaw_rate = np.where(turning & (angle * way < 0), 0.0, yaw_rate)
        yaw_rate = np.where(approaching, gains.yaw_gain * steer, yaw_rate)
        limit = self._max_yaw_rate[kind]
        return np.minimum(speed, self._max_speed[kind]), np.clip(yaw_rate, -limit, limit)

    def done(self, memory: ManoeuvreMemory, rest: Pose) -> Bool:
        """Returns where (W,) the vessel will come to rest where the manoeuvre is to end."""
        goal, turn = rest
        kind, axis = np.minimum(memory.kind, REST - 1), self.way(memory)
        own, far = self._pair_gains, self._manoeuvres.far(goal)
        bearing, _ = self._manoeuvres.bearing(rest)
        way = np.where(kind % 2 == 0, 1.0, -1.0)
        towards = way * bearing < own.turned_bearing
        turned = np.where(far, towards, way * turn < own.release_error * self._heading)
        driven = (goal / axis).real < own.release_error * self._position
        return np.where((kind >= TURN) & (kind < SLIDE), turned, driven)
