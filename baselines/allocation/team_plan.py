"""What a team decides before it moves: who goes where, who is there, and which way the vessel goes.

Boats get contact points when an episode begins and when one of them fails, and teams of two for
every manoeuvre. When all are in place the team has grasped the vessel. It then drives it on its
direct path, along the axis of the formation or against it, among obstacles leg by leg.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from asv_env.params import EnvParams
from asv_env.tasks.formation import Relations
from asv_env.types import Bool, Complex, Float, Int, Sensed, put_rows, rows, zeros
from baselines.allocation.allocation_gains import AllocationGains, ManoeuvreGains
from baselines.allocation.boats import Boats
from baselines.allocation.contact_approach import ContactApproach
from baselines.allocation.contact_points import PAIR, WEAK, columns, effort, gyration, needed
from baselines.allocation.direct_path import Course, DirectPath, Limits
from baselines.allocation.manoeuvres import REST, ManoeuvreMemory, Manoeuvres, Pose
from baselines.allocation.pushes import Pushes
from baselines.allocation.waypoints import Way, Waypoints

IN_PLACE = (0.03, 0.85)  #: distance to its point, m, and cosine, at which a boat gets in place
OUT_OF_PLACE = (0.08, 0.6)  #: distance and cosine at which it is no longer in place
WAITS_FOR = 0.03  #: distance over which the team slows down for a boat before it is out of place, m


@dataclass
class TeamPlan:
    """What the team has decided."""

    place: Complex  #: (W, A) where boats touch the hull, vessel frame, m
    inward: Complex  #: (W, A) how they point there
    number: Int  #: (W, A) numbers of their points in the formation
    working: Bool  #: (W, A) boats that worked
    in_place: Bool  #: (W, A)
    grasped: Bool  #: (W,) whether boats have pushed since points were assigned
    waiting: Int  #: (W,) ticks for which a boat has been missing
    pair: Bool  #: (W,) whether the team is one of two boats, which go by manoeuvres
    manoeuvre: ManoeuvreMemory
    way: Way  #: of the vessel among obstacles
    course: Course
    limits: Limits
    lacking: Bool  #: (W,) worlds that lacked contact points at the last tick


def empty_plan(worlds: int, team: int) -> dict[str, Any]:
    """Returns the fields of a plan to be filled when episodes begin."""
    world, boats = (worlds,), (worlds, team)
    course = zeros(Course, *[world] * 8)
    course.axis[:] = 1.0
    return {
        "place": np.zeros(boats, dtype=np.complex128),
        "inward": np.ones(boats, dtype=np.complex128),
        "number": np.zeros(boats, dtype=np.int64),
        "working": np.zeros(boats, dtype=np.bool_),
        "in_place": np.zeros(boats, dtype=np.bool_),
        "grasped": np.zeros(world, dtype=np.bool_),
        "waiting": np.zeros(world, dtype=np.int64),
        "pair": np.zeros(world, dtype=np.bool_),
        "manoeuvre": ManoeuvreMemory.empty(worlds, team),
        "way": Way.empty(worlds),
        "course": course,
        "limits": zeros(Limits, *[world] * 4),
        "lacking": np.zeros(world, dtype=np.bool_),
    }


class Decided(NamedTuple):
    """What follows for a tick."""

    boats: Boats  #: round a hull that moves as it is estimated to
    begins: Bool  #: (W,) worlds whose boats have new contact points
    moves: Bool  #: (W,) worlds whose teams move the vessel
    share: Float  #: (W,) fraction of its speeds with which they do, so that boats keep up
    goal: Complex  #: (W,) what the direct path leads to, vessel frame, m
    turn: Float  #: (W,) heading there, vessel frame, rad
    last: Bool  #: (W,) whether that is the goal, and no waypoint
    rest: Pose | None  #: the goal when vessels of teams of two have come to rest, if there are such


class TeamPlanner:
    """Decides for the teams of an environment; all worlds have the nominal scale."""

    def __init__(
        self, params: EnvParams, gains: AllocationGains, pair_gains: ManoeuvreGains
    ) -> None:
        vessel, self._boat = params.hulls()
        self._pair_gains = pair_gains
        self._patience = gains.patience * params.clock.control
        self._has_goal, self._gyration = params.definition.has_goal, gyration(vessel)
        self._manoeuvres = Manoeuvres(params, pair_gains)
        self.approach = ContactApproach(params, gains)
        self.path = DirectPath(params, gains)
        self.pushes = Pushes(params, gains, pair_gains, self._manoeuvres)
        among = params.obstacles or params.water.walls is not None
        self.waypoints = Waypoints(params, gains) if among else None

    def lacks(self, sensed: Sensed, plan: TeamPlan, fresh: Bool) -> Bool:
        """Returns the worlds (W,) whose teams have no contact points.

        There is no goal, or it is not final yet; no wrench cone contains what moving the vessel
        takes; or there is no way among obstacles. In the worlds ``fresh`` (W,) an episode begins.
        """
        if not self._has_goal:
            return np.ones(len(sensed.side), dtype=np.bool_)
        plan.way.missing[fresh] = False
        spans = self.approach.spans(sensed.working)
        if self._manoeuvres.pairs.spans:
            spans = spans | (sensed.working.sum(axis=1) == PAIR)
        return ~(spans & sensed.anchored) | plan.way.missing

    def update(
        self,
        relations: Relations,
        drift: Complex,
        sensed: Sensed,
        plan: TeamPlan,
        fresh: Bool,
        lacking: Bool,
    ) -> Decided:
        """Decides for one tick; what is said of the worlds ``lacking`` (W,) means nothing.

        Args:
            relations: of the estimated motion.
            drift: (W,) velocity of the water, m/s, world frame.
            sensed: what the teams know.
            plan: updated in place, but for ``lacking``.
            fresh: (W,) worlds in which an episode begins.
            lacking: (W,) see ``lacks``.
        """
        changed = (plan.working != sensed.working).any(axis=1)
        begins = ~lacking & (fresh | plan.lacking | changed)
        plan.pair = (sensed.working.sum(axis=1) == PAIR) & ~lacking
        rest = self._change(relations, drift, sensed, plan, begins)
        self._assign(relations, sensed, plan, begins)
        plan.working, course = sensed.working.copy(), plan.course
        boats = boats_of(relations, drift, sensed, plan)
        before = plan.grasped
        moves, share = self._gather(boats, sensed.touching[..., 0], plan)
        goal, turn = relations.goal, -relations.heading_error
        grasps, last = plan.grasped & ~before, np.ones_like(before)
        self.path.begin(course, grasps, goal, turn)
        if self.waypoints is not None:
            plan.way.legs[begins] = 0
            plans = (begins | (grasps & ~lacking)) & ~plan.pair
            known = sensed.goal, sensed.obstacle, plan.limits, sensed.working
            self.waypoints.plan(plan.way, relations, *known, plans)
            goal, turn, last = self.waypoints.target(plan.way, course, relations, moves)
        self.path.arrive(course, goal, turn, moves, last)
        if rest is not None:
            self._release(plan, rest, moves)
        return Decided(boats, begins, moves, share, goal, turn, last, rest)

    def _change(
        self, relations: Relations, drift: Complex, sensed: Sensed, plan: TeamPlan, begins: Bool
    ) -> Pose | None:
        """Decides about the manoeuvres of teams of two.

        Args:
            relations: estimated relations.
            drift: (W,) velocity of the water, m/s, world frame.
            sensed: what the teams know.
            plan: updated in place.
            begins: (W,) worlds in which boats get new places, updated in place.

        Returns:
            The goal when their vessels have come to rest, if there are such teams.
        """
        pair = plan.pair
        if not pair.any():
            return None
        own = rows(plan.manoeuvre, pair)
        boats = rows(boats_of(relations, drift, sensed, plan), pair)
        rest = self._manoeuvres.rest(rows(relations, pair), drift[pair])
        now = begins[pair], plan.grasped[pair]
        begins[pair] |= self._manoeuvres.update(boats, own, rest, *now)
        put_rows(plan.manoeuvre, pair, own)
        return rest

    def _release(self, plan: TeamPlan, rest: Pose, moves: Bool) -> None:
        """Lets teams of two go where a push is done or lost.

        Args:
            plan: updated in place.
            rest: the goal when their vessels have come to rest.
            moves: (W,) worlds whose boats push.
        """
        pair, own = plan.pair, rows(plan.manoeuvre, plan.pair)
        plan.course.axis[pair] = self.pushes.way(own)
        whole = (plan.in_place | ~plan.working).all(axis=1)
        done = moves[pair] & self.pushes.done(own, rest)
        free = self._manoeuvres.release(own, done, (plan.grasped & ~whole)[pair])
        put_rows(plan.manoeuvre, pair, own)
        plan.grasped[pair] &= ~free
        plan.in_place[pair] &= ~free[:, None]

    def _assign(self, relations: Relations, sensed: Sensed, plan: TeamPlan, which: Bool) -> None:
        """Assigns contact points to the boats that work in the worlds ``which`` (W,)."""
        course, limits = plan.course, plan.limits
        for world in np.flatnonzero(which).tolist():
            works, boat = sensed.working[world], relations.boat[world]
            plan.place[world], plan.inward[world] = boat, 1.0
            if plan.pair[world]:
                kind = min(int(plan.manoeuvre.kind[world]), REST - 1)
                pair = self.approach.assign_pair(boat[works], kind)
                plan.place[world, works], plan.inward[world, works] = pair[:2]
                plan.number[world, works] = pair[2]
                continue
            formation, number = self.approach.assign(boat[works])
            plan.number[world, works] = number
            plan.place[world, works] = formation.place[number]
            plan.inward[world, works] = formation.inward[number]
            course.axis[world] = formation.axis
            for name, value in vars(self.path.limits(formation)).items():
                getattr(limits, name)[world] = value
        for flags in (plan.in_place, plan.grasped, course.arrived, course.holds):
            flags[which] = False
        for rates in (course.speed, course.slide, course.yaw_rate, plan.waiting):
            rates[which] = 0

    def _gather(self, boats: Boats, touches: Bool, plan: TeamPlan) -> tuple[Bool, Float]:
        """Updates which boats are in place, and whether the team grasps the vessel.

        A team waits for boats that are not in place, but no longer than its patience where the
        wrench cone of the others contains what a direct path takes. A team of two pushes once both
        boats have touched the hull (``touches``, (W, A)).

        Returns:
            Worlds (W,) whose teams move the vessel, and the fraction (W,) of its speeds with which
            they do, so that boats keep up.
        """
        gap, working, pair, own = boats.gap, boats.working, plan.pair, plan.manoeuvre
        ahead = np.where(pair, self._pair_gains.standoff, 0.0)[:, None]
        plan.in_place = in_place(gap, boats.alignment, plan.in_place, ahead) & working
        whole = (plan.in_place | ~working).all(axis=1)
        plan.waiting = np.where(whole, 0, plan.waiting + 1)
        late = np.flatnonzero(plan.waiting > self._patience)
        ready: Bool = np.array(whole)
        if len(late):
            ready[late] = self._spanned(plan, late)
        ready &= ~(pair & (own.leaving | (own.kind == REST)))
        plan.grasped = plan.grasped | ready
        own.touched = (own.touched | touches) & plan.grasped[:, None]
        engaged = ~pair | (own.touched | ~working).all(axis=1)
        room = (OUT_OF_PLACE[0] - np.abs(gap.imag)) / WAITS_FOR
        slowest = np.where(plan.in_place, np.clip(room, 0.0, 1.0), 1.0).min(axis=1)
        share = np.where(ready, slowest, 0.0)
        return plan.grasped & (share > 0.0) & engaged, share

    def _spanned(self, plan: TeamPlan, worlds: np.ndarray) -> Bool:
        """Returns whether the wrench cones of the boats in place span a direct path, (n,)."""
        place, inward = plan.place[worlds], plan.inward[worlds]
        column = columns(place + inward * self._boat.length / 2, inward, self._gyration)
        wrench = needed(plan.course.axis[worlds])
        column = np.repeat(column[:, None], wrench.shape[1], axis=1)
        pushes = np.repeat(plan.in_place[worlds][:, None], wrench.shape[1], axis=1)
        return np.asarray(effort(column, wrench, pushes).sum(axis=1) < WEAK)


def in_place(gap: Complex, alignment: Float, before: Bool, ahead: Float | float = 0.0) -> Bool:
    """Returns whether boats (W, A) are at their contact points; it takes more to leave them.

    Args:
        gap: from each boat to its point, in the direction of the point, m.
        alignment: cosines of the angles between the boats and these directions.
        before: whether they were there.
        ahead: by how much farther off the hull a boat may be, m.
    """
    far, turned = (
        np.where(before, out, into) for into, out in zip(IN_PLACE, OUT_OF_PLACE, strict=True)
    )
    near = (np.abs(gap.real) < far + ahead) & (np.abs(gap.imag) < far)
    return np.asarray(near & (alignment > turned))


def boats_of(relations: Relations, drift: Complex, sensed: Sensed, plan: TeamPlan) -> Boats:
    """Returns the boats round a hull that moves as it is estimated to, in water that drifts."""
    frame, yaw_rate = relations.heading[:, :1].conj(), relations.yaw_rate[:, :1]
    return Boats(
        position=relations.boat,
        bow=relations.heading[:, 1:] * frame,
        velocity=relations.velocity[:, 1:] * frame,
        hull=relations.velocity[:, :1] * frame + 1j * yaw_rate * relations.boat,
        water=drift[:, None] * frame,
        yaw_rate=yaw_rate,
        place=plan.place,
        inward=plan.inward,
        number=plan.number,
        working=sensed.working,
        seen=sensed.seen[:, 1:],
    )
