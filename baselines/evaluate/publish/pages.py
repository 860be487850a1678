"""The published results on pages for readers: ``python -m baselines.evaluate.publish``.

Everything follows from the ``episodes.csv`` of the suites, so that no number is typed in; with
``--check`` nothing is written, and pages that say something else are named.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from asv_env.types import Float
from baselines.evaluate import statistics
from baselines.evaluate.conditions import Condition
from baselines.evaluate.publish import marks, model_cards
from baselines.evaluate.results import Results, of_rows, read_csv
from baselines.evaluate.suites import SUITES
from baselines.evaluate.tables import formats
from baselines.evaluate.tables.formats import NOTHING
from baselines.evaluate.tables.table import grid
from baselines.learned import shipped

FOLDER, README = Path("docs/results"), Path("README.md")
START = "<!-- results: what follows is written by python -m baselines.evaluate.publish -->"
END = "<!-- results: up to here -->"
HEADS = ("condition", "what it is", "policy", "success", "difference", "distance [cm]", "time [s]")
INTRODUCTION = """\
# Results on the suites

Written by `python -m baselines.evaluate.publish` from the `episodes.csv` of each suite. Success
with its 95 % interval; the smallest distance to the goal and the time to it are medians, the time
of the episodes that were delivered. *Difference*: of success from that of the first policy on the
same episodes. Each folder holds the report of its run too (`report.md`).
"""


def read(folder: Path) -> list[Results]:
    """The results of all suites that lie in a folder, in the order of ``SUITES``.

    Raises:
        FileNotFoundError: there are none.
        ValueError: rows that are not those of the suite.
    """
    files = {name: folder / name / "episodes.csv" for name in SUITES}
    found = [of_rows(SUITES[name], read_csv(file)) for name, file in files.items() if file.exists()]
    if not found:
        raise FileNotFoundError(f"{folder} holds no results of suites: run some with --out there")
    return found


def overview(results: Sequence[Results]) -> str:
    """A line a suite, in Markdown: mean success of each policy over the conditions, and its worst condition."""
    policies = list(dict.fromkeys(policy for one in results for policy in one.policies))
    lines = [
        [
            f"`{one.suite.name}`",
            f"{len(one.suite.conditions)} × {one.suite.episodes:,}",
            *(_overall(one, policy) if policy in one.policies else NOTHING for policy in policies),
        ]
        for one in results
    ]
    return grid(["suite", "conditions × episodes", *policies], lines, left=("suite",))


def _overall(results: Results, policy: str) -> str:
    """Mean success over the conditions, and the worst of them."""
    rates = {
        condition.name: results.success(condition.name, policy).mean()
        for condition in results.suite.conditions
    }
    worst = min(rates, key=rates.__getitem__)
    mean = formats.share(float(np.mean(list(rates.values()))))
    return f"{mean} (worst: {worst}, {formats.share(float(rates[worst]))})"


def page(results: Sequence[Results]) -> str:
    """All conditions of all suites, in Markdown."""
    parts = [INTRODUCTION.strip()]
    for one in results:
        suite = one.suite
        command = f"python -m baselines.evaluate --suite {suite.name} --policies "
        command += f"{' '.join(one.policies)} --episodes {suite.episodes}"
        lines = [
            _line(one, condition, name) for condition in suite.conditions for name in one.policies
        ]
        parts += [
            f"## {suite.name}",
            f"{suite.about} {suite.episodes:,} episodes a condition.",
            grid(HEADS, lines, left=HEADS[:3]),
            f"`{command} --out {FOLDER / suite.name}`",
        ]
    return "\n\n".join(parts) + "\n"


def _line(results: Results, condition: Condition, policy: str) -> list[str]:
    first = results.policies[0]
    success = results.success(condition.name, policy)
    compared = NOTHING
    if policy != first:
        estimate = statistics.difference_in_success(success, results.success(condition.name, first))
        compared = formats.points(vars(estimate))
    return [
        *([condition.name, condition.about] if policy == first else ["", ""]),
        policy,
        formats.share_estimate(vars(statistics.proportion(success))),
        compared,
        _median(results.column(condition.name, policy, "min_position_error"), "cm", 100.0),
        _median(results.column(condition.name, policy, "time_to_goal"), "s"),
    ]


def _median(values: Float, unit: str, scale: float = 1.0) -> str:
    present = values[np.isfinite(values)]
    return formats.quantity(float(np.median(present)), unit, scale) if len(present) else NOTHING


def pages(results: Sequence[Results], folder: Path, readme: Path) -> dict[Path, str]:
    """What the pages should say, by path.

    Raises:
        ValueError: the readme has no place for the table.
    """
    text = marks.replaced(readme.read_text(encoding="utf-8"), START, END, overview(results))
    return {
        readme: text,
        folder / "README.md": page(results),
        shipped.FOLDER / "README.md": model_cards.page(shipped.FOLDER),
    }


def main(arguments: Sequence[str] | None = None) -> None:
    """Entry point."""
    parser = argparse.ArgumentParser(prog="python -m baselines.evaluate.publish")
    parser.add_argument("--results", type=Path, default=FOLDER, help="folder (%(default)s)")
    parser.add_argument("--page", type=Path, default=README, help="overview (%(default)s)")
    parser.add_argument("--check", action="store_true", help="only say which pages are stale")
    options = parser.parse_args(arguments)
    try:
        wanted = pages(read(options.results), options.results, options.page)
    except (ValueError, OSError) as error:
        parser.error(str(error))
    stale = [
        p for p, text in wanted.items() if not p.exists() or p.read_text(encoding="utf-8") != text
    ]
    if options.check and stale:
        sys.exit(f"stale: {', '.join(map(str, stale))}: run {parser.prog}")
    for path in stale:
        path.write_text(wanted[path], encoding="utf-8")
        print(f"{path}: written")
