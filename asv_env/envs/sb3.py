"""Adapter: a stable-baselines3 VecEnv with one row a boat, for policies that all boats share."""

from __future__ import annotations

import time
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Dict

from asv_env.envs.common import Adapter, boat_spaces, goal_option, summaries
from asv_env.sensing.global_state import global_state, global_state_bound
from asv_env.sensing.observation import NAMES
from asv_env.simulation import WORLDS_PER_SPACE, InitialStates
from asv_env.tasks import starts
from asv_env.types import Action, Bool, Observation, rows

try:
    from stable_baselines3.common.monitor import Monitor
    from stable_baselines3.common.vec_env import VecEnv
    from stable_baselines3.common.vec_env.base_vec_env import VecEnvIndices
except ImportError as error:
    raise ImportError(
        "asv_env.envs.sb3 needs stable-baselines3: pip install 'asv-env[train]'"
    ) from error

Seen = Observation | dict[str, Observation]


class BoatVecEnv(Adapter, VecEnv):
    """Rows = worlds x boats, world by world: boat i of world w is row ``w * A + i``.

    Observation (W A, K) float32, action (W A, 2) float32 in [-1, 1] (finite values outside are
    clipped), reward (W A,) float32. With ``with_state`` the observation is a dictionary of "obs",
    the same, and "state" (W A, S) float32, the true state of the row's world, for a centralised
    critic; see ``global_state``. The boats of a world end together, and the world begins its
    next episode in the same step. The infos of its rows then hold "terminal_observation",
    "TimeLimit.truncated" (True at the time limit; False after success or straying), "episode"
    (r, l, t: what a Monitor would write, so that no wrapper is needed for SB3's logs) and the
    metrics of the episode, see ``metrics.summary``.

    ``seed`` and ``set_options`` count in rows; a world takes those of its first row. SB3's
    ``evaluate_policy`` counts episodes in rows too: multiply ``n_eval_episodes`` by the boats.

    Args:
        task: "approach", "push" or "transport".
        num_envs: W, the number of worlds.
        num_boats: A, 2 to 100; None takes the preset's.
        scenario: what disturbs the worlds.
        render_mode: None, "rgb_array" or "human", which shows world 0.
        stagger: shortens the first episode of world w after a reset to the share (w + 1) / W of
            the time limit, so that not all worlds truncate in the same step.
        worlds_per_space: see ``Simulation``.
        initial_states: how episodes begin, see ``Simulation``.
        with_state: whether the state of the world is observed too.
        **options: see ``presets.make_params``.

    Attributes:
        num_envs: rows, W A.
        num_worlds: W.

    Raises:
        ValueError: an unknown name or a value out of range.
        TypeError: an option of the wrong type.
    """

    metadata: dict[str, Any]

    def __init__(
        self,
        task: str = "transport",
        num_envs: int = 64,
        num_boats: int | None = None,
        scenario: str = "nominal",
        render_mode: str | None = None,
        stagger: bool = False,
        worlds_per_space: int = WORLDS_PER_SPACE,
        initial_states: InitialStates = starts.sample,
        with_state: bool = False,
        **options: Any,
    ) -> None:
        names = {"task": task, "num_boats": num_boats, "scenario": scenario}
        self._open(render_mode, {**names, **options}, num_envs, worlds_per_space, initial_states)
        self.num_worlds, self._team = num_envs, self.params.num_boats
        self._stagger, self._with_state = stagger, with_state
        self._limit = np.full(num_envs, self.params.time_limit_ticks)
        self._return = np.zeros((num_envs, self._team))
        self._actions: Action | None = None
        self._began = time.time()
        boats, acts = boat_spaces()
        observes: gymnasium.Space[Any] = boats
        if with_state:
            bound = global_state_bound(self._team)
            observes = Dict({"obs": boats, "state": Box(-bound, bound)})
        super().__init__(num_envs * self._team, observes, acts)
        self.metadata["render_fps"] = self.params.clock.control

    def reset(self) -> Seen:
        """Begins new episodes of all worlds, with the seeds and options that were set.

        Returns:
            Observations of all rows.

        Raises:
            ValueError: a bad seed or goal, or the environment is closed.
        """
        self._check_open("reset")
        seeds = self._seeds[:: self._team]
        goals = [_hashable(goal_option(options)) for options in self._options[:: self._team]]
        observation = np.zeros((self.num_worlds, self._team, len(NAMES)), dtype=np.float32)
        for goal in dict.fromkeys(goals):
            mask = np.array([one == goal for one in goals])
            some = [seed for seed, chosen in zip(seeds, mask, strict=True) if chosen]
            observation[mask] = self.simulation.reset(mask, some, goal)
        self._reset_seeds()
        self._reset_options()
        self.reset_infos = [{} for _ in range(self.num_envs)]
        self._limit[...] = self.params.time_limit_ticks
        if self._stagger:
            shares = np.arange(1, self.num_worlds + 1) / self.num_worlds
            self._limit[...] = np.ceil(shares * self.params.time_limit_ticks)
        self._return[...] = 0.0
        self._actions = None
        self._life = self._RUNNING
        self._show()
        return self._seen(observation, slice(None))

    def step_async(self, actions: Action) -> None:
        """Takes the actions (W A, 2) of the next step.

        Raises:
            ValueError: a wrong shape; before a reset or after close (``ResetNeededError``,
                ``ClosedError``).
        """
        self._check_running("step")
        actions = np.asarray(actions)
        if actions.shape != (self.num_envs, 2):
            raise ValueError(f"actions of shape {actions.shape}: must be {(self.num_envs, 2)}")
        self._actions = actions.reshape(self.num_worlds, self._team, 2)

    def step_wait(self) -> tuple[Seen, Observation, Bool, list[dict[str, Any]]]:
        """Advances every world by one control step, and into its next episode if it is over.

        Returns:
            Observations of all rows, rewards (W A,), dones (W A,), an info for each row.

        Raises:
            ValueError: NaN or infinity among the actions.
            RuntimeError: there are none.
        """
        if self._actions is None:
            raise RuntimeError("step_wait: there are no actions; call step_async first")
        step, self._actions = self.simulation.step(self._actions), None
        self._return += step.reward
        observation, terminated = step.observation, step.ending.terminated
        over = terminated | (self.simulation.state.tick >= self._limit)
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        if over.any():
            self._tell_ends(infos, over, terminated, observation)
            observation[over] = self.simulation.reset(over)
            self._return[over] = 0.0
            self._limit[over] = self.params.time_limit_ticks
        self._show()
        return (
            self._seen(observation, slice(None)),
            step.reward.astype(np.float32).reshape(-1),
            np.repeat(over, self._team),
            infos,
        )

    def _tell_ends(
        self, infos: list[dict[str, Any]], over: Bool, terminated: Bool, observation: Observation
    ) -> None:
        """Fills the infos of the rows whose episodes end."""
        worlds = np.flatnonzero(over)
        last = self._seen(observation[worlds], worlds)  # copies
        elapsed = round(time.time() - self._began, 6)
        told = zip(worlds, summaries(self.simulation, worlds), strict=True)
        for number, (world, summary) in enumerate(told):
            length = int(self.simulation.state.tick[world])
            for boat, total in enumerate(self._return[world].tolist()):
                row = world * self._team + boat
                infos[row] = {
                    **summary,
                    "terminal_observation": _row(last, number * self._team + boat),
                    "TimeLimit.truncated": not terminated[world],
                    "episode": {"r": total, "l": length, "t": elapsed},
                }
                self.reset_infos[row] = {}

    def close(self) -> None:
        """Closes the window, if there is one; the environment cannot be used any more."""
        self._close()

    def render(self, mode: str | None = None) -> Any:
        """All worlds tiled in one frame (H, W, 3) uint8; with "human" world 0 in a window."""
        if self.render_mode == "human":
            return self._draw()
        return super().render(mode)

    def get_images(self) -> list[Any]:
        """A frame of every world."""
        return [self._draw(world) for world in range(self.num_worlds)]

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> list[Any]:
        """An attribute of the environment, which all rows share, once for each row."""
        return [getattr(self, attr_name) for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: VecEnvIndices = None) -> None:
        """Sets an attribute of the environment, which all rows share."""
        setattr(self, attr_name, value)

    def env_method(
        self,
        method_name: str,
        *method_args: Any,
        indices: VecEnvIndices = None,
        **method_kwargs: Any,
    ) -> list[Any]:
        """Calls a method of the environment, which all rows share, once; its result by row."""
        result = getattr(self, method_name)(*method_args, **method_kwargs)
        return [result for _ in self._get_indices(indices)]

    def env_is_wrapped(
        self,
        wrapper_class: type[gymnasium.Wrapper[Any, Any, Any, Any]],
        indices: VecEnvIndices = None,
    ) -> list[bool]:
        """Whether each row is wrapped: as if by a Monitor, whose reports it makes itself."""
        return [issubclass(Monitor, wrapper_class) for _ in self._get_indices(indices)]

    def _seen(self, observation: Observation, worlds: Any) -> Seen:
        """What is observed of some worlds (n, A, K), by rows."""
        by_row = observation.reshape(-1, observation.shape[-1])
        if not self._with_state:
            return by_row
        state = global_state(rows(self.simulation.state, worlds), self.params)
        return {"obs": by_row, "state": np.repeat(state, self._team, axis=0)}


def _row(seen: Seen, row: int) -> Seen:
    """One row of what is observed."""
    if isinstance(seen, dict):
        return {name: values[row] for name, values in seen.items()}
    return seen[row]


def _hashable(goal: Any) -> Any:
    """A goal that can be a key; what is no sequence of numbers is refused by the simulation."""
    return tuple(goal) if isinstance(goal, list | np.ndarray) else goal
