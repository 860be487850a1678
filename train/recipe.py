"""The recipe of the policies that are part of this package: ``python -m train.recipe``.

Several trainings, some of which begin with what another has learned, and at the end the policy
file of those that are put together: one network that approaches the vessel and one that pushes it.
Each training is a run as ``python -m train`` makes it, with a folder of its own; the same command
goes on where it was stopped.
"""

from __future__ import annotations

import argparse
import shutil
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from baselines import network, phases
from baselines.network import SUFFIX
from baselines.phases import Phase
from train import export, ppo
from train.config import PRESETS, Config
from train.run import BEST, write


@dataclass(frozen=True)
class Training:
    """One training of the recipe.

    Attributes:
        config: of the run, but for its seed, its folder and where it begins.
        after: name of the training with whose best policy it begins; None for one that has none.
    """

    config: Config
    after: str | None = None


FROM_NOTHING = replace(
    PRESETS["push"],
    imitation_rounds=0,
    critic_updates=0,
    num_envs=64,
    num_steps=128,
    update_epochs=3,
    gamma=0.99,
    actor_learning_rate=3e-4,
    anneal_lr=False,
    log_std_init=-0.7,
    log_std_min=-1.7,
    ent_coef=0.002,
)
TRAININGS = {}
