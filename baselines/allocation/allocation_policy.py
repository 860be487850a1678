"""The policy ``allocation``: assigns contact points, moves the vessel, and shares out the force.

All worlds are computed at once, and what happens in one depends on it alone. Everything follows
from what the team knows, so that each boat can compute its own part; with sensors of their own
they do, see ``baselines.distributed``. A world of another scale is shrunk.
"""

from copy import deepcopy
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from asv_env.params import EnvParams
from asv_env.sensing.kalman import predicted
from asv_env.tasks.formation import Relations, relate
from asv_env.types import Action, Bool, Complex, Float, Int, Observation, Sensed, zeros
from baselines.allocation.allocation_gains import AllocationGains
from baselines.allocation.boats import Boats
from baselines.allocation.contact import Contact
from baselines.allocation.contact_approach import ContactApproach
from baselines.allocation.contact_points import WEAK, columns, effort, gyration, needed
from baselines.allocation.direct_path import Course, DirectPath, Limits
from baselines.allocation.force_shares import share
from baselines.mirror import at_scale
from baselines.scripted.helm import Helm
from baselines.scripted.observer import VesselMemory, VesselObserver
from baselines.scripted.scripted_policy import ScriptedPolicy

IN_PLACE = (0.03, 0.85)  #: distance to its point, m, and cosine, at which a boat gets in place
OUT_OF_PLACE = (0.08, 0.6)  #: distance and cosine at which it is no longer in place
WAITS_FOR = 0.03  #: distance over which the team slows down for a boat before it is out of place, m


@dataclass
class Memory:
    """What the team remembers from tick to tick."""

    wanted: Float  #: (W, A, 2) speeds and yaw rates that the boats are to have, m/s and rad/s
    reference: Float  #: (W, A, 2) of the boats' autopilots, m/s and rad/s
    vessel: VesselMemory
    course: Course
    limits: Limits
    place: Complex  #: (W, A) where boats touch the hull, vessel frame, m
    inward: Complex  #: (W, A) how they point there
    number: Int  #: (W, A) numbers of their points in the formation
    working: Bool  #: (W, A) boats that worked
    in_place: Bool  #: (W, A)
    astern: Bool  #: (W, A) boats that have missed their points and go astern to try again
    grasped: Bool  #: (W,) whether boats have pushed since points were assigned
    waiting: Int  #: (W,) ticks for which a boat has been missing
    by_script: Bool  #: (W,) worlds in which the scripted policy acts
    scripted: Any  #: its memory; None as long as it has not acted

    @classmethod
    def empty(cls, worlds: int, team: int) -> Self:
        """Returns memory to be filled when episodes begin."""
        world, boats = (worlds,), (worlds, team)
        course = zeros(Course, *[world] * 8)
        course.axis[:] = 1.0
        return cls(
            wanted=np.zeros((*boats, 2)),
            reference=np.zeros((*boats, 2)),
            vessel=VesselMemory.empty(worlds, team),
            course=course,
            limits=zeros(Limits, *[world] * 4),
            place=np.zeros(boats, dtype=np.complex128),
            inward=np.ones(boats, dtype=np.complex128),
            number=np.zeros(boats, dtype=np.int64),
            working=np.zeros(boats, dtype=np.bool_),
            in_place=np.zeros(boats, dtype=np.bool_),
            astern=np.zeros(boats, dtype=np.bool_),
            grasped=np.zeros(world, dtype=np.bool_),
            waiting=np.zeros(world, dtype=np.int64),
            by_script=np.zeros(world, dtype=np.bool_),
            scripted=None,
        )


class AllocationPolicy:
    """Drives, brakes and turns the vessel by boats on all its sides; reads ``Sensed`` only.

    Where that cannot be done the policy is ``ScriptedPolicy``: in tasks without a goal, until a
    goal is final that is anchored at closure, and for teams whose wrench cone does not contain
    what a direct path takes, as with two boats or round hulls.

    Args:
        params: parameters of the environment; ``action_mode`` must be "tracking".
        gains: gains of the policy.

    Raises:
        ValueError: the environment takes thruster actions.
    """

    def __init__(self, params: EnvParams, gains: AllocationGains = AllocationGains()) -> None:  # noqa: B008
        self._scripted = ScriptedPolicy(params)
        self._shrinking = 1.0 / params.scale
        params = params.rescaled(self._shrinking)
        self._vessel, self._boat = params.hulls()
        self._has_goal = params.definition.has_goal
        self._delay = params.sensors.delay
        self._patience = gains.patience * params.clock.control
        self._gains, self._helm, self._observer = gains, Helm(params), VesselObserver(params)
        self._approach, self._contact = ContactApproach(params, gains), Contact(params, gains)
        self._path, self._gyration = DirectPath(params, gains), gyration(self._vessel)

    def act(
        self, sensed: Sensed, observation: Observation, memory: Memory | None, fresh: Bool
    ) -> tuple[Action, Memory]:
        """See ``Policy.act``."""
        worlds, team = sensed.slot.shape
        if memory is None:
            memory, fresh = Memory.empty(worlds, team), np.ones_like(fresh)
        memory = deepcopy(memory)
        by_script = self._by_script(sensed)
        action = np.zeros((worlds, team, 2), dtype=np.float32)
        if not by_script.all():
            action = self._allocate(at_scale(sensed, self._shrinking), memory, fresh, by_script)
        if by_script.any():
            begins = fresh | ~memory.by_script
            given = sensed, observation, memory.scripted, begins
            scripted, memory.scripted = self._scripted.act(*given)
            action[by_script] = scripted[by_script]
        memory.by_script = by_script
        return action, memory

    def _by_script(self, sensed: Sensed) -> Bool:
        """Returns the worlds (W,) in which the scripted policy acts."""
        if not self._has_goal:
            return np.ones(len(sensed.side), dtype=np.bool_)
        return ~(self._approach.spans(sensed.working) & sensed.anchored)

    def _allocate(self, sensed: Sensed, memory: Memory, fresh: Bool, by_script: Bool) -> Action:
        """Returns the actions (W, A, 2) of one tick; those of worlds ``by_script`` mean nothing."""
        relations = self._observe(sensed, memory, fresh)
        changed = (memory.working != sensed.working).any(axis=1)
        self._assign(relations, sensed, memory, ~by_script & (fresh | memory.by_script | changed))
        memory.working, course = sensed.working.copy(), memory.course
        boats = self._boats(relations, sensed, memory)
        before, speed_share = memory.grasped, self._gather(boats, memory)
        goal, turn = relations.goal, -relations.heading_error
        self._path.begin(course, memory.grasped & ~before, goal, turn)
        moving = memory.grasped & (speed_share > 0.0)
        self._path.advance(course, memory.limits, goal, turn, moving, speed_share)
        coming, turns, memory.astern = self._approach.command(
            self._moved(boats, memory), memory.astern, ~memory.grasped
        )
        pushes = memory.in_place & memory.grasped[:, None]
        speed, error = self._push(boats, pushes, memory)
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

    @staticmethod
    def _moved(boats: Boats, memory: Memory) -> Boats:
        """Returns the boats round a hull that moves by its reference, where it is grasped."""
        course, grasped = memory.course, memory.grasped[:, None]
        wanted = course.velocity[:, None] + 1j * course.yaw_rate[:, None] * boats.position
        yaw_rate = np.where(grasped, course.yaw_rate[:, None], boats.yaw_rate)
        return replace(boats, hull=np.where(grasped, wanted, boats.hull), yaw_rate=yaw_rate)

    def _push(self, boats: Boats, pushes: Bool, memory: Memory) -> tuple[Float, Float]:
        """Returns speeds, m/s, and heading errors, rad, (W, A) of the boats that push (W, A).

        The vessel's memory receives the force and the moment that they exert.
        """
        course, contact, vessel = memory.course, self._contact, memory.vessel
        wanted = self._moved(boats, memory)
        sideways = np.where(
            course.holds[:, None], 0.0, contact.sideways(wanted, course.slide != 0.0)
        )
        along_hull = 1j * boats.inward * boats.gap.imag
        touch = boats.place - along_hull + boats.inward * self._boat.length / 2
        force = self._shares(touch, sideways, pushes, boats.water[:, 0], memory)
        felt = np.where(pushes, contact.felt(wanted, force, boats.hull), 0.0)
        vessel.force = (felt * boats.inward).sum(axis=1)
        vessel.moment = (felt * (touch.conj() * boats.inward).imag).sum(axis=1)
        return contact.command(wanted, force, sideways, course.holds)

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
            formation, number = self._approach.assign(boat[works])
            memory.number[world, works] = number
            memory.place[world], memory.inward[world] = boat, 1.0
            memory.place[world, works] = formation.place[number]
            memory.inward[world, works] = formation.inward[number]
            course.axis[world] = formation.axis
            for name, value in vars(self._path.limits(formation)).items():
                getattr(limits, name)[world] = value
        for flags in (memory.astern, memory.in_place, memory.grasped, course.arrived, course.holds):
            flags[which] = False
        for rates in (course.speed, course.slide, course.yaw_rate, memory.waiting):
            rates[which] = 0

    def _gather(self, boats: Boats, memory: Memory) -> Float:
        """Updates which boats are in place, and whether the team grasps the vessel.

        A team waits for boats that are not in place, but no longer than its patience where the
        wrench cone of the others contains what a direct path takes.

        Returns:
            Fraction (W,) of its speeds with which the vessel is moved, so that boats keep up.
        """
        gap, working = boats.gap, boats.working
        far = np.where(memory.in_place, OUT_OF_PLACE[0], IN_PLACE[0])
        turned = np.where(memory.in_place, OUT_OF_PLACE[1], IN_PLACE[1])
        near = (np.abs(gap.real) < far) & (np.abs(gap.imag) < far)
        memory.in_place = near & (boats.alignment > turned) & working
        whole = (memory.in_place | ~working).all(axis=1)
        memory.waiting = np.where(whole, 0, memory.waiting + 1)
        late = np.flatnonzero(memory.waiting > self._patience)
        ready: Bool = np.array(whole)
        if len(late):
            ready[late] = self._spanned(memory, late)
        begins = ready & ~memory.grasped
        memory.grasped = memory.grasped | begins
        room = (OUT_OF_PLACE[0] - np.abs(gap.imag)) / WAITS_FOR
        slowest = np.where(memory.in_place, np.clip(room, 0.0, 1.0), 1.0).min(axis=1)
        return np.where(ready, slowest, 0.0)

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
        grip = np.where(pushes, contact.grip(sideways, memory.course.holds), 0.0)
        limit = np.where(pushes, gains.max_force * contact.thrust, 0.0)
        least = np.minimum(grip, gains.min_force * contact.thrust)
        rest = wrench - (column * least[..., None]).sum(axis=1)
        return least + share(column, rest, grip - least, np.maximum(limit - least, 0.0))
