"""Adapter: a PettingZoo ParallelEnv in which every boat is an agent."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium.spaces import Box
from pettingzoo import ParallelEnv

from asv_env.envs.common import (
    RENDER_FPS,
    RENDER_MODES,
    Adapter,
    boat_spaces,
    boat_terms,
    goal_option,
    summaries,
)
from asv_env.sensing.global_state import global_state, global_state_bound
from asv_env.simulation import InitialStates
from asv_env.tasks import starts
from asv_env.types import Action, Observation


class AsvParallelEnv(Adapter, ParallelEnv[str, Observation, Action]):
    """One world whose boats are the agents "asv_0", "asv_1" ...

    Of each agent: observation (K,) float32, action (2,) float32 in [-1, 1] (finite values
    outside are clipped), reward float. All agents live and end together: success and straying
    terminate, the time limit truncates, and then ``agents`` is empty until the next reset.
    ``info["reward_terms"]`` holds the weighted terms of the agent's reward; at the last step of
    an episode every agent's info also holds its metrics, see ``metrics.summary``.

    Args:
        task: "approach", "push" or "transport".
        num_boats: 2 to 100; None takes the preset's.
        render_mode: None, "rgb_array" or "human".
        scenario: what disturbs the world.
        initial_states: how episodes begin, see ``Simulation``.
        **options: see ``presets.make_params``.

    Attributes:
        possible_agents: all agents.
        agents: those of the running episode.
        state_space: of ``state()``, (S,) float32.

    Raises:
        ValueError: an unknown name or a value out of range.
        TypeError: an option of the wrong type.
    """

    metadata: dict[str, Any] = {
        "name": "asv_env/transport-v0",
        "render_modes": list(RENDER_MODES),
        "render_fps": RENDER_FPS,
        "is_parallelizable": True,
    }

    def __init__(
        self,
        task: str = "transport",
        num_boats: int | None = None,
        render_mode: str | None = None,
        scenario: str = "nominal",
        initial_states: InitialStates = starts.sample,
        **options: Any,
    ) -> None:
        names = {"task": task, "num_boats": num_boats, "scenario": scenario}
        self._open(render_mode, {**names, **options}, initial_states=initial_states)
        self.metadata = self._metadata(name=f"asv_env/{task}-v0", is_parallelizable=True)
        team = self.params.num_boats
        self.possible_agents = [f"asv_{boat}" for boat in range(team)]
        self.agents: list[str] = []
        spaces = [boat_spaces() for _ in range(team)]
        self.observation_spaces = {
            a: s[0] for a, s in zip(self.possible_agents, spaces, strict=True)
        }
        self.action_spaces = {a: s[1] for a, s in zip(self.possible_agents, spaces, strict=True)}
        bound = global_state_bound(team)
        self.state_space = Box(-bound, bound, dtype=np.float32)

    def observation_space(self, agent: str) -> Box[np.float32]:
        """The agent's observation space, always the same object."""
        return self._of(agent, self.observation_spaces)

    def action_space(self, agent: str) -> Box[np.float32]:
        """The agent's action space, always the same object."""
        return self._of(agent, self.action_spaces)

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Observation], dict[str, dict[str, Any]]]:
        """Begins an episode.

        Args:
            seed: of the world; None goes on with its Generator.
            options: ``{"goal": [x m, y m, heading rad]}`` sets the goal of this episode; other
                keys are ignored with a warning.

        Returns:
            Observations (K,) and empty infos, by agent.

        Raises:
            ValueError: a bad seed or goal, or the environment is closed.
            TypeError: options that are not a mapping.
        """
        self._check_open("reset")
        observation = self.simulation.reset(seeds=[seed], goal=goal_option(options))
        self.agents = self.possible_agents[:]
        self._life = self._RUNNING
        self._show()
        return dict(zip(self.agents, observation[0], strict=True)), {a: {} for a in self.agents}

    def step(
        self, actions: Mapping[str, Action]
    ) -> tuple[
        dict[str, Observation],
        dict[str, float],
        dict[str, bool],
        dict[str, bool],
        dict[str, dict[str, Any]],
    ]:
        """Advances the world by one control step.

        Args:
            actions: (2,) of every agent.

        Returns:
            Observations (K,), rewards, terminations, truncations and infos, by agent.

        Raises:
            ValueError: agents missing or unknown, a wrong shape, NaN or infinity; before a
                reset, after the end of an episode or after close (``ResetNeededError``,
                ``ClosedError``).
            TypeError: actions that are not a mapping.
        """
        self._check_running("step")
        agents = self.agents
        step = self.simulation.step(self._stacked(actions)[None])
        terminated, truncated = step.ending.terminated.item(), step.ending.truncated.item()
        terms = boat_terms(step.terms, len(agents))
        infos: dict[str, dict[str, Any]] = {
            agent: {"reward_terms": term} for agent, term in zip(agents, terms, strict=True)
        }
        if terminated or truncated:
            self.agents = []
            self._life = self._OVER
            summary = summaries(self.simulation, [0])[0]
            infos = {agent: {**info, **summary} for agent, info in infos.items()}
        self._show()
        return (
            dict(zip(agents, step.observation[0], strict=True)),
            dict(zip(agents, step.reward[0].tolist(), strict=True)),
            dict.fromkeys(agents, terminated),
            dict.fromkeys(agents, truncated),
            infos,
        )

    def state(self) -> Observation:
        """The global view (S,) float32 for centralised critics; see ``global_state``."""
        self._check_begun("state")
        return global_state(self.simulation.state, self.params)[0]

    def render(self) -> Any:
        """A frame (H, W, 3) uint8 with "rgb_array"; None with "human", which needs no call."""
        return self._draw()

    def close(self) -> None:
        """Closes the window, if there is one; the environment cannot be used any more."""
        self.agents = []
        self._close()

    def _of(self, agent: str, spaces: dict[str, Box[np.float32]]) -> Box[np.float32]:
        if agent not in spaces:
            raise ValueError(f"unknown agent {agent!r}.{self._nearest(agent)}")
        return spaces[agent]

    def _stacked(self, actions: Mapping[str, Action]) -> Action:
        """The actions (A, 2) in the order of the agents."""
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
        near = difflib.get_close_matches(str(agent), self.possible_agents, n=1)
        first, last = self.possible_agents[0], self.possible_agents[-1]
        hint = f" Did you mean {near[0]!r}?" if near else ""
        return f"{hint} The agents are {first!r} to {last!r}."


def parallel_env(
    task: str = "transport",
    num_boats: int | None = None,
    render_mode: str | None = None,
    scenario: str = "nominal",
    initial_states: InitialStates = starts.sample,
    **options: Any,
) -> AsvParallelEnv:
    """A PettingZoo environment whose agents are the boats; see ``AsvParallelEnv``."""
    return AsvParallelEnv(task, num_boats, render_mode, scenario, initial_states, **options)
