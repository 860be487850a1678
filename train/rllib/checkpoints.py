"""What a learner of RLlib leaves and hands on: checkpoints, layers of policy files, weights."""

import json
import shutil
import tempfile
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import torch
from ray.rllib.algorithms.ppo import PPO
from ray.rllib.core.columns import Columns
from torch import nn

from asv_env.files import write_text
from baselines.learned.network import Layers, NetworkPolicy
from train import actors
from train.keep_best import Status
from train.rllib.settings import BOAT
from train.run import Run

STATUS = "status.json"  #: file in a checkpoint that says how far the training has come
LAST = "last"  #: file that names the last checkpoint, always one that is whole
COMPARED = 256  #: number of observations on which they are compared


def last_checkpoint(folder: Path) -> tuple[Path | None, Status]:
    """Returns the last of the checkpoints in a folder, if there is one, and its status.

    Raises:
        ValueError: it is damaged.
    """
    last = folder / LAST
    if not last.exists():
        return None, Status()
    try:
        found = folder / last.read_text(encoding="utf-8")
        return found, Status(**json.loads((found / STATUS).read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError) as error:
        raise _damaged(folder, error) from error


def restore(algorithm: PPO, checkpoint: Path) -> None:
    """Gives the learner what is in a checkpoint; ValueError where that is damaged."""
    try:
        algorithm.restore_from_path(checkpoint.absolute())
    except Exception as error:  # libraries raise whatever they meet
        raise _damaged(checkpoint, error) from error


def _damaged(path: Path, error: Exception) -> ValueError:
    reason = f"{type(error).__name__}: {error}".splitlines()[0]
    return ValueError(
        f"{path} cannot be read ({reason}): put back a copy of it, or begin again with --overwrite"
    )


def save_checkpoint(folder: Path, algorithm: PPO, status: Status) -> None:
    """Writes a checkpoint into the folder, names it as the last, and deletes the others."""
    folder.mkdir(exist_ok=True)
    new = Path(tempfile.mkdtemp(prefix=f"{status.timesteps}-", dir=folder))
    algorithm.save_to_path(new.absolute())
    write_text(new / STATUS, json.dumps(asdict(status)))
    write_text(folder / LAST, new.name)
    for other in folder.iterdir():
        if other.is_dir() and other != new:
            shutil.rmtree(other)


def module_of(algorithm: PPO) -> Any:
    """Returns actor and critic of the learner."""
    (found,) = algorithm.learner_group.foreach_learner(lambda learner: learner.module[BOAT])
    return found.get()


def actor(module: Any) -> nn.Sequential:
    """Returns the network from observations to mean actions; it shares the module's weights."""
    return nn.Sequential(module.encoder.actor_encoder.net, module.pi.net)


def checked_layers(algorithm: PPO, run: Run) -> Layers:
    """Returns the layers of the actor for a policy file of a run.

    Raises:
        ValueError: the policy file would not act as the learner does.
    """
    module = module_of(algorithm)
    layers = actors.get_layers(actor(module))
    policy = NetworkPolicy(layers, run.metadata, run.config.params())
    size = (COMPARED, len(layers[0][0]))
    seen = np.random.default_rng(0).standard_normal(size, dtype=np.float32)
    outputs = module.forward_inference({Columns.OBS: torch.from_numpy(seen)})
    mean = outputs[Columns.ACTION_DIST_INPUTS][:, :2]
    actors.difference(policy, seen, mean.numpy().clip(-1.0, 1.0))
    return layers


def distribute_weights(algorithm: PPO) -> None:
    """Gives the learner's weights to all processes and waits until they have them.

    RLlib's own ``sync_weights`` drops what is for a process that has not yet answered the last
    time, as it is with those that have just been made: after its ``restore_from_path`` too, the
    first steps would come from untrained weights.
    """
    state = algorithm.learner_group.get_state("learner/rl_module", inference_only=True)["learner"]
    algorithm.env_runner_group.foreach_env_runner(lambda runner: runner.set_state(state))
