"""The network of sets in torch, for training; see ``baselines.learned.set_network``."""

import numpy as np
import torch
from torch import Tensor, nn

from baselines.learned.seen import Seen
from baselines.learned.set_network import HIDDEN, ITEMS, Weights, layers

FIRST_OUTPUT = 0.1  #: factor on the last layer's initial weights, so that first actions are small


class SetActor(nn.Module):
    """Maps what boats (n, ...) see to their mean commands (n, 3), see ``TeamView.command``.

    Sets of boats may be padded with zeros, which are not present.
    """

    def __init__(self, hidden: int = HIDDEN, items: int = ITEMS) -> None:
        super().__init__()
        self.layers = nn.ModuleDict(
            {name: nn.Linear(*sizes) for name, sizes in layers(hidden, items).items()}
        )
        with torch.no_grad():
            self._layer("out").weight.mul_(FIRST_OUTPUT)

    def _layer(self, name: str) -> nn.Linear:
        layer = self.layers[name]
        assert isinstance(layer, nn.Linear)
        return layer

    def forward(self, own: Tensor, boats: Tensor, outline: Tensor, obstacles: Tensor) -> Tensor:
        """Returns mean commands (n, 3); the arguments are the fields of ``Seen``."""
        action: Tensor = self._layer("out")(self.trunk(own, boats, outline, obstacles))
        return action

    def trunk(self, own: Tensor, boats: Tensor, outline: Tensor, obstacles: Tensor) -> Tensor:
        """Returns the last hidden layer (n, H)."""
        layer, present = self._layer, boats[..., :1]
        item = torch.relu(layer("boat_1")(boats) + layer("own_1")(own).unsqueeze(-2))
        item = torch.relu(layer("boat_2")(item)) * present
        mean = item.sum(dim=-2) / present.sum(dim=-2)
        pooled = [item.amax(dim=-2), mean, torch.relu(layer("point_1")(outline).amax(dim=-2))]
        if obstacles.shape[-2]:
            point = torch.relu(layer("obstacle_1")(obstacles)) * obstacles[..., :1]
            pooled.append(point.amax(dim=-2))
        else:
            pooled.append(torch.zeros_like(mean))
        x = torch.cat([own, *pooled], dim=-1)
        for name in ("trunk_1", "trunk_2"):
            x = torch.relu(layer(name)(x))
        return x

    def weights(self) -> Weights:
        """Returns the weights as a policy file has them."""
        found = {}
        for name in self.layers:
            layer = self._layer(name)
            found[f"{name}.weight"] = layer.weight.detach().numpy().T.copy()
            found[f"{name}.bias"] = layer.bias.detach().numpy().copy()
        return found

    def load(self, weights: Weights) -> None:
        """Takes the weights of a policy file."""
        with torch.no_grad():
            for name in self.layers:
                layer = self._layer(name)
                layer.weight.copy_(torch.from_numpy(np.asarray(weights[f"{name}.weight"]).T))
                layer.bias.copy_(torch.from_numpy(np.asarray(weights[f"{name}.bias"])))


def tensors(seen: Seen) -> list[Tensor]:
    """Returns what boats see as tensors."""
    return [torch.from_numpy(one) for one in seen]
