"""Policies of several networks in a file: one approaches the vessel, others push it.

Each of them has a job that is learned in minutes to hours, and can be trained and watched alone.
Which of them acts is decided as in the scripted policy: the team approaches until the vessel is in
closure, then it pushes; when the goal is not reached in time, or a boat is lost, it begins again,
and then the next network pushes. A team size may have networks of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from asv_env.geometry import plane
from asv_env.params import NOMINAL_LENGTH, EnvParams
from asv_env.tasks import TASKS
from asv_env.types import Action, Bool, Int, Observation, Sensed
from baselines.learned import network
from baselines.learned.metadata import Phase
from baselines.learned.network import NetworkMemory, NetworkPolicy
from baselines.mirror import SideAway, SideMemory, goal_across

BEHIND = 0.1
"""How far on the side of the team a goal must lie for it to go round, lengths of the vessel."""
FAR = 2.0
"""Distance from the vessel at which a boat is lost while others push, lengths of the vessel."""


@dataclass
class PhaseMemory:
    """What a team remembers.

    Attributes:
        sides: from which sides the teams push.
        attempt: (W,) number of the attempt, from 0.
        acts: (W,) number of the network that acts; 0 approaches.
        ticks: (W,) for which it has acted.
        held: of each network.
    """

    sides: SideMemory
    attempt: Int
    acts: Int
    ticks: Int
    held: Sequence[NetworkMemory | None]


class PhasedPolicy:
    """Approaches from the side of the vessel away from the goal, then pushes.

    Args:
        phases: the network that approaches, then those that push: the first one in the first
            attempt, and so on; the last one in all that are left. Only those count that serve
            the environment's team.
        params: of the environment.

    Raises:
        ValueError: they were made for other actions, other observations or other teams.
    """

    def __init__(self, phases: Sequence[Phase], params: EnvParams) -> None:
        phases = serving(phases, params.num_boats)
        self._networks = [
            NetworkPolicy(
                one.layers, replace(one.metadata, tasks=tuple(TASKS), mirrors=False), params
            )
            for one in phases
        ]
        self._params = params
        self._away = SideAway(params)
        scale = params.vessel.length / NOMINAL_LENGTH * params.clock.control
        self._behind = BEHIND * params.vessel.length
        limits = [np.inf if one.patience is None else one.patience for one in phases]
        self._patience = scale * np.array(limits)

    def act(
        self, sensed: Sensed, observation: Observation, memory: PhaseMemory | None, fresh: Bool
    ) -> tuple[Action, PhaseMemory]:
        """See ``Policy.act``."""
        if memory is None:
            none = np.zeros(len(fresh), dtype=np.int64)
            memory = PhaseMemory(None, none, none, none, [None] * len(self._networks))  # type: ignore[arg-type]
        ticks = memory.ticks + 1
        late = ticks >= self._patience[memory.acts]
        gives_up = ~fresh & (late | ((memory.acts > 0) & self._lost(sensed)))
        begins = fresh | gives_up
        attempt = np.where(fresh, 0, memory.attempt + gives_up)
        seen, sides = self._away.see(sensed, memory.sides, begins)
        misses = seen.closed & (memory.acts == 0) & ~begins & (goal_across(seen) > self._behind)
        if misses.any():
            begins |= misses
            seen, sides = self._away.see(sensed, sides, begins)
        pushes = seen.closed | ((memory.acts > 0) & ~begins)
        acts = np.where(pushes, 1 + np.minimum(attempt, len(self._networks) - 2), 0)
        changes = begins | (acts != memory.acts)
        observed = network.observe(seen, self._params)
        action = np.zeros((*sensed.slot.shape, 2), dtype=np.float32)
        held = []
        for number, one in enumerate(self._networks):
            says, holds = one.act(seen, observed, memory.held[number], changes)
            action = np.where((acts == number)[:, None, None], says, action)
            held.append(holds)
        action[..., 1] *= sides.side[:, None].astype(np.float32)
        ticks = np.where(changes, 0, ticks)
        return action, PhaseMemory(sides, attempt, acts, ticks, held)

    def _lost(self, sensed: Sensed) -> Bool:
        """(W,) whether a boat that works is far from the vessel."""
        place = plane(sensed.estimate)
        far = np.abs(place[:, 1:] - place[:, :1]) > FAR * self._params.vessel.length
        lost: Bool = np.logical_or.reduce(far & sensed.working, axis=1)
        return lost


def serving(phases: Sequence[Phase], num_boats: int) -> Sequence[Phase]:
    """Those for a team: its own, or those of all teams that have none.

    Raises:
        ValueError: there are fewer than two.
    """
    own = [one for one in phases if one.team_size == num_boats]
    own = own or [one for one in phases if one.team_size is None]
    if len(own) < 2:
        raise ValueError(
            f"{len(own)} networks for a team of {num_boats}: there must be two at least, one that "
            "approaches and one that pushes"
        )
    return own
