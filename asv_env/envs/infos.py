"""Infos of environments: reward terms and metrics of the episode so far, always with the same keys.

The keys are ``reward_<term>`` for every term of the task's reward, 0.0 at a reset, and the names
of ``metrics.summary``. Values are bool, int or float, and never NaN.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from asv_env.simulation import Simulation
from asv_env.types import Bool, Float, TimeStep

DTYPES = {"b": np.bool_, "i": np.int64, "u": np.int64}  #: by the kind of a metric; else float64


def reward_terms(simulation: Simulation, step: TimeStep | None = None) -> dict[str, Float]:
    """Returns the reward terms of a step by key, (W, 1) shared or (W, A); zeros without a step."""
    if step is not None:
        return {f"reward_{name}": value for name, value in step.terms.items()}
    zeros = np.zeros((simulation.num_worlds, 1))
    return {f"reward_{term.name}": zeros for term in simulation.params.definition.reward}


def team_infos(simulation: Simulation, step: TimeStep | None = None) -> dict[str, Any]:
    """Returns the infos (W,) of all worlds; reward terms are means over the boats."""
    terms = reward_terms(simulation, step)
    return {name: team_mean(value) for name, value in terms.items()} | metrics_of(simulation)


def metrics_of(simulation: Simulation) -> dict[str, Any]:
    """Returns the metrics (W,) of the episodes so far: bool, int64 or float64."""
    summary = simulation.summary()
    for one in simulation.params.definition.metrics:
        value = summary[one.name]
        summary[one.name] = value.astype(DTYPES.get(value.dtype.kind, np.float64), copy=False)
    return summary


def of_world(infos: Mapping[str, Any], world: int = 0) -> dict[str, Any]:
    """Returns the infos of one world as Python scalars."""
    return {name: value.item(world) for name, value in infos.items()}


def masked(infos: Mapping[str, Any], mask: Bool) -> dict[str, Any]:
    """Returns infos (W,) in the format of Gymnasium's vector environments.

    They are zero outside the mask (W,), and ``_key`` is a copy of the mask for every key.
    """
    found, everywhere = {}, mask.all()
    for name, value in infos.items():
        found[name] = value if everywhere else np.where(mask, value, value.dtype.type(0))
        found[f"_{name}"] = mask.copy()
    return found


def team_mean(values: Float) -> Float:
    """Returns the mean (W,) over the boats of values (W, A) or (W, 1).

    All adapters use this one formula, so that they agree to the bit.
    """
    boats = values.shape[1]
    return values[:, 0] if boats == 1 else np.add.reduce(values, axis=1) / boats
