"""VMAS ``transport``, to be timed: ``python benchmarks/vmas_process.py WORLDS THREADS``.

Four agents, random continuous actions, one physics substep a step. It is stepped through its
public interface and never reset, which is in its favour. Actions are drawn beforehand.
"""

import contextlib
import io
import itertools
import sys
from typing import Any

from turns import serve

with contextlib.redirect_stderr(io.StringIO()):  # an old gym complains of its age
    import torch
    from vmas import make_env

NUM_AGENTS = 4
ACTIONS = 32  #: number of actions that are drawn beforehand and used in turn


def main(worlds: int, threads: int) -> None:
    """Serves measurements of so many worlds on so many torch threads."""
    torch.set_num_threads(threads)
    options: dict[str, Any] = {"continuous_actions": True, "n_agents": NUM_AGENTS, "seed": 0}
    env = make_env("transport", num_envs=worlds, device="cpu", **options)
    env.reset()
    drawn = [[2 * torch.rand(worlds, 2) - 1 for _ in range(NUM_AGENTS)] for _ in range(ACTIONS)]
    actions = itertools.cycle(drawn)
    for _ in range(20):
        env.step(next(actions))
    serve(lambda: env.step(next(actions)), lambda word: None, lambda: 0.0)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
