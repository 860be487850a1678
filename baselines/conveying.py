"""The push phase: a path of arcs to the goal, and boats that carry the vessel along it.

The path is planned as the vessel sees the water: a current carries vessel and path alike, and the
path is laid so that they meet the goal when the vessel comes to its end. On the way the boats at
the side exert the force and the moment, those at the ends the force along the hull, that
``steering`` asks for. Nobody can brake the vessel, so that its speed follows that at which it
coasts past the goal, slow enough to count as delivered. One that misses its goal goes round again.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from asv_env.formation import Relations
from asv_env.geometry import direction, wrap
from asv_env.params import SMALLEST_CAGE, EnvParams
from asv_env.tracking import bandwidth
from asv_env.types import Bool, Complex, Float
from baselines import dubins
from baselines.arcs import ArcPath
from baselines.steering import PreviewSteering, Tolerances

SEGMENTS = 4
SLOWEST = 0.02
"""Speed to which that of a boat is rounded up where a course follows from it, m/s."""
LARGEST_LEAN = 0.3
"""Of a boat at the side, rad, and
``LARGEST_LEAD`` and ``LARGEST_PRESS`` of one at an end: off the slot's direction, and of that
what presses on the hull."""
LARGEST_LEAD = 1.0
LARGEST_PRESS = 0.6
FARTHEST = 0.2
"""Offset from the path, lengths of the vessel, and
``MOST_TURNED``, rad, beyond which deviations count no more."""
MOST_TURNED = 0.7


@dataclass(frozen=True)
class PushGains:
    """What the push may be tuned by.

    Attributes:
        radius: of the widest arcs that are considered, half-lengths of the vessel.
        tightest: of the tightest ones, in parts of that.
        tight: cost of an arc tighter by a half-length, lengths of way.
        runout: straight end of the path, lengths of the vessel, where it is longest.
        short: cost of one shorter by a length, lengths of way.
        speed: of the vessel on its path, m/s.
        braking: share of the speed from which the vessel would coast to the goal.
        passing: speed at the goal, m/s.
        missed: way beyond the goal, lengths of the vessel, after which a new path is planned, and
        astray: offset from the path at which one is.
        pull: force for the speed that the vessel lacks, per mass, 1/s.
        spare: force that boats at the side may always use for the moment, and
        contact: that they exert at least, all together, in parts of the drag at ``speed``.
        most_force: of the boats at the ends along the hull, N, and
        grip: of each on it, at least, N.
        spread: of the boats at the side, relative to their slots.
        closing: speed for a gap to the hull, 1/s.
        turning: yaw rate for a heading error, 1/s.
        sideways: speed of boats at the ends along the hull for the distance off the slot, 1/s.
        steer: heading of boats at the side for it, rad/m.
        skid: share of the skid in a turn that the end boats steer against.
    """

    radius: float = 3.8
    tightest: float = 0.56
    tight: float = 0.516
    runout: float = 0.36
    short: float = 0.8
    speed: float = 0.069
    braking: float = 0.38
    passing: float = 0.00722
    missed: float = 0.1
    astray: float = 0.75
    pull: float = 1.1
    spare: float = 1.04
    most_force: float = 5.6e-3
    contact: float = 0.145
    grip: float = 7e-4
    spread: float = 1.2
    closing: float = 0.2
    turning: float = 4.0
    sideways: float = 0.234
    steer: float = 2.23
    skid: float = 1.21
    lean: float = 0.4


@dataclass
class PushMemory:
    """The vessel's path through the water.

    Attributes:
        start: (W, 3) pose where it begins; m, m, rad.
        curvature: (W, n) of its segments, 1/m.
        length: (W, n) of its segments, m; those that are not needed are 0.
        way: (W,) covered on it, m.
        missed: (W,) whether the vessel has left it, and a new one is needed.
    """

    start: Float
    curvature: Float
    length: Float
    way: Float
    missed: Bool


@dataclass
class Wrench:
    """What the boats exert on the vessel.

    Attributes:
        ahead: (W, A) by each boat at the side, along -n, N.
        along: (W,) by those at the ends, along the hull, N.
        moment: (W,) N m.
    """

    ahead: Float
    along: Float
    moment: Float


class Conveying:
    """Speed and yaw rate of boats that push the vessel to its goal."""

    def __init__(self, params: EnvParams, gains: PushGains, tolerances: Tolerances) -> None:
        self._vessel, self._boat = params.hulls()
        self._gains = gains
        if params.num_boats < SMALLEST_CAGE:
            tolerances = replace(tolerances, force=0.0)
        across, speed = self._vessel.sway, gains.speed
        self._cruising_drag = (across[0] + across[1] * speed) * speed
        self._steering = PreviewSteering(self._vessel, tolerances)
        way = np.linspace(0.0, 100 * self._vessel.length, 5000)
        slowness = 1.0 / self._speed(way)
        steps = np.diff(way) * (slowness[1:] + slowness[:-1]) / 2
        self._timetable = way, np.concatenate([[0.0], np.cumsum(steps)])

    def fresh(self, worlds: int) -> PushMemory:
        """Memory to be filled by ``begin``."""
        return PushMemory(
            start=np.zeros((worlds, 3)),
            curvature=np.zeros((worlds, SEGMENTS)),
            length=np.zeros((worlds, SEGMENTS)),
            way=np.zeros(worlds),
            missed=np.zeros(worlds, dtype=np.bool_),
        )

    def begin(self, relations: Relations, drift: Complex, memory: PushMemory, which: Bool) -> None:
        """Plans the paths of some worlds from where their vessels are.

        Args:
            relations: of all worlds.
            drift: (W,) velocity of the water, m/s, world frame.
            memory: receives the paths.
            which: (W,) worlds that need one.
        """
        if not which.any():
            return
        position, heading = relations.position[which, 0], relations.heading[which, 0]
        goal, turn = relations.goal[which], -relations.heading_error[which]
        path, carried = self.plan(goal, turn), 0.0 * goal
        if (drift[which] != 0).any():
            for _ in range(2):  # The time depends on the path, and that on the time.
                carried = drift[which] * self._time(path.total_length)
                path = self.plan(goal - carried * heading.conj(), turn)
        start = position + carried
        memory.start[which] = np.stack([start.real, start.imag, np.angle(heading)], axis=-1)
        memory.curvature[which], memory.length[which] = path.curvature, path.length
        memory.way[which], memory.missed[which] = 0.0, False

    def plan(self, goal: Complex, turn: Float) -> ArcPath:
        """Best of some paths to goals (W,) with headings (W,), in the vessel's frame.

        All are a shortest path of bounded curvature and a straight behind it, on which the
        vessel recovers from the turn and slows down. Wide arcs and long straights are easier to
        follow than tight and short ones: the cost is the way and what these are worth.
        """
        gains, length = self._gains, self._vessel.length
        radii = gains.radius * np.linspace(1.0, gains.tightest, 3)
        runouts = gains.runout * np.linspace(1.0, 0.0, 3)
        radius, runout = (grid.reshape(-1, 1) for grid in np.meshgrid(radii, runouts))
        cost = gains.tight * (radii[0] - radius) + gains.short * (runouts[0] - runout)
        before = goal + 1j * runout * length * direction(turn)
        heading = np.broadcast_to(turn, before.shape)
        poses = np.stack([before.real, before.imag, heading], axis=-1)
        paths = dubins.shortest(poses, radius * length / 2)
        straight = np.broadcast_to(runout * length, before.shape)[..., None]
        ways = np.concatenate([paths.length, straight], axis=-1)
        curvatures = np.concatenate([paths.curvature, np.zeros_like(straight)], axis=-1)
        best = np.argmin(ways.sum(axis=-1) + length * cost, axis=0), np.arange(len(goal))
        return ArcPath(np.zeros(3), curvatures[best], ways[best])

    def steer(
        self, relations: Relations, slot: Complex, drift: Complex, memory: PushMemory
    ) -> tuple[Float, Wrench]:
        """Speed m/s and yaw rate rad/s (W, A, 2) of the boats, and what they exert by it.

        Brings ``memory.way`` and ``memory.missed`` up to date.
        """
        caging = np.abs(slot.real) > self._vessel.length / 2
        places = np.where(caging, slot, self._gains.spread * slot.real + 1j * slot.imag)
        wrench = self._wrench(relations, places, caging, drift, memory)
        gap = places - relations.boat
        does, along = hull_velocity(relations, places)
        at_side = self._at_side(gap, does, along, relations.yaw_rate[:, :1], wrench.ahead)
        at_end = self._at_end(relations, gap, does, along, wrench.along)
        speed, lead = np.where(caging, at_end, at_side)
        yaw_rate = relations.yaw_rate[:, :1] + self._gains.turning * turn_to(
            relations, lead - np.pi / 2
        )
        return np.stack([speed, yaw_rate], axis=-1), wrench

    def _wrench(
        self,
        relations: Relations,
        places: Complex,
        caging: Bool,
        drift: Complex,
        memory: PushMemory,
    ) -> Wrench:
        """What the boats are to exert so that the vessel follows its path to rest."""
        gains, vessel = self._gains, self._vessel
        velocity = (relations.velocity[:, 0] - drift) * relations.heading[:, 0].conj()
        speed, yaw_rate = -velocity.imag, relations.yaw_rate[:, 0]
        offset, turned, left, curvature = self._follow(relations, drift, speed, memory)
        aside = np.clip(offset, -FARTHEST * vessel.length, FARTHEST * vessel.length)
        turned = np.clip(turned, -MOST_TURNED, MOST_TURNED)
        deviation = np.stack([aside, turned, velocity.real, yaw_rate], axis=-1)
        along, moment = self._steering.wrench(speed, deviation, curvature).T

        wanted = self._speed(left)
        drag = (vessel.sway[0] + vessel.sway[1] * wanted) * wanted
        drag *= np.where(wanted < gains.speed, 1 - gains.braking, 1.0)
        ahead = drag + gains.pull * vessel.total_mass * (wanted - speed)
        limit = gains.most_force
        along = np.clip(along, -limit, limit)
        return self._shared(ahead, along, moment, places.real, caging)

    def _follow(
        self, relations: Relations, drift: Complex, speed: Float, memory: PushMemory
    ) -> tuple[Float, Float, Float, Float]:
        """Where the vessel is on its path.

        Returns:
            (W,) offset along the hull, m; (W,) heading error, rad; (W,) way left, m; (W, LOOKS)
            curvature of the path ahead, 1/m.
        """
        path = ArcPath(memory.start, memory.curvature, memory.length)
        total, length = path.total_length, self._vessel.length
        position = relations.position[:, 0] + drift * self._time(total - memory.way)
        reference = path.pose_at(memory.way)
        offset = position - (reference[:, 0] + 1j * reference[:, 1])
        offset = offset * np.exp(-1j * reference[:, 2])
        reached = memory.way - offset.imag
        memory.way = np.clip(reached, 0.0, total)
        turned = wrap(np.angle(relations.heading[:, 0]) - path.pose_at(memory.way)[:, 2])
        astray = np.abs(offset.real) > self._gains.astray * length
        memory.missed = astray | (reached - total > self._gains.missed * length)

        ahead = memory.way[:, None] + np.maximum(speed, 0.0)[:, None] * self._steering.ahead
        curvature = path[:, None].curvature_at(ahead)
        curvature = np.where(ahead < total[:, None], curvature, 0.0)
        return offset.real, turned, total - reached, curvature

    def _shared(
        self, ahead: Float, along: Float, moment: Float, u: Float, caging: Bool
    ) -> Wrench:
        """Shares force ahead (W,) and moment (W,) out to the boats at the side (W, A).

        They can only push. The moment goes first: where it asks for more force than the way
        ahead does, the vessel gets faster.
        """
        gains = self._gains
        lever = np.where(caging, 0.0, u)
        pushers = np.maximum((~caging).sum(axis=1), 1)
        levers = np.maximum((lever**2).sum(axis=1), 1e-6)
        per_moment = pushers * np.maximum(np.abs(lever).max(axis=1), 1e-6) / levers
        most = np.maximum(ahead, gains.spare * self._cruising_drag) / per_moment
        moment = np.clip(moment, -most, most)
        force = np.maximum(np.maximum(ahead, 0.0), per_moment * np.abs(moment))
        each = (force / pushers)[:, None] - (moment / levers)[:, None] * lever
        contact = (gains.contact * self._cruising_drag / pushers)[:, None]
        each = np.maximum(each, contact)
        falls_back = np.minimum(ahead / pushers, 0.0)[:, None]
        each = np.where(falls_back < 0, each - contact + falls_back, each)
        each = np.where(caging, 0.0, each)
        return Wrench(each, along, -(each * lever).sum(axis=1))

    def _at_side(self, gap: Complex, does: Float, along: Float, yaw_rate: Float, force: Float) -> tuple[Float, Float]:
        """Speed and lead (W, A) of boats that push: the hull's own, and more by their force.

        The hull takes them along by friction, and if they leaned much they would push it
        sideways; they only steer for their places.
        """
        gains, boat = self._gains, self._boat
        stiffness = boat.total_mass * bandwidth(boat)  # of the speed loop on board
        lead = np.clip(gains.steer * gap.real, -LARGEST_LEAN, LARGEST_LEAN)
        sway = boat.sway[0] + boat.sway[1] * np.abs(along)
        surge = (boat.surge[0] + boat.surge[1] * np.abs(does)) * does
        need = boat.total_mass * yaw_rate * does + sway * along
        have = np.maximum(force, 0) + np.maximum(surge, 0) + sway * np.maximum(does, 0)
        lead = lead + np.clip(gains.lean * need / np.maximum(have, 1e-3), -.6, .6)
        follow = does + gains.closing * np.maximum(-gap.imag, 0.0)
        return follow * np.cos(lead) + force / stiffness, lead

    def _at_end(
        self, relations: Relations, gap: Complex, does: Float, along: Float, force: Float
    ) -> tuple[Float, Float]:
        """Speed and lead (W, A) of boats at the ends: they go with the hull and press on it.

        The hull of a boat that leans off its course is carried sideways by the water, so that
        a small lean presses hard.
        """
        gains, boat = self._gains, self._boat
        speed = does - 2 * gains.closing * gap.imag
        course = np.arctan2(along + gains.sideways * gap.real, np.maximum(does, SLOWEST))
        skid = boat.total_mass * relations.yaw_rate[:, :1] / max(boat.sway[0], 1e-3)
        inward = np.sign(relations.boat.real) * -1.0
        press = np.maximum(force[:, None] * inward, 0.0) + gains.grip
        surge = np.maximum((boat.surge[0] + boat.surge[1] * np.abs(does)) * does, 1e-3)
        sway = (boat.sway[0] + boat.sway[1] * SLOWEST) * np.maximum(does, SLOWEST)
        lean = inward * np.minimum(press / (surge + sway), LARGEST_PRESS)
        lead = np.clip(course + gains.skid * skid + lean, -LARGEST_LEAD, LARGEST_LEAD)
        return speed, lead

    def _speed(self, left: Float) -> Float:
        """Speed (...) m/s of the vessel at ways (...) in m before its goal."""
        gains = self._gains
        beyond = self._way_to_rest(gains.passing / gains.braking)
        coasting = self._coasting(np.clip(left + beyond, 0.0, 1.0))
        return np.minimum(gains.speed, gains.braking * coasting)

    def _time(self, left: Float) -> Float:
        """Time (...) s that the vessel takes for the way (...) in m that is left."""
        return np.interp(left, *self._timetable)

    def _coasting(self, way: Float) -> Float:
        """Speed (...) from which the vessel comes to rest after a way (...) in m.

        With drag (Y + Yv |v|) v and mass m the way to rest is m/Yv ln(1 + v Yv / Y).
        """
        linear, quadratic = self._vessel.sway
        if quadratic == 0:
            return way * linear / self._vessel.total_mass
        return linear / quadratic * np.expm1(way * quadratic / self._vessel.total_mass)

    def _way_to_rest(self, speed: float) -> float:
        """Inverse of ``_coasting``."""
        linear, quadratic = self._vessel.sway
        if quadratic == 0:
            return speed * self._vessel.total_mass / linear
        return self._vessel.total_mass / quadratic * float(np.log1p(speed * quadratic / linear))


def hull_velocity(relations: Relations, slot: Complex) -> tuple[Float, Float]:
    """Velocity (W, A) of the vessel at each slot: across, towards -n, and along +u, m/s."""
    moves = (relations.velocity[:, 0] * relations.heading[:, 0].conj())[:, None]
    yaw_rate = relations.yaw_rate[:, :1]
    return -moves.imag - yaw_rate * slot.real, moves.real - yaw_rate * slot.imag


def turn_to(relations: Relations, heading: Float) -> Float:
    """Angle (W, A) by which boats have to turn to a heading (W, A) in the vessel's frame."""
    turn = direction(heading) * relations.heading[:, :1] / relations.heading[:, 1:]
    return np.arctan2(turn.imag, turn.real)
