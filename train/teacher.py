"""The scripted policy in a hurry: whom the learner imitates first.

It takes the vessel from whichever side leads to the goal sooner, on narrower arcs with a shorter
straight at their end. That loses the grasp now and then, where the scripted policy is careful;
what the learner makes of it is its own affair.
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
from baselines import dubins
from baselines.route import RouteGains, Router
from baselines.scripted import ScriptedPolicy

HASTY = RouteGains(radius=2.8, runout=0.25)
PUSHES, GOES = 0.06, 0.16
"""Speeds of the vessel and of boats on their way, by which sides are compared, m/s."""
ROUND = 1.0
"""Way round the hull for a boat on its other side, lengths of the vessel."""
SIDES = (1.0, -1.0)


@dataclass
class Memory:
    """What the team remembers.

    Attributes:
        slot: (W, A) as ``State.slot``, on the side that was chosen.
        side: (W,) that side.
        closed: (W,) whether these slots are held.
        script: of the scripted policy.
    """

    slot: Complex
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
        if not self._chooses:
            script = None if memory is None else memory.script
            action, script = self._script.act(sensed, observation, script, fresh)
            return action, Memory(sensed.slot, sensed.side, sensed.closed, script)
        if memory is None:
            fresh = np.ones_like(fresh)
            memory = Memory(sensed.slot.copy(), sensed.side.copy(), np.zeros_like(fresh))
        memory = replace(
            memory, slot=memory.slot.copy(), side=memory.side.copy(), closed=memory.closed & ~fresh
        )
        for world in map(int, np.flatnonzero(fresh)):
            self._choose(sensed, memory, world)
        self._judge_closure(sensed, memory)
        seen = replace(sensed, slot=memory.slot, side=memory.side, closed=memory.closed)
        action, memory.script = self._script.act(seen, observation, memory.script, fresh)
        return action, memory

    def _choose(self, sensed: Sensed, memory: Memory, world: int) -> None:
        """Takes the side from which the goal is reached sooner."""
        motion, working = sensed.estimate[world], sensed.working[world]
        best = np.inf
        for side in SIDES:
            slot = formation.assign_slots(self._params, motion, working, side)
            time = self._time(motion, sensed.goal[world], slot[working], working, side)
            if time < best:
                best = time
                memory.slot[world], memory.side[world] = slot, side

    def _time(self, motion: Float, goal: Float, slot: Complex, working: Bool, side: float) -> float:
        """About what a delivery from one side takes, s."""
        length = self._params.vessel.length
        to_vessel = np.exp(-1j * motion[0, 2])
        there = (goal[0] + 1j * goal[1] - plane(motion)[0]) * to_vessel
        turn = np.angle(np.exp(1j * (goal[2] - motion[0, 2])))
        pose = np.array([there.real, side * there.imag, side * turn])
        way = float(dubins.length(pose, 0.75 * HASTY.radius * length / 2))
        boats = ((plane(motion)[1:] - plane(motion)[0]) * to_vessel)[working]
        wrong = boats.imag * side < 0
        return way / PUSHES + float(np.max(np.abs(slot - boats) + ROUND * length * wrong)) / GOES

    def _judge_closure(self, sensed: Sensed, memory: Memory) -> None:
        """What the environment says of its own slots, of these."""
        task = self._params.task
        relations = relate(sensed.estimate, sensed.goal, memory.slot, memory.side)
        idle = ~sensed.working
        all_hold = (formation.holding(relations, task) | idle).all(axis=1)
        at_rest = (formation.at_rest(relations, task) | idle).all(axis=1)
        for world in map(int, np.flatnonzero(at_rest & ~memory.closed & ~all_hold)):
            memory.slot[world] = formation.assign_slots(
                self._params, sensed.estimate[world], sensed.working[world], memory.side[world]
            )
        near = relations.slot_error <= LOSING * task.slot_distance
        memory.closed = all_hold | (memory.closed & (near | idle).all(axis=1))
