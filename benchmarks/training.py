"""Parts of the time of a training: physics, torch, and all the rest.

``python benchmarks/training.py`` runs PPO as ``python -m train`` does, without evaluations and
checkpoints, on 64 worlds of 4 boats. It times three parts: the motion of the hulls and their
contacts (``Dynamics``: water, motors, Pymunk); what torch computes (forward passes, updates, the
minibatches that it gathers); and all the rest (sensing, observations, rewards, resets, buffers,
stable-baselines3). Worlds of one scenario share one simulation, in which each call of NumPy serves
all of them.
"""

from contextlib import ExitStack
from dataclasses import dataclass
from typing import Annotated
from unittest import mock

import torch
import tyro
from stable_baselines3.common.buffers import RolloutBuffer
from stable_baselines3.common.policies import ActorCriticPolicy
from stopwatch import Stopwatch

from asv_env.checks import check_whole
from asv_env.physics.basin import Basin
from asv_env.physics.dynamics import Dynamics
from baselines.rollout.commands import command
from train.config import Config
from train.sb3.ppo import Learner, TorchRolloutBuffer
from train.sb3.vec_env import TrainingVecEnv
from train.sections import WorldOptions

PARTS = (
    (Dynamics, "advance", "physics"),
    (Basin, "touching", "physics"),
    (ActorCriticPolicy, "forward", "torch"),
    (ActorCriticPolicy, "predict_values", "torch"),
    (Learner, "train", "torch"),
    (TorchRolloutBuffer, "_get_samples", "torch"),
    (RolloutBuffer, "add", "rest"),
)
"""Methods that are timed, with the part to which each belongs."""


@dataclass(frozen=True)
class Options:
    """Times the parts of a PPO training."""

    num_envs: int = 64  #: number of worlds
    task: str = "transport"  #: name of the task
    scenarios: tuple[str, ...] = WorldOptions.scenarios  #: of the worlds
    updates: int = 8  #: number of updates that are timed
    torch_threads: int = 2  #: number of threads of torch

    def __post_init__(self) -> None:
        check_whole(self, "updates", 1, 10**6)
        check_whole(self, "torch_threads", 1, 1024)


def time_parts(options: Annotated[Options, tyro.conf.arg(name="")]) -> None:
    """Time the parts of a PPO training."""
    torch.set_num_threads(options.torch_threads)
    worlds = {"scenarios": options.scenarios, "num_envs": options.num_envs}
    config = Config(options.task).changed(worlds=worlds, ppo={"critic_updates": 0})
    env = TrainingVecEnv(config)
    learner = Learner.create(config, env)
    rollout = env.num_envs * config.ppo.num_steps
    learner.learn(rollout)  # warms up
    watch = Stopwatch()
    with ExitStack() as patches:
        for owner, name, part in PARTS:
            timed = watch.timed(part, getattr(owner, name))
            patches.enter_context(mock.patch.object(owner, name, timed))
        batches = watch.timed_iterator("rest", RolloutBuffer.get)
        patches.enter_context(mock.patch.object(RolloutBuffer, "get", batches))
        learn = watch.timed("rest", learner.learn)
        learn(options.updates * rollout, reset_num_timesteps=False)
    total = sum(watch.seconds.values())
    print(f"{options.updates * rollout / total:,.0f} timesteps a second")
    for part in ("physics", "torch", "rest"):
        print(f"{part:8} {watch.seconds[part] / total:6.1%}")


main = command(time_parts, "python benchmarks/training.py")

if __name__ == "__main__":
    main()
