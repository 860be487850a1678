"""Infos of environments: reward terms and metrics of the episode so far, always with the same keys.

The keys are ``reward_<term>`` for every term of the task's reward, 0.0 at a reset, and the names
of ``metrics.summary``. Values are bool, int or float, and never NaN.
"""

from collections.abc import Iterable, Mapping
from functools import cache
from typing import Any

import numpy as np

from asv_env.simulation import Simulation
from asv_env.tasks.metrics import Block, by_name
from asv_env.types import Bool, Float, TimeStep

DTYPES = {"b": np.bool_, "i": np.int64, "u": np.int64}  #: by the kind of a metric; else float64


def reward_terms(simulation: Simulation, step: TimeStep | None = None) -> dict[str, Float]:
    """Returns the reward terms of a step by key, (W, 1) shared or (W, A); zeros without a step."""
    if step is not None:
        return dict(zip(_keys(tuple(step.terms)), step.terms.values(), strict=True))
    names = tuple(term.name for term in simulation.params.definition.reward)
    return dict.fromkeys(_keys(names), np.zeros((simulation.num_worlds, 1)))


def team_blocks(simulation: Simulation, step: TimeStep | None = None) -> list[Block]:
    """Returns the infos of all worlds by type; reward terms are means over the boats."""
    terms = reward_terms(simulation, step)
    means = np.empty((len(terms), simulation.num_worlds))
    for row, value in zip(means, terms.values(), strict=True):
        row[...] = team_mean(value)
    return [(tuple(terms), means), *_metrics(simulation)]


@cache
def _keys(names: tuple[str, ...]) -> tuple[str, ...]:
    """Returns the keys of terms with these names."""
    return tuple(f"reward_{name}" for name in names)


def team_infos(simulation: Simulation, step: TimeStep | None = None) -> dict[str, Any]:
    """Returns the infos (W,) of all worlds; reward terms are means over the boats."""
    return by_name(team_blocks(simulation, step))


def metrics_of(simulation: Simulation) -> dict[str, Any]:
    """Returns the metrics (W,) of the episodes so far: bool, int64 or float64."""
    return by_name(_metrics(simulation))


def _metrics(simulation: Simulation) -> list[Block]:
    """Returns the metrics of the episodes so far: bool, int64 or float64."""
    return [
        (names, values.astype(DTYPES.get(values.dtype.kind, np.float64), copy=False))
        for names, values in simulation.metrics()
    ]


def of_world(infos: Mapping[str, Any], world: int = 0) -> dict[str, Any]:
    """Returns the infos of one world as Python scalars."""
    return {name: value.item(world) for name, value in infos.items()}


def masked(blocks: Iterable[Block], mask: Bool | None = None) -> dict[str, Any]:
    """Returns infos in the format of Gymnasium's vector environments.

    They are copies that are zero outside the mask (W,), and ``_key`` is a copy of the mask for
    every key. Without a mask they are the infos of all worlds, not copied.
    """
    found = {}
    for names, values in blocks:
        mask_names = _masks(names)
        shown = values if mask is None else np.where(mask, values, values.dtype.type(0))
        masks = np.empty(values.shape, dtype=np.bool_)
        masks[...] = True if mask is None else mask
        for name, mask_name, row, copy in zip(names, mask_names, shown, masks, strict=True):
            found[name], found[mask_name] = row, copy
    return found


@cache
def _masks(names: tuple[str, ...]) -> tuple[str, ...]:
    """Returns the keys of the masks of infos with these names."""
    return tuple(f"_{name}" for name in names)


def put_blocks(blocks: Iterable[Block], others: Iterable[Block], mask: Bool) -> None:
    """Overwrites infos in the worlds of a mask (W,) by others of the same names, in place."""
    for (_, values), (_, new) in zip(blocks, others, strict=True):
        np.copyto(values, new, where=mask)


def team_mean(values: Float) -> Float:
    """Returns the mean (W,) over the boats of values (W, A) or (W, 1).

    All adapters use this one formula, so that they agree to the bit.
    """
    boats = values.shape[1]
    return values[:, 0] if boats == 1 else np.add.reduce(values, axis=1) / boats
