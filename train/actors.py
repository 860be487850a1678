"""Conversion between an actor in torch and the layers of a policy file."""

from collections.abc import Sequence

import numpy as np
import torch
from torch import nn

from asv_env.types import Action, Observation
from baselines.learned.network import Layers, NetworkPolicy

TOLERANCE = 1e-5  #: largest difference between the actions of policy file and network


def linear_layers(actor: nn.Module) -> list[nn.Linear]:
    """Returns the linear layers of an actor, from the observation to the mean action."""
    return [module for module in actor.modules() if isinstance(module, nn.Linear)]


def get_layers(actor: nn.Module) -> Layers:
    """Returns the weights (inputs, outputs) and biases of an actor, as a policy file has them."""
    return [
        (layer.weight.detach().numpy().T.copy(), layer.bias.detach().numpy().copy())
        for layer in linear_layers(actor)
    ]


def check_sizes(layers: Layers, sizes: Sequence[int]) -> None:
    """Refuses layers of a policy file for an actor that is narrower, or has more or fewer layers.

    ``sizes`` are those of the actor's observation, of its layers and of its action.
    """
    given = [len(layers[0][0]), *(len(bias) for _, bias in layers)]
    if len(given) != len(sizes) or any(a > b for a, b in zip(given, sizes, strict=True)):
        raise ValueError(
            f"layers of sizes {given} do not fit into the actor's {list(sizes)}: choose --hidden "
            "after them, or wider"
        )


def set_layers(actor: nn.Module, layers: Layers) -> None:
    """Gives the actor the weights of a policy file; see ``check_sizes`` for what does not fit.

    Where the actor's layers are wider, it acts as the file does: weights from its further units
    begin with zero.
    """
    own = linear_layers(actor)
    check_sizes(layers, [own[0].in_features, *(layer.out_features for layer in own)])
    with torch.no_grad():
        for layer, (weight, bias) in zip(own, layers, strict=True):
            inputs, outputs = weight.shape
            layer.weight[:outputs, :inputs] = torch.as_tensor(weight.T)
            layer.weight[:outputs, inputs:] = 0.0
            layer.bias[:outputs] = torch.as_tensor(bias)


def difference(policy: NetworkPolicy, seen: Observation, wanted: Action) -> float:
    """Returns the largest difference, on observations (..., K), from the actions wanted (..., 2).

    Raises:
        ValueError: it is larger than ``TOLERANCE``, or is no number.
    """
    largest = float(np.abs(policy.forward(seen) - wanted).max())
    if not largest <= TOLERANCE:
        raise ValueError(f"actions of policy file and network differ by up to {largest:.1e}")
    return largest
