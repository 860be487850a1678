"""The paper's controller in two phases, for all worlds at once.

Approach: every boat spirals to its slot and waits there until the vessel is in conditional
closure (``grasping``). Push: two circular arcs lead to the goal, and the boats carry the vessel
along them (``conveying``). When closure is lost, the boats approach again.

Everything a boat does follows from the measurement that the team shares and from its own slot,
so that each boat can compute its own part. Where the team pushes from the vessel's -n side, the
world is mirrored first.
"""

from __future__ import annotations

from copy import deepcopy
from dataclasses import dataclass

import numpy as np

from asv_env import tracking
from asv_env.formation import relate
from asv_env.geometry import mirrored
from asv_env.params import EnvParams
from asv_env.types import Action, Bool, Observation, Sensed
from baselines.conveying import Conveying, PushGains, PushMemory
from baselines.grasping import GraspGains, Grasping, GraspMemory


@dataclass
class Memory:
    """What the team remembers from tick to tick.

    Attributes:
        pushing: (W,) whether the push has begun.
        grasp: of the approach.
        push: of the push.
    """

    pushing: Bool
    grasp: GraspMemory
    push: PushMemory


class ScriptedPolicy:
    """The scripted baseline, batched and distributed; reads ``Sensed`` only.

    Args:
        params: of the environment; ``action_mode`` must be "tracking".
        grasp: gains of the approach.
        push: gains of the push.

    Raises:
        ValueError: the environment takes thruster actions.
    """

    def __init__(
        self,
        params: EnvParams,
        grasp: GraspGains = GraspGains(),  # noqa: B008 (frozen)
        push: PushGains = PushGains(),  # noqa: B008
    ) -> None:
        if params.action_mode != "tracking":
            raise ValueError(
                f"action_mode = {params.action_mode!r}: the scripted policy speaks "
                "'tracking', forward speed and yaw rate; make the environment with it"
            )
        self._pushes = params.task.name != "approach"
        self._grasping = Grasping(params, grasp)
        self._conveying = Conveying(params, push)

    def act(
        self, sensed: Sensed, observation: Observation, memory: Memory | None, fresh: Bool
    ) -> tuple[Action, Memory]:
        """See ``Policy.act``."""
        flip = np.where(sensed.side < 0, -1.0, 1.0)
        slot = sensed.slot.real + 1j * sensed.slot.imag * flip[:, None]
        relations = relate(
            mirrored(sensed.estimate, flip), mirrored(sensed.goal, flip), slot, np.ones(len(flip))
        )

        if memory is None:
            fresh = np.ones(len(flip), dtype=np.bool_)
            memory = Memory(
                ~fresh, self._grasping.fresh(*slot.shape), self._conveying.fresh(len(flip))
            )
        memory = deepcopy(memory)
        pushing = sensed.closed & self._pushes
        approaches = fresh | (memory.pushing & ~pushing)
        pushes = pushing & (fresh | ~memory.pushing)
        memory.pushing = pushing
        self._grasping.begin(relations, slot, sensed, memory.grasp, approaches)
        self._conveying.begin(relations, memory.push, pushes)

        approach = self._grasping.steer(relations, slot, sensed, memory.grasp)
        push = self._conveying.steer(relations, slot, memory.push)
        wanted = np.where(pushing[:, None, None], push, approach)
        wanted[..., 1] *= flip[:, None]
        action = np.clip(wanted / tracking.SCALE, -1.0, 1.0)
        return action.astype(np.float32), memory
