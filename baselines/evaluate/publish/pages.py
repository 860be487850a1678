"""Writes the published results onto pages: ``python -m baselines.evaluate.publish``.

Every number follows from the ``episodes.csv`` of the suites; where there are none, the pages say
so. With ``--check`` nothing is written, and stale pages are an error.
"""

import sys
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import tyro

from asv_env import files
from asv_env.checks import choice
from asv_env.types import Float
from baselines.evaluate import statistics
from baselines.evaluate.conditions import Condition
from baselines.evaluate.overall import overall
from baselines.evaluate.publish import marks, model_card, summaries
from baselines.evaluate.results import Results, of_rows, read_csv
from baselines.evaluate.suites import SUITES
from baselines.evaluate.summary import TOLERANCES, WIDE
from baselines.evaluate.tables import formats
from baselines.evaluate.tables.formats import NOTHING
from baselines.evaluate.tables.table import grid
from baselines.learned import policy_file
from baselines.rollout.commands import FilePath, command
from baselines.rollout.lock import locked

PROGRAM = "python -m baselines.evaluate.publish"
FOLDER = "docs/results"
HEADS = (
    *("condition", "what it is", "policy", "success", "difference"),
    *(f"{WIDE} tolerances", "distance [cm]", "time [s]"),
)
TITLE = "# Results on the suites"
POSITION, HEADING = TOLERANCES[WIDE]
INTRODUCTION = f"""\
Written by `{PROGRAM}` from the `episodes.csv` of each suite. *Success* is
the success rate with its 95 % interval, in per cent. *Difference* is the success rate minus that of
the first policy on the same episodes, in percentage points. *Wide tolerances* is the share of
episodes in which the vessel was, when nearest to its goal and however fast, within {POSITION:g}
times the tolerance of position and {HEADING:g} times that of heading: 10 cm and 0.5 rad with the
nominal vessel, the scale of the paper's tank experiment. *Distance* is the median of the smallest
distance to the goal; *time* is the median time of the successful episodes. The folder of each suite
also holds the report of its run (`report.md`).
"""
OVERVIEW = (
    "Mean success rate of each policy over the live conditions of a suite, in which some policy's "
    "rate lies between 2 and 98 %; the same over live conditions out of distribution (unseen); "
    "and its worst condition:"
)
NOT_YET = "Published results of the scripted and the learned policies follow with the new worlds."
START = f"<!-- results: what follows is written by {PROGRAM} -->"
END = "<!-- results: up to here -->"


@dataclass(frozen=True)
class Options:
    """Files that are read and written."""

    results: FilePath = Path(FOLDER)  # folder of the results, with one folder a suite
    page: FilePath = Path("README.md")  # page that receives the table between its marks
    check: bool = False  # whether only to check that the pages are up to date; fails if not


def read(folder: Path) -> list[Results]:
    """Returns the results of all suites in a folder, in the order of ``SUITES``."""
    return [_results(name, path) for name, path in _files(folder).items()]


def _files(folder: Path) -> dict[str, Path]:
    """Returns the episodes of all suites in a folder, by suite.

    Raises:
        FileNotFoundError: there is no such folder.
        ValueError: it holds results of something else, such as a suite of an old name.
    """
    if not folder.is_dir():
        raise FileNotFoundError(f"{folder} does not exist: give the folder of the results")
    found = {path.parent.name: path for path in folder.glob("*/episodes.csv")}
    for name, path in found.items():
        try:
            choice("suite", name, SUITES)
        except ValueError as error:
            raise ValueError(f"{path}: {error}") from error
    return {name: found[name] for name in SUITES if name in found}


def _results(suite: str, file: Path) -> Results:
    """Returns the results of a suite in a file; ValueError, which names it, where it has others."""
    rows = read_csv(file)
    try:
        return of_rows(SUITES[suite], rows)
    except ValueError as error:
        raise ValueError(f"{file}: {error}") from error


def pages(published: Sequence[Results], options: Options) -> dict[Path, str]:
    """Returns the text of every page, by path; ValueError where the overview's has no marks."""
    readme = marks.read(options.page)
    texts = {
        options.page: _overview_in(readme, options.page, published),
        options.results / "README.md": page(published),
        policy_file.LEARNED.parent / "README.md": _card(policy_file.LEARNED),
    }
    for results in published:
        folder = options.results / results.suite.name
        file = folder / summaries.NAME
        if file.exists():
            texts[folder / "report.md"] = summaries.markdown(file, results, summaries.read(file))
    return texts


def _card(file: Path) -> str:
    """Returns the page of the model card in a file; ValueError where it lacks something."""
    try:
        return model_card.page(file)
    except (KeyError, TypeError, IndexError, AttributeError) as error:
        raise ValueError(f"{file}: its model card lacks {error}, train it again") from error


def _overview_in(text: str, page: Path, published: Sequence[Results]) -> str:
    """Returns the text of a page with the table of all suites; ValueError names the page."""
    try:
        return marks.replaced(text, START, END, overview(published))
    except ValueError as error:
        raise ValueError(f"{page}: {error}") from error


def overview(published: Sequence[Results]) -> str:
    """Returns a table with a line a suite: every policy's mean success and worst condition."""
    if not published:
        return NOT_YET
    policies = list(dict.fromkeys(policy for results in published for policy in results.policies))
    lines = [
        [
            f"`{results.suite.name}`",
            f"{len(results.suite.conditions)} × {results.suite.episodes:,}",
            *(_overall(results, p) if p in results.policies else NOTHING for p in policies),
        ]
        for results in published
    ]
    table = grid(["suite", "conditions × episodes", *policies], lines, left=("suite",))
    return f"{OVERVIEW}\n\n{table}"


def _overall(results: Results, policy: str) -> str:
    """Returns the mean success over the live conditions, and the worst of all."""
    found = overall(results, policy)
    unseen = "" if found.unseen is None else f"unseen: {formats.share(found.unseen)}; "
    worst = f"worst: {found.worst}, {formats.share(found.least)}"
    return f"{formats.share(found.mean)} ({unseen}{worst})"


def page(published: Sequence[Results]) -> str:
    """Returns all conditions of all suites, in Markdown."""
    parts = [TITLE, INTRODUCTION.strip() if published else NOT_YET]
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
        *([condition.name, _about(condition)] if policy == first else ["", ""]),
        policy,
        formats.share_estimate(vars(statistics.proportion(success))),
        formats.points(vars(difference)) if policy != first else NOTHING,
        _wide(results, condition, policy),
        _median(results.column(condition.name, policy, "min_position_error"), "cm", 100.0),
        _median(results.column(condition.name, policy, "time_to_goal"), "s"),
    ]


def _about(condition: Condition) -> str:
    return condition.about + " (unseen)" * condition.out_of_distribution


def _wide(results: Results, condition: Condition, policy: str) -> str:
    """Returns the share of episodes placed within the wide tolerances, if the task has a goal."""
    if not condition.params.definition.has_goal:
        return NOTHING
    placed = results.placed(condition.name, policy, POSITION, HEADING)
    return formats.share(float(placed.mean()))


def _median(values: Float, unit: str, scale: float = 1.0) -> str:
    present = values[np.isfinite(values)]
    return formats.quantity(float(np.median(present)), unit, scale) if len(present) else NOTHING


def publish(options: Annotated[Options, tyro.conf.arg(name="")]) -> None:
    """Write the published results onto the pages of the repository.

    Raises:
        ValueError, OSError: a file is missing, damaged or cannot be written, or is in use.
    """
    folder = options.results
    if options.check:
        _check(pages(read(folder), options))
        return
    with ExitStack() as locks:
        for used in (folder, *(path.parent for path in _files(folder).values())):
            locks.enter_context(locked(used))
        _write(pages(read(folder), options))


main = command(publish, PROGRAM)


def _stale(texts: Mapping[Path, str]) -> dict[Path, str]:
    """Returns the pages that differ from what is written, with what they should be."""
    written = {path: marks.read(path) for path in texts if path.exists()}
    return {path: text for path, text in texts.items() if written.get(path) != text}


def _check(texts: Mapping[Path, str]) -> None:
    stale = _stale(texts)
    if stale:
        sys.exit(f"stale: {', '.join(map(str, stale))}: run {PROGRAM}")


def _write(texts: Mapping[Path, str]) -> None:
    for path, text in _stale(texts).items():
        files.write_text(path, text)
        print(f"{path}: written")
