"""The actor as torch holds it and as a policy file does; the same for every engine."""

from __future__ import annotations

import sys

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

    Raises:
        ValueError: layers of other sizes.
    """
    own = linear_layers(actor)
    wanted = [tuple(one.weight.shape)[::-1] for one in own]
    given = [weight.shape for weight, _ in layers]
    if wanted != given:
        raise ValueError(
            f"layers of sizes {given} do not fit the actor's {wanted}: choose --hidden after them"
        )
    with torch.no_grad():
        for one, (weight, bias) in zip(own, layers, strict=True):
            one.weight.copy_(torch.as_tensor(weight.T))
            one.bias.copy_(torch.as_tensor(bias))


def begin(actor: nn.Module, config: Config, start: Layers | None) -> None:
    """Gives an untrained actor what it begins with: weights of a file, then imitation."""
    if start is not None:
        put_layers(actor, start)
    if config.imitation_rounds:
        rounds = config.imitation_rounds
        with tqdm(total=rounds, unit=" round", desc="imitation", file=sys.stderr) as bar:
            imitate(actor, config, bar)
