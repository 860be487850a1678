"""Checked copy of the best policy of a run: ``python -m train.sb3.export RUN FILE``.

The actions of the policy file, which needs no torch, are compared with those of the network that
was trained, on observations of a rollout.
"""

import shutil
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
import tyro
from tyro.conf import Positional

from asv_env.params import EnvParams
from asv_env.simulation import Simulation
from asv_env.types import Action, Observation
from baselines.learned import policy_file
from baselines.learned.network import NetworkPolicy
from baselines.rollout import seeds
from baselines.rollout.files import write
from baselines.rollout.loop import rollout
from train.run import BEST
from train.sb3 import policies
from train.sb3.ppo import Learner

TOLERANCE = 1e-5
"""Largest difference between the actions of a policy file and those of the network."""
WORLDS = 16
"""Number of worlds in which they are compared."""
SECONDS = 20.0
"""Simulated time for which they are compared, s."""


@dataclass(frozen=True)
class Options:
    """Copy the best policy of a run, if its file acts as the network that was trained."""

    run: Positional[Path]  # folder of the run
    file: Positional[Path]  # policy file (.npz) to be written
    overwrite: bool = False  # replace the file if it exists


def largest_difference(
    policy: NetworkPolicy, network: Callable[[Observation], Action], params: EnvParams
) -> float:
    """Returns the largest difference between the actions of a policy, which acts, and a network.

    The network goes from observations (n, K) to actions (n, 2) in [-1, 1].
    """

    def act(sensed: Any, observation: Observation, *_: Any) -> tuple[Action, None]:
        return policy.forward(observation), None

    first, largest = seeds.DEVELOPMENT.start, 0.0
    episodes, ticks = range(first, first + WORLDS), round(SECONDS * params.clock.control)
    for tick in rollout(Simulation(params, WORLDS), act, episodes, ticks):
        wanted = network(tick.observation.reshape(-1, tick.observation.shape[-1]))
        difference = np.abs(tick.action - wanted.reshape(tick.action.shape)).max()
        largest = max(largest, float(difference))
    return largest


def check(run: Path) -> float:
    """Returns the difference of the best policy file of a run from the network that was trained.

    Raises:
        ValueError: it is larger than ``TOLERANCE``.
        FileNotFoundError: the run has none.
    """
    file, model = run / f"{BEST}{policy_file.SUFFIX}", run / f"{BEST}.zip"
    for needed in (file, model):
        if not needed.exists():
            raise FileNotFoundError(f"{needed} does not exist; has the run been evaluated yet?")
    learner = Learner.load(model, device="cpu")
    actor, params = policies.actor(learner.policy), learner.config.params()

    def trained(observation: Observation) -> Action:
        with torch.no_grad():
            return actor(torch.from_numpy(observation)).clamp(-1.0, 1.0).numpy()

    phase, _ = policy_file.read_single(file)
    policy = NetworkPolicy(phase.layers, phase.metadata, params)
    difference = largest_difference(policy, trained, params)
    if difference > TOLERANCE:
        raise ValueError(
            f"{file}: its actions differ by up to {difference:.1e} from those of the original"
        )
    return difference


def main(arguments: Sequence[str] | None = None) -> None:
    """Exports as a command line says; exits with a message where something is wrong."""
    options = tyro.cli(Options, args=arguments, prog="python -m train.sb3.export")
    file = options.file
    try:
        if file.exists() and not options.overwrite:
            raise FileExistsError(f"{file} exists: name another, or use --overwrite")
        if file.suffix != policy_file.SUFFIX:
            raise ValueError(f"{file}: a policy file ends in {policy_file.SUFFIX}")
        difference, own = check(options.run), options.run / f"{BEST}{policy_file.SUFFIX}"
        write(file, lambda part: shutil.copyfile(own, part))
    except (ValueError, OSError) as error:
        sys.exit(f"python -m train.sb3.export: {error}")
    print(f"{file}: the same to {difference:.1e}, {file.stat().st_size:,} bytes")


if __name__ == "__main__":
    main()
