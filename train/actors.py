"""The actor as torch holds it and as a policy file does; the same for every engine."""

from __future__ import annotations

import sys
from collections.abc import Sequence

import torch
from torch import nn
from tqdm import tqdm

from baselines.learned.metadata import Layers
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


def check_fit(layers: Layers, sizes: Sequence[int]) -> None:
    """Refuses layers of a policy file for an actor that is narrower, or deeper or less deep.

    Args:
        layers: of the file.
        sizes: of the actor's observation, of its layers and of its action.

    Raises:
        ValueError: they do not fit.
    """
    given = [len(layers[0][0]), *(len(bias) for _, bias in layers)]
    if len(given) != len(sizes) or any(a > b for a, b in zip(given, sizes, strict=True)):
        raise ValueError(
            f"layers of sizes {given} do not fit into the actor's {list(sizes)}: choose --hidden "
            "after them, or wider"
        )


def put_layers(actor: nn.Module, layers: Layers) -> None:
    """Gives the actor the weights of a policy file.

    Where the actor's layers are wider, it acts as the file does: what its further units say does
    not count in the beginning.

    Raises:
        ValueError: they do not fit, see ``check_fit``.
    """
    own = linear_layers(actor)
    check_fit(layers, [own[0].in_features, *(one.out_features for one in own)])
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
