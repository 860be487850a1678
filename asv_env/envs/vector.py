"""Adapter: a Gymnasium VectorEnv, many worlds, one agent for all boats of each."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from asv_env.checks import choice
from asv_env.envs.common import Adapter, ResetNeededError, Stage, goal_option, team_mean
from asv_env.presets import Overrides, make_params
from asv_env.simulation import WORLDS_PER_SPACE, Simulation
from asv_env.tasks import Task
from asv_env.types import Action, Bool, Float, Observation, TimeStep

Infos = dict[str, Any]


class AsvVectorEnv(Adapter, VectorEnv[Observation, Action, np.ndarray]):
    """Many worlds at once: ``gymnasium.make_vec("asv_env/Transport-v0", num_envs=64)``.

    W is the number of worlds, A that of boats, K that of observed features.

    Observation: (W, A, K) float32.
    Action: (W, A, 2) float32 in [-1, 1]; finite values outside are clipped.
    Reward: (W,), the mean of the boats' rewards.
    End: success and leaving the arena terminate, the time limit truncates.
    Info: as in ``JointEnv``, in the format of Gymnasium's vector environments.

    Equal to Gymnasium's ``SyncVectorEnv`` of ``JointEnv``, to the bit with
    ``worlds_per_space=1``, and many times faster.

    Args:
        num_envs: W.
        task, num_boats, scenario: as in ``JointEnv``.
        render_mode: None, "rgb_array" or "human", which shows world 0.
        autoreset_mode: an ``AutoresetMode`` or its value. With NEXT_STEP the step after the end
            of an episode ignores the world's action and begins the next one, with reward 0;
            with SAME_STEP the last observation and info are in ``infos["final_obs"]`` and
            ``infos["final_info"]``; with DISABLED use ``reset(options={"reset_mask": ...})``.
        worlds_per_space: see ``Simulation``; with 1 results do not depend on the batch.
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
        worlds_per_space: int = WORLDS_PER_SPACE,
        **options: Any,
    ) -> None:
        if not isinstance(autoreset_mode, AutoresetMode):
            known = [mode.value for mode in AutoresetMode]
            autoreset_mode = AutoresetMode(choice("autoreset_mode", autoreset_mode, known))
        params = make_params(task, num_boats, scenario, **options)
        simulation = Simulation(params, num_envs, worlds_per_space)
        self._open(simulation, render_mode, autoreset_mode=autoreset_mode)
        self.num_envs, self._mode = num_envs, autoreset_mode
        spaces = self._boat_spaces(params.num_boats)
        self.single_observation_space, self.single_action_space = spaces
        self.observation_space, self.action_space = (batch_space(s, num_envs) for s in spaces)
        self._over = np.zeros(num_envs, dtype=np.bool_)
        self._latest = np.zeros(self.observation_space.shape or (), dtype=np.float32)

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Observation, Infos]:
        """Begins new episodes; returns observations (W, A, K) of all worlds and empty infos.

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
        self._latest[mask] = self.simulation.reset(mask, chosen, goal)
        if isinstance(seed, int):
            super().reset(seed=seed)
        self._over[mask] = False
        self._stage = Stage.RUNNING
        self._show()
        return self._latest.copy(), {}

    def step(self, actions: Action) -> tuple[Observation, Float, Bool, Bool, Infos]:
        """Advances all worlds by a control step under actions (W, A, 2), or into the next episode.

        Returns:
            Observations (W, A, K), rewards (W,), terminated (W,), truncated (W,), infos.

        Raises:
            ValueError: as ``JointEnv.step``, with autoreset not after the end of an episode.
        """
        self._require("step", Stage.RUNNING)
        resetting = self._over
        if resetting.any():
            actions = self._without(actions, resetting)
        step = self.simulation.step(actions)
        ending = step.ending
        terminated, truncated = ending.terminated & ~resetting, ending.truncated & ~resetting
        reward = np.where(resetting, 0.0, team_mean(step.reward))
        over = terminated | truncated
        same_step = self._mode is AutoresetMode.SAME_STEP
        infos = self._infos(step, over, ~resetting, same_step)
        observation = step.observation
        fresh = over if same_step else resetting
        if fresh.any():
            observation[fresh] = self.simulation.reset(fresh)
        self._over = over & (not same_step)
        self._latest[...] = observation
        self._show()
        return observation, reward, terminated, truncated, infos

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

    def _without(self, actions: Action, resetting: Bool) -> Action:
        """Returns actions that are 0 in the worlds whose next episode begins."""
        if self._mode is AutoresetMode.DISABLED:
            worlds = np.flatnonzero(resetting).tolist()
            raise ResetNeededError(
                f"step: the episodes of worlds {worlds} are over; call reset with "
                "options={'reset_mask': ...} first"
            )
        actions = np.array(actions)
        if actions.shape == self.action_space.shape:
            actions[resetting] = 0.0
        return actions

    def _infos(self, step: TimeStep, over: Bool, stepped: Bool, same_step: bool) -> Infos:
        terms = {name: team_mean(value) for name, value in step.terms.items()}
        continuing = stepped & ~over if same_step else stepped
        infos = _masked({"reward_terms": terms}, continuing) if continuing.any() else {}
        if not over.any():
            return infos
        summary = self.simulation.summary()
        if not same_step:
            return infos | _masked(summary, over)
        last = np.full(self.num_envs, None, dtype=object)
        for world in np.flatnonzero(over):
            last[world] = step.observation[world].copy()
        infos |= {"final_obs": last, "_final_obs": over.copy()}
        return infos | _masked({"final_info": {"reward_terms": terms, **summary}}, over)

    def _mask(self, mask: Any) -> Bool:
        mask = np.ones(self.num_envs, dtype=np.bool_) if mask is None else np.asarray(mask)
        if mask.shape != (self.num_envs,) or mask.dtype != np.bool_ or not mask.any():
            raise ValueError(
                f"reset_mask = {mask!r}: must be bool of shape ({self.num_envs},) with a True in it"
            )
        return mask

    def _seeds(self, seed: int | Sequence[int | None] | None) -> list[Any]:
        if isinstance(seed, Sequence | np.ndarray) and not isinstance(seed, str):
            if len(seed) != self.num_envs:
                raise ValueError(f"{len(seed)} seeds for {self.num_envs} worlds: give one for each")
            return list(seed)
        if isinstance(seed, int | np.integer) and not isinstance(seed, bool):
            return [seed + world for world in range(self.num_envs)]
        return [seed] * self.num_envs  # None, or what the simulation refuses


def _masked(values: Mapping[str, Any], mask: Bool) -> dict[str, Any]:
    """Returns values (W,) by name, zero outside a mask (W,), with their masks as Gymnasium does."""
    infos: dict[str, Any] = {}
    for name, value in values.items():
        if isinstance(value, Mapping):
            infos[name] = _masked(value, mask)
        else:
            infos[name] = np.where(mask, value, value.dtype.type(0))
        infos[f"_{name}"] = mask.copy()
    return infos
