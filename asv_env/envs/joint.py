"""Adapter: a Gymnasium Env in which one agent drives all boats of one world."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np

from asv_env.envs.common import (
    RENDER_FPS,
    RENDER_MODES,
    Adapter,
    boat_spaces,
    goal_option,
    joint_terms,
    summaries,
    team_mean,
)
from asv_env.types import Action, Observation


class JointEnv(Adapter, gymnasium.Env[Observation, Action]):
    """One world, one agent for all boats: ``gymnasium.make("asv_env/Transport-v0")``.

    Observation (A, K) float32, action (A, 2) float32 in [-1, 1] (finite values outside are
    clipped), reward: the mean of the boats' rewards. Success and straying terminate, the time
    limit truncates. ``info["reward_terms"]`` holds the weighted terms of each step's reward;
    at the last step of an episode ``info`` also holds its metrics, see ``metrics.summary``.

    Args:
        task: "approach", "push" or "transport".
        num_boats: A, 2 to 100; None takes the preset's.
        scenario: what disturbs the world.
        render_mode: None, "rgb_array" or "human".
        **options: see ``presets.make_params``.

    Raises:
        ValueError: an unknown name or a value out of range.
        TypeError: an option of the wrong type.
    """

    metadata: dict[str, Any] = {"render_modes": list(RENDER_MODES), "render_fps": RENDER_FPS}

    def __init__(
        self,
        task: str = "transport",
        num_boats: int | None = None,
        scenario: str = "nominal",
        render_mode: str | None = None,
        **options: Any,
    ) -> None:
        names = {"task": task, "num_boats": num_boats, "scenario": scenario}
        self._open(render_mode, {**names, **options})
        self.metadata = self._metadata()
        self._team = self.params.num_boats
        self.observation_space, self.action_space = boat_spaces(self._team)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begins an episode.

        Args:
            seed: of the world; None goes on with its Generator.
            options: ``{"goal": [x m, y m, heading rad]}`` sets the goal of this episode; other
                keys are ignored with a warning.

        Returns:
            Observation (A, K) and an empty info.

        Raises:
            ValueError: a bad seed or goal, or the environment is closed.
            TypeError: options that are not a mapping.
        """
        self._check_open("reset")
        observation = self.simulation.reset(seeds=[seed], goal=goal_option(options))
        super().reset(seed=None if seed is None else int(seed))
        self._life = self._RUNNING
        self._show()
        return observation[0], {}

    def step(self, action: Action) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Advances the world by one control step.

        Args:
            action: (A, 2).

        Returns:
            Observation (A, K), reward, terminated, truncated, info.

        Raises:
            ValueError: a wrong shape, NaN or infinity; before a reset, after the end of an
                episode or after close (``ResetNeededError``, ``ClosedError``).
        """
        self._check_running("step")
        action = np.asarray(action)
        if action.shape != (self._team, 2):
            raise ValueError(f"action of shape {action.shape}: must be {(self._team, 2)}")
        step = self.simulation.step(action[None])
        terminated, truncated = step.ending.terminated.item(), step.ending.truncated.item()
        info: dict[str, Any] = {"reward_terms": joint_terms(step.terms)}
        if terminated or truncated:
            self._life = self._OVER
            info |= summaries(self.simulation, [0])[0]
        self._show()
        return step.observation[0], team_mean(step.reward).item(), terminated, truncated, info

    def render(self) -> Any:
        """A frame (H, W, 3) uint8 with "rgb_array"; None with "human", which needs no call."""
        return self._draw()

    def close(self) -> None:
        """Closes the window, if there is one; the environment cannot be used any more."""
        self._close()
