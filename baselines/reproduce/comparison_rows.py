"""Rows of tables that compare conditions over the same episodes."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from asv_env.types import Float
from baselines.evaluate import statistics

Column = Sequence[float | None]  #: values of a measure by episode; None where it does not apply
Values = Mapping[str, Mapping[str, Column]]  #: values by condition and measure
RATES = ("delivered", "closure reached")  #: measures that are 1 for a success and 0 for a failure


def describe(values: Column) -> dict[str, float | None]:
    """Returns mean, standard deviation of the sample and median; None for too few values."""
    array = np.array(values, dtype=np.float64)
    array = array[~np.isnan(array)]
    return {
        "mean": float(array.mean()) if len(array) else None,
        "sd": float(array.std(ddof=1)) if len(array) > 1 else None,
        "median": float(np.median(array)) if len(array) else None,
    }


def rows_of(values: Values) -> list[dict[str, Any]]:
    """Returns the rows of a table, measure by measure.

    The first condition is the one with which the others are compared, episode by episode.
    """
    first, *_ = values.values()
    return [
        _row(condition, measure, own[measure], None if own is first else first[measure])
        for measure in first
        for condition, own in values.items()
    ]


def _row(condition: str, measure: str, values: Column, first: Column | None) -> dict[str, Any]:
    row = {
        "condition": condition,
        "episodes": sum(value is not None for value in values),
        "measure": measure,
        **describe(values),
        "difference": None,
        "its median": None,
    }
    if first is not None:
        own, compared = (np.array(column, dtype=np.float64) for column in (values, first))
        if not np.isnan(own - compared).all():
            row["difference"] = difference(own, compared, rate=measure in RATES)
            row["its median"] = float(np.nanmedian(own - compared))
    return row


def difference(own: Float, compared: Float, rate: bool) -> str:
    """Returns the mean difference of values (E,), NaN left out, and its interval in words."""
    if rate:
        both = np.isfinite(own - compared)
        found = statistics.difference_in_success(own[None, both], compared[None, both])
    else:
        found = statistics.difference(own[None], compared[None])
    text = f"{found.value:+.3g}"
    return text if found.low is None else f"{text} [{found.low:+.3g}, {found.high:+.3g}]"
