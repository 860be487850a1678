"""The paper's controller in two phases, made strong, for all worlds at once.

Approach: every boat spirals to its slot and waits there until the vessel is in conditional
closure (``grasping``). Push: arcs lead to the goal, and the boats carry the vessel along them
(``conveying``). When the grasp is lost, the boats approach again. All the while they estimate
how the vessel moves, and where the water carries it (``observer``).

Everything a boat does follows from the measurement that the team shares and from its own slot,
so that each boat can compute its own part. Where the team pushes from the vessel's -n side, the
world is mirrored first.
"""

from __future__ import annotations

from copy import deepcopy
from dataclasses import dataclass

import numpy as np

from asv_env.params import EnvParams
from asv_env.physics import autopilot
from asv_env.tasks.formation import Relations, relate
from asv_env.types import Action, Bool, Float, Observation, Sensed, put_rows, rows
from baselines.mirror import seen_from
from baselines.scripted.grasp import GraspGains, Grasping, GraspMemory
from baselines.scripted.lqr import Tolerances
from baselines.scripted.observer import Observer, VesselMemory
from baselines.scripted.path_following import Conveying, PushGains, PushMemory
from baselines.scripted.planner import RouteGains, Router

GRASP = 0.3
"""Distance of a boat to its slot beyond which the grasp is lost, lengths of the vessel."""


@dataclass
class Memory:
    """What the team remembers from tick to tick.

    Attributes:
        pushing: (W,) whether the push has begun.
        vessel: what is known of the vessel.
        grasp: of the approach.
        push: of the push.
    """

    pushing: Bool
    vessel: VesselMemory
    grasp: GraspMemory
    push: PushMemory


class ScriptedPolicy:
    """The scripted baseline, batched and distributed; reads ``Sensed`` only.

    Args:
        params: of the environment; ``action_mode`` must be "tracking".
        grasp: gains of the approach.
        push: gains of the push.
        tolerances: of the vessel on its path.
        router: plans the vessel's paths; None plans them by ``RouteGains``.

    Raises:
        ValueError: the environment takes thruster actions.
    """

    def __init__(
        self,
        params: EnvParams,
        grasp: GraspGains = GraspGains(),  # noqa: B008 (frozen)
        push: PushGains = PushGains(),  # noqa: B008
        tolerances: Tolerances = Tolerances(),  # noqa: B008
        router: Router | None = None,
    ) -> None:
        if params.action_mode != "tracking":
            raise ValueError(
                f"action_mode = {params.action_mode!r}: the scripted policy speaks "
                "'tracking', forward speed and yaw rate; make the environment with it"
            )
        self._pushes = params.task.name != "approach"
        self._loose = GRASP * params.vessel.length
        self._observer = Observer(params)
        self._grasping = Grasping(params, grasp)
        router = router or Router(params.hulls()[0], RouteGains())
        self._conveying = Conveying(params, router, push, tolerances)

    def act(
        self,
        sensed: Sensed,
        observation: Observation,
        memory: Memory | None,
        fresh: Bool,
    ) -> tuple[Action, Memory]:
        """See ``Policy.act``."""
        side = np.where(sensed.side < 0, -1.0, 1.0)
        sensed = seen_from(sensed, side)
        if memory is None:
            fresh, memory = np.ones_like(fresh), self._blank(*sensed.slot.shape)
        memory = deepcopy(memory)
        self._observer.update(sensed, memory.vessel, memory.pushing)
        self._observer.begin(sensed, memory.vessel, fresh)
        motion = sensed.estimate.copy()
        motion[:, 0] = memory.vessel.motion
        relations = relate(motion, sensed.goal, sensed.slot, np.ones(len(side)))

        pushing = self._grasped(relations, sensed, memory.pushing & ~fresh) & self._pushes
        approaches = ~pushing & (fresh | memory.pushing)
        pushes = pushing & (fresh | ~memory.pushing | memory.push.missed)
        memory.pushing = pushing
        wanted = np.zeros((*sensed.slot.shape, 2))
        self._approach(relations, sensed, memory, approaches, wanted)
        self._push(relations, sensed, memory, pushes, wanted)
        wanted[..., 1] *= side[:, None]
        action = np.clip(wanted / autopilot.SCALE, -1.0, 1.0)
        return action.astype(np.float32), memory

    def _blank(self, worlds: int, team: int) -> Memory:
        return Memory(
            pushing=np.zeros(worlds, dtype=np.bool_),
            vessel=self._observer.fresh(worlds),
            grasp=self._grasping.fresh(worlds, team),
            push=self._conveying.fresh(worlds),
        )

    def _approach(
        self,
        relations: Relations,
        sensed: Sensed,
        memory: Memory,
        starts: Bool,
        wanted: Float,
    ) -> None:
        """Speeds and yaw rates (W, A, 2) in the worlds that are in this phase."""
        here = np.flatnonzero(~memory.pushing)
        if not len(here):
            return
        relations, sensed, grasp = (
            rows(relations, here),
            rows(sensed, here),
            rows(memory.grasp, here),
        )
        self._grasping.begin(relations, sensed.slot, sensed, grasp, starts[here])
        wanted[here] = self._grasping.steer(relations, sensed.slot, sensed, grasp)
        put_rows(memory.grasp, here, grasp)

    def _push(
        self,
        relations: Relations,
        sensed: Sensed,
        memory: Memory,
        starts: Bool,
        wanted: Float,
    ) -> None:
        """The same in this phase; what the boats exert is told to the observer."""
        force, moment = (
            np.zeros(len(starts), dtype=np.complex128),
            np.zeros(len(starts)),
        )
        here = np.flatnonzero(memory.pushing)
        if len(here):
            relations, drift, path = (
                rows(relations, here),
                memory.vessel.drift[here],
                rows(memory.push, here),
            )
            self._conveying.begin(relations, drift, path, starts[here])
            wanted[here], wrench = self._conveying.steer(
                relations, sensed.slot[here], sensed.working[here], drift, path
            )
            put_rows(memory.push, here, path)
            force[here] = wrench.along - 1j * wrench.ahead.sum(axis=1)
            moment[here] = wrench.moment
        self._observer.expect(memory.vessel, force, moment)

    def _grasped(self, relations: Relations, sensed: Sensed, pushing: Bool) -> Bool:
        """(W,) whether the team can push: from closure on, until a boat is far from its slot."""
        at_hand = (relations.slot_error < self._loose) | ~sensed.working
        return sensed.closed | (pushing & at_hand.all(axis=1))
