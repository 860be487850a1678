"""Adapter: a Gymnasium VectorEnv, many worlds, one agent for all boats of each."""

from collections.abc import Sequence
from numbers import Integral
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from asv_env.checks import Whole, choice, plain
from asv_env.envs.common import Adapter, ResetNeededError, Stage, goal_option, world_seeds
from asv_env.envs.infos import masked, put_blocks, team_blocks, team_mean
from asv_env.envs.limits import limited
from asv_env.envs.row_attributes import RowAttributes
from asv_env.numerics import numerics
from asv_env.presets import Overrides, make_params
from asv_env.simulation import Simulation
from asv_env.tasks import Task
from asv_env.tasks.metrics import Block
from asv_env.types import Action, Bool, Float, Observation

Infos = dict[str, Any]
SINGLE = {name: f"single_{name}" for name in ("observation_space", "action_space")}
"""Attributes of a world that have another name for all worlds."""


class AsvVectorEnv(Adapter, VectorEnv[Observation, Action, np.ndarray]):
    """Many worlds at once: ``gymnasium.make_vec("asv_env/Transport-v0", num_envs=64)``.

    W is the number of worlds, A that of boats, K that of observed features.

    Observation: (W, A, K) float32; (W, A K) with ``flat``.
    Action: (W, A, 2) float32 in [-1, 1], (W, 2 A) with ``flat``; finite values outside are
    clipped. With ``action_mode="discrete"`` (W, A) numbers of ``DISCRETE_ACTIONS``.
    Reward: (W,), the mean of the boats' rewards.
    End: success and leaving the arena terminate, the time limit truncates.
    Info: as in ``JointEnv``, in the format of Gymnasium's vector environments.

    Equal to Gymnasium's ``SyncVectorEnv`` of ``JointEnv``, to the bit, and many times faster.

    Args:
        num_envs: W.
        task, num_boats, scenario: as in ``JointEnv``.
        render_mode: None, "rgb_array" or "human", which shows world 0.
        autoreset_mode: an ``AutoresetMode`` or its value. With NEXT_STEP the step after the end
            of an episode ignores the world's action and begins the next one, with reward 0;
            with SAME_STEP the last observation and info are in ``infos["final_obs"]`` and
            ``infos["final_info"]``; with DISABLED use ``reset(options={"reset_mask": ...})``.
        num_threads: see ``Simulation``.
        flat, max_episode_steps: as in ``JointEnv``.
        disable_env_checker: as ``gymnasium.make`` has it; there is no checker here.
        **options: see ``presets.make_params``.
    """

    metadata: dict[str, Any] = {**Adapter.metadata, "autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(
        self,
        num_envs: int = 1,
        task: str | Task = "transport",
        num_boats: int | None = None,
        scenario: str | Overrides = "nominal",
        render_mode: str | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        num_threads: int | None = None,
        flat: bool = False,
        max_episode_steps: int | None = None,
        disable_env_checker: bool | None = None,
        **options: Any,
    ) -> None:
        if not isinstance(autoreset_mode, AutoresetMode):
            known = [mode.value for mode in AutoresetMode]
            autoreset_mode = AutoresetMode(choice("autoreset_mode", autoreset_mode, known))
        num_envs = Whole(1).checked("num_envs", num_envs)
        params = make_params(task, num_boats, scenario, **options)
        params = limited(params, options, max_episode_steps=max_episode_steps)
        simulation = Simulation(params, num_envs, num_threads)
        self._open(simulation, render_mode, autoreset_mode=autoreset_mode)
        self.num_envs, self.autoreset_mode = num_envs, autoreset_mode
        spaces = self._boat_spaces(params.num_boats, flat=flat)
        self.single_observation_space, self.single_action_space = spaces
        self.observation_space, self.action_space = (batch_space(s, num_envs) for s in spaces)
        self._shapes = tuple((num_envs, *(space.shape or ())) for space in spaces)
        self._attributes = RowAttributes(self, num_envs)
        self._over = np.zeros(num_envs, dtype=np.bool_)
        self._some_over = False  # whether one of them is
        self._latest = np.zeros(self._shapes[0], dtype=np.float32)

    @numerics()
    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Observation, Infos]:
        """Begins new episodes; returns the observations of all worlds and their infos.

        Args:
            seed: seed of world 0, world i gets ``seed + i``; or one for each world; None
                continues the worlds' Generators.
            options: as in ``JointEnv``; and "reset_mask" (W,) bool selects the worlds to reset.

        Raises:
            ValueError: bad seeds, goal or mask, or the environment is closed.
            TypeError: options that are not a mapping.
        """
        self._require("reset", Stage.NEW, Stage.RUNNING)
        goal = goal_option(options, others=["reset_mask"])
        mask = self._mask((options or {}).get("reset_mask"))
        seeds = self._seeds(seed)
        chosen = [seeds[world] for world in np.flatnonzero(mask)]
        observation = self.simulation.reset(mask, chosen, goal)
        self._latest[mask] = observation.reshape(len(chosen), *self._shapes[0][1:])
        if isinstance(seed, Integral):
            super().reset(seed=int(seed))
        self._over[mask] = False
        self._some_over = bool(self._over.any())
        self._stage = Stage.RUNNING
        self._show()
        return self._latest.copy(), masked(team_blocks(self.simulation), mask)

    @numerics()
    def step(self, actions: Action) -> tuple[Observation, Float, Bool, Bool, Infos]:
        """Advances all worlds by a control step under actions, or into the next episode.

        Returns:
            Observations, rewards (W,), terminated (W,), truncated (W,), infos.

        Raises:
            ValueError: as ``JointEnv.step``, with autoreset not after the end of an episode.
        """
        self._require("step", Stage.RUNNING)
        waiting = self._some_over  # for a reset by this step
        step = self.simulation.step(self._checked(actions))
        ending, reward = step.ending, team_mean(step.reward)
        terminated, truncated = ending.terminated.copy(), ending.truncated.copy()
        if waiting:
            reward = np.where(self._over, 0.0, reward)
            terminated &= ~self._over
            truncated &= ~self._over
        blocks, observation = team_blocks(self.simulation, step), step.observation
        # Where none is over and none was, there is nothing to begin.
        over, same_step = terminated | truncated, self.autoreset_mode is AutoresetMode.SAME_STEP
        some_over = self.simulation.some_over and bool(over.any())
        fresh = over if same_step else self._over
        final = self._final(observation, blocks, over) if same_step and some_over else {}
        if some_over if same_step else waiting:
            observation[fresh] = self.simulation.reset(fresh)
            put_blocks(blocks, team_blocks(self.simulation), fresh)
        infos = masked(blocks) | final
        self._over = np.zeros_like(over) if same_step else over
        self._some_over = some_over and not same_step
        self._latest = observation.reshape(self._shapes[0])
        self._show()
        return self._latest.copy(), reward, terminated, truncated, infos

    def call(self, name: str, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        """Returns what a method or an attribute gives for each world; worlds share most of them.

        Raises:
            ValueError: a method that acts on all worlds at once.
        """
        if name in ("reset", "step", "close"):
            raise ValueError(f"call({name!r}): it acts on all worlds at once; use env.{name}")
        values = self._attributes.get(SINGLE.get(name, name), range(self.num_envs))
        if any(value is not values[0] for value in values):  # the worlds' own
            return tuple(one(*args, **kwargs) if callable(one) else one for one in values)
        result = values[0](*args, **kwargs) if callable(values[0]) else values[0]
        return result if name == "render" else (result,) * self.num_envs

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """Returns an attribute for each world, see ``call``."""
        return self.call(name)

    def set_attr(self, name: str, values: Any) -> None:
        """Sets an attribute: a list or tuple has a value for each world, anything else is for all.

        Raises:
            ValueError: another number of values, or the worlds share this attribute.
        """
        values = values if isinstance(values, list | tuple) else [values] * self.num_envs
        if len(values) != self.num_envs:
            raise ValueError(f"{len(values)} values for {self.num_envs} worlds: give one for each")
        self._attributes.set(name, values, range(self.num_envs))

    def render(self) -> tuple[Any, ...]:
        """Returns frames (H, W, 3) uint8 of all worlds; with "human" the window shows world 0."""
        if self.render_mode == "human":
            self._frame()
            return (None,) * self.num_envs
        return tuple(self._frame(world) for world in range(self.num_envs))

    close = VectorEnv.close

    def close_extras(self, **kwargs: Any) -> None:
        """Closes the window, if there is one; the environment cannot be used any more."""
        Adapter.close(self)

    def _checked(self, actions: Action) -> Action:
        """Returns actions by boat, which are 0 in the worlds whose next episode begins."""
        if self._some_over and self.autoreset_mode is AutoresetMode.DISABLED:
            worlds = np.flatnonzero(self._over).tolist()
            raise ResetNeededError(
                f"step: the episodes of worlds {worlds} are over; call reset with "
                "options={'reset_mask': ...} first"
            )
        actions = np.array(actions)
        if actions.shape != self._shapes[1]:
            raise ValueError(f"actions of shape {actions.shape}: must be {self._shapes[1]}")
        if self._some_over:
            actions[self._over] = 0.0
        return actions.reshape(self.num_envs, -1, *self._action_shape)

    def _final(self, observation: Observation, blocks: list[Block], over: Bool) -> Infos:
        """Returns the last observations and infos of the worlds whose episodes are over."""
        last = np.full(self.num_envs, None, dtype=object)
        for world in np.flatnonzero(over):
            last[world] = observation[world].reshape(self._shapes[0][1:]).copy()
        infos = {"final_info": masked(blocks, over), "_final_info": over.copy()}
        return {"final_obs": last, "_final_obs": over.copy(), **infos}

    def _mask(self, mask: Any) -> Bool:
        mask = np.ones(self.num_envs, dtype=np.bool_) if mask is None else np.asarray(mask)
        if mask.shape != (self.num_envs,) or mask.dtype != np.bool_ or not mask.any():
            raise ValueError(
                f"reset_mask = {mask!r}: must be bool of shape ({self.num_envs},) with a True in it"
            )
        return mask

    def _seeds(self, seed: int | Sequence[int | None] | None) -> list[Any]:
        seed = plain(seed)
        if isinstance(seed, Sequence) and not isinstance(seed, str):
            if len(seed) != self.num_envs:
                raise ValueError(f"{len(seed)} seeds for {self.num_envs} worlds: give one for each")
            return list(seed)
        return world_seeds(seed, self.num_envs)
