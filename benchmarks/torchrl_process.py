"""TorchRL environments, to be timed: ``python benchmarks/torchrl_process.py SUBJECT WORLDS``.

``asv`` is ``TorchRLEnv`` and ``wrapper`` TorchRL's ``PettingZooWrapper`` of ``parallel_env``, both
in the situation "unconstrained" of ``subjects.py``; ``vmas`` is TorchRL's wrapper of VMAS
``transport`` with four agents. Actions are drawn beforehand, and episodes that end begin again.
"""

import itertools
import sys
import warnings
from collections.abc import Callable
from typing import Any

import torch
from turns import serve

NUM_BOATS = 4
ACTIONS = 32  #: number of actions that are drawn beforehand and used in turn


def asv(worlds: int) -> Any:
    """Returns many worlds of this package."""
    from subjects import SITUATIONS

    import asv_env

    options = SITUATIONS["unconstrained"].options
    return asv_env.TorchRLEnv("transport", worlds, seed=0, num_threads=1, **options)


def wrapper(worlds: int) -> Any:
    """Returns one world of this package as TorchRL wraps it."""
    from subjects import SITUATIONS
    from torchrl.envs import PettingZooWrapper

    import asv_env

    single = asv_env.parallel_env("transport", **SITUATIONS["unconstrained"].options)
    return PettingZooWrapper(single, return_state=True, seed=0)


def vmas(worlds: int) -> Any:
    """Returns many worlds of VMAS."""
    from torchrl.envs.libs.vmas import VmasEnv

    return VmasEnv("transport", num_envs=worlds, n_agents=NUM_BOATS, seed=0, device="cpu")


SUBJECTS: dict[str, Callable[[int], Any]] = {"asv": asv, "wrapper": wrapper, "vmas": vmas}


def main(subject: str, worlds: int) -> None:
    """Serves measurements of a subject with so many worlds on one thread."""
    torch.set_num_threads(1)
    warnings.simplefilter("ignore")
    env = SUBJECTS[subject](worlds)
    torch.manual_seed(0)
    actions = itertools.cycle([env.full_action_spec.rand() for _ in range(ACTIONS)])
    tensors = env.reset()

    def step() -> None:
        nonlocal tensors
        _, tensors = env.step_and_maybe_reset(tensors.update(next(actions)))

    for _ in range(20):
        step()
    serve(step, lambda word: None, lambda: 0.0)


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]))
