"""Adapter: a PettingZoo ParallelEnv in which every boat is an agent."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium.spaces import Box, Space
from pettingzoo import ParallelEnv

from asv_env.checks import nearest
from asv_env.envs.common import Adapter, Stage, goal_option
from asv_env.presets import Overrides, make_params
from asv_env.sensing.global_state import global_state, global_state_bound
from asv_env.simulation import Simulation
from asv_env.tasks import InitialStates, Task
from asv_env.types import Action, Observation, TimeStep

Infos = dict[str, dict[str, Any]]


class AsvParallelEnv(Adapter, ParallelEnv[str, Observation, Action]):
    """One world whose boats are the agents "asv_0", "asv_1" ...; also named ``parallel_env``.

    Observation: (K,) float32 for each agent, K features.
    Action: (2,) float32 in [-1, 1] for each agent; finite values outside are clipped.
    Reward: a float for each agent.
    End: as in ``JointEnv``, for all agents together; then ``agents`` is empty until the next reset.
    Info: as in ``JointEnv``, with the terms of the agent's own reward.

    Args:
        task, num_boats, render_mode, scenario: as in ``JointEnv``.
        initial_states: distribution of the initial states, see ``Simulation``.
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
        **options: Any,
    ) -> None:
        params = make_params(task, num_boats, scenario, **options)
        name = f"asv_env/{params.task.name}-v0"
        simulation = Simulation(params, initial_states=initial_states)
        self._open(simulation, render_mode, name=name)
        self.possible_agents = [f"asv_{boat}" for boat in range(params.num_boats)]
        self.agents: list[str] = []  #: those of the running episode
        # Every agent has spaces of its own, so that seeding one leaves the others alone.
        spaces = {agent: self._boat_spaces() for agent in self.possible_agents}
        self.observation_spaces = {agent: observed for agent, (observed, _) in spaces.items()}
        self.action_spaces = {agent: acted for agent, (_, acted) in spaces.items()}
        bound = global_state_bound(params.num_boats)
        self.state_space = Box(-bound, bound, dtype=np.float32)  #: of ``state()``, (S,)

    def observation_space(self, agent: str) -> Space[Any]:
        """Returns the agent's observation space, always the same object."""
        return self._space(agent, self.observation_spaces)

    def action_space(self, agent: str) -> Space[Any]:
        """Returns the agent's action space, always the same object."""
        return self._space(agent, self.action_spaces)

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Observation], Infos]:
        """Begins an episode, see ``JointEnv``; returns observations (K,) and infos by agent."""
        observation = self._begin(seed, goal_option(options))
        self.agents = self.possible_agents[:]
        return dict(zip(self.agents, observation, strict=True)), {a: {} for a in self.agents}

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
        agents = self.agents
        step, terminated, truncated, summary = self._advance(self._stacked(actions))
        if terminated or truncated:
            self.agents = []
        observations = dict(zip(agents, step.observation[0], strict=True))
        rewards = dict(zip(agents, step.reward[0].tolist(), strict=True))
        ends = dict.fromkeys(agents, terminated), dict.fromkeys(agents, truncated)
        infos = {a: {"reward_terms": _terms(step, i), **summary} for i, a in enumerate(agents)}
        return observations, rewards, *ends, infos

    def state(self) -> Observation:
        """Returns the global state (S,) float32 for centralised critics; see ``global_state``."""
        self._require("state", Stage.RUNNING, Stage.OVER)
        return global_state(self.simulation.state, self.params)[0]

    def close(self) -> None:
        """Closes the window, if there is one, and ends the episode."""
        self.agents = []
        super().close()

    def _space(self, agent: str, spaces: dict[str, Space[Any]]) -> Space[Any]:
        if agent not in spaces:
            raise ValueError(f"unknown agent {agent!r}.{self._nearest(agent)}")
        return spaces[agent]

    def _stacked(self, actions: Mapping[str, Action]) -> Action:
        """Returns the actions (A, 2) in the order of the agents."""
        if not isinstance(actions, Mapping):
            raise TypeError(f"actions of type {type(actions).__name__}: give a dict by agent")
        if actions.keys() != self.action_spaces.keys():
            missing = [agent for agent in self.agents if agent not in actions]
            unknown = [agent for agent in actions if agent not in self.action_spaces]
            hint = self._nearest(unknown[0]) if unknown else ""
            raise ValueError(f"actions: missing agents {missing}, unknown agents {unknown}.{hint}")
        stacked = [np.asarray(actions[agent]) for agent in self.agents]
        for agent, action in zip(self.agents, stacked, strict=True):
            if action.shape != (2,):
                raise ValueError(f"action of {agent} of shape {action.shape}: must be (2,)")
        return np.array(stacked)

    def _nearest(self, agent: object) -> str:
        first, last = self.possible_agents[0], self.possible_agents[-1]
        return f"{nearest(agent, self.possible_agents)} The agents are {first!r} to {last!r}."


def _terms(step: TimeStep, boat: int) -> dict[str, float]:
    """Returns the reward terms of a boat of an only world, as Python floats."""
    # A term that the team shares has one column.
    return {name: value[0, boat % value.shape[1]].item() for name, value in step.terms.items()}


parallel_env = AsvParallelEnv
