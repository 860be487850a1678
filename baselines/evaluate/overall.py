"""Success of a policy over the conditions of a suite, of which saturated ones do not count.

Where all policies succeed nearly always, or none ever does, a condition tells nothing apart, and
would only move all means towards each other.
"""

from dataclasses import dataclass

from baselines.evaluate.conditions import Condition
from baselines.evaluate.results import Results

LIVE = (0.02, 0.98)  #: success rates between which a condition tells policies apart


@dataclass(frozen=True)
class Overall:
    """Success rates of a policy over a suite."""

    mean: float  #: over the live conditions in distribution; over all of these where none is live
    unseen: float | None  #: the same out of distribution; None without such conditions
    worst: str  #: name of the condition in which it is least
    least: float  #: success rate there


def live(results: Results, unseen: bool) -> list[Condition]:
    """Returns the conditions in which at least one policy's success rate lies within ``LIVE``.

    Where there is none, all are returned. Only conditions out of distribution count with
    ``unseen``, and without it only the others.
    """
    of_kind = [c for c in results.suite.conditions if c.out_of_distribution == unseen]
    low, high = LIVE
    found = [
        condition
        for condition in of_kind
        if any(low <= _rate(results, condition, policy) <= high for policy in results.policies)
    ]
    return found or of_kind


def overall(results: Results, policy: str) -> Overall:
    """Returns the success rates of a policy over the suite of the results."""

    def mean(conditions: list[Condition]) -> float | None:
        rates = [_rate(results, condition, policy) for condition in conditions]
        return sum(rates) / len(rates) if rates else None

    usual, unseen = (mean(live(results, flag)) for flag in (False, True))
    worst = min(results.suite.conditions, key=lambda one: _rate(results, one, policy))
    first = usual if usual is not None else unseen
    assert first is not None  # A suite has a condition.
    return Overall(first, unseen, worst.name, _rate(results, worst, policy))


def _rate(results: Results, condition: Condition, policy: str) -> float:
    return float(results.success(condition.name, policy).mean())
