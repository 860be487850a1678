"""The words and tables of a report: the same in the web page and in Markdown."""

from collections.abc import Mapping, Sequence
from typing import Any

from baselines.evaluate.results import Results
from baselines.evaluate.tables import descriptions, formats
from baselines.rollout.episodes import Episode

SHOWN = 20
"""Largest number of broken episodes that are listed."""
BROKEN = (
    "In these episodes the policy raised an error or gave an invalid action. They count as "
    "failures."
)
"""Explanation of the list of broken episodes."""
METHODS = (
    "Every policy meets the same episodes: initial states, goals, disturbances and noise follow "
    "from the seed of an episode alone.",
    "Shares have Wilson's interval; means and interquartile means (IQM) one by bootstrap-t over "
    "the episodes. Times and errors count the episodes to which they apply: a policy that fails "
    "often has few times to goal.",
    "Where a policy was trained several times, trainings and episodes are crossed sources of "
    "variance, and the intervals widen with the differences between trainings: runs of many "
    "episodes do not replace many trainings.",
    "Policies are compared within episodes, so that what makes an episode hard for both cancels. "
    "To be sooner counts a failure as later than any success, and a tie as one half.",
    "McNemar's test is exact and two-sided; it compares two single policies and is not given where "
    "one was trained several times.",
    "Every interval and every p holds on its own; nothing is adjusted for multiple comparisons.",
)
"""How the numbers were computed, point by point."""


def content(results: Results, summary: Mapping[str, Any]) -> dict[str, Any]:
    """Returns what the templates of both reports show, by the names they use."""
    compared = (
        (f"Compared with {results.policies[0]}", descriptions.comparisons(summary)),
        ("Compared with the control", descriptions.controls(summary)),
    )
    provenance = summary["provenance"]
    return {
        "summary": summary,
        "ran": _ran(results, summary),
        "policies": {
            name: _policy(name, fingerprints) for name, fingerprints in summary["policies"].items()
        },
        "tables": [descriptions.results(summary), descriptions.measures(summary)],
        "comparisons": [(heading, shown) for heading, shown in compared if shown.rows],
        "conditions": _conditions(results, summary),
        "broken": _broken(results),
        "about_broken": BROKEN,
        "methods": METHODS,
        "provenance": provenance,
        "libraries": ", ".join(f"{k} {v}" for k, v in provenance["set of libraries"].items()),
    }


def _ran(results: Results, summary: Mapping[str, Any]) -> str:
    """Returns how much was run, such as "1 policy in 2 conditions of 8 episodes, seed 3"."""
    low, high = summary["seeds"]
    conditions = _counted(len(results.suite.conditions), "condition")
    policies = _counted(len(results.policies), "policy", "policies")
    seeds = f"seed {low}" if low == high else f"seeds {low} to {high}"
    return f"{policies} in {conditions} of {_counted(results.suite.episodes, 'episode')}, {seeds}"


def _policy(name: str, fingerprints: Sequence[str]) -> str:
    """Returns a description of a policy from its fingerprints, one a training."""
    first = fingerprints[0]
    if len(fingerprints) > 1:
        return f"{len(fingerprints)} trainings: {', '.join(fingerprints)}"
    if len(first) == 16 and set(first) <= set("0123456789abcdef"):
        return f"fingerprint {first}"
    return "part of this package" if first == name else f"{first}, part of this package"


def _conditions(results: Results, summary: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Returns of each condition its name, a description, its successes and all its measures."""
    described = []
    for condition in results.suite.conditions:
        parts = [condition.about] if condition.about else []
        parts += [_counted(condition.params.num_boats, "boat"), f"task {condition.task_name}"]
        parts += [f"control {condition.control}"] if condition.control else []
        policies = summary["conditions"][condition.name]["policies"]
        described.append(
            {
                "name": condition.name,
                "about": "; ".join(parts),
                "shares": {p: formats.share(policies[p]["success"]["value"]) for p in policies},
                "table": descriptions.of_condition(summary, condition.name),
            }
        )
    return described


def _broken(results: Results) -> list[str]:
    """Returns the first episodes that ended with an error of the policy, one a line."""
    rows = [row for row in results if row.error]
    lines = [_error(row) for row in rows[:SHOWN]]
    if len(rows) > SHOWN:
        lines.append(f"and {len(rows) - SHOWN} more: see the column error of episodes.csv")
    return lines


def _error(row: Episode) -> str:
    training = "" if row.training_seed is None else f", training {row.training_seed}"
    message = " ".join(str(row.error).split())
    return f"{row.policy}{training}, {row.condition}, seed {row.seed}: {message}"


def _counted(number: int, one: str, several: str | None = None) -> str:
    return f"{number} {one if number == 1 else several or one + 's'}"
