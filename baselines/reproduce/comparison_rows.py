"""Means with what they are worth."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.stats import bootstrap

LEVEL = 0.95
RESAMPLES = 2000


def describe(values: Sequence[float]) -> dict[str, float | None]:
    """Mean, standard deviation of the sample and median; None where there are too few values."""
    array = np.asarray(values, dtype=np.float64)
    return {
        "mean": float(array.mean()) if len(array) else None,
        "sd": float(array.std(ddof=1)) if len(array) > 1 else None,
        "median": float(np.median(array)) if len(array) else None,
    }


def interval(differences: ArrayLike) -> tuple[float, float] | None:
    """Bootstrap interval (95 %) of the mean of paired differences (n,); None for n < 2."""
    array = np.asarray(differences, dtype=np.float64)
    if len(array) < 2:
        return None
    if np.ptp(array) == 0:
        return float(array[0]), float(array[0])
    result = bootstrap(
        (array,), np.mean, confidence_level=LEVEL, n_resamples=RESAMPLES, method="percentile",
        rng=np.random.default_rng(0),
    ).confidence_interval  # fmt: skip
    return float(result.low), float(result.high)


def share(flags: Sequence[bool]) -> float | None:
    """Share of true ones; None of nothing."""
    return sum(flags) / len(flags) if flags else None


def in_words(differences: Sequence[float]) -> str | None:
    """Mean of differences and its interval; None without any."""
    if not differences:
        return None
    bounds = interval(differences)
    text = f"{np.mean(differences):+.3g}"
    return text if bounds is None else f"{text} [{bounds[0]:+.3g}, {bounds[1]:+.3g}]"


def row(
    condition: str, measure: str, values: Sequence[float], first: Sequence[float] | None
) -> dict[str, Any]:
    """A row of the table.

    Args:
        condition: under which it was measured.
        measure: what was measured, and its unit.
        values: one an episode.
        first: those of the first condition in the same episodes; None for itself.
    """
    differences = [] if first is None else [float(d) for d in np.subtract(values, first)]
    return {
        "condition": condition,
        "episodes": len(values),
        "measure": measure,
        **describe(values),
        "difference": in_words(differences),
        "its median": describe(differences)["median"],
    }


def rows_of(values: dict[str, dict[str, list[float]]]) -> list[dict[str, Any]]:
    """Rows of a table by measure: ``values[condition][measure]``, one an episode.

    The first condition is the one that the others are compared with.
    """
    first, *_ = values.values()
    return [
        row(condition, measure, own[measure], None if own is first else first[measure])
        for measure in first
        for condition, own in values.items()
    ]
