"""The actor as torch holds it and as a policy file does; the same for every engine."""

from __future__ import annotations

import sys

import numpy as np
import torch
from torch import nn
from tqdm import tqdm

from baselines.network import Layers
from train.config import Config
from train.imitation import imitate


def linear_layers(actor: nn.Module) -> list[nn.Linear]:
    """Those of an actor, from the observation to the mean action."""
    return [one for one in actor.modules() if isinstance(one, nn.Linear)]


def layers_of(actor: nn.Module) -> Layers:
    """The actor as a policy file wants it."""
    return [
        (one.weight.detach().numpy().T.copy(), one.bias.detach().numpy().copy())
        for one in linear_layers(actor)
    ]


def put_layers(actor: nn.Module, layers: Layers) -> None:
    """Gives the actor the weights of a policy file.

    Where the actor's layers are wider, it acts as the file does: what its further units say does
    not count in the beginning.

    Raises:
        ValueError: layers that are more, fewer or wider than the actor's.
    """
    own = linear_layers(actor)
    wanted = [tuple(one.weight.shape)[::-1] for one in own]
    given = [weight.shape for weight, _ in layers]
    if len(wanted) != len(given) or (np.array(given) > wanted).any():
        raise ValueError(
            f"layers of sizes {given} do not fit into the actor's {wanted}: choose --hidden "
            "after them, or wider"
        )
    with torch.no_grad():
        for one, (weight, bias) in zip(own, layers, strict=True):
            inputs, outputs = weight.shape
            one.weight[:outputs, :inputs] = torch.as_tensor(weight.T)
            one.weight[:outputs, inputs:] = 0.0
            one.bias[:outputs] = torch.as_tensor(bias)


def begin(actor: nn.Module, config: Config, start: Layers | None) -> None:
    """Gives an untrained actor what it begins with: weights of a file, then imitation."""
    if start is not None:
        put_layers(actor, start)
    if config.imitation_rounds:
        rounds = config.imitation_rounds
        with tqdm(total=rounds, unit=" round", desc="imitation", file=sys.stderr) as bar:
            imitate(actor, config, bar)
