"""Adapter: a Gymnasium Env in which one agent drives all boats of one world."""

from typing import Any

import gymnasium
import numpy as np

from asv_env.envs.common import Adapter, Stage, goal_option
from asv_env.envs.gym_spec import completed, requested_steps
from asv_env.envs.infos import of_world, team_infos, team_mean
from asv_env.envs.keyboard import keys_to_action
from asv_env.envs.limits import limited
from asv_env.numerics import numerics
from asv_env.params import EnvParams
from asv_env.presets import Overrides, make_params
from asv_env.simulation import Simulation
from asv_env.tasks import Task
from asv_env.types import Action, Observation


class JointEnv(Adapter, gymnasium.Env[Observation, Action]):
    """One world, one agent for all boats: ``gymnasium.make("asv_env/Transport-v0")``.

    A is the number of boats, K the number of observed features.

    Observation: (A, K) float32; (A K,) with ``flat``.
    Action: (A, 2) float32 in [-1, 1], (2 A,) with ``flat``; finite values outside are clipped.
    With ``action_mode="discrete"`` (A,) numbers of ``DISCRETE_ACTIONS``.
    Reward: the mean of the boats' rewards.
    End: success and leaving the arena terminate, the time limit truncates.
    Info: "reward_<term>" for every weighted term of the step's reward, 0.0 at a reset, and the
    metrics of the episode so far, see ``metrics.summary``; always the same keys.

    Args:
        task: name of a task, "module:NAME", or a ``Task``.
        num_boats: A, 2 to 100; None takes the preset's.
        scenario: name of the disturbances, see ``presets.SCENARIOS``.
        render_mode: None, "rgb_array" or "human".
        flat: whether observation and action have one axis, as many learners expect.
        max_episode_steps: number of steps after which an episode is truncated, in place of
            ``time_limit``.
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
        flat: bool = False,
        max_episode_steps: int | None = None,
        **options: Any,
    ) -> None:
        params = make_params(task, num_boats, scenario, **options)
        self._options = options
        self._open(Simulation(self._limited(params, max_episode_steps)), render_mode)
        spaces = self._boat_spaces(params.num_boats, flat=flat)
        self.observation_space, self.action_space = spaces
        self._shapes = tuple(space.shape or () for space in spaces)

    def _limited(self, params: EnvParams, steps: int | None) -> EnvParams:
        return limited(params, self._options, max_episode_steps=steps)

    @property
    def spec(self) -> Any:
        """The ``EnvSpec`` from which Gymnasium made the environment, or None."""
        return self._spec

    @spec.setter
    def spec(self, spec: Any) -> None:
        params = self._limited(self.params, requested_steps())
        if params is not self.params:
            self.params, self.simulation = params, Simulation(params)
        self._spec = completed(spec, params.time_limit_ticks)

    @numerics()
    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begins an episode; returns the observation and the info.

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
        return observation.reshape(self._shapes[0]), of_world(team_infos(self.simulation))

    @numerics()
    def step(self, action: Action) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Advances the world by one control step under an action.

        The number 0 stands for an action of zeros, which stops the boats: ``gymnasium.utils.play``
        sends it where no key is pressed.

        Returns:
            Observation, reward, terminated, truncated, info.

        Raises:
            ValueError: a wrong shape, NaN or infinity; ``ResetNeededError`` where no episode is
                running; ``ClosedError`` after close.
        """
        self._require("step", Stage.RUNNING)
        shape = self._shapes[1]
        zero = np.zeros(shape, dtype=self.action_space.dtype)
        given: Any = zero if _is_zero(action) else np.asarray(action)
        if given.shape != shape:
            raise ValueError(f"action of shape {given.shape}: must be {shape}")
        step, terminated, truncated = self._advance(given.reshape(-1, *self._action_shape))
        observation = step.observation.reshape(self._shapes[0])
        info = of_world(team_infos(self.simulation, step))
        return observation, team_mean(step.reward).item(), terminated, truncated, info

    def get_keys_to_action(self) -> dict[tuple[str, ...], Action]:
        """Returns the keys by which ``gymnasium.utils.play`` steers all boats at once.

        W and S are ahead and astern, A and D turn to port and starboard.
        """
        actions = keys_to_action(self.params.action_mode, self.params.num_boats)
        return {keys: action.reshape(self._shapes[1]) for keys, action in actions.items()}


def _is_zero(action: Any) -> bool:
    return isinstance(action, int) and not isinstance(action, bool) and action == 0
