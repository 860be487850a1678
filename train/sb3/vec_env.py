"""The worlds of a training: several team sizes and scenarios side by side, as one ``VecEnv``."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from itertools import chain
from typing import Any

import gymnasium
import numpy as np
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import VecEnv
from stable_baselines3.common.vec_env.base_vec_env import VecEnvIndices

from asv_env.envs.sb3 import BoatVecEnv
from asv_env.presets import make_params
from asv_env.types import Action
from train.config import Config
from train.curriculum import Midway, Starts, grown, training_params
from train.sb3.residual import CorrectedVecEnv

WATCHED, LEAST_WATCHED = 384, 24
"""Episodes from which midway starts are taken, shared out over the groups; least of a group."""


class Worlds(VecEnv):
    """One ``BoatVecEnv`` for each combination of team size and scenario, their rows joined.

    Args:
        config: of the run.
    """

    def __init__(self, config: Config) -> None:
        self._config = config
        self._groups = config.shared_out(config.num_envs)
        self._midways = [self._midway(*group) for group in self._groups]
        self._parts = self._made(config.first_share)
        rows = [part.num_envs for part in self._parts]
        self._cuts = np.cumsum(rows)[:-1]
        first = self._parts[0]
        super().__init__(sum(rows), first.observation_space, first.action_space)

    def renew(self, share: float, seed: int) -> Any:
        """Makes all worlds anew and begins their episodes.

        Whatever was in them is gone: what follows depends on these two arguments alone.

        Args:
            share: to which goals, noise and variation have grown.
            seed: of the first world; the others count up from it.

        Returns:
            Observations of all rows.
        """
        self.close()
        self._parts = self._made(share)
        self.seed(seed)
        return self.reset()

    def _made(self, share: float) -> list[BoatVecEnv]:
        config = self._config
        made: Any = BoatVecEnv
        if config.residual:
            made = partial(CorrectedVecEnv, share=config.residual)
        parts = []
        for number, ((team, scenario), worlds) in enumerate(self._groups.items()):
            params = grown(training_params(config, team, scenario), share)
            parts.append(
                made(
                    config.task,
                    worlds,
                    team,
                    scenario,
                    stagger=True,
                    initial_states=Starts(config, self._midways[number], share),
                    with_state=config.critic == "central",
                    clock=params.clock,
                    sensors=params.sensors,
                    variation=params.variation,
                    task_params=params.task,
                )
            )
        return parts

    def _midway(self, team: int, scenario: str) -> Midway | None:
        if not self._config.midway_starts:
            return None
        config = self._config
        watched = max(LEAST_WATCHED, WATCHED // len(self._groups))
        seeds = range(config.first_seed, config.first_seed + watched)
        if config.hand_over is not None:
            params = make_params("transport", team, scenario)
            return Midway.handed_over(config.hand_over, params, seeds)
        return Midway.watched(config, make_params(config.task, team, scenario), seeds)

    def reset(self) -> Any:
        """Begins new episodes everywhere."""
        return _joined([part.reset() for part in self._parts])

    def step_async(self, actions: Action) -> None:
        """Takes the actions of all rows."""
        for part, some in zip(self._parts, np.split(actions, self._cuts), strict=True):
            part.step_async(some)

    def step_wait(self) -> Any:
        """See ``BoatVecEnv.step_wait``."""
        observations, rewards, dones, infos = zip(
            *(part.step_wait() for part in self._parts), strict=True
        )
        told = list(chain.from_iterable(infos))
        return _joined(observations), np.concatenate(rewards), np.concatenate(dones), told

    def close(self) -> None:
        """Closes all worlds."""
        for part in self._parts:
            part.close()

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Seeds the rows of all worlds, which count up from ``seed``."""
        given: list[int | None] = []
        for part in self._parts:
            given += part.seed(None if seed is None else seed + len(given))
        return given

    def set_options(self, options: Any = None) -> None:
        """Not for a training, whose episodes begin as its curriculum says."""
        raise NotImplementedError("the worlds of a training take no options")

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> list[Any]:
        """An attribute of every row."""
        values = list(chain.from_iterable(part.get_attr(attr_name) for part in self._parts))
        return [values[row] for row in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: VecEnvIndices = None) -> None:
        """Sets an attribute of all worlds."""
        for part in self._parts:
            part.set_attr(attr_name, value)

    def env_method(
        self,
        method_name: str,
        *method_args: Any,
        indices: VecEnvIndices = None,
        **method_kwargs: Any,
    ) -> list[Any]:
        """Calls a method of all worlds; its result by row."""
        results = [
            part.env_method(method_name, *method_args, **method_kwargs) for part in self._parts
        ]
        values = list(chain.from_iterable(results))
        return [values[row] for row in self._get_indices(indices)]

    def env_is_wrapped(
        self,
        wrapper_class: type[gymnasium.Wrapper[Any, Any, Any, Any]],
        indices: VecEnvIndices = None,
    ) -> list[bool]:
        """As if every row had a Monitor, see ``BoatVecEnv``."""
        return [issubclass(Monitor, wrapper_class) for _ in self._get_indices(indices)]


def _joined(parts: Sequence[Any]) -> Any:
    """Observations of all rows, of arrays or of dictionaries of arrays."""
    if isinstance(parts[0], dict):
        return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    return np.concatenate(parts)
