"""Adapter: a PettingZoo ParallelEnv in which every boat is an agent."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium.spaces import Box, Space
from gymnasium.utils import seeding
from pettingzoo import ParallelEnv

from asv_env.checks import nearest
from asv_env.envs.common import Adapter, Stage, goal_option
from asv_env.envs.infos import metrics_of, of_world, reward_terms
from asv_env.envs.limits import limited
from asv_env.numerics import numerics
from asv_env.presets import Overrides, make_params
from asv_env.sensing.global_state import global_state, global_state_bound
from asv_env.simulation import Simulation
from asv_env.tasks import InitialStates, Task
from asv_env.types import Action, Observation, TimeStep

Infos = dict[str, dict[str, Any]]


class AsvParallelEnv(Adapter, ParallelEnv[str, Observation, Action]):
    """One world whose boats are the agents "asv_0", "asv_1" ...; also named ``parallel_env``.

    Observation: (K,) float32 for each agent, K features.
    Action: (2,) float32 in [-1, 1] for each agent; finite values outside are clipped. With
    ``action_mode="discrete"`` a number of ``DISCRETE_ACTIONS``.
    Reward: a float for each agent.
    End: as in ``JointEnv``, for all agents together; then ``agents`` is empty until the next reset.
    Info: as in ``JointEnv``, with the terms of the agent's own reward.

    Args:
        task, num_boats, render_mode, scenario: as in ``JointEnv``.
        initial_states: distribution of the initial states, see ``Simulation``.
        max_cycles, max_episode_steps: number of steps after which an episode is truncated, in
            place of ``time_limit``; PettingZoo's and Gymnasium's name of the same.
        **options: see ``presets.make_params``.
    """

    metadata = {**Adapter.metadata, "name": "asv_env/transport-v0", "is_parallelizable": True}

    def __init__(
        self,
        task: str | Task = "transport",
        num_boats: int | None = None,
        render_mode: str | None = None,
        scenario: str | Overrides = "nominal",
        initial_states: InitialStates | None = None,
        max_cycles: int | None = None,
        max_episode_steps: int | None = None,
        **options: Any,
    ) -> None:
        params = make_params(task, num_boats, scenario, **options)
        given = {"max_cycles": max_cycles, "max_episode_steps": max_episode_steps}
        params = limited(params, options, **given)
        name = f"asv_env/{params.task.name}-v0"
        simulation = Simulation(params, initial_states=initial_states)
        self._open(simulation, render_mode, name=name)
        # What is public is the user's to change; what a name means is decided by these.
        self._names = tuple(f"asv_{boat}" for boat in range(params.num_boats))
        # Every agent has spaces of its own, so that seeding one leaves the others alone.
        self._spaces = {agent: self._boat_spaces() for agent in self._names}
        self.possible_agents = list(self._names)
        self.agents: list[str] = []  #: those of the running episode
        #: Generator for wrappers, such as SuperSuit's; the world has one of its own
        self.np_random: np.random.Generator = seeding.np_random()[0]
        self.observation_spaces = {agent: seen for agent, (seen, _) in self._spaces.items()}
        self.action_spaces = {agent: acted for agent, (_, acted) in self._spaces.items()}
        bound = global_state_bound(params.num_boats)
        self.state_space = Box(-bound, bound, dtype=np.float32)  #: of ``state()``, (S,)

    def observation_space(self, agent: str) -> Space[Any]:
        """Returns the agent's observation space, always the same object."""
        return self._spaces[self._known(agent)][0]

    def action_space(self, agent: str) -> Space[Any]:
        """Returns the agent's action space, always the same object."""
        return self._spaces[self._known(agent)][1]

    @numerics()
    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Observation], Infos]:
        """Begins an episode, see ``JointEnv``; returns observations (K,) and infos by agent."""
        observation = self._begin(seed, goal_option(options))
        self.agents = list(self._names)
        if seed is not None:
            self.np_random = seeding.np_random(int(seed))[0]
        return dict(zip(self._names, observation, strict=True)), self._infos()

    @numerics()
    def step(
        self, actions: Mapping[str, Action]
    ) -> tuple[dict[str, Observation], dict[str, float], dict[str, bool], dict[str, bool], Infos]:
        """Advances the world by one control step under an action (2,) of every agent.

        Returns:
            Observations (K,), rewards, terminations, truncations and infos, by agent.

        Raises:
            ValueError: agents missing or unknown, and as ``JointEnv.step``.
            TypeError: actions that are not a mapping.
        """
        self._require("step", Stage.RUNNING)
        step, terminated, truncated = self._advance(self._stacked(actions))
        if terminated or truncated:
            self.agents = []
        observations = dict(zip(self._names, step.observation[0], strict=True))
        rewards = dict(zip(self._names, step.reward[0].tolist(), strict=True))
        ends = dict.fromkeys(self._names, terminated), dict.fromkeys(self._names, truncated)
        return observations, rewards, *ends, self._infos(step)

    @numerics()
    def state(self) -> Observation:
        """Returns the global state (S,) float32 for centralised critics; see ``global_state``."""
        self._require("state", Stage.RUNNING, Stage.OVER)
        return global_state(self.simulation.state, self.params)[0]

    def close(self) -> None:
        """Closes the window, if there is one, and ends the episode."""
        self.agents = []
        super().close()

    def _infos(self, step: TimeStep | None = None) -> Infos:
        """Returns the info of every agent, with the terms of its own reward."""
        terms = reward_terms(self.simulation, step)
        # A term that the team shares has one column.
        columns = {name: np.broadcast_to(v[0], len(self._names)) for name, v in terms.items()}
        summary = of_world(metrics_of(self.simulation))
        return {a: of_world(columns, i) | summary for i, a in enumerate(self._names)}

    def _known(self, agent: str) -> str:
        if agent not in self._names:
            raise ValueError(f"unknown agent {agent!r}.{self._nearest(agent)}")
        return agent

    def _stacked(self, actions: Mapping[str, Action]) -> Action:
        """Returns the actions (A, 2) or (A,) in the order of the boats."""
        if not isinstance(actions, Mapping):
            raise TypeError(f"actions of type {type(actions).__name__}: give a dict by agent")
        if actions.keys() != self._spaces.keys():
            missing = [agent for agent in self._names if agent not in actions]
            unknown = [agent for agent in actions if agent not in self._names]
            hint = self._nearest(unknown[0]) if unknown else ""
            raise ValueError(f"actions: missing agents {missing}, unknown agents {unknown}.{hint}")
        stacked = [np.asarray(actions[agent]) for agent in self._names]
        for agent, action in zip(self._names, stacked, strict=True):
            if action.shape != self._action_shape:
                must = f"must be {self._action_shape}"
                raise ValueError(f"action of {agent} of shape {action.shape}: {must}")
        return np.array(stacked)

    def _nearest(self, agent: object) -> str:
        first, last = self._names[0], self._names[-1]
        return f"{nearest(agent, self._names)} The agents are {first!r} to {last!r}."


parallel_env = AsvParallelEnv
