"""Checked copy of the best policy of a run: ``python -m train.sb3.export RUN FILE``.

The actions of the policy file, which needs no torch, are compared with those of the network that
was trained, on observations of a rollout.
"""

from pathlib import Path
from typing import Any

import numpy as np
import torch
from stable_baselines3.common.save_util import load_from_zip_file
from torch import nn
from tyro.conf import Positional

from asv_env.files import write_bytes
from asv_env.presets import make_params
from asv_env.simulation import Simulation
from asv_env.types import Action, Observation
from baselines.learned import policy_file
from baselines.learned.network import NetworkPolicy
from baselines.rollout import seeds
from baselines.rollout.commands import FilePath, command
from baselines.rollout.loop import rollout
from train import actors
from train.run import BEST
from train.sb3.policies import ACTIVATIONS

ACTOR = ("mlp_extractor.policy_net.", "action_net.")  #: names of the actor's weights begin so
WORLDS = 16  #: number of worlds in which they are compared
SECONDS = 20.0  #: simulated time for which they are compared, s


def check(run: Path) -> float:
    """Returns the difference of the best policy file of a run from the network that was trained.

    Raises:
        ValueError: it is larger than ``actors.TOLERANCE``.
        FileNotFoundError: the run has none.
    """
    file, model = run / BEST, run / "best.zip"
    for needed in (file, model):
        if not needed.exists():
            raise FileNotFoundError(f"{needed} does not exist; has the run been evaluated yet?")
    layers, metadata, card = policy_file.read(file)
    network = _network(model, metadata.activation)
    try:
        task = card["options"]["task"]
    except (KeyError, TypeError) as error:
        raise ValueError(f"{file}: its model card has no options of a training") from error
    params = make_params(task, observation=metadata.observation)
    policy = NetworkPolicy(layers, metadata, params)

    def act(sensed: Any, observation: Observation, *_: Any) -> tuple[Action, None]:
        return policy.forward(observation), None

    first, ticks = seeds.DEVELOPMENT.start, round(SECONDS * params.clock.control)
    steps = rollout(Simulation(params, WORLDS), act, range(first, first + WORLDS), ticks)
    seen = np.stack([tick.observation for tick in steps])
    with torch.no_grad():
        wanted = network(torch.from_numpy(seen)).clamp(-1.0, 1.0).numpy()
    return actors.difference(policy, seen, wanted)


def _network(model: Path, activation: str) -> nn.Module:
    """Returns the actor in a file of stable-baselines3, of which only the weights are read."""
    layers: list[nn.Module] = []
    try:
        _, weights, _ = load_from_zip_file(model, load_data=False, device="cpu")
        arrays = [
            array for name, array in dict(weights["policy"]).items() if name.startswith(ACTOR)
        ]
        for weight, bias in zip(arrays[::2], arrays[1::2], strict=True):
            layer = nn.Linear(*reversed(weight.shape))
            layer.load_state_dict({"weight": weight, "bias": bias})
            layers += [layer, ACTIVATIONS[activation]()]
    except Exception as error:  # libraries raise whatever they meet
        raise ValueError(f"{model} cannot be read ({type(error).__name__}: {error})") from error
    return nn.Sequential(*layers[:-1])


def export(run: Positional[FilePath], file: Positional[FilePath], overwrite: bool = False) -> None:
    """Copy the best policy of a run, if its file acts as the network that was trained.

    Args:
        run: Folder of the run.
        file: Policy file (.npz) to be written.
        overwrite: Replace the file if it exists.
    """
    if file.exists() and not overwrite:
        raise FileExistsError(f"{file} exists: name another, or use --overwrite")
    if file.suffix != policy_file.SUFFIX:
        raise ValueError(f"{file}: a policy file ends in {policy_file.SUFFIX}")
    difference, own = check(run), run / BEST
    write_bytes(file, own.read_bytes())
    print(f"{file}: the same to {difference:.1e}, {file.stat().st_size:,} bytes")


main = command(export, "python -m train.sb3.export")

if __name__ == "__main__":
    main()
