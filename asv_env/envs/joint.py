"""Adapter: a Gymnasium Env in which one agent drives all boats of one world."""

from typing import Any

import gymnasium
import numpy as np

from asv_env.envs.common import Adapter, Stage, goal_option, team_mean
from asv_env.presets import Overrides, make_params
from asv_env.simulation import Simulation
from asv_env.tasks import Task
from asv_env.types import Action, Observation


class JointEnv(Adapter, gymnasium.Env[Observation, Action]):
    """One world, one agent for all boats: ``gymnasium.make("asv_env/Transport-v0")``.

    A is the number of boats, K the number of observed features.

    Observation: (A, K) float32.
    Action: (A, 2) float32 in [-1, 1]; finite values outside are clipped.
    Reward: the mean of the boats' rewards.
    End: success and leaving the arena terminate, the time limit truncates.
    Info: "reward_terms", the weighted terms of the step's reward; at the last step of an episode
    also its metrics, see ``metrics.summary``.

    Args:
        task: name of a task, "module:NAME", or a ``Task``.
        num_boats: A, 2 to 100; None takes the preset's.
        scenario: name of the disturbances, see ``presets.SCENARIOS``.
        render_mode: None, "rgb_array" or "human".
        **options: see ``presets.make_params``.

    Raises:
        ValueError: an unknown name or a value out of range.
        TypeError: an option of the wrong type.
    """

    def __init__(
        self,
        task: str | Task = "transport",
        num_boats: int | None = None,
        scenario: str | Overrides = "nominal",
        render_mode: str | None = None,
        **options: Any,
    ) -> None:
        params = make_params(task, num_boats, scenario, **options)
        self._open(Simulation(params), render_mode)
        self.observation_space, self.action_space = self._boat_spaces(params.num_boats)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begins an episode; returns the observation (A, K) and an empty info.

        Args:
            seed: seed of the world; None continues its Generator.
            options: ``{"goal": [x m, y m, heading rad]}`` sets the goal of this episode; other
                keys are ignored with a warning.

        Raises:
            ValueError: a bad seed or goal, or the environment is closed.
            TypeError: options that are not a mapping.
        """
        observation = self._begin(seed, goal_option(options))
        super().reset(seed=None if seed is None else int(seed))
        return observation, {}

    def step(self, action: Action) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Advances the world by one control step under an action (A, 2).

        Returns:
            Observation (A, K), reward, terminated, truncated, info.

        Raises:
            ValueError: a wrong shape, NaN or infinity; ``ResetNeededError`` where no episode is
                running; ``ClosedError`` after close.
        """
        self._require("step", Stage.RUNNING)
        action = np.asarray(action)
        if action.shape != self.action_space.shape:
            raise ValueError(f"action of shape {action.shape}: must be {self.action_space.shape}")
        step, terminated, truncated, summary = self._advance(action)
        terms = {
            name: (value if value.size == 1 else team_mean(value)).item()
            for name, value in step.terms.items()
        }
        info = {"reward_terms": terms, **summary}
        return step.observation[0], team_mean(step.reward).item(), terminated, truncated, info
