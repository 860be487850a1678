"""A policy of several networks: one approaches the vessel, others push it.

Each network has a job that is learned in minutes to hours, and can be trained and evaluated alone.
As in the scripted policy a team is in one of two states: it begins to PUSH where closure is formed.
Three events also change its state: START, RETRY and GO_ROUND.

After each of these the team selects the side from which it pushes again, and begins
with PUSH where the vessel is in closure there, with APPROACH elsewhere.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from asv_env.geometry import plane
from asv_env.params import NOMINAL_LENGTH, EnvParams
from asv_env.sensing.observation import features
from asv_env.types import Action, Bool, Int, Observation, Sensed
from baselines.learned.network import Layers, Metadata, NetworkMemory, NetworkPolicy, observe
from baselines.mirror import PushSide, goal_lateral_offset, view

APPROACH, PUSH = range(2)  #: states of a team
NOTHING = 0  #: no event
START = 1  #: an episode begins, with the first attempt
RETRY = 2  #: the next attempt: patience is exhausted, or in PUSH a boat is far from the vessel
GO_ROUND = 3  #: in the same attempt an approach ends with the goal behind the team
BEHIND = 0.1  #: distance on the team's side beyond which a goal is behind, vessel lengths
FAR = 2.0  #: distance from the vessel at which a boat is lost for a push, vessel lengths


@dataclass(frozen=True)
class Phase:
    """One network of a policy, and when it acts."""

    layers: Layers
    metadata: Metadata
    patience: float | None = None  #: until it is given up, s for a vessel of 0.40 m; None: for ever
    team_size: int | None = None  #: only teams of this size use it; None: all without their own


@dataclass
class PhaseMemory:
    """What a phased policy remembers from one control tick to the next."""

    state: Int  #: (W,) state of each team
    ticks: Int  #: (W,) control ticks in this state
    attempt: Int  #: (W,) number of the attempt, from 0
    push_side: PushSide | None
    networks: Sequence[NetworkMemory | None]


class PhasedPolicy:
    """Approaches the vessel on the side away from the goal, then pushes.

    Args:
        phases: the network that approaches, then those that push: the first of them in the first
            attempt, and so on; the last in all further attempts. A team that has phases of its
            own uses these alone.
        params: parameters of the environment.

    Raises:
        ValueError: the networks were made for other actions, observations or teams.
    """

    def __init__(self, phases: Sequence[Phase], params: EnvParams) -> None:
        phases = _of_team(phases, params.num_boats)
        tasks = (params.definition.name,)
        self._networks = [
            NetworkPolicy(phase.layers, replace(phase.metadata, tasks=tasks, mirrors=False), params)
            for phase in phases
        ]
        self._params = params
        scale = params.vessel.size / NOMINAL_LENGTH * params.clock.control
        limits = [np.inf if phase.patience is None else phase.patience for phase in phases]
        self._patience = scale * np.array(limits)

    def act(
        self, sensed: Sensed, observation: Observation, memory: PhaseMemory | None, fresh: Bool
    ) -> tuple[Action, PhaseMemory]:
        """See ``Policy.act``."""
        if memory is None:
            zeros = np.zeros(len(fresh), dtype=np.int64)
            memory = PhaseMemory(zeros, zeros, zeros, None, [None] * len(self._networks))
        event = np.where(fresh, START, np.where(self._fails(sensed, memory), RETRY, NOTHING))
        seen, push_side = view(self._params, sensed, memory.push_side, event != NOTHING)
        if (behind := self._goal_is_behind(seen, memory, event)).any():
            event[behind] = GO_ROUND
            seen, push_side = view(self._params, sensed, push_side, event != NOTHING)
        pushes_on = (memory.state == PUSH) & (event == NOTHING)
        state = np.where(seen.closed | pushes_on, PUSH, APPROACH)
        attempt = np.where(event == START, 0, memory.attempt + (event == RETRY))
        changed = (event != NOTHING) | (state != memory.state)
        action, networks = self._act(seen, self._network(state, attempt), memory, changed)
        action[..., 1] *= push_side.side[:, None].astype(np.float32)
        ticks = np.where(changed, 0, memory.ticks + 1)
        return action, PhaseMemory(state, ticks, attempt, push_side, networks)

    def _network(self, state: Int, attempt: Int) -> Int:
        """Returns the number (W,) of the network that acts in a state and an attempt."""
        return np.where(state == PUSH, 1 + np.minimum(attempt, len(self._networks) - 2), 0)

    def _fails(self, sensed: Sensed, memory: PhaseMemory) -> Bool:
        """Returns (W,) whether patience is exhausted, or a boat is lost for a push."""
        patience = self._patience[self._network(memory.state, memory.attempt)]
        position = plane(sensed.estimate)
        far = np.abs(position[:, 1:] - position[:, :1]) > FAR * self._params.vessel.size
        lost = np.logical_or.reduce(far & sensed.working, axis=1)
        return (memory.ticks + 1 >= patience) | ((memory.state == PUSH) & lost)

    def _goal_is_behind(self, seen: Sensed, memory: PhaseMemory, event: Int) -> Bool:
        """Returns (W,) whether an approach ends in closure with the goal behind the team."""
        behind = goal_lateral_offset(seen) > BEHIND * self._params.vessel.size
        return seen.closed & (memory.state == APPROACH) & (event == NOTHING) & behind

    def _act(
        self, seen: Sensed, acting: Int, memory: PhaseMemory, changed: Bool
    ) -> tuple[Action, list[NetworkMemory]]:
        """Returns the actions (W, A, 2) of the acting networks (W,), and all memories."""
        observation = observe(seen, features(self._params), self._params)
        pairs = zip(self._networks, memory.networks, strict=True)
        decided = [network.act(seen, observation, before, changed) for network, before in pairs]
        actions, memories = zip(*decided, strict=True)
        return np.stack(actions)[acting, np.arange(len(acting))], list(memories)


def _of_team(phases: Sequence[Phase], num_boats: int) -> Sequence[Phase]:
    """Returns the phases of a team, two at least: its own, or those of all that have none."""
    own = [phase for phase in phases if phase.team_size == num_boats]
    own = own or [phase for phase in phases if phase.team_size is None]
    if len(own) < 2:
        raise ValueError(
            f"{len(own)} networks for a team of {num_boats}: there must be two at least, one that "
            "approaches and one that pushes"
        )
    return own
