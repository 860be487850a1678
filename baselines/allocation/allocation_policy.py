"""The policy ``allocation``: assigns contact points, moves the vessel, and shares out the force.

All worlds are computed at once, and what happens in one depends on it alone. Everything follows
from what the team knows, so that each boat can compute its own part; with sensors of their own
they do, see ``baselines.distributed``. A world of another scale is shrunk.
"""

from dataclasses import replace

import numpy as np

from asv_env.params import EnvParams
from asv_env.sensing.kalman import predicted
from asv_env.tasks.formation import Relations, relate
from asv_env.types import (
    Action,
    Bool,
    Complex,
    Float,
    Observation,
    Sensed,
    copied,
    put_rows,
    rows,
)
from baselines.allocation.allocation_gains import AllocationGains, ManoeuvreGains
from baselines.allocation.allocation_memory import Memory
from baselines.allocation.boats import Boats
from baselines.allocation.contact import Contact
from baselines.allocation.contact_approach import ContactApproach
from baselines.allocation.contact_points import PAIR, WEAK, columns, effort, gyration, needed
from baselines.allocation.direct_path import Course, DirectPath
from baselines.allocation.force_shares import share
from baselines.allocation.manoeuvres import REST, Manoeuvres, Pose
from baselines.allocation.pushes import Pushes
from baselines.allocation.waypoints import Waypoints
from baselines.mirror import at_scale
from baselines.scripted.helm import Helm
from baselines.scripted.observer import VesselObserver
from baselines.scripted.routes import Routes
from baselines.scripted.scripted_policy import ScriptedPolicy
from baselines.scripted.ways import Way

IN_PLACE = (0.03, 0.85)  #: distance to its point, m, and cosine, at which a boat gets in place
OUT_OF_PLACE = (0.08, 0.6)  #: distance and cosine at which it is no longer in place
RECOIL_TIME = 2.0  #: time for which a boat that was kept from its place goes astern, s
WAITS_FOR = 0.03  #: distance over which the team slows down for a boat before it is out of place, m


class AllocationPolicy:
    """Drives, brakes and turns the vessel by boats on all its sides; reads ``Sensed`` only.

    Two boats do one of these at a time, by ``Manoeuvres``, and let the vessel coast in between.
    Where no wrench cone contains what that takes the policy is ``ScriptedPolicy``: on round hulls,
    with one boat, in tasks without a goal, and until a goal is final that is anchored at closure.

    Args:
        params: parameters of the environment; ``action_mode`` must be "tracking".
        gains: gains of the policy.
        pair_gains: gains of teams of two boats.

    Raises:
        ValueError: the environment takes thruster actions.
    """

    def __init__(
        self,
        params: EnvParams,
        gains: AllocationGains = AllocationGains(),  # noqa: B008 (frozen)
        pair_gains: ManoeuvreGains = ManoeuvreGains(),  # noqa: B008
    ) -> None:
        self._scripted = ScriptedPolicy(params)
        self._shrinking = 1.0 / params.scale
        params = params.rescaled(self._shrinking)
        self._vessel, self._boat = params.hulls()
        self._has_goal = params.definition.has_goal
        self._delay = params.sensors.delay
        self._recoil = round(RECOIL_TIME * params.clock.control)
        self._patience = gains.patience * params.clock.control
        self._gains, self._helm, self._observer = gains, Helm(params), VesselObserver(params)
        self._approach, self._contact = ContactApproach(params, gains), Contact(params, gains)
        self._path, self._gyration = DirectPath(params, gains), gyration(self._vessel)
        self._pair_gains, self._manoeuvres = pair_gains, Manoeuvres(params, pair_gains)
        self._pushes = Pushes(params, gains, pair_gains, self._manoeuvres)
        among = params.obstacles or params.water.walls is not None
        self._waypoints = Waypoints(params, gains) if among else None
        # A boat that meets a vessel at rest then moves it by no more than the speed of a held one.
        masses = self._vessel.contact_mass + self._boat.masses[0]
        self._closing = params.task.speed_tolerance * masses / self._boat.masses[0]

    def act(
        self, sensed: Sensed, observation: Observation, memory: Memory | None, fresh: Bool
    ) -> tuple[Action, Memory]:
        """See ``Policy.act``."""
        worlds, team = sensed.slot.shape
        if memory is None:
            memory, fresh = Memory.empty(worlds, team), np.ones_like(fresh)
        memory = copied(memory)
        memory.way.missing[fresh] = False
        by_script = self._by_script(sensed) | memory.way.missing
        action = np.zeros((worlds, team, 2), dtype=np.float32)
        if not by_script.all():
            action = self._allocate(at_scale(sensed, self._shrinking), memory, fresh, by_script)
        if by_script.any():
            given = rows(sensed, by_script), observation[by_script]
            begins = (fresh | ~memory.by_script)[by_script]
            own = memory.of_script(by_script)
            action[by_script], memory.scripted = self._scripted.act(*given, own, begins)
            memory.wanted[by_script] = memory.scripted.wanted
            memory.reference[by_script] = memory.scripted.reference
        memory.by_script = by_script
        return action, memory

    def _by_script(self, sensed: Sensed) -> Bool:
        """Returns the worlds (W,) in which the scripted policy acts."""
        if not self._has_goal:
            return np.ones(len(sensed.side), dtype=np.bool_)
        spans = self._approach.spans(sensed.working)
        if self._manoeuvres.pairs.spans:
            spans = spans | (sensed.working.sum(axis=1) == PAIR)
        return ~(spans & sensed.anchored)

    def _allocate(self, sensed: Sensed, memory: Memory, fresh: Bool, by_script: Bool) -> Action:
        """Returns the actions (W, A, 2) of one tick; those of worlds ``by_script`` mean nothing."""
        relations = self._observe(sensed, memory, fresh)
        changed = (memory.working != sensed.working).any(axis=1)
        begins = ~by_script & (fresh | memory.by_script | changed)
        memory.pair = (sensed.working.sum(axis=1) == PAIR) & ~by_script
        rest = self._change(relations, sensed, memory, begins)
        self._assign(relations, sensed, memory, begins)
        memory.working, course = sensed.working.copy(), memory.course
        boats, touches = self._boats(relations, sensed, memory), sensed.touching[..., 0]
        before, of_pairs = memory.grasped, rows(course, memory.pair)
        moves, speed_share = self._gather(boats, touches, memory)
        goal, turn = relations.goal, -relations.heading_error
        grasps, last = memory.grasped & ~before, None
        self._path.begin(course, grasps, goal, turn)
        if self._waypoints is not None:
            memory.way.legs[begins], memory.end[begins] = 0, np.nan
            plans = (begins | (grasps & ~by_script)) & ~memory.pair
            known = sensed.goal, sensed.obstacle, memory.limits, sensed.working
            self._waypoints.plan(memory.way, relations, *known, plans)
            goal, turn, last = self._waypoints.target(memory.way, course, relations, moves)
        self._path.advance(course, memory.limits, goal, turn, moves, speed_share, last)
        if rest is not None:
            self._advance_pairs(of_pairs, relations, memory, rest, moves)
        among = self._among(boats, relations, sensed, memory, ~by_script)
        coming, turns = self._come(boats, touches | sensed.touching[..., 1], memory, among)
        pushes = memory.in_place & memory.grasped[:, None]
        speed, error = self._push(boats, pushes, touches, memory)
        speed, error = np.where(pushes, speed, coming), np.where(pushes, error, turns)
        yaw_rate = self._helm.turn(error) + np.where(pushes, course.yaw_rate[:, None], 0.0)
        memory.wanted = np.stack([speed, yaw_rate], axis=-1) * sensed.working[..., None]
        memory.reference[fresh] = 0.0
        action, memory.reference = self._helm.set_points(memory.wanted, memory.reference)
        return action.astype(np.float32)

    def _boats(self, relations: Relations, sensed: Sensed, memory: Memory) -> Boats:
        """Returns the boats round a hull that moves as it is estimated to."""
        frame, yaw_rate = relations.heading[:, :1].conj(), relations.yaw_rate[:, :1]
        return Boats(
            position=relations.boat,
            bow=relations.heading[:, 1:] * frame,
            velocity=relations.velocity[:, 1:] * frame,
            hull=relations.velocity[:, :1] * frame + 1j * yaw_rate * relations.boat,
            water=memory.vessel.drift[:, None] * frame,
            yaw_rate=yaw_rate,
            place=memory.place,
            inward=memory.inward,
            number=memory.number,
            working=sensed.working,
            seen=sensed.seen[:, 1:],
        )

    def _change(
        self, relations: Relations, sensed: Sensed, memory: Memory, begins: Bool
    ) -> Pose | None:
        """Decides about the manoeuvres of teams of two.

        Args:
            relations: estimated relations.
            sensed: what the teams know.
            memory: updated in place.
            begins: (W,) worlds in which boats get new places, updated in place.

        Returns:
            The goal when their vessels have come to rest, if there are such teams.
        """
        pair = memory.pair
        if not pair.any():
            return None
        own, boats = (
            rows(memory.manoeuvre, pair),
            rows(self._boats(relations, sensed, memory), pair),
        )
        rest = self._manoeuvres.rest(rows(relations, pair), memory.vessel.drift[pair])
        now = begins[pair], memory.grasped[pair]
        begins[pair] |= self._manoeuvres.update(boats, own, rest, *now)
        put_rows(memory.manoeuvre, pair, own)
        return rest

    def _advance_pairs(
        self, course: Course, relations: Relations, memory: Memory, rest: Pose, moves: Bool
    ) -> None:
        """Advances the courses of teams of two, and lets go where a push is done or lost.

        Args:
            course: of their worlds.
            relations: estimated relations.
            memory: updated in place.
            rest: the goal when their vessels have come to rest.
            moves: (W,) worlds whose boats push.
        """
        pair, own = memory.pair, rows(memory.manoeuvre, memory.pair)
        here = relations.goal[pair], -relations.heading_error[pair]
        velocity = (relations.velocity[:, 0] * relations.heading[:, 0].conj())[pair]
        done = self._pushes.advance(course, own, here, rest, velocity, moves[pair])
        whole = (memory.in_place | ~memory.working).all(axis=1)
        free = self._manoeuvres.release(own, done, (memory.grasped & ~whole)[pair])
        put_rows(memory.manoeuvre, pair, own)
        put_rows(memory.course, pair, course)
        memory.grasped[pair] &= ~free
        memory.in_place[pair] &= ~free[:, None]

    def _among(
        self, boats: Boats, relations: Relations, sensed: Sensed, memory: Memory, which: Bool
    ) -> Way | None:
        """Returns the ways of boats among obstacles in the worlds ``which`` (W,), if there are."""
        if self._waypoints is None:
            return None
        coming = which & ~(memory.in_place | ~sensed.working).all(axis=1)
        known = Routes(memory.via, memory.left, memory.end)
        return self._approach.among(boats, relations, sensed, known, coming)

    def _come(
        self, boats: Boats, touches: Bool, memory: Memory, among: Way | None
    ) -> tuple[Float, Float]:
        """Returns speeds, m/s, and heading errors, rad, (W, A) of boats that do not push.

        One that touches something (W, A) before it is in place, such as a failed boat that lies
        there, recoils: it would push without being asked to.
        """
        bumps = touches & ~memory.in_place
        memory.recoil = np.where(bumps, self._recoil, np.maximum(memory.recoil - 1, 0))
        own, gains = memory.manoeuvre, self._pair_gains
        apart = np.where(own.kind == REST, gains.rest_gap, gains.standoff)
        standoff = np.where(memory.pair, apart, self._gains.standoff)
        standoff = np.where(memory.grasped, 0.0, standoff)
        wanted = self._moved(boats, memory)
        speed, error, memory.astern = self._approach.command(
            wanted, memory.astern, memory.recoil > 0, standoff, among
        )
        leaves = (memory.pair & own.leaving)[:, None]
        away = (boats.hull / boats.bow).real - gains.leaving_speed
        straight = np.angle(boats.inward / boats.bow)
        return np.where(leaves, away, speed), np.where(leaves, straight, error)

    @staticmethod
    def _moved(boats: Boats, memory: Memory) -> Boats:
        """Returns the boats round a hull that moves by its reference, where it is grasped."""
        course, grasped = memory.course, memory.grasped[:, None]
        wanted = course.velocity[:, None] + 1j * course.yaw_rate[:, None] * boats.position
        yaw_rate = np.where(grasped, course.yaw_rate[:, None], boats.yaw_rate)
        return replace(boats, hull=np.where(grasped, wanted, boats.hull), yaw_rate=yaw_rate)

    def _push(
        self, boats: Boats, pushes: Bool, touches: Bool, memory: Memory
    ) -> tuple[Float, Float]:
        """Returns speeds, m/s, and heading errors, rad, (W, A) of the boats that push (W, A).

        The vessel's memory receives the force and the moment that they exert. Of teams of two boats
        that do not touch the hull (``touches``, (W, A)) exert none, and go to the hull first.
        """
        course, contact, vessel = memory.course, self._contact, memory.vessel
        wanted = self._moved(boats, memory)
        sideways = np.where(
            course.holds[:, None], 0.0, contact.sideways(wanted, course.slide != 0.0)
        )
        along_hull = 1j * boats.inward * boats.gap.imag
        touch = boats.place - along_hull + boats.inward * self._boat.length / 2
        force = self._shares(touch, sideways, pushes, boats.water[:, 0], memory)
        acts = pushes & (touches | ~memory.pair[:, None])
        felt = np.where(acts, contact.felt(wanted, force, boats.hull), 0.0)
        vessel.force = (felt * boats.inward).sum(axis=1)
        vessel.moment = (felt * (touch.conj() * boats.inward).imag).sum(axis=1)
        speed, error = contact.command(wanted, force, sideways, course.holds)
        comes = memory.pair[:, None] & ~memory.manoeuvre.touched
        return np.where(comes, (boats.hull / boats.bow).real + self._closing, speed), error

    def _observe(self, sensed: Sensed, memory: Memory, fresh: Bool) -> Relations:
        """Returns the relations of the estimated motion; slots play no part."""
        vessel = memory.vessel
        self._observer.update(sensed, vessel, memory.grasped)
        self._observer.restart(sensed, vessel, fresh | (sensed.seen[:, 0] & ~vessel.seen))
        vessel.seen = sensed.seen[:, 0].copy()
        motion = sensed.estimate.copy()
        motion[:, 0] = vessel.motion
        motion = predicted(motion, self._delay)
        return relate(motion, sensed.goal, sensed.slot, np.ones(len(motion)))

    def _assign(self, relations: Relations, sensed: Sensed, memory: Memory, which: Bool) -> None:
        """Assigns contact points to the boats that work in the worlds ``which`` (W,)."""
        course, limits = memory.course, memory.limits
        for world in np.flatnonzero(which).tolist():
            works, boat = sensed.working[world], relations.boat[world]
            memory.place[world], memory.inward[world] = boat, 1.0
            if memory.pair[world]:
                kind = min(int(memory.manoeuvre.kind[world]), REST - 1)
                pair = self._approach.assign_pair(boat[works], kind)
                memory.place[world, works], memory.inward[world, works] = pair[:2]
                memory.number[world, works] = pair[2]
                continue
            formation, number = self._approach.assign(boat[works])
            memory.number[world, works] = number
            memory.place[world, works] = formation.place[number]
            memory.inward[world, works] = formation.inward[number]
            course.axis[world] = formation.axis
            for name, value in vars(self._path.limits(formation)).items():
                getattr(limits, name)[world] = value
        for flags in (memory.astern, memory.in_place, memory.grasped, course.arrived, course.holds):
            flags[which] = False
        for rates in (course.speed, course.slide, course.yaw_rate, memory.waiting):
            rates[which] = 0

    def _gather(self, boats: Boats, touches: Bool, memory: Memory) -> tuple[Bool, Float]:
        """Updates which boats are in place, and whether the team grasps the vessel.

        A team waits for boats that are not in place, but no longer than its patience where the
        wrench cone of the others contains what a direct path takes. A team of two pushes once both
        boats have touched the hull (``touches``, (W, A)).

        Returns:
            Worlds (W,) whose teams move the vessel, and the fraction (W,) of its speeds with which
            they do, so that boats keep up.
        """
        gap, working, pair, own = boats.gap, boats.working, memory.pair, memory.manoeuvre
        far = np.where(memory.in_place, OUT_OF_PLACE[0], IN_PLACE[0])
        turned = np.where(memory.in_place, OUT_OF_PLACE[1], IN_PLACE[1])
        ahead = far + np.where(pair, self._pair_gains.standoff, 0.0)[:, None]
        near = (np.abs(gap.real) < ahead) & (np.abs(gap.imag) < far)
        memory.in_place = near & (boats.alignment > turned) & working
        whole = (memory.in_place | ~working).all(axis=1)
        memory.waiting = np.where(whole, 0, memory.waiting + 1)
        late = np.flatnonzero(memory.waiting > self._patience)
        ready: Bool = np.array(whole)
        if len(late):
            ready[late] = self._spanned(memory, late)
        ready &= ~(pair & (own.leaving | (own.kind == REST)))
        memory.grasped = memory.grasped | ready
        own.touched = (own.touched | touches) & memory.grasped[:, None]
        engaged = ~pair | (own.touched | ~working).all(axis=1)
        room = (OUT_OF_PLACE[0] - np.abs(gap.imag)) / WAITS_FOR
        slowest = np.where(memory.in_place, np.clip(room, 0.0, 1.0), 1.0).min(axis=1)
        share = np.where(ready, slowest, 0.0)
        return memory.grasped & (share > 0.0) & engaged, share

    def _spanned(self, memory: Memory, worlds: np.ndarray) -> Bool:
        """Returns whether the wrench cones of the boats in place span a direct path, (n,)."""
        place, inward = memory.place[worlds], memory.inward[worlds]
        column = columns(place + inward * self._boat.length / 2, inward, self._gyration)
        wrench = needed(memory.course.axis[worlds])
        column = np.repeat(column[:, None], wrench.shape[1], axis=1)
        pushes = np.repeat(memory.in_place[worlds][:, None], wrench.shape[1], axis=1)
        return np.asarray(effort(column, wrench, pushes).sum(axis=1) < WEAK)

    def _shares(
        self, touch: Complex, sideways: Float, pushes: Bool, water: Complex, memory: Memory
    ) -> Float:
        """Returns the forces (W, A) N of boats that push at points (W, A) m, in the water (W,)."""
        gains, contact = self._gains, self._contact
        force, moment = self._path.wrench(memory.course, water)
        weight = np.array([1.0, 1.0, gains.moment_weight])
        wrench = np.stack([force.real, force.imag, moment / self._gyration], axis=-1) * weight
        column = columns(touch, memory.inward, self._gyration) * weight
        # What two boats push on top is not taken up by others.
        grips = pushes & ~memory.pair[:, None]
        grip = np.where(grips, contact.grip(sideways, memory.course.holds), 0.0)
        limit = np.where(pushes, gains.max_force * contact.thrust, 0.0)
        least = np.minimum(grip, gains.min_force * contact.thrust)
        rest = wrench - (column * least[..., None]).sum(axis=1)
        return least + share(column, rest, grip - least, np.maximum(limit - least, 0.0))
