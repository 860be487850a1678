"""Tables of the published results: a line a suite for an overview, and a line a condition."""

from collections.abc import Sequence

import numpy as np

from asv_env.types import Float
from baselines.evaluate import statistics
from baselines.evaluate.conditions import Condition
from baselines.evaluate.results import Results
from baselines.evaluate.tables import formats
from baselines.evaluate.tables.formats import NOTHING
from baselines.evaluate.tables.table import grid

PROGRAM = "python -m baselines.evaluate.publish"
FOLDER = "docs/results"
HEADS = ("condition", "what it is", "policy", "success", "difference", "distance [cm]", "time [s]")
INTRODUCTION = f"""\
# Results on the suites

Written by `{PROGRAM}` from the `episodes.csv` of each suite. Success
with its 95 % interval; the smallest distance to the goal and the time to it are medians, the time
of the episodes that were delivered. *Difference*: of success from that of the first policy on the
same episodes. Each folder also holds the report of its run (`report.md`).
"""


def overview(published: Sequence[Results]) -> str:
    """Returns a table with a line a suite: every policy's mean success and worst condition."""
    policies = list(dict.fromkeys(policy for results in published for policy in results.policies))
    lines = [
        [
            f"`{results.suite.name}`",
            f"{len(results.suite.conditions)} × {results.suite.episodes:,}",
            *(_overall(results, p) if p in results.policies else NOTHING for p in policies),
        ]
        for results in published
    ]
    return grid(["suite", "conditions × episodes", *policies], lines, left=("suite",))


def _overall(results: Results, policy: str) -> str:
    """Returns the mean success over the conditions, and the worst of them."""
    rates = {
        condition.name: float(results.success(condition.name, policy).mean())
        for condition in results.suite.conditions
    }
    worst = min(rates, key=rates.__getitem__)
    mean = formats.share(float(np.mean(list(rates.values()))))
    return f"{mean} (worst: {worst}, {formats.share(rates[worst])})"


def page(published: Sequence[Results]) -> str:
    """Returns all conditions of all suites, in Markdown."""
    parts = [INTRODUCTION.strip()]
    for results in published:
        suite, policies = results.suite, results.policies
        lines = [_line(results, condition, p) for condition in suite.conditions for p in policies]
        parts += [
            f"## {suite.name}",
            f"{suite.about} {suite.episodes:,} episodes a condition.",
            grid(HEADS, lines, left=HEADS[:3]),
            f"`python -m baselines.evaluate --suite {suite.name} --policies {' '.join(policies)} "
            f"--episodes {suite.episodes} --out {FOLDER}/{suite.name}`",
        ]
    return "\n\n".join(parts) + "\n"


def _line(results: Results, condition: Condition, policy: str) -> list[str]:
    first = results.policies[0]
    success, reference = (results.success(condition.name, name) for name in (policy, first))
    difference = statistics.difference_in_success(success, reference)
    return [
        *([condition.name, condition.about] if policy == first else ["", ""]),
        policy,
        formats.share_estimate(vars(statistics.proportion(success))),
        formats.points(vars(difference)) if policy != first else NOTHING,
        _median(results.column(condition.name, policy, "min_position_error"), "cm", 100.0),
        _median(results.column(condition.name, policy, "time_to_goal"), "s"),
    ]


def _median(values: Float, unit: str, scale: float = 1.0) -> str:
    present = values[np.isfinite(values)]
    return formats.quantity(float(np.median(present)), unit, scale) if len(present) else NOTHING
