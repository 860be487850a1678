"""What a report says in words: the same in the page and in its Markdown twin."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from baselines.evaluate.results import Results
from baselines.rollout.episodes import Episode

SHOWN = 20
"""Broken episodes that are named."""
TABLES = {
    "results": "Success with its 95 % interval; the share of episodes in which the vessel was "
    "within so many tolerances of its goal pose when it was nearest, at rest or not; and why "
    "episodes failed.",
    "measures": "Medians and interquartile means (IQM, of the middle half of the values) with "
    "their 95 % intervals, over the episodes to which a measure applies.",
    "comparisons": "Differences of each policy to {first} within the same episodes, with their "
    "95 % intervals; the probability to be done sooner in the same episode; and McNemar's p that "
    "both succeed equally often.",
    "controls": "Differences of each policy in a disturbed condition to itself in the control condition, "
    "episode by episode, with their 95 % intervals.",
}
"""What the tables show."""
BROKEN = (
    "In these episodes the policy raised an error or gave an action of no use. They count as "
    "failures."
)
METHODS = (
    "Every policy meets the same episodes: starts, goals, disturbances and noise follow from the "
    "seed of an episode alone.",
    "Shares have Wilson's interval; means and interquartile means (IQM) one by bootstrap-t over "
    "the episodes. Times and errors count the episodes to which they apply: a policy that fails "
    "often has few times to goal.",
    "Where a policy was trained several times, trainings and episodes are crossed sources of "
    "variance, and the intervals widen by what the trainings differ: runs of many episodes do not "
    "stand for many trainings.",
    "Policies are compared within episodes, so that what makes an episode hard for both cancels. "
    "To be sooner counts a failure as later than any success, and a tie as one half.",
    "McNemar's test is exact and two-sided; it compares two single policies and is not given where "
    "one was trained several times.",
    "Every interval and every p holds on its own; nothing is adjusted for how many are looked at.",
)


def ran(results: Results, summary: Mapping[str, Any]) -> str:
    """How much was run."""
    low, high = summary["seeds"]
    conditions = _counted(len(results.suite.conditions), "condition")
    policies = _counted(len(results.policies), "policy", "policies")
    seeds = f"seed {low}" if low == high else f"seeds {low} to {high}"
    return f"{policies} in {conditions} of {_counted(results.suite.episodes, 'episode')}, {seeds}"


def policy(prints: Sequence[str], name: str) -> str:
    """What a policy is, from its fingerprints."""
    if len(prints) > 1:
        return f"{len(prints)} trainings: {', '.join(prints)}"
    if len(prints[0]) == 16 and set(prints[0]) <= set("0123456789abcdef"):
        return f"fingerprint {prints[0]}"
    known = "part of this package"
    return known if prints[0] == name else f"{prints[0]}, {known}"


def conditions(results: Results) -> dict[str, str]:
    """What each condition is, by name."""
    said = {}
    for condition in results.suite.conditions:
        parts = [condition.about] if condition.about else []
        parts.append(_counted(condition.params.num_boats, "boat"))
        parts.append(f"task {condition.task}")
        if condition.control:
            parts.append(f"control {condition.control}")
        said[condition.name] = "; ".join(parts)
    return said


def broken(results: Results) -> list[str]:
    """The episodes that a policy has broken, the first of them, one a line."""
    rows = [row for row in results if row.error]
    lines = [_broken(row) for row in rows[:SHOWN]]
    if len(rows) > SHOWN:
        lines.append(f"and {len(rows) - SHOWN} more: see the column error of episodes.csv")
    return lines


def _broken(row: Episode) -> str:
    training = "" if row.training_seed is None else f", training {row.training_seed}"
    said = " ".join(str(row.error).split())
    return f"{row.policy}{training}, {row.condition}, seed {row.seed}: {said}"


def _counted(number: int, one: str, several: str | None = None) -> str:
    return f"{number} {one if number == 1 else several or one + 's'}"
