"""The push phase: a path of arcs to the goal, and boats that carry the vessel along it.

The boats at the side push with the speeds that turn the vessel about the centre of its arc
(Eq 16), corrected by what the hull does instead; the boats at the ends keep it from slipping
out. Nobody can brake the vessel, so its speed follows that at which it would coast to the goal.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from asv_env.formation import Relations
from asv_env.geometry import direction, wrap
from asv_env.params import EnvParams
from asv_env.tracking import bandwidth
from asv_env.types import Bool, Complex, Float
from baselines import dubins, pushing, two_arc
from baselines.arcs import ArcPath

SEGMENTS = 3
DETOUR = 1.5
"""Two arcs longer than this many Dubins paths are not taken."""
LEAST_TURN = 1e-6
"""Smallest change of heading for which the angle of the first arc is free, rad."""
DAMPING = 0.8
LARGEST_PUSHER_LEAD = 0.3
LARGEST_CAGER_LEAD = 1.0


@dataclass(frozen=True)
class PushGains:
    """What the push may be tuned by.

    Attributes:
        alpha1: angle of the first arc, rad (the paper's 1); None leaves it to the length.
        min_radius: of the arcs, half-lengths of the vessel; closure bears 1, water asks for more.
        speed: of the vessel on its path, m/s.
        braking: share of the speed from which the vessel would coast to the goal.
        path_scale: way over which deviations from the path decay, m.
        foresight: time by which the arcs are looked ahead, s: the vessel turns slowly.
        load: share of the vessel's drag that is fed forward to the pushers.
        grip: speed asked beyond what Eq (16) wants, per speed that the hull lacks.
        closing: speed for a gap to the hull, 1/s.
        turning: yaw rate for a heading error, 1/s.
        sideways: speed along the hull for the distance off the slot, 1/s.
        steer: heading of a pusher for its distance off the slot, rad/m.
        skid: share of the skid in a turn that the end boats steer against.
    """

    alpha1: float | None = 1.0
    min_radius: float = 2.8
    speed: float = 0.04
    braking: float = 0.85
    path_scale: float = 0.22
    foresight: float = 0.8
    load: float = 1.0
    grip: float = 3.0
    closing: float = 0.3
    turning: float = 3.0
    sideways: float = 0.3
    steer: float = 6.0
    skid: float = 1.0


@dataclass
class PushMemory:
    """The vessel's path.

    Attributes:
        start: (W, 3) pose where it begins; m, m, rad.
        curvature: (W, n) of its segments, 1/m.
        length: (W, n) of its segments, m; those behind the last are 0.
        way: (W,) covered on it, m.
    """

    start: Float
    curvature: Float
    length: Float
    way: Float

    @property
    def path(self) -> ArcPath:
        """The paths of all worlds."""
        return ArcPath(self.start, self.curvature, self.length)


class Conveying:
    """Speed and yaw rate of boats that push the vessel to its goal."""

    def __init__(self, params: EnvParams, gains: PushGains) -> None:
        self._vessel, self._boat = params.hulls()
        self._gains = gains

    def fresh(self, worlds: int) -> PushMemory:
        """Memory to be filled by ``begin``."""
        return PushMemory(
            start=np.zeros((worlds, 3)),
            curvature=np.zeros((worlds, SEGMENTS)),
            length=np.zeros((worlds, SEGMENTS)),
            way=np.zeros(worlds),
        )

    def begin(self, relations: Relations, memory: PushMemory, which: Bool) -> None:
        """Plans the paths of some worlds from where their vessels are."""
        memory.way[which] = 0.0
        memory.curvature[which] = memory.length[which] = 0.0
        for world in np.flatnonzero(which):
            position, heading = relations.position[world, 0], relations.heading[world, 0]
            goal, turn = relations.goal[world], -relations.heading_error[world]
            path = self.plan(np.array([goal.real, goal.imag, turn]))
            segments = path.length.shape[-1]
            memory.start[world] = position.real, position.imag, np.angle(heading)
            memory.curvature[world, :segments] = path.curvature
            memory.length[world, :segments] = path.length

    def plan(self, goal: Float) -> ArcPath:
        """Path to a goal pose (3,) in the vessel's frame.

        Two arcs, the first through ``alpha1``, or else the shortest two; where neither bears the
        radius or both are a long way round, a Dubins path.
        """
        radius = self._gains.min_radius * self._vessel.length / 2
        alpha1, last_resort = self._gains.alpha1, dubins.shortest(goal, radius)
        candidates = [two_arc.shortest(goal, radius)]
        if alpha1 is not None and abs(goal[2]) > LEAST_TURN:  # else it is not free
            candidates.insert(0, two_arc.plan(goal, alpha1))
        for arcs in candidates:
            short = arcs.total_length <= DETOUR * last_resort.total_length
            if short and two_arc.feasible(arcs, radius):
                return arcs
        return last_resort

    def steer(self, relations: Relations, slot: Complex, memory: PushMemory) -> Float:
        """Speed m/s and yaw rate rad/s (W, A, 2); brings ``memory.way`` up to date."""
        gains, gap, u = self._gains, relations.slot_gap, slot.real
        curvature, speed = self._command(relations, memory)
        caging = np.abs(u) > self._vessel.length / 2
        ought = pushing.normal_speeds(u, curvature[:, None], speed[:, None])
        does, along = hull_velocity(relations, slot)

        pushers = ought + gains.grip * (ought - does) + self._load(curvature, speed, u, caging)
        pushers += gains.closing * np.maximum(-gap.imag, 0.0)
        cagers = does - 2 * gains.closing * gap.imag
        lead = self._lead(relations, gap, does, along, caging)
        yaw_rate = (curvature * speed)[:, None] + gains.turning * turn_to(
            relations, lead - np.pi / 2
        )
        return np.stack([np.where(caging, cagers, pushers), yaw_rate], axis=-1)

    def _command(self, relations: Relations, memory: PushMemory) -> tuple[Float, Float]:
        """Curvature (W,) 1/m and speed (W,) m/s that lead the vessel along its path to rest."""
        gains, path = self._gains, memory.path
        total = path.total_length
        reference = path.pose_at(memory.way)
        offset = relations.position[:, 0] - (reference[:, 0] + 1j * reference[:, 1])
        offset = offset * np.exp(-1j * reference[:, 2])
        reached = memory.way - offset.imag
        memory.way = np.clip(reached, 0.0, total)

        heading = np.angle(relations.heading[:, 0])
        turned = wrap(heading - path.pose_at(memory.way)[:, 2])
        ahead = -(relations.velocity[:, 0] * relations.heading[:, 0].conj()).imag
        foreseen = memory.way + gains.foresight * np.maximum(ahead, 0.0)
        curvature = path.curvature_at(np.minimum(foreseen, total - 1e-9))
        scale = gains.path_scale
        curvature = curvature - offset.real / scale**2 - 2 * DAMPING * turned / scale
        limit = 1.0 / (0.6 * self._vessel.length)
        speed = np.minimum(gains.speed, gains.braking * self._coasting(total - reached))
        return np.clip(curvature, -limit, limit), speed

    def _coasting(self, way: Float) -> Float:
        """Speed (W,) from which the vessel comes to rest after a way (W,) in m.

        With drag (Y + Yv |v|) v and mass m the way to rest is m/Yv ln(1 + v Yv / Y).
        """
        linear, quadratic = self._vessel.sway
        mass, way = self._vessel.total_mass, np.clip(way, 0.0, 1.0)
        if quadratic == 0:
            return way * linear / mass
        return linear / quadratic * np.expm1(way * quadratic / mass)

    def _load(self, curvature: Float, speed: Float, u: Float, caging: Bool) -> Float:
        """Speed (W, A) that a pusher asks for beyond its own to bear its share of the drag."""
        vessel, yaw_rate = self._vessel, curvature * speed
        force = (vessel.sway[0] + vessel.sway[1] * speed) * speed
        moment = (vessel.yaw[0] + vessel.yaw[1] * np.abs(yaw_rate)) * yaw_rate
        lever = np.where(caging, 0.0, u)
        levers = np.maximum((lever**2).sum(axis=1), 1e-6)
        pushers = np.maximum((~caging).sum(axis=1), 1)
        thrust = (force / pushers)[:, None] - (moment / levers)[:, None] * lever
        stiffness = self._boat.total_mass * bandwidth(self._boat)  # of the speed loop on board
        return self._gains.load * thrust / stiffness

    def _lead(
        self, relations: Relations, gap: Complex, does: Float, along: Float, caging: Bool
    ) -> Float:
        """Heading (W, A) off that of the slots with which boats keep up along the hull.

        The hull takes pushers along by friction, and if they leaned they would push it sideways;
        they only steer for their slots. The end boats have to follow by themselves.
        """
        gains = self._gains
        skid = self._boat.total_mass * relations.yaw_rate[:, :1] / max(self._boat.sway[0], 1e-3)
        lead = np.arctan2(along + gains.sideways * gap.real, np.maximum(does, 0.02))
        cagers = np.clip(lead + gains.skid * skid, -LARGEST_CAGER_LEAD, LARGEST_CAGER_LEAD)
        pushers = np.clip(gains.steer * gap.real, -LARGEST_PUSHER_LEAD, LARGEST_PUSHER_LEAD)
        return np.where(caging, cagers, pushers)


def hull_velocity(relations: Relations, slot: Complex) -> tuple[Float, Float]:
    """Velocity (W, A) of the vessel at each slot: across, towards -n, and along +u, m/s."""
    moves = (relations.velocity[:, 0] * relations.heading[:, 0].conj())[:, None]
    yaw_rate = relations.yaw_rate[:, :1]
    return -moves.imag - yaw_rate * slot.real, moves.real - yaw_rate * slot.imag


def turn_to(relations: Relations, heading: Float) -> Float:
    """Angle (W, A) by which boats have to turn to a heading (W, A) in the vessel's frame."""
    turn = direction(heading) * relations.heading[:, :1] / relations.heading[:, 1:]
    return np.arctan2(turn.imag, turn.real)
