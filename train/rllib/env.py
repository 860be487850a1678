"""The worlds of a training as RLlib wants them, and how they are numbered over its processes."""

from typing import Any

import numpy as np
from ray.rllib.env.wrappers.pettingzoo_env import ParallelPettingZooEnv

from asv_env.envs.parallel import AsvParallelEnv
from train.config import Config
from train.curriculum import adapter_options

SEED_LIMIT = 2**31  #: RLlib takes seeds below this number


def num_processes(config: Config) -> int:
    """Returns the number of processes that sample; without any others this one does."""
    return max(1, config.compute.num_env_runners)


def worlds_per_process(config: Config) -> int:
    """Returns the number of worlds of each process."""
    return -(-config.worlds.num_envs // num_processes(config))


def num_worlds(config: Config) -> int:
    """Returns the number of worlds of all processes, at least as many as are asked for."""
    return worlds_per_process(config) * num_processes(config)


def world_number(seed: int, first: int, process: int, worlds: int) -> int:
    """Returns the number of a world within the training, from 0, from the seed that RLlib gives it.

    RLlib seeds world w of process p with ``first + p + w``, so that worlds of different processes
    share seeds. Their numbers must differ. The processes that sample count from 1, each with
    ``worlds``; without any, process 0 samples. ``first`` is the seed of the training.

    >>> [world_number(100 + 1 + w, 100, process=1, worlds=3) for w in range(3)]
    [0, 1, 2]
    >>> [world_number(100 + 2 + w, 100, process=2, worlds=3) for w in range(3)]
    [3, 4, 5]
    """
    return seed - first - process + max(0, process - 1) * worlds


class Boats(ParallelPettingZooEnv):
    """A world of the training.

    RLlib 2.60 takes an episode for terminated when each of its agents is truncated, and values
    its end at nothing: so the end of the time is reported by ``__all__`` alone. The number of a
    world decides its scenario and the length of its first episode, so that not all worlds end in
    the same step.

    Args:
        context: an ``EnvContext`` with ``config`` of the run and ``seed`` of its first world.
    """

    par_env: AsvParallelEnv

    def __init__(self, context: Any) -> None:
        self._context = context
        self._ticks_left = -1
        super().__init__(self._create(0))

    def _create(self, number: int) -> AsvParallelEnv:
        config = self._context["config"]
        team, scenarios = config.worlds.teams[0], config.worlds.scenarios
        group = team, scenarios[number % len(scenarios)]
        return AsvParallelEnv(**adapter_options(config, group, None, 1.0))

    def reset(self, *, seed: int | None = None, options: Any = None) -> Any:
        """Begins an episode; with a seed the first one of the world that has it."""
        self._ticks_left = -1
        if seed is not None:
            config, first = self._context["config"], self._context["seed"]
            process, worlds = self._context.worker_index, worlds_per_process(config)
            number = world_number(seed, first % SEED_LIMIT, process, worlds)
            self.par_env.close()
            self.par_env = self._create(number)
            fraction = (number + 1) / num_worlds(config)
            self._ticks_left = int(np.ceil(fraction * self.par_env.params.time_limit_ticks))
            seed = first + number
        return super().reset(seed=seed, options=options)

    def step(self, action_dict: dict[str, Any]) -> Any:
        """Advances the world by a decision of each boat."""
        *step, truncated, infos = super().step(action_dict)
        self._ticks_left -= 1
        return *step, {"__all__": truncated["__all__"] or self._ticks_left == 0}, infos
