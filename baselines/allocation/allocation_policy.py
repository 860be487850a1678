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
from baselines.allocation.contact_points import columns, gyration
from baselines.allocation.direct_path import Course
from baselines.allocation.force_shares import share
from baselines.allocation.manoeuvres import REST, Pose
from baselines.allocation.team_plan import TeamPlanner
from baselines.mirror import at_scale
from baselines.scripted.helm import Helm
from baselines.scripted.observer import VesselObserver
from baselines.scripted.routes import Routes
from baselines.scripted.scripted_policy import ScriptedPolicy
from baselines.scripted.ways import Way

RECOIL_TIME = 2.0  #: time for which a boat that was kept from its place goes astern, s


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
        vessel, self._boat = params.hulls()
        self._delay, self._gyration = params.sensors.delay, gyration(vessel)
        self._recoil = round(RECOIL_TIME * params.clock.control)
        self._gains, self._pair_gains = gains, pair_gains
        self._helm, self._observer = Helm(params), VesselObserver(params)
        self._contact = Contact(params, gains)
        self._planner = TeamPlanner(params, gains, pair_gains)
        # A boat that meets a vessel at rest then moves it by no more than the speed of a held one.
        masses = vessel.contact_mass + self._boat.masses[0]
        self._closing = params.task.speed_tolerance * masses / self._boat.masses[0]

    def act(
        self, sensed: Sensed, observation: Observation, memory: Memory | None, fresh: Bool
    ) -> tuple[Action, Memory]:
        """See ``Policy.act``."""
        worlds, team = sensed.slot.shape
        if memory is None:
            memory, fresh = Memory.empty(worlds, team), np.ones_like(fresh)
        memory = copied(memory)
        by_script = self._planner.lacks(sensed, memory, fresh)
        action = np.zeros((worlds, team, 2), dtype=np.float32)
        if not by_script.all():
            action = self._allocate(at_scale(sensed, self._shrinking), memory, fresh, by_script)
        if by_script.any():
            given = rows(sensed, by_script), observation[by_script]
            begins = (fresh | ~memory.lacking)[by_script]
            own = memory.of_script(by_script)
            action[by_script], memory.scripted = self._scripted.act(*given, own, begins)
            memory.wanted[by_script] = memory.scripted.wanted
            memory.reference[by_script] = memory.scripted.reference
        memory.lacking = by_script
        return action, memory

    def _allocate(self, sensed: Sensed, memory: Memory, fresh: Bool, lacking: Bool) -> Action:
        """Returns the actions (W, A, 2) of one tick; those of worlds ``lacking`` mean nothing."""
        relations = self._observe(sensed, memory, fresh)
        known = relations, memory.vessel.drift, sensed
        decided = self._planner.update(*known, memory, fresh, lacking)
        boats, touches, course = decided.boats, sensed.touching[..., 0], memory.course
        memory.astern[decided.begins], memory.end[decided.begins] = False, np.nan
        of_pairs = rows(course, memory.pair)
        to = decided.goal, decided.turn, decided.moves, decided.share
        self._planner.path.advance(course, memory.limits, *to)
        if decided.rest is not None:
            self._advance_pairs(of_pairs, relations, memory, decided.rest, decided.moves)
        among = self._among(boats, relations, sensed, memory, ~lacking)
        coming, turns = self._come(boats, touches | sensed.touching[..., 1], memory, among)
        pushes = memory.in_place & memory.grasped[:, None]
        speed, error = self._push(boats, pushes, touches, memory)
        speed, error = np.where(pushes, speed, coming), np.where(pushes, error, turns)
        yaw_rate = self._helm.turn(error) + np.where(pushes, course.yaw_rate[:, None], 0.0)
        memory.wanted = np.stack([speed, yaw_rate], axis=-1) * sensed.working[..., None]
        memory.reference[fresh] = 0.0
        action, memory.reference = self._helm.set_points(memory.wanted, memory.reference)
        return action.astype(np.float32)

    def _advance_pairs(
        self, course: Course, relations: Relations, memory: Memory, rest: Pose, moves: Bool
    ) -> None:
        """Advances the courses of teams of two.

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
        self._planner.pushes.advance(course, own, here, rest, velocity, moves[pair])
        put_rows(memory.course, pair, course)

    def _among(
        self, boats: Boats, relations: Relations, sensed: Sensed, memory: Memory, which: Bool
    ) -> Way | None:
        """Returns the ways of boats among obstacles in the worlds ``which`` (W,), if there are."""
        if self._planner.waypoints is None:
            return None
        coming = which & ~(memory.in_place | ~sensed.working).all(axis=1)
        known = Routes(memory.via, memory.left, memory.end)
        return self._planner.approach.among(boats, relations, sensed, known, coming)

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
        speed, error, memory.astern = self._planner.approach.command(
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

    def _shares(
        self, touch: Complex, sideways: Float, pushes: Bool, water: Complex, memory: Memory
    ) -> Float:
        """Returns the forces (W, A) N of boats that push at points (W, A) m, in the water (W,)."""
        gains, contact = self._gains, self._contact
        force, moment = self._planner.path.wrench(memory.course, water)
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
