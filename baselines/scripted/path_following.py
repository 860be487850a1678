"""The push phase: boats that carry the vessel along a path of arcs to its goal.

The path is planned as the vessel sees the water: a current carries vessel and path alike, and the
path is laid so that they meet the goal when the vessel comes to its end. On the way the boats at
the side exert the force and the moment, those at the ends the force along the hull, that
``steering`` asks for. A vessel that misses its goal goes round again.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from asv_env.geometry import direction, wrap
from asv_env.params import NOMINAL_LENGTH, EnvParams
from asv_env.physics.autopilot import bandwidth
from asv_env.tasks.formation import Relations
from asv_env.types import Bool, Complex, Float
from baselines.paper.arcs import ArcPath
from baselines.scripted.lqr import PreviewSteering, Tolerances
from baselines.scripted.planner import SEGMENTS, Router

FARTHEST = 0.2
"""Offset from the path, lengths of the vessel, and
``MOST_TURNED``, heading error, rad, beyond which they count no more."""
MOST_TURNED = 0.7
MISSED = 0.1
"""Way beyond the goal after which a new path is planned, lengths of the vessel, and
``ASTRAY``, offset from the path at which one is."""
ASTRAY = 0.75
LARGEST_LEAN = 0.3
"""Of a boat at the side towards its place, rad, and
``LARGEST_CARRY``, with the hull that slides along."""
LARGEST_CARRY = 0.6
LARGEST_PRESS = 0.6
"""Of a boat at an end towards the hull, rad, and
``LARGEST_LEAD``, of all that turns it off its slot's direction."""
LARGEST_LEAD = 1.0
UNCAGED_TURN = 0.1
"""Heading error that costs as much as the others where no boat keeps the vessel from skidding."""
SLOWEST = 0.02
"""Speed to which that of a boat is rounded up where a course follows from it, m/s."""
WEAKEST = 1e-3
"""Force to which that of a boat is rounded up where a course follows from it, N."""
TINY = 1e-6


@dataclass(frozen=True)
class PushGains:
    """What the push may be tuned by.

    Attributes:
        pull: force for the speed that the vessel lacks, per mass, 1/s.
        spare: force that boats at the side may always use for the moment, and
        contact: that they exert at least, all together, in parts of the drag at full speed.
        most_force: of the boats at the ends along a hull of 0.40 m, N, and
        grip: of each on it, at least, N.
        spread: of the boats at the side, relative to their slots.
        closing: speed for a gap to the hull, 1/s.
        turning: yaw rate for a heading error, 1/s.
        steer: lean of boats at the side for the distance off their places, rad/m, and
        carry: share that they lean of what would let them slide along with the hull freely.
        sideways: speed of boats at the ends along the hull for that distance, 1/s, and
        skid: share of the skid in a turn that they steer against.
    """

    pull: float = 1.33
    spare: float = 0.6
    contact: float = 0.145
    most_force: float = 5.6e-3
    grip: float = 7e-4
    spread: float = 1.2
    closing: float = 0.2
    turning: float = 4.0
    steer: float = 2.2
    carry: float = 0.32
    sideways: float = 0.23
    skid: float = 1.2


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


@dataclass
class Grip:
    """The hull as a boat meets it at its place.

    Attributes:
        gap: (W, A) from each boat to its place, in the vessel's frame, m.
        does: (W, A) speed of the hull there across, towards -n, and
        slides: (W, A) along +u, m/s.
        yaw_rate: (W, 1) of the vessel, rad/s.
        drag: (W, A) of a boat that goes along across, N, and
        sway: (W, A) its force per sideways speed, kg/s.
    """

    gap: Complex
    does: Float
    slides: Float
    yaw_rate: Float
    drag: Float
    sway: Float


class Conveying:
    """Speed and yaw rate of boats that push the vessel to its goal.

    Args:
        params: of the environment.
        router: plans the paths.
        gains: of the push.
        tolerances: of the vessel on its path.
    """

    def __init__(
        self, params: EnvParams, router: Router, gains: PushGains, tolerances: Tolerances
    ) -> None:
        self._vessel, self._boat = params.hulls()
        self._router, self._gains = router, gains
        across, speed = self._vessel.sway, router.gains.speed
        self._full_drag = (across[0] + across[1] * speed) * speed
        self._caged = PreviewSteering(self._vessel, tolerances)
        self._uncaged = PreviewSteering(
            self._vessel, replace(tolerances, force=0.0, turn=UNCAGED_TURN)
        )

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
        path, carried = self._router.plan(goal, turn), 0.0 * goal
        if (drift[which] != 0).any():
            for _ in range(2):  # The time depends on the path, and that on the time.
                carried = drift[which] * self._router.time(path.total_length)
                path = self._router.plan(goal - carried * heading.conj(), turn)
        start = position + carried
        memory.start[which] = np.stack([start.real, start.imag, np.angle(heading)], axis=-1)
        memory.curvature[which], memory.length[which] = path.curvature, path.length
        memory.way[which], memory.missed[which] = 0.0, False

    def steer(
        self,
        relations: Relations,
        slot: Complex,
        working: Bool,
        drift: Complex,
        memory: PushMemory,
    ) -> tuple[Float, Wrench]:
        """Speed m/s and yaw rate rad/s (W, A, 2) of the boats, and what they exert by it.

        Brings ``memory.way`` and ``memory.missed`` up to date.

        Args:
            relations: of the estimated motion.
            slot: (W, A) of each boat, m.
            working: (W, A) boats whose thrusters work; the others are not reckoned with.
            drift: (W,) velocity of the water, m/s, world frame.
            memory: with the path.
        """
        caging = np.abs(slot.real) > self._vessel.length / 2
        pushing = working & ~caging
        places = self._places(slot, pushing)
        caged = np.asarray((working & caging).any(axis=1))
        wrench = self._wrench(relations, places, pushing, caged, drift, memory)
        grip = self._gripped(relations, places)
        at_side = self._at_side(grip, wrench.ahead)
        at_end = self._at_end(grip, np.sign(places.real), wrench.along)
        speed, lead = np.where(caging, at_end, at_side)
        turn = turn_to(relations, lead - np.pi / 2)
        return np.stack([speed, grip.yaw_rate + self._gains.turning * turn], axis=-1), wrench

    def _places(self, slot: Complex, pushing: Bool) -> Complex:
        """Where boats belong (W, A): those that push, spread as far as the ends allow, m."""
        farthest = np.abs(np.where(pushing, slot.real, 0.0)).max(axis=1, keepdims=True)
        room = self._vessel.length / 2 - self._boat.width
        spread = np.clip(room / np.maximum(farthest, TINY), 1.0, self._gains.spread)
        return np.where(pushing, spread, 1.0) * slot.real + 1j * slot.imag

    def _wrench(
        self,
        relations: Relations,
        places: Complex,
        pushing: Bool,
        caged: Bool,
        drift: Complex,
        memory: PushMemory,
    ) -> Wrench:
        """What the boats are to exert so that the vessel follows its path to rest."""
        vessel, gains = self._vessel, self._gains
        velocity = (relations.velocity[:, 0] - drift) * relations.heading[:, 0].conj()
        speed, yaw_rate = -velocity.imag, relations.yaw_rate[:, 0]
        offset, turned, left, curvature = self._follow(relations, drift, speed, memory)
        aside = np.clip(offset, -FARTHEST * vessel.length, FARTHEST * vessel.length)
        turned = np.clip(turned, -MOST_TURNED, MOST_TURNED)
        deviation = np.stack([aside, turned, velocity.real, yaw_rate], axis=-1)
        wanted = self._uncaged.wrench(speed, deviation, curvature)
        if caged.any():
            wanted = np.where(
                caged[:, None], self._caged.wrench(speed, deviation, curvature), wanted
            )
        most = gains.most_force * vessel.length / NOMINAL_LENGTH
        along, moment = np.clip(wanted[:, 0], -most, most), wanted[:, 1]
        each, moment = self._shared(self._ahead(left, speed), moment, places.real, pushing)
        return Wrench(each, along, moment)

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
        position = relations.position[:, 0] + drift * self._router.time(total - memory.way)
        reference = path.pose_at(memory.way)
        offset = position - (reference[:, 0] + 1j * reference[:, 1])
        offset = offset * direction(-reference[:, 2])
        reached = memory.way - offset.imag
        memory.way = np.clip(reached, 0.0, total)
        turned = wrap(np.angle(relations.heading[:, 0]) - path.pose_at(memory.way)[:, 2])
        astray = np.abs(offset.real) > ASTRAY * length
        memory.missed = astray | (reached - total > MISSED * length)
        ahead = memory.way[:, None] + np.maximum(speed, 0.0)[:, None] * self._caged.ahead
        curvature = path[:, None].curvature_at(ahead)  # Beyond the end, that of a straight.
        return offset.real, turned, total - reached, curvature

    def _ahead(self, left: Float, speed: Float) -> Float:
        """Force (W,) N that brings the vessel to the speed at which it is to be."""
        across, wanted = self._vessel.sway, self._router.speed(left)
        drag = (across[0] + across[1] * wanted) * wanted
        coasts = wanted < self._router.gains.speed
        drag *= np.where(coasts, 1 - self._router.gains.braking, 1.0)
        return drag + self._gains.pull * self._vessel.total_mass * (wanted - speed)

    def _shared(self, ahead: Float, moment: Float, u: Float, pushing: Bool) -> tuple[Float, Float]:
        """Shares force ahead (W,) and moment (W,) out to the boats at the side.

        They can only push. The moment goes first: where it asks for more force than the way
        ahead does, the vessel gets faster. A vessel that is too fast is left alone by them.

        Returns:
            (W, A) force of each boat, N; (W,) the moment that comes about, N m.
        """
        lever = np.where(pushing, u, 0.0)
        pushers = np.maximum(pushing.sum(axis=1), 1)
        levers = np.maximum((lever**2).sum(axis=1), TINY)
        per_moment = pushers * np.maximum(np.abs(lever).max(axis=1), TINY) / levers
        most = np.maximum(ahead, self._gains.spare * self._full_drag) / per_moment
        moment = np.clip(moment, -most, most)
        force = np.maximum(np.maximum(ahead, 0.0), per_moment * np.abs(moment))
        each = (force / pushers)[:, None] - (moment / levers)[:, None] * lever
        contact = (self._gains.contact * self._full_drag / pushers)[:, None]
        surplus = np.minimum(ahead / pushers, 0.0)[:, None]
        each = np.maximum(each, contact) + np.where(surplus < 0, surplus - contact, 0.0)
        each = np.where(pushing, each, 0.0)
        return each, -(each * lever).sum(axis=1)

    def _gripped(self, relations: Relations, places: Complex) -> Grip:
        """The hull as the boats meet it at their places (W, A)."""
        boat = self._boat
        moves = (relations.velocity[:, 0] * relations.heading[:, 0].conj())[:, None]
        yaw_rate = relations.yaw_rate[:, :1]
        does = -moves.imag - yaw_rate * places.real
        slides = moves.real - yaw_rate * places.imag
        drag = (boat.surge[0] + boat.surge[1] * np.abs(does)) * does
        sway = boat.sway[0] + boat.sway[1] * np.abs(slides)
        return Grip(places - relations.boat, does, slides, yaw_rate, drag, sway)

    def _at_side(self, grip: Grip, force: Float) -> tuple[Float, Float]:
        """Speed and lead (W, A) of boats that push: the hull's own, and more by their force.

        The hull takes them along by friction, which hinders its turning; a lean by which their
        thrust would take them along by itself takes some of that away. Too much of it would
        push the vessel sideways.
        """
        gains, boat = self._gains, self._boat
        stiffness = boat.total_mass * bandwidth(boat)  # of the speed loop on board
        needed = boat.total_mass * grip.yaw_rate * grip.does + grip.sway * grip.slides
        turned = np.maximum(force, 0.0) + np.maximum(grip.drag, 0.0)
        turned += grip.sway * np.maximum(grip.does, 0.0)
        carry = gains.carry * needed / np.maximum(turned, WEAKEST)
        lean = np.clip(gains.steer * grip.gap.real, -LARGEST_LEAN, LARGEST_LEAN)
        lean += np.clip(carry, -LARGEST_CARRY, LARGEST_CARRY)
        follow = grip.does + gains.closing * np.maximum(-grip.gap.imag, 0.0)
        return follow * np.cos(lean) + force / stiffness, lean

    def _at_end(self, grip: Grip, end: Float, force: Float) -> tuple[Float, Float]:
        """Speed and lead (W, A) of boats at the ends: they go with the hull and press on it.

        The water carries the hull of a boat that leans off its course sideways, so that a small
        lean presses hard.
        """
        gains, boat = self._gains, self._boat
        ahead = np.maximum(grip.does, SLOWEST)
        course = np.arctan2(grip.slides + gains.sideways * grip.gap.real, ahead)
        skid = boat.total_mass * grip.yaw_rate / max(boat.sway[0], WEAKEST)
        press = np.maximum(-force[:, None] * end, 0.0) + gains.grip
        per_lean = (boat.sway[0] + boat.sway[1] * SLOWEST) * ahead + np.maximum(grip.drag, WEAKEST)
        lean = np.minimum(press / per_lean, LARGEST_PRESS)
        lead = np.clip(course + gains.skid * skid - end * lean, -LARGEST_LEAD, LARGEST_LEAD)
        return grip.does - 2 * gains.closing * grip.gap.imag, lead


def turn_to(relations: Relations, heading: Float) -> Float:
    """Angle (W, A) by which boats have to turn to a heading (W, A) in the vessel's frame."""
    turn = direction(heading) * relations.heading[:, :1] / relations.heading[:, 1:]
    return np.arctan2(turn.imag, turn.real)
