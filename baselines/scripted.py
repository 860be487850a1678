"""The paper's controller in two phases, for all worlds at once: wiring of the library's laws.

Approach: every boat spirals to its slot (``braitenberg``), at the speed that brings all of them
there together, and waits there until the vessel is in conditional closure. Push: two circular
arcs lead to the goal (``two_arc``); the boats push with the speeds that turn the vessel about
the circle's centre (``pushing``), corrected by how far it is off the path; the vessel slows
down as it would coast, because boats on one side cannot brake it.

Everything a boat does follows from the measurement that the team shares and from its own slot,
so that each boat can compute its own part. Where the team pushes from the vessel's -n side, the
world is mirrored along the vessel's axis first.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from asv_env import tracking
from asv_env.formation import Relations, relate
from asv_env.geometry import direction, wrap
from asv_env.params import EnvParams
from asv_env.types import Action, Bool, Complex, Float, Int, Observation, Sensed
from baselines import braitenberg, dubins, pushing, two_arc
from baselines.arcs import ArcPath
from baselines.spiral import approach_speed

SEGMENTS = 3


@dataclass(frozen=True)
class Gains:
    """What the controller may be tuned by.

    Attributes:
        sigma: decay of the spiral (Eq 2), rad.
        alpha1: angle of the first arc, rad; None chooses the shortest path.
        cruise: approach speed of the boat with the longest way, m/s.
        push_speed: speed of the vessel on its path, m/s.
        heading: yaw rate asked per rad of heading error, 1/s.
        standoff: gap to the hull in which boats wait for closure, m.
        clearance: of boats' centres from the hull while they pass it, m.
        path_scale: way over which deviations from the path decay, m.
        min_radius: of paths that are planned, vessel half-lengths.
        load: share of the vessel's drag that is fed forward to the pushers.
        closing: speed per distance from the slot, 1/s.
        braking: share of the speed from which the vessel would coast to the goal.
        sideways: course per distance by which a boat is off its slot along the hull, rad/m.
    """

    sigma: float = 0.7
    alpha1: float | None = 1.0
    cruise: float = 0.09
    push_speed: float = 0.05
    heading: float = 3.0
    standoff: float = 0.01
    clearance: float = 0.12
    path_scale: float = 0.22
    min_radius: float = 1.2
    load: float = 1.0
    closing: float = 0.3
    braking: float = 0.85
    sideways: float = 0.45
    ff: float = 0.7
    steer: float = 4.0
    lean: float = 0.1
    slide: float = 0.3
    foresight: float = 0.8
    grip: float = 3.0
    approach_skid: float = 0.7
    docking: float = 0.25
    dock_skid: float = 0.7
    retry: float = 0.15
    turning: float = 2.0


@dataclass
class Memory:
    """What the team remembers from tick to tick.

    Attributes:
        sense: (W, A) direction in which each boat goes round the vessel, 0 or 1.
        astern: (W, A) boats that have missed their slots and go astern to try again.
        due: (W,) tick at which all boats are to arrive.
        pushing: (W,) whether the push has begun.
        start: (W, 3) start of the vessel's path.
        curvature: (W, n) of its segments, 1/m.
        length: (W, n) of its segments, m.
        way: (W,) covered on it, m.
    """

    sense: Int
    astern: Bool
    due: Float
    pushing: Bool
    start: Float
    curvature: Float
    length: Float
    way: Float


class ScriptedPolicy:
    """The scripted baseline, batched and distributed; reads ``Sensed`` only.

    Args:
        params: of the environment; ``action_mode`` must be "tracking".
        gains: what may be tuned.

    Raises:
        ValueError: the environment takes thruster actions.
    """

    def __init__(self, params: EnvParams, gains: Gains | None = None) -> None:
        if params.action_mode != "tracking":
            raise ValueError(
                f"action_mode = {params.action_mode!r}: the scripted policy speaks "
                "'tracking', forward speed and yaw rate; make the environment with it"
            )
        self.params = params
        self.gains = gains or Gains()
        self._vessel, self._boat = params.hulls()
        self._end = self._vessel.length / 2

    def act(
        self, sensed: Sensed, observation: Observation, memory: Memory | None, fresh: Bool
    ) -> tuple[Action, Memory]:
        """See ``Policy.act``."""
        flip = np.where(sensed.side < 0, -1.0, 1.0)
        motion = _mirrored(sensed.estimate, flip)
        goal = _mirrored(sensed.goal, flip)
        slot = sensed.slot.real + 1j * sensed.slot.imag * flip[:, None]
        relations = relate(motion, goal, slot, np.ones(len(flip)))

        memory = self._remember(relations, slot, sensed, memory, fresh)
        approach = self._approach(relations, slot, sensed, memory)
        push = self._push(relations, motion, slot, memory)
        wanted = np.where(memory.pushing[:, None, None], push, approach)
        wanted[..., 1] *= flip[:, None]
        action = np.clip(wanted / tracking.SCALE, -1.0, 1.0)
        return action.astype(np.float32), memory

    # ------------------------------------------------------------------ memory

    def _remember(
        self,
        relations: Relations,
        slot: Complex,
        sensed: Sensed,
        memory: Memory | None,
        fresh: Bool,
    ) -> Memory:
        """Begins approaches in worlds that are fresh or have lost closure, and pushes."""
        worlds, team = slot.shape
        if memory is None:
            fresh = np.ones(worlds, dtype=np.bool_)
            memory = Memory(
                sense=np.zeros((worlds, team), dtype=np.int64),
                astern=np.zeros((worlds, team), dtype=np.bool_),
                due=np.zeros(worlds),
                pushing=np.zeros(worlds, dtype=np.bool_),
                start=np.zeros((worlds, 3)),
                curvature=np.zeros((worlds, SEGMENTS)),
                length=np.zeros((worlds, SEGMENTS)),
                way=np.zeros(worlds),
            )
        memory = Memory(*(getattr(memory, f.name).copy() for f in fields(memory)))
        approaches = fresh | (memory.pushing & ~sensed.closed)
        closed = sensed.closed & (self.params.task.name != "approach")
        pushes = closed & (~memory.pushing | fresh)
        memory.pushing = closed
        self._plan_approach(relations, slot, sensed, memory, approaches)
        for world in np.flatnonzero(pushes):
            self._plan_push(relations, memory, world)
        return memory

    def _plan_approach(
        self, relations: Relations, slot: Complex, sensed: Sensed, memory: Memory, which: Bool
    ) -> None:
        """Which way round each boat goes, and when all are due: the longest way at cruise."""
        where = self._approach_frame(relations.boat, self._waiting(slot))
        memory.sense[which] = braitenberg.approach_direction(*where)[which]
        _, length = braitenberg.approach_heading(*where, direction=memory.sense)
        longest = (length * sensed.working).max(axis=1)
        due = sensed.tick + longest / self.gains.cruise * self.params.clock.control
        memory.due[which] = due[which]
        memory.astern[which] = False

    def _plan_push(self, relations: Relations, memory: Memory, world: int) -> None:
        """The path of the vessel from where it is to its goal."""
        position, heading = relations.position[world, 0], relations.heading[world, 0]
        goal = relations.goal[world]
        turn = -relations.heading_error[world]
        path = self._path(np.array([goal.real, goal.imag, turn]))
        memory.start[world] = position.real, position.imag, np.angle(heading)
        memory.curvature[world] = memory.length[world] = 0.0
        segments = path.length.shape[-1]
        memory.curvature[world, :segments] = path.curvature
        memory.length[world, :segments] = path.length
        memory.way[world] = 0.0

    def _path(self, goal: Float) -> ArcPath:
        """Two arcs where they are feasible and not absurdly long, else a Dubins path."""
        radius = self.gains.min_radius * self._end
        shortest = dubins.shortest(goal, radius)
        if self.gains.alpha1 is None:
            arcs = two_arc.shortest(goal, radius)
        else:
            arcs = two_arc.plan(goal, self.gains.alpha1)
        fits = two_arc.feasible(arcs, radius) and arcs.total_length < 1.5 * shortest.total_length
        return arcs if fits else shortest

    # ------------------------------------------------------------------ approach

    def _waiting(self, slot: Complex) -> Complex:
        """Where boats wait for closure: a little off the side, or in place beside the ends."""
        return np.where(np.abs(slot.real) > self._end, slot, slot + 1j * self.gains.standoff)

    def _approach_frame(self, boat: Complex, slot: Complex) -> tuple[Any, ...]:
        """Arguments that ``braitenberg``'s approach functions share."""
        vessel, gains = self._vessel, self.gains
        return (
            np.stack([boat.real, boat.imag], axis=-1),
            np.stack([slot.real, slot.imag], axis=-1),
            vessel.length,
            vessel.width,
            gains.clearance,
            gains.sigma,
        )

    def _approach(
        self, relations: Relations, slot: Complex, sensed: Sensed, memory: Memory
    ) -> Float:
        """Speed and yaw rate (W, A, 2) on the way to the slots and in wait there."""
        gains, waiting = self.gains, self._waiting(slot)
        frame = self._approach_frame(relations.boat, waiting)
        course, length = braitenberg.approach_heading(*frame, direction=memory.sense)
        time_left = (memory.due - sensed.tick) / self.params.clock.control
        speed = approach_speed(length, time_left[:, None], max_speed=gains.cruise, min_speed=0.02)
        speed = np.minimum(speed, 0.02 + gains.closing * np.abs(waiting - relations.boat))

        gap = waiting - relations.boat
        height, aside = -gap.imag, np.abs(gap.real)
        facing = relations.alignment.real > 0.3
        docks = facing & (height < 0.25) & (aside < 0.012 + 0.3 * np.maximum(height, 0.0))
        missed = facing & ~docks & self._at_hull(relations.boat)
        memory.astern = (memory.astern & (height < gains.retry)) | missed
        docks &= ~memory.astern
        does, along = self._hull_at(relations, slot)
        descent = does + np.clip(gains.docking * height, -0.05, 0.06)
        lead = self._lead(relations, along + gains.sideways * gap.real, descent, gains.dock_skid)
        speed = np.where(docks, descent, np.where(memory.astern, -0.06, speed))
        course = np.where(docks, lead, np.where(memory.astern, 0.0, course + np.pi / 2)) - np.pi / 2

        vessel = relations.heading[:, :1]
        error = _angle(direction(course) * vessel / relations.heading[:, 1:])
        error = wrap(error - gains.approach_skid * _drift(relations) * ~(docks | memory.astern))
        # A boat that faces away turns before it drives off.
        speed = speed * np.where(docks, 1.0, np.clip(1.5 * np.cos(error) - 0.3, 0.0, 1.0))
        return np.stack([speed, gains.turning * error], axis=-1)

    def _at_hull(self, boat: Complex) -> Bool:
        """(W, A) boats so near the pushed side or an end that they had better go astern."""
        reach = self.gains.clearance + 0.06
        beside = np.abs(boat.real) < self._vessel.length / 2 + reach
        return beside & (boat.imag < self._vessel.width / 2 + reach) & (boat.imag > -0.05)

    def _hull_at(self, relations: Relations, slot: Complex) -> tuple[Float, Float]:
        """Velocity (W, A) across and along itself that the vessel has at each slot, m/s."""
        moves = (relations.velocity[:, 0] * relations.heading[:, 0].conj())[:, None]
        yaw_rate = relations.yaw_rate[:, :1]
        return -moves.imag - yaw_rate * slot.real, moves.real - yaw_rate * slot.imag

    def _lead(self, relations: Relations, along: Float, ahead: Float, skid: float) -> Float:
        """Heading (W, A) off the slot's that gives a velocity along the hull, skid allowed for."""
        lead = np.arctan2(along, np.maximum(ahead, 0.03)) - skid * _drift(relations)
        return np.clip(lead, -0.5, 0.5)

    # ------------------------------------------------------------------ push

    def _push(
        self, relations: Relations, motion: Float, slot: Complex, memory: Memory
    ) -> Float:
        """Speed and yaw rate (W, A, 2) that carry the vessel along its path."""
        gains = self.gains
        curvature, speed = self._vessel_command(motion, memory)
        u = slot.real
        caging = np.abs(u) > self._end
        # Eq 16, its component along -n: what the hull ought to do at each slot, and what it does.
        ought = pushing.normal_speeds(u, curvature[:, None], speed[:, None])
        does, along = self._hull_at(relations, slot)
        load = self._load(curvature, speed, u, caging)
        gap = relations.slot_gap
        pushers = ought + load + gains.grip * (ought - does) - gains.closing * np.minimum(gap.imag, 0.0)
        cagers = does - 2 * gains.closing * gap.imag
        forward = np.where(caging, cagers, pushers)

        # Along the hull a boat keeps up with what is before it, skidding outwards in a turn. The
        # hull carries pushers along by friction, and theirs would push it sideways.
        skid = self._boat.total_mass * relations.yaw_rate[:, :1] / self._boat.sway[0]
        lead = np.arctan2(along + gains.slide * gap.real, np.maximum(does, 0.02)) + gains.ff * skid
        pusher_lead = np.clip(gains.lean * lead + gains.steer * gap.real, -0.3, 0.3)
        course = np.where(caging, np.clip(lead, -1.0, 1.0), pusher_lead) - np.pi / 2
        vessel = relations.heading[:, :1]
        error = _angle(direction(course) * vessel / relations.heading[:, 1:])
        yaw_rate = (curvature * speed)[:, None] + gains.heading * error
        return np.stack([forward, yaw_rate], axis=-1)

    def _vessel_command(self, motion: Float, memory: Memory) -> tuple[Float, Float]:
        """Curvature (W,) and speed (W,) that lead the vessel along its path to rest."""
        gains, vessel = self.gains, motion[:, 0]
        path = ArcPath(memory.start, memory.curvature, memory.length)
        reference = path.pose_at(memory.way)
        offset = vessel[:, 0] - reference[:, 0] + 1j * (vessel[:, 1] - reference[:, 1])
        offset = offset * np.exp(-1j * reference[:, 2])
        total = path.total_length
        reached = memory.way - offset.imag
        memory.way = np.clip(reached, 0.0, total)

        turned = wrap(vessel[:, 2] - path.pose_at(memory.way)[:, 2])
        scale = gains.path_scale
        velocity = (vessel[:, 3] + 1j * vessel[:, 4]) * np.exp(-1j * vessel[:, 2])
        sooner = memory.way + gains.foresight * np.maximum(-velocity.imag, 0.0)
        curvature = path.curvature_at(np.minimum(sooner, total - 1e-9))
        curvature = curvature - offset.real / scale**2 - 1.6 * turned / scale
        limit = 1.0 / (0.6 * self._vessel.length)
        curvature = np.clip(curvature, -limit, limit)
        speed = np.minimum(gains.push_speed, self._coasting_speed(total - reached))
        return curvature, speed

    def _coasting_speed(self, way: Float) -> Float:
        """A share of the speed from which the vessel would come to rest after ``way`` m.

        With drag (Y + Yv |v|) v of mass m the way from v to rest is m/Yv ln(1 + v Yv / Y).
        """
        linear, quadratic = self._vessel.sway
        mass = self._vessel.total_mass
        way = np.clip(way, 0.0, 1.0)
        if quadratic == 0:
            return self.gains.braking * way * linear / mass
        return self.gains.braking * linear / quadratic * np.expm1(way * quadratic / mass)

    def _load(self, curvature: Float, speed: Float, u: Float, caging: Bool) -> Float:
        """Speed that a pusher must ask for beyond its own to bear its share of the drag."""
        vessel = self._vessel
        yaw_rate = curvature * speed
        force = (vessel.sway[0] + vessel.sway[1] * speed) * speed
        moment = (vessel.yaw[0] + vessel.yaw[1] * np.abs(yaw_rate)) * yaw_rate
        lever = np.where(caging, 0.0, u)
        spread = np.maximum((lever**2).sum(axis=1), 1e-6)
        share = force / np.maximum((~caging).sum(axis=1), 1)
        thrust = share[:, None] - moment[:, None] * lever / spread[:, None]
        stiffness = self._boat.total_mass / (2 * self._boat.lag)
        return self.gains.load * thrust / stiffness


def _mirrored(pose: Float, flip: Float) -> Float:
    """Poses (W, 3) or motions (W, B, 6) with y, heading, vy, yaw rate times ``flip`` (W,)."""
    signs = np.ones((len(flip), pose.shape[-1]))
    signs[:, [1, 2, 4, 5][: 2 * (pose.shape[-1] // 3)]] = flip[:, None]
    return pose * (signs if pose.ndim == 2 else signs[:, None])


def _angle(z: Complex) -> Float:
    return np.arctan2(z.imag, z.real)


def _drift(relations: Relations) -> Float:
    """(W, A) angle from a boat's heading to its course: boats skid in curves. 0 at rest."""
    velocity = relations.velocity[:, 1:] * relations.heading[:, 1:].conj()
    moving = velocity.real > 0.03
    return np.where(moving, np.arctan2(velocity.imag, np.maximum(velocity.real, 0.03)), 0.0)

