"""Where the time of a training goes: physics, torch, and what is neither.

``python benchmarks/training.py`` runs PPO as ``python -m train`` does, on 64 worlds of 4 boats, and
times three parts of it: the motion of the hulls and their contacts (``Dynamics``: water, motors,
Pymunk), what is computed by torch (forward passes, updates, the minibatches that it gathers), and
all the rest (sensing, observations, rewards, resets, buffers, stable-baselines3). Nothing runs
beside it that is not part of a training; without evaluations and checkpoints. ``--help`` says how
to choose the worlds: those of one scenario share one simulation, in which each call of NumPy serves
all of them.
"""

from __future__ import annotations

import argparse
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any
from unittest import mock

import torch
from stable_baselines3.common.buffers import RolloutBuffer
from stable_baselines3.common.policies import ActorCriticPolicy

from asv_env.physics.dynamics import Dynamics
from train.config import Config
from train.sb3.buffer import TorchRolloutBuffer
from train.sb3.ppo import Learner
from train.sb3.vec_env import TrainingVecEnv


class Clock:
    """Adds up the time spent in functions, each without those that it calls."""

    def __init__(self) -> None:
        self.spent: dict[str, float] = defaultdict(float)
        self._running: list[str] = []
        self._since = time.perf_counter()

    def _charge(self) -> None:
        now = time.perf_counter()
        if self._running:
            self.spent[self._running[-1]] += now - self._since
        self._since = now

    def timed(self, name: str, function: Callable[..., Any]) -> Callable[..., Any]:
        """The function, whose time goes to ``name``."""

        def call(*args: Any, **kwargs: Any) -> Any:
            self._charge()
            self._running.append(name)
            try:
                return function(*args, **kwargs)
            finally:
                self._charge()
                self._running.pop()

        return call

    def timed_iterator(self, name: str, function: Callable[..., Any]) -> Callable[..., Any]:
        """The same of a function that yields."""

        def call(*args: Any, **kwargs: Any) -> Iterator[Any]:
            following = self.timed(name, partial(next, function(*args, **kwargs), None))
            while (item := following()) is not None:
                yield item

        return call


PARTS = (
    (Dynamics, "advance", "physics"),
    (Dynamics, "touching", "physics"),
    (ActorCriticPolicy, "forward", "torch"),
    (ActorCriticPolicy, "predict_values", "torch"),
    (Learner, "train", "torch"),
    (TorchRolloutBuffer, "_get_samples", "torch"),
    (RolloutBuffer, "add", "rest"),
)


def main() -> None:
    """Prints the shares."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--num-envs", type=int, default=64, help="worlds (%(default)s)")
    parser.add_argument("--task", default="transport")
    parser.add_argument("--scenarios", nargs="+", default=list(Config.scenarios))
    parser.add_argument("--updates", type=int, default=8, help="that are timed (%(default)s)")
    parser.add_argument("--torch-threads", type=int, default=2)
    options = parser.parse_args()
    torch.set_num_threads(options.torch_threads)
    config = Config(
        task=options.task,
        scenarios=tuple(options.scenarios),
        num_envs=options.num_envs,
        critic_updates=0,
    )
    worlds = TrainingVecEnv(config)
    learner = Learner.create(config, worlds)
    rollout = worlds.num_envs * config.num_steps
    learner.learn(rollout)  # warms up
    clock = Clock()
    patches = [
        mock.patch.object(owner, name, clock.timed(part, getattr(owner, name)))
        for owner, name, part in PARTS
    ]
    batches = clock.timed_iterator("rest", RolloutBuffer.get)
    patches.append(mock.patch.object(RolloutBuffer, "get", batches))
    for patch in patches:
        patch.start()
    clock.timed("rest", learner.learn)(options.updates * rollout, reset_num_timesteps=False)
    for patch in patches:
        patch.stop()
    total = sum(clock.spent.values())
    print(f"{options.updates * rollout / total:,.0f} timesteps a second")
    for part in ("physics", "torch", "rest"):
        print(f"{part:8} {clock.spent[part] / total:6.1%}")


if __name__ == "__main__":
    main()
