"""What the tests of trainings share: a tiny training, and what it says when it refuses."""

import io
from contextlib import redirect_stderr
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from asv_env.tasks import PUSH
from baselines.learned import policy_file
from train.__main__ import main
from train.config import parse

ROOT = Path(__file__).parents[1]
SHORT = replace(PUSH, time_limit=8.0)
"""Push with short episodes, so that evaluations cost little."""
TINY_OPTIONS = """
    --num-envs 8 --num-steps 16 --num-minibatches 2 --update-epochs 2 --hidden 16 16
    --scenarios noisy --time-limit 5 --critic-updates 1
    --imitation.rounds 1 --imitation.worlds 4 --imitation.time 3 --imitation.steps 20
    --total-timesteps 2048 --checkpoint-every 512
    --evaluation.every 1024 --evaluation.episodes 2 --torch-threads 1
"""
TINY = TINY_OPTIONS.split()
"""Options of a training that is over in seconds; 512 timesteps an update."""


def words(*options):
    """The command line of a tiny training of ``SHORT``, or of the task among the options."""
    task = [] if "--task" in options else ["--task", "train_helpers:SHORT"]
    return [*TINY, *task, *map(str, options)]


@cache
def parsed():
    return parse(words())


def tiny(**options):
    """Options of a tiny training, changed as by ``Config.changed``."""
    return parsed().changed(**options)


def train(folder, *options):
    main(words("--out", folder, *options))


def refusal(*options):
    """The message with which a command exits; several lines are joined."""
    printed = io.StringIO()
    with pytest.raises(SystemExit) as exit, redirect_stderr(printed):
        main(words(*options))
    return " ".join(f"{exit.value} {printed.getvalue()}".replace("│", " ").split())


def layers_of(file):
    """Layers of a policy file."""
    return policy_file.read(file)[0]


def actor_of(folder):
    """Layers of the last policy of a run."""
    return layers_of(folder / "policy.npz")


def same(layers, others):
    """Whether layers are equal to the bit."""
    pairs = zip(layers, others, strict=True)
    return all(np.array_equal(a, b) for one, two in pairs for a, b in zip(one, two, strict=True))


def timesteps(file):
    """Timesteps of the evaluations in a curve."""
    if not file.exists():
        return []
    return [int(line.split(",")[0]) for line in file.read_text().splitlines()[1:]]
