"""The scripted baseline: observes, decides side and phase of every world, and lets it act.

All worlds are computed at once. Everything a boat does follows from what the team knows and from
its own slot, so that each boat can compute its own part; with sensors of their own they do, see
``baselines.distributed``. Where the team pushes from the vessel's -n side, the world is mirrored
first; a world of another scale is shrunk.

The task prescribes the side for the grasp. Where the goal is to be held in water that would carry
the vessel off the boats there, the team then goes round and grasps it from the other side.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from asv_env.params import EnvParams
from asv_env.sensing.kalman import predicted
from asv_env.tasks.formation import relate
from asv_env.types import Action, Bool, Float, Observation, Sensed, copied, put_rows, rows
from baselines.mirror import PushSide, at_scale, mirror_image, view_from
from baselines.scripted.clear_planner import ClearPlanner
from baselines.scripted.docking import GraspMemory
from baselines.scripted.gains import GraspGains, PathGains, PushGains, Tolerances
from baselines.scripted.grasp_controller import GraspController
from baselines.scripted.helm import Helm
from baselines.scripted.observer import VesselMemory, VesselObserver
from baselines.scripted.path_following import PathMemory
from baselines.scripted.planner import PathPlanner
from baselines.scripted.push_controller import PushController

LOST = 0.3  #: distance of a boat to its slot beyond which the grasp is lost, vessel lengths
HELD = 0.2  #: share by which a vessel is held from which on a lost boat does not matter


@dataclass
class Memory:
    """What the team remembers from tick to tick."""

    pushing: Bool  #: (W,) phase of each world: PUSH where true, APPROACH otherwise
    wanted: Float  #: (W, A, 2) motions that boats are to have, m/s and rad/s
    reference: Float  #: (W, A, 2) of the boats' autopilots, m/s and rad/s
    vessel: VesselMemory
    grasp: GraspMemory
    path: PathMemory
    side: Float  #: (W,) from which the team pushes, +1 or -1
    own: PushSide | None  #: how the team stands on that side, where it chooses it


class ScriptedPolicy:
    """The scripted baseline, batched and distributed; reads ``Sensed`` only.

    Args:
        params: parameters of the environment; ``action_mode`` must be "tracking".
        grasp: gains of the approach.
        push: gains of the push.
        tolerances: tolerated deviations of the vessel from its path.
        planner: plans the vessel's paths; None plans them with the default ``PathGains``.
        filtered: whether it acts on filtered motion; else on the latest measurements as they are.

    Raises:
        ValueError: the environment takes thruster actions.
    """

    def __init__(
        self,
        params: EnvParams,
        grasp: GraspGains = GraspGains(),  # noqa: B008 (frozen)
        push: PushGains = PushGains(),  # noqa: B008
        tolerances: Tolerances = Tolerances(),  # noqa: B008
        planner: PathPlanner | None = None,
        filtered: bool = True,
    ) -> None:
        if params.action_mode != "tracking":
            raise ValueError(
                f"action_mode = {params.action_mode!r}: the scripted policy speaks "
                "'tracking', forward speed and yaw rate; make the environment with it"
            )
        self._shrinking, self._params = 1.0 / params.scale, params
        params = params.rescaled(self._shrinking)  # Gains are those of the nominal size.
        self._has_goal = params.definition.has_goal
        self._helm = Helm(params)
        self._lost = LOST * params.vessel.size
        #: age of the measurements, s, for which the motion is predicted
        self._delay = params.sensors.delay
        self._grasp = GraspController(params, grasp)
        planner = planner or PathPlanner(params.hulls()[0], PathGains())
        self._among = None
        if params.obstacles or params.water.walls is not None:
            self._among = ClearPlanner(params, planner.gains, grasp, params.sensors.shared)
        self._push = PushController(params, planner, push, tolerances, self._among)
        self._observer, self._filtered = VesselObserver(params, by_thrust=True), filtered

    def act(
        self, sensed: Sensed, observation: Observation, memory: Memory | None, fresh: Bool
    ) -> tuple[Action, Memory]:
        """See ``Policy.act``."""
        if memory is None:
            memory, fresh = self._empty(*sensed.slot.shape), np.ones_like(fresh)
        memory = copied(memory)
        sensed, switch = self._seen(sensed, memory, fresh)
        side = memory.side
        self._observer.update(sensed, memory.vessel, memory.pushing & ~memory.path.released)
        # What was believed of a vessel that comes into sight is older than its measurement.
        sighted = sensed.seen[:, 0] & ~memory.vessel.seen
        self._observer.restart(sensed, memory.vessel, fresh | sighted | (not self._filtered))
        memory.vessel.seen = sensed.seen[:, 0].copy()
        motion = sensed.measured
        if self._filtered:
            motion = sensed.estimate.copy()
            motion[:, 0] = memory.vessel.motion
        motion = predicted(motion, self._delay)
        relations = relate(motion, sensed.goal, sensed.slot, np.ones(len(side)))

        # A world PUSHes from closure on, or where a failed boat prevents it, until a boat is far
        # from its slot; a vessel is also held by some of the boats.
        held = memory.pushing & (memory.path.held > HELD)
        near = (relations.slot_error < self._lost) | ~sensed.working | ~sensed.seen[:, 1:]
        near |= held[:, None] & (relations.slot_error < 2 * self._lost)
        blocked = self._grasp.blocked(sensed, memory.grasp)
        lets_go = memory.path.lets_go & memory.pushing & ~fresh
        pushes_on = (memory.pushing | blocked) & ~(fresh | switch | lets_go) & near.all(axis=1)
        pushing = (sensed.closed | pushes_on) & self._has_goal
        begins = fresh | lets_go | (pushing != memory.pushing)
        memory.pushing = pushing
        command = np.zeros((*sensed.slot.shape, 2))
        approach, push = (self._grasp, memory.grasp, ~pushing), (self._push, memory.path, pushing)
        phases: list[Any] = [approach, push]
        for phase, own, where in phases:
            if where.any():
                records = relations, sensed, memory.vessel, own
                here = [rows(record, where) for record in records]
                command[where] = phase.act(*here, begins[where])
                put_rows(memory.vessel, where, here[2])
                put_rows(own, where, here[3])
        command[..., 1] *= side[:, None]
        memory.wanted = command
        memory.reference[fresh] = 0.0
        before = memory.reference
        action, memory.reference = self._helm.set_points(command, before)
        self._observer.command(memory.vessel, before, memory.reference)
        return action.astype(np.float32), memory

    def _empty(self, worlds: int, team: int) -> Memory:
        """Returns memory of worlds in which nothing has happened yet."""
        return Memory(
            np.zeros(worlds, dtype=bool),
            np.zeros((worlds, team, 2)),
            np.zeros((worlds, team, 2)),
            VesselMemory.empty(worlds, team),
            GraspMemory.empty(worlds, team),
            PathMemory.empty(worlds, self._among is not None),
            np.ones(worlds),
            None,
        )

    def _seen(self, sensed: Sensed, memory: Memory, fresh: Bool) -> tuple[Sensed, Bool]:
        """Returns what a team that pushes from the +n side would sense, and where it switches (W,).

        The task prescribes the side. Among obstacles the team chooses it when an episode begins.
        It switches to the other side where its path, or the water at its goal, asks for it.
        """
        prescribed = np.where(sensed.side < 0, -1.0, 1.0)
        if not self._params.sensors.shared or not self._has_goal:  # Boats had to agree on it.
            memory.side, memory.path.switch[:] = prescribed, False
            seen = mirror_image(at_scale(sensed, self._shrinking), prescribed)
            return seen, np.zeros_like(fresh)
        memory.side[fresh] = prescribed[fresh]
        if self._among is not None and fresh.any():
            here = rows(at_scale(sensed, self._shrinking), fresh)
            here = mirror_image(here, prescribed[fresh])
            other = self._among.sides(here.measured[:, 0, :3], here.goal, here.obstacle)
            memory.side[fresh] = np.where(other, -1.0, 1.0) * prescribed[fresh]
        switch = memory.path.switch & memory.pushing & ~fresh
        memory.side[switch] *= -1.0
        memory.path.switch[:] = False
        if switch.any():  # What is remembered is that of the mirror image from now on.
            memory.vessel.turn(switch)
        changes = fresh | switch
        seen, memory.own = view_from(self._params, sensed, memory.own, changes, memory.side)
        return at_scale(replace(seen, side=memory.side.copy()), self._shrinking), switch


def unfiltered(params: EnvParams) -> ScriptedPolicy:
    """Returns the scripted policy without its filters, to find out what they are worth."""
    return ScriptedPolicy(params, filtered=False)
