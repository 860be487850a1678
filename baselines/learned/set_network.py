"""A network from what a boat sees, itself and sets of things, to its action; on NumPy alone.

    boats:      e = relu(boat_2 relu(boat_1 item + own_1 own)), pooled by largest and by mean
    outline:    relu(largest of point_1 item)
    obstacles:  largest of relu(obstacle_1 item) of those that are present
    action:     out relu(trunk_2 relu(trunk_1 [own, pooled boats, outline, obstacles]))

with affine layers. Pools do not depend on the order of a set or on its size, so one network serves
every team, hull and layout of obstacles. The largest of affine functions of a hull's points is what
the support function is: how far the hull reaches, in as many directions as there are of them.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from asv_env.types import Action, Float
from baselines.learned.seen import WIDTHS, Seen

Weights = Mapping[str, Any]  #: arrays by names: "LAYER.weight" (inputs, outputs), "LAYER.bias"
COMMAND = 3  #: numbers that a boat is commanded by, see ``TeamView.command``
HIDDEN, ITEMS = 192, 48  #: default sizes of the trunk's layers and of an encoded item


def layers(hidden: int = HIDDEN, items: int = ITEMS) -> dict[str, tuple[int, int]]:
    """Returns the numbers (inputs, outputs) of the layers of a network, by name."""
    own, boat, point, obstacle = WIDTHS
    return {
        "own_1": (own, items),
        "boat_1": (boat, items),
        "boat_2": (items, items),
        "point_1": (point, items),
        "obstacle_1": (obstacle, items),
        "trunk_1": (own + 4 * items, hidden),
        "trunk_2": (hidden, hidden),
        "out": (hidden, COMMAND),
    }


class SetNetwork:
    """The network of some weights.

    Raises:
        ValueError: they are not those of a network.
    """

    def __init__(self, weights: Weights) -> None:
        check(weights)
        self._weights = {name: np.asarray(w, np.float32) for name, w in weights.items()}

    def __call__(self, seen: Seen) -> Action:
        """Returns the outputs (W, A, 3) within [-1, 1], for what boats (W, A, ...) see.

        Every product of matrices has one factor for each world, whose shape does not depend on W:
        the actions of a world are the same to the bit in every batch.
        """
        own = seen.own
        boats: Float = self._layer("boat_1", seen.boats) + self._layer("own_1", own)[:, :, None]
        boats = relu(self._layer("boat_2", relu(boats)))
        outline = relu(pooled(self._layer("point_1", seen.outline), np.maximum))
        mean = pooled(boats, np.add) * np.float32(1.0 / boats.shape[2])
        obstacles = np.zeros_like(outline)
        if seen.obstacles.shape[2]:
            points = relu(self._layer("obstacle_1", seen.obstacles)) * seen.obstacles[..., :1]
            obstacles = pooled(points, np.maximum)
        parts = [own, pooled(boats, np.maximum), mean, outline, obstacles]
        x: Float = np.concatenate(parts, axis=-1)
        for name in ("trunk_1", "trunk_2"):
            x = relu(self._layer(name, x))
        return np.clip(self._layer("out", x), -1.0, 1.0).astype(np.float32)

    def _layer(self, name: str, x: Float) -> Float:
        """Returns an affine function (W, A, ..., outputs) of (W, A, ..., inputs)."""
        weight, bias = self._weights[f"{name}.weight"], self._weights[f"{name}.bias"]
        rows = x.reshape(len(x), -1, x.shape[-1])  # one matrix for each world
        y: Float = np.matmul(rows, weight)
        y += bias
        return y.reshape(*x.shape[:-1], -1)


def relu(x: Float) -> Float:
    """Returns the positive part of an array, in its place."""
    return np.maximum(x, 0.0, out=x)


def pooled(items: Float, function: np.ufunc) -> Float:
    """Returns the items of sets (W, A, n, F) joined by a function, (W, A, F).

    Item by item, this takes half the time of a reduction along the axis.
    """
    result: Float = items[:, :, 0].copy()
    for k in range(1, items.shape[2]):
        function(result, items[:, :, k], out=result)
    return result


def check(weights: Weights) -> None:
    """Refuses weights that are not finite, or not those of ``layers`` of any sizes."""
    try:
        items, hidden = weights["boat_2.weight"].shape[1], weights["trunk_2.weight"].shape[1]
    except (KeyError, AttributeError, IndexError) as error:
        raise ValueError(f"weights {sorted(weights)} are not those of a network of sets") from error
    wanted: dict[str, tuple[int, ...]] = {}
    for name, (inputs, outputs) in layers(hidden, items).items():
        wanted |= {f"{name}.weight": (inputs, outputs), f"{name}.bias": (outputs,)}
    found = {name: np.shape(array) for name, array in weights.items()}
    if found != wanted:
        name = next(iter(sorted(set(found.items()) ^ set(wanted.items()))))[0]
        raise ValueError(
            f"{name} has the shape {found.get(name)}, a network of sets has {wanted.get(name)}"
        )
    if not all(array.dtype.kind == "f" for array in weights.values()):
        raise ValueError("weights are not real numbers")
    if not all(np.isfinite(array).all() for array in weights.values()):
        raise ValueError("weights are not finite")
