"""Info dictionaries: reward terms and metrics in the shapes that each API expects."""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from asv_env.simulation import Simulation
from asv_env.types import Bool, Float


def team_mean(values: Float) -> Float:
    """Returns the mean (W,) over the boats of values (W, A) or (W, 1).

    All adapters use this one formula, so that they agree to the bit.
    """
    mean: Float = np.add.reduce(values, axis=1) / values.shape[1]
    return mean


def joint_terms(terms: Mapping[str, Float]) -> dict[str, float]:
    """Returns the reward terms of a single world, team means, as Python floats."""
    return {
        name: value.item() if value.size == 1 else team_mean(value).item()
        for name, value in terms.items()
    }


def boat_terms(terms: Mapping[str, Float], team: int) -> list[dict[str, float]]:
    """Returns the reward terms of every boat of a single world, as Python floats."""
    values = {name: value[0].tolist() for name, value in terms.items()}
    return [
        {name: value[boat] if len(value) > 1 else value[0] for name, value in values.items()}
        for boat in range(team)
    ]


def summaries(simulation: Simulation, worlds: Iterable[int]) -> list[dict[str, Any]]:
    """Returns the metrics of the episodes of some worlds, as Python scalars."""
    summary = simulation.summary()
    return [{name: value[world].item() for name, value in summary.items()} for world in worlds]


def masked(values: Mapping[str, Any], mask: Bool) -> dict[str, Any]:
    """Returns infos of some worlds in the format of Gymnasium's vector environments.

    Args:
        values: arrays (W,), or mappings of arrays, by name.
        mask: (W,) worlds that have them.

    Returns:
        Each value, zero where there is none, and its mask under the name with "_" before it.
    """
    infos: dict[str, Any] = {}
    everywhere = mask.all()
    for name, value in values.items():
        if isinstance(value, Mapping):
            infos[name] = masked(value, mask)
        elif everywhere:
            infos[name] = value.copy()
        else:
            infos[name] = np.where(mask, value, value.dtype.type(0))
        infos[f"_{name}"] = mask.copy()
    return infos
