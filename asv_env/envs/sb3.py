"""Adapter: a stable-baselines3 VecEnv, whose rows are boats that share a policy, or worlds."""

import time
from typing import Any

import numpy as np
from gymnasium.spaces import Box, Dict

from asv_env.checks import Whole
from asv_env.envs.common import Adapter, Stage, goal_option
from asv_env.envs.infos import metrics_of, of_world, team_mean
from asv_env.envs.limits import limited
from asv_env.envs.row_attributes import RowAttributes
from asv_env.numerics import numerics
from asv_env.presets import Overrides, make_params
from asv_env.sensing.global_state import global_state, global_state_bound
from asv_env.simulation import Simulation
from asv_env.tasks import InitialStates, Task
from asv_env.types import Action, Bool, Observation, rows

try:
    from stable_baselines3.common.monitor import Monitor
    from stable_baselines3.common.vec_env import VecEnv
    from stable_baselines3.common.vec_env.base_vec_env import VecEnvIndices
except ImportError as error:
    raise ImportError(
        "asv_env.envs.sb3 needs stable-baselines3: pip install 'asv-env[train]'"
    ) from error

RowObservation = Observation | dict[str, Observation]  #: (rows, K), or with their worlds' states


class BoatVecEnv(Adapter, VecEnv):
    """A ``VecEnv`` whose rows are boats: boat i of world w is row ``w * A + i``.

    W is the number of worlds, A that of boats, K that of observed features.

    Observation: (W A, K) float32; with ``with_state`` a dictionary of "obs", the same, and
    "state" (W A, S) float32 of the row's world, for a centralised critic; see ``global_state``.
    Action: (W A, 2) float32 in [-1, 1]; finite values outside are clipped. With
    ``action_mode="discrete"`` (W A,) numbers of ``DISCRETE_ACTIONS``.
    Reward: (W A,) float32, one of each boat.
    End: as in ``JointEnv``; the world begins its next episode in the same step.
    Info: at the end of an episode "terminal_observation", "TimeLimit.truncated", "episode" (r,
    l, t, as a ``Monitor`` writes) and the metrics, see ``metrics.summary``.

    With ``flat`` a row is a world, and one agent drives all its boats: observation (W, A K), action
    (W, 2 A), or (W, A) if discrete, reward (W,), the mean of the boats' rewards.

    ``seed`` and ``set_options`` count in rows; a world takes those of its first row. SB3's
    ``evaluate_policy`` counts episodes in rows too: multiply ``n_eval_episodes`` by the boats.

    Args:
        task, num_boats, scenario: as in ``JointEnv``.
        num_envs: W, the number of worlds.
        render_mode: None, "rgb_array" or "human", which shows world 0.
        stagger: whether the first episode of world w after a reset is shortened to the fraction
            (w + 1) / W of the time limit, so that not all worlds truncate in the same step.
        num_threads: see ``Simulation``.
        initial_states: distribution of the initial states, see ``Simulation``.
        with_state: whether the state of the world is observed too.
        flat, max_episode_steps: as in ``JointEnv``.
        **options: see ``presets.make_params``.
    """

    num_envs: int  #: rows, W A; W with ``flat``
    num_worlds: int  #: W

    def __init__(
        self,
        task: str | Task = "transport",
        num_envs: int = 64,
        num_boats: int | None = None,
        scenario: str | Overrides = "nominal",
        render_mode: str | None = None,
        stagger: bool = False,
        num_threads: int | None = None,
        initial_states: InitialStates | None = None,
        with_state: bool = False,
        flat: bool = False,
        max_episode_steps: int | None = None,
        **options: Any,
    ) -> None:
        num_envs = Whole(1).checked("num_envs", num_envs)
        params = make_params(task, num_boats, scenario, **options)
        params = limited(params, options, max_episode_steps=max_episode_steps)
        simulation = Simulation(params, num_envs, num_threads, initial_states)
        self._open(simulation, render_mode)
        self.num_worlds, self._rows = num_envs, 1 if flat else params.num_boats  # of a world
        self._stagger, self._with_state = stagger, with_state
        self._limit = np.full(num_envs, params.time_limit_ticks)
        self._return = np.zeros((num_envs, self._rows))
        self._actions: Action | None = None
        self._began = time.time()
        boat, action_space = self._boat_spaces()
        self._shape = (num_envs, params.num_boats, *(boat.shape or ()))
        observation_space = boat
        if flat:
            observation_space, action_space = self._boat_spaces(params.num_boats, flat=True)
        self._attributes = RowAttributes(self, num_envs * self._rows)
        if with_state:
            bound = global_state_bound(params.num_boats)
            observation_space = Dict({"obs": observation_space, "state": Box(-bound, bound)})
        super().__init__(num_envs * self._rows, observation_space, action_space)
        self.metadata["render_fps"] = params.clock.control

    @numerics()
    def reset(self) -> RowObservation:
        """Begins episodes with the seeds and options that were set; returns all observations.

        Raises:
            ValueError: a bad seed or goal, or the environment is closed.
        """
        self._require("reset", Stage.NEW, Stage.RUNNING)
        seeds = self._seeds[:: self._rows]
        goals = [goal_option(options) for options in self._options[:: self._rows]]
        goals = [None if goal is None else self.params.checked_goal(goal) for goal in goals]
        observation = np.zeros(self._shape, dtype=np.float32)
        for goal in dict.fromkeys(goals):
            mask = np.array([other == goal for other in goals])
            chosen = [seeds[world] for world in np.flatnonzero(mask)]
            observation[mask] = self.simulation.reset(mask, chosen, goal)
        self._reset_seeds()
        self._reset_options()
        self.reset_infos = [{} for _ in range(self.num_envs)]
        shares = np.arange(1, self.num_worlds + 1) / self.num_worlds if self._stagger else 1.0
        self._limit[...] = np.ceil(shares * self.params.time_limit_ticks)
        self._return[...] = 0.0
        self._actions = None
        self._stage = Stage.RUNNING
        self._show()
        return self._by_row(observation, slice(None))

    def step_async(self, actions: Action) -> None:
        """Takes the actions of the next step, a row each.

        Raises:
            ValueError: a wrong shape; ``ResetNeededError`` before a reset, ``ClosedError``
                after close.
        """
        self._require("step", Stage.RUNNING)
        actions = np.array(actions)
        shape = (self.num_envs, *(self.action_space.shape or ()))
        if actions.shape != shape:
            raise ValueError(f"actions of shape {actions.shape}: must be {shape}")
        self._actions = actions.reshape(self.num_worlds, -1, *self._action_shape)

    @numerics()
    def step_wait(self) -> tuple[RowObservation, Observation, Bool, list[dict[str, Any]]]:
        """Advances every world by one control step, and into its next episode if it is over.

        Returns:
            Observations, rewards and dones of all rows, an info for each.

        Raises:
            ValueError: NaN or infinity among the actions.
            RuntimeError: there are none.
        """
        if self._actions is None:
            raise RuntimeError("step_wait: there are no actions; call step_async first")
        step, self._actions = self.simulation.step(self._actions), None
        reward = step.reward if self._rows > 1 else team_mean(step.reward)[:, None]
        self._return += reward
        observation, terminated = step.observation, step.ending.terminated
        over = terminated | (self.simulation.state.tick >= self._limit)
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        if over.any():
            self._report_ends(infos, over, terminated, observation)
            observation[over] = self.simulation.reset(over)
            self._return[over] = 0.0
            self._limit[over] = self.params.time_limit_ticks
        self._show()
        by_row = self._by_row(observation, slice(None))
        rewards = reward.astype(np.float32).reshape(-1)
        return by_row, rewards, np.repeat(over, self._rows), infos

    def _report_ends(
        self, infos: list[dict[str, Any]], over: Bool, terminated: Bool, observation: Observation
    ) -> None:
        """Fills the infos of the rows whose episodes end."""
        worlds = np.flatnonzero(over)
        last = self._by_row(observation[worlds], worlds)  # copies
        elapsed = round(time.time() - self._began, 6)
        metrics = metrics_of(self.simulation)
        for number, world in enumerate(map(int, worlds)):
            length = int(self.simulation.state.tick[world])
            for one, total in enumerate(self._return[world].tolist()):
                infos[world * self._rows + one] = {
                    **of_world(metrics, world),
                    "terminal_observation": _row(last, number * self._rows + one),
                    "TimeLimit.truncated": not terminated[world],
                    "episode": {"r": total, "l": length, "t": elapsed},
                }

    def render(self, mode: str | None = None) -> Any:
        """Returns all worlds tiled in a frame (H, W, 3) uint8; "human" shows world 0."""
        return self._frame() if self.render_mode == "human" else VecEnv.render(self, mode)

    def get_images(self) -> list[Any]:
        """Returns a frame (H, W, 3) uint8 of every world."""
        return [self._frame(world) for world in range(self.num_worlds)]

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> list[Any]:
        """Returns an attribute for each row; those of the environment are shared by all rows."""
        return self._attributes.get(attr_name, self._get_indices(indices))

    def set_attr(self, attr_name: str, value: Any, indices: VecEnvIndices = None) -> None:
        """Sets an attribute of rows; ValueError for some rows of one that all share."""
        rows = self._get_indices(indices)
        self._attributes.set(attr_name, [value] * len(rows), rows)

    def env_method(
        self, method_name: str, *args: Any, indices: VecEnvIndices = None, **kwargs: Any
    ) -> list[Any]:
        """Calls a method of the environment once; returns its result for each row."""
        rows = self._get_indices(indices)
        result = getattr(self, method_name)(*args, **kwargs)
        return [result for _ in rows]

    def env_is_wrapped(self, wrapper_class: type, indices: VecEnvIndices = None) -> list[bool]:
        """Returns for each row whether it is wrapped: as if by a Monitor, whose work it does."""
        return [issubclass(Monitor, wrapper_class) for _ in self._get_indices(indices)]

    def _get_indices(self, indices: VecEnvIndices) -> list[int]:
        return self._attributes.checked(indices)

    def _by_row(self, observation: Observation, worlds: Any) -> RowObservation:
        """Returns the observations (n, A, K) of some worlds, by rows."""
        by_row = observation.reshape(len(observation) * self._rows, -1)
        if not self._with_state:
            return by_row
        state = global_state(rows(self.simulation.state, worlds), self.params)
        return {"obs": by_row, "state": np.repeat(state, self._rows, axis=0)}


def _row(seen: RowObservation, row: int) -> RowObservation:
    """Returns one row of observations."""
    if isinstance(seen, dict):
        return {name: values[row] for name, values in seen.items()}
    return seen[row]
