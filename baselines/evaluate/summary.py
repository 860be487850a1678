"""Summary of the episodes of a comparison, as plain values for ``summary.json``."""

from collections import Counter
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from asv_env.types import Float
from baselines.evaluate import statistics
from baselines.evaluate.conditions import Condition
from baselines.evaluate.results import Results
from baselines.evaluate.statistics import Estimate

WIDE = "wide"  #: name of the tolerances that suit the paper's tank experiment
TOLERANCES = {"0.5": (0.5, 0.5), "1": (1.0, 1.0), WIDE: (2.0, 5.0)}
"""Multiples of the task's tolerances of position and heading, by name.

With the nominal vessel 1 is 5 cm and 0.1 rad, and wide is 10 cm and 0.5 rad: what the trials of the
paper's tank experiment can be expected to meet.
"""


@dataclass(frozen=True)
class Measure:
    """A column that is summarised."""

    label: str  #: name in tables
    unit: str  #: unit in tables
    scale: float = 1.0  #: factor from the column's unit to that of tables
    signed: bool = True  #: whether its sign counts; else magnitudes are summarised
    least: float = 0.0  #: least possible value, below which no interval of a mean reaches


MEASURES = {
    "time_to_closure": Measure("time to closure", "s"),
    "closure_spread": Measure("spread of arrivals", "s"),
    "time_to_goal": Measure("time to goal", "s"),
    "position_error": Measure("position error at the end", "cm", 100.0),
    "heading_error": Measure("heading error at the end", "rad", signed=False),
    "min_position_error": Measure("smallest distance", "cm", 100.0),
    "heading_error_at_min": Measure("heading error then", "rad", least=-np.pi),
    "path_length_ratio": Measure("path length over Dubins path", ""),
    "effort": Measure("effort", "s"),
    "collisions": Measure("collisions", ""),
    "closure_lost": Measure("closure lost", ""),
    "episode_return": Measure("return", "", least=-np.inf),
}
COMPARED = ("time_to_goal", "time_to_closure", "min_position_error", "effort")
"""Columns whose differences are taken, episode by episode."""


def summarise(results: Results) -> dict[str, Any]:
    """Returns the summary of a comparison.

    Under ``conditions``, by name, each has ``about``, ``control``, ``policies``, ``comparisons`` of
    the other policies with the first, and ``against_control`` of each policy with itself in the
    condition without the disturbance. A comparison holds differences first - second where both
    apply; ``mcnemar``, the p-value of a difference in success (None where a policy has several
    trainings); and ``improvement``, the probability that the first is done sooner in the same
    episode (a tie counts half, a failure is later than any success). Intervals have the level 0.95.
    """
    conditions = results.suite.conditions
    return {"conditions": {one.name: _condition(results, one) for one in conditions}}


def _condition(results: Results, condition: Condition) -> dict[str, Any]:
    first, *others = results.policies
    name, control = condition.name, condition.control
    return {
        "about": condition.about,
        "control": control,
        "policies": {policy: _policy(results, condition, policy) for policy in results.policies},
        "comparisons": {
            other: _comparison(results, (name, other), (name, first)) for other in others
        },
        "against_control": {
            policy: _comparison(results, (name, policy), (control, policy))
            for policy in results.policies
            if control is not None
        },
    }


def _policy(results: Results, condition: Condition, policy: str) -> dict[str, Any]:
    """Returns successes, causes of failures and ``MEASURES`` of one policy in one condition."""
    key = condition.name, policy
    success = results.success(*key)
    causes = [row.cause for training in results.rows[key] for row in training if row.cause]
    placed = TOLERANCES if condition.params.definition.has_goal else {}
    summary: dict[str, Any] = {
        "episodes": success.shape[1],
        "trainings": success.shape[0],
        "success": asdict(statistics.proportion(success)),
        "placed": {
            name: asdict(statistics.proportion(results.placed(*key, *multiples)))
            for name, multiples in placed.items()
        },
        "causes": dict(sorted(Counter(causes).items())),
    }
    for column, measure in MEASURES.items():
        values = results.column(*key, column)
        if np.isfinite(values).any():
            summary[column] = _measured(values if measure.signed else np.abs(values), measure.least)
    return summary


def _measured(values: Float, least: float) -> dict[str, Any]:
    """Returns mean and interquartile mean with intervals, median, 90th percentile, deviation."""
    present = values[np.isfinite(values)]
    return {
        "mean": _bounded(statistics.mean(values), least),
        "iqm": _bounded(statistics.interquartile_mean(values), least),
        "median": float(np.median(present)),
        "p90": float(np.quantile(present, 0.9)),
        "sd": float(present.std(ddof=1)) if len(present) > 1 else None,
    }


def _bounded(estimate: Estimate, least: float) -> dict[str, Any]:
    """Returns an estimate whose interval does not reach below the least possible value."""
    low = estimate.low if estimate.low is None else max(estimate.low, least)
    return asdict(replace(estimate, low=low))


def _comparison(
    results: Results, first: tuple[str, str], second: tuple[str, str]
) -> dict[str, Any]:
    """Returns how one condition and policy compare with another, episode by episode."""
    successes = results.success(*first), results.success(*second)
    scores = results.scores(*first), results.scores(*second)
    single = len(successes[0]) == len(successes[1]) == 1
    differences = {}
    for column in COMPARED:
        pair = results.column(*first, column), results.column(*second, column)
        if all(np.isfinite(values).any() for values in pair):
            differences[column] = asdict(statistics.difference(*pair))
    return {
        "with": second[1] if first[0] == second[0] else second[0],
        "success": asdict(statistics.difference_in_success(*successes)),
        "mcnemar": statistics.mcnemar(successes[0][0], successes[1][0]) if single else None,
        "improvement": asdict(statistics.improvement(*scores)),
        **differences,
    }
