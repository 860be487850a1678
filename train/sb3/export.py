"""From a run to a policy file that needs no torch: ``python -m train.sb3.export RUN FILE``.

The best policy of the run is taken. Before its file is left where it is wanted, its actions are
held against those of the network that was trained, on what boats observe.
"""

from __future__ import annotations

import argparse
import shutil
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch

from asv_env.params import EnvParams
from asv_env.presets import make_params
from asv_env.simulation import Simulation
from asv_env.types import Action, Observation
from baselines.learned import policy_file
from baselines.learned.network import NetworkPolicy
from baselines.rollout import seeds
from baselines.rollout.files import write
from baselines.rollout.loop import Tick, rollout
from train.run import BEST
from train.sb3 import policies
from train.sb3.ppo import Learner

TOLERANCE = 1e-5
"""Largest difference between the actions of a policy file and those of the original."""
WORLDS, SECONDS = 16, 20.0
"""From which the observations come."""


def compare(
    policy: NetworkPolicy, original: Callable[[Observation], Action], params: EnvParams
) -> float:
    """Largest difference between two policies' actions, on the way of the first.

    Args:
        policy: from a policy file.
        original: from observations (n, K) to actions (n, 2) in [-1, 1].
        params: of the environment.
    """
    simulation = Simulation(params, WORLDS)
    first = seeds.DEVELOPMENT.start
    ticks = round(SECONDS * params.clock.control)

    def act(sensed: Any, observation: Observation, *_: Any) -> tuple[Action, None]:
        return policy.forward(observation), None

    def difference(tick: Tick) -> float:
        wanted = original(tick.observation.reshape(-1, tick.observation.shape[-1]))
        return float(np.abs(tick.action - wanted.reshape(tick.action.shape)).max())

    return max(map(difference, rollout(simulation, act, range(first, first + WORLDS), ticks)))


def check(file: Path, original: Callable[[Observation], Action]) -> float:
    """The difference of a policy file from its original.

    Raises:
        ValueError: it is larger than ``TOLERANCE``.
    """
    phase, _ = policy_file.read_single(file)
    params = make_params(phase.metadata.tasks[0])
    policy = NetworkPolicy(phase.layers, phase.metadata, params)
    difference = compare(policy, original, params)
    if difference > TOLERANCE:
        raise ValueError(
            f"{file}: its actions differ by up to {difference:.1e} from those of the original"
        )
    return difference


def trained(folder: Path) -> Callable[[Observation], Action]:
    """The network of the best policy of a run.

    Raises:
        FileNotFoundError: the run has none.
    """
    file = folder / f"{BEST}.zip"
    if not file.exists():
        raise FileNotFoundError(f"{file}: there is none; has the run been evaluated yet?")
    actor = policies.actor(Learner.load(file, device="cpu").policy)

    def act(observation: Observation) -> Action:
        with torch.no_grad():
            action: Action = actor(torch.from_numpy(observation)).clamp(-1.0, 1.0).numpy()
        return action

    return act


def main(arguments: Sequence[str] | None = None) -> None:
    """Exports as a command line says; exits with a message where something is wrong."""
    parser = argparse.ArgumentParser(prog="python -m train.sb3.export", description=__doc__)
    parser.add_argument("run", type=Path, help="folder of a run")
    parser.add_argument("file", type=Path, help="policy file (.npz) to be written")
    parser.add_argument("--overwrite", action="store_true", help="replace it if it is there")
    options = parser.parse_args(arguments)
    try:
        if options.file.exists() and not options.overwrite:
            raise FileExistsError(f"{options.file} exists: name another, or use --overwrite")
        if options.file.suffix != policy_file.SUFFIX:
            raise ValueError(f"{options.file}: a policy file ends in {policy_file.SUFFIX}")
        own = options.run / f"{BEST}{policy_file.SUFFIX}"
        difference = check(own, trained(options.run))
        write(options.file, lambda part: shutil.copyfile(own, part))
    except (ValueError, OSError) as error:
        parser.error(str(error))
    print(f"{options.file}: the same to {difference:.1e}, {options.file.stat().st_size:,} bytes")


if __name__ == "__main__":
    main()
