"""The scripted policy in a hurry: whom the learner imitates first.

It takes the vessel from the side away from the goal, on narrower arcs with a shorter straight at
their end. The side follows from where the goal lies until the vessel is grasped, not from how the
episode began, and on the other side every boat has the slot across the hull from its own: so a
learner without a memory can tell both.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from asv_env import formation
from asv_env.formation import relate
from asv_env.geometry import plane
from asv_env.params import EnvParams
from asv_env.simulation import LOSING
from asv_env.types import Action, Bool, Complex, Float, Observation, Sensed
from baselines.route import RouteGains, Router
from baselines.scripted import ScriptedPolicy

HASTY = RouteGains(radius=2.8, runout=0.25)
SIDES = (1.0, -1.0)


@dataclass
class Memory:
    """What the team remembers.

    Attributes:
        side: (W,) from which it pushes.
        closed: (W,) whether the slots there are held.
        script: of the scripted policy.
    """

    side: Float
    closed: Bool
    script: Any = None


class HastyPolicy:
    """See the module.

    Args:
        params: of the environment.
    """

    def __init__(self, params: EnvParams) -> None:
        self._params = params
        self._script = ScriptedPolicy(params, router=Router(params.hulls()[0], HASTY))
        self._chooses = params.task.name == "transport"

    def act(
        self, sensed: Sensed, observation: Observation, memory: Memory | None, fresh: Bool
    ) -> tuple[Action, Memory]:
        """See ``Policy.act``."""
        script = None if memory is None else memory.script
        if self._chooses:
            side, closed = self._side(sensed, memory, fresh)
        else:
            side, closed = sensed.side, sensed.closed
        slot = np.where((side == sensed.side)[:, None], sensed.slot, sensed.slot.conj())
        if self._chooses:
            closed = self._closed(sensed, slot, side, closed)
        seen = replace(sensed, slot=slot, side=side, closed=closed)
        action, script = self._script.act(seen, observation, script, fresh)
        return action, Memory(side, closed, script)

    def _side(self, sensed: Sensed, memory: Memory | None, fresh: Bool) -> tuple[Float, Bool]:
        """The side away from the goal, until the vessel is grasped; whether its slots were held."""
        vessel, goal = sensed.estimate[:, 0], sensed.goal
        there = (plane(goal) - plane(vessel)) * np.exp(-1j * vessel[:, 2])
        side = np.where(there.imag <= 0, *SIDES)
        if memory is None:
            return side, np.zeros_like(fresh)
        side = np.where(memory.script.pushing & ~fresh, memory.side, side)
        return side, memory.closed & ~fresh & (side == memory.side)

    def _closed(self, sensed: Sensed, slot: Complex, side: Float, closed: Bool) -> Bool:
        """What the environment says of its own slots, of these."""
        task, idle = self._params.task, ~sensed.working
        relations = relate(sensed.estimate, sensed.goal, slot, side)
        all_hold = np.logical_and.reduce(formation.holding(relations, task) | idle, axis=1)
        near = relations.slot_error <= LOSING * task.slot_distance
        lost = np.logical_or.reduce(~near & ~idle, axis=1)
        return all_hold | (closed & ~lost)
