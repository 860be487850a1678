"""A ``VecEnv`` of several team sizes and scenarios side by side, in which a policy trains."""

from collections.abc import Iterable, Sequence
from functools import partial
from itertools import chain
from typing import Any

import numpy as np
from stable_baselines3.common.vec_env import VecEnv
from stable_baselines3.common.vec_env.base_vec_env import VecEnvIndices

from asv_env.envs.sb3 import BoatVecEnv, RowObservation
from asv_env.types import Action, Bool, Observation
from baselines.distributed import distributed
from baselines.scripted.scripted_policy import ScriptedPolicy
from train.config import Config
from train.curriculum import adapter_options, rollout_states


class TrainingVecEnv(VecEnv):
    """One ``BoatVecEnv`` for each combination of team size and scenario, their rows joined."""

    def __init__(self, config: Config) -> None:
        self._config = config
        self._groups = config.worlds.groups(config.worlds.num_envs)
        self._states = [rollout_states(config, *group) for group in self._groups]
        self._parts = self._create(config.curriculum.first_progress)
        rows = [part.num_envs for part in self._parts]
        self._cuts = np.cumsum(rows)[:-1]
        first = self._parts[0]
        super().__init__(sum(rows), first.observation_space, first.action_space)

    def restart(self, progress: float, seed: int) -> Any:
        """Makes all worlds again and begins their episodes; returns observations of all rows.

        What follows depends on the progress of the curriculum and the seed of the first world
        alone; the seeds of the others count up from it.
        """
        self.close()
        self._parts = self._create(progress)
        self.seed(seed)
        return self.reset()

    def _create(self, progress: float) -> list[BoatVecEnv]:
        config = self._config
        residual, with_state = config.network.residual, config.network.critic == "central"
        adapter: Any = partial(ResidualVecEnv, scale=residual) if residual else BoatVecEnv
        parts = []
        for states, (group, worlds) in zip(self._states, self._groups.items(), strict=True):
            options = adapter_options(config, group, states, progress)
            parts.append(adapter(num_envs=worlds, stagger=True, with_state=with_state, **options))
        return parts

    def reset(self) -> Any:
        """Begins new episodes in all worlds."""
        return _joined([part.reset() for part in self._parts])

    def step_async(self, actions: Action) -> None:
        """Takes the actions of all rows."""
        for part, some in zip(self._parts, np.split(actions, self._cuts), strict=True):
            part.step_async(some)

    def step_wait(self) -> Any:
        """See ``BoatVecEnv.step_wait``."""
        steps = zip(*(part.step_wait() for part in self._parts), strict=True)
        observations, *numbers, infos = steps
        rewards, dones = map(np.concatenate, numbers)
        return _joined(observations), rewards, dones, list(chain.from_iterable(infos))

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

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> list[Any]:
        """Returns an attribute, once for each row."""
        return self._of_rows((part.get_attr(attr_name) for part in self._parts), indices)

    def set_attr(self, attr_name: str, value: Any, indices: VecEnvIndices = None) -> None:
        """Sets an attribute of all worlds."""
        for part in self._parts:
            part.set_attr(attr_name, value)

    def env_method(
        self, method_name: str, *args: Any, indices: VecEnvIndices = None, **kwargs: Any
    ) -> list[Any]:
        """Calls a method of all worlds and returns its result, once for each row."""
        results = [part.env_method(method_name, *args, **kwargs) for part in self._parts]
        return self._of_rows(results, indices)

    def env_is_wrapped(self, wrapper_class: Any, indices: VecEnvIndices = None) -> list[bool]:
        """Returns whether each row is wrapped; see ``BoatVecEnv.env_is_wrapped``."""
        return self._of_rows((part.env_is_wrapped(wrapper_class) for part in self._parts), indices)

    def _of_rows(self, values: Iterable[list[Any]], indices: VecEnvIndices) -> list[Any]:
        """Returns those of some rows, of values by part and row."""
        by_row = list(chain.from_iterable(values))
        return [by_row[row] for row in self._get_indices(indices)]

    def set_options(self, options: Any = None) -> None:
        """Refuses options: episodes of a training begin as its curriculum says."""
        raise NotImplementedError("the worlds of a training are set up by its options alone")


class ResidualVecEnv(BoatVecEnv):
    """A ``BoatVecEnv`` whose actions, scaled, are added to those of the scripted policy."""

    def __init__(self, *args: Any, scale: float, **options: Any) -> None:
        super().__init__(*args, **options)
        scripted = ScriptedPolicy(self.params)
        self._scale, self._scripted = scale, distributed(scripted, self.params)
        self._memory: Any = None
        self._fresh = np.ones(self.num_worlds, dtype=np.bool_)

    def reset(self) -> RowObservation:
        """See ``BoatVecEnv.reset``."""
        self._fresh[...] = True
        return super().reset()

    def step_async(self, actions: Action) -> None:
        """Takes the corrections (W A, 2) of the next step."""
        sensed = self.simulation.sensed
        unused = np.empty(0, dtype=np.float32)  # the scripted policy reads what is sensed
        scripted, self._memory = self._scripted.act(sensed, unused, self._memory, self._fresh)
        super().step_async(scripted.reshape(-1, 2) + self._scale * np.asarray(actions))

    def step_wait(self) -> tuple[RowObservation, Observation, Bool, list[dict[str, Any]]]:
        """See ``BoatVecEnv.step_wait``."""
        seen, reward, done, infos = super().step_wait()
        self._fresh = done.reshape(self.num_worlds, -1)[:, 0].copy()
        return seen, reward, done, infos


def _joined(parts: Sequence[Any]) -> Any:
    """Returns the observations of all rows, as an array or a dictionary of arrays."""
    if isinstance(parts[0], dict):
        return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    return np.concatenate(parts)
