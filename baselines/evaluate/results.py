"""Rows of finished episodes, by condition, policy and training; and ``episodes.csv``."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from types import NoneType
from typing import Any, get_args, get_type_hints

import numpy as np

from asv_env.types import Bool, Float
from baselines.evaluate.conditions import Condition, Suite
from baselines.rollout.episodes import COLUMNS, Episode
from baselines.rollout.files import write_text

NOTHING = ""
"""In a CSV file, where a column does not apply."""
HEADS = tuple("arm" if name == "condition" else name for name in COLUMNS)
"""Heads of the columns of ``episodes.csv``: those of the published version 1 files."""


@dataclass(frozen=True)
class Results:
    """All episodes of a comparison.

    Attributes:
        suite: that was run, with as many episodes as were.
        policies: names, in order; the first is the one that the others are compared with.
        rows: by condition and policy: S trainings (1 of a script) of E episodes each.
    """

    suite: Suite
    policies: tuple[str, ...]
    rows: Mapping[tuple[str, str], Sequence[Sequence[Episode]]]

    def column(self, condition: str, policy: str, name: str) -> Float:
        """Numbers (S, E) of a column, NaN where it does not apply."""
        rows = self.rows[condition, policy]
        values = [[getattr(row, name) for row in training] for training in rows]
        return np.array(values, dtype=np.float64)

    def success(self, condition: str, policy: str) -> Bool:
        """(S, E) whether the task was done."""
        return self.column(condition, policy, "success") > 0

    def placed(self, condition: str, policy: str, tolerance: float) -> Bool:
        """(S, E) whether the vessel was within so many tolerances of its goal pose.

        At the instant at which it was nearest, which is when the paper looks; at rest or not.
        """
        task = next(a for a in self.suite.conditions if a.name == condition).params.task
        near = (
            self.column(condition, policy, "min_position_error")
            <= tolerance * task.position_tolerance
        )
        heading = np.abs(self.column(condition, policy, "heading_error_at_min"))
        placed: Bool = near & (heading <= tolerance * task.heading_tolerance)
        return placed

    def scores(self, condition: str, policy: str) -> Float:
        """(S, E) time until the task was done, s; infinite where it was not."""
        return np.where(
            self.success(condition, policy), self.column(condition, policy, "duration"), np.inf
        )

    def __iter__(self) -> Iterator[Episode]:
        """All rows, by condition, policy, training and seed."""
        for condition in self.suite.conditions:
            for policy in self.policies:
                for training in self.rows[condition.name, policy]:
                    yield from training


def of_rows(suite: Suite, rows: Iterable[Episode]) -> Results:
    """Results from rows in any order, such as those of a file.

    Raises:
        ValueError: rows that are not those of the suite's first episodes, or not the same ones
            for every policy and in every condition.
    """
    found: dict[str, dict[str, dict[int | None, dict[int, Episode]]]] = {}
    for row in rows:
        trainings = found.setdefault(row.policy, {}).setdefault(row.condition, {})
        trainings.setdefault(row.training_seed, {})[row.seed] = row
    count = max((row.seed for row in _all(found)), default=suite.seed - 1) - suite.seed + 1
    suite = suite.first(count)
    kept: dict[tuple[str, str], list[list[Episode]]] = {}
    for policy, conditions in found.items():
        numbers = sorted(next(iter(conditions.values())), key=_number)
        for condition in suite.conditions:
            trainings = conditions.get(condition.name, {})
            if sorted(trainings, key=_number) != numbers or len(conditions) != len(
                suite.conditions
            ):
                raise ValueError(
                    f"{policy}: not all conditions of {suite.name} are there, or others"
                )
            kept[condition.name, policy] = [
                _checked(suite, condition, trainings[n]) for n in numbers
            ]
    if not kept:
        raise ValueError(f"there are no episodes of {suite.name}")
    return Results(suite, tuple(found), kept)


def _all(found: Mapping[str, Any]) -> Iterator[Episode]:
    for conditions in found.values():
        for trainings in conditions.values():
            for rows in trainings.values():
                yield from rows.values()


def _checked(suite: Suite, condition: Condition, rows: Mapping[int, Episode]) -> list[Episode]:
    """Rows of one training in one condition, in the order of their seeds."""
    if sorted(rows) != list(suite.seeds):
        raise ValueError(f"{condition.name}: seeds are not the first ones of {suite.name}")
    is_of = (condition.task, condition.scenario, condition.params.num_boats)
    for row in rows.values():
        if (row.task, row.scenario, row.num_boats) != is_of:
            raise ValueError(f"{condition.name}, seed {row.seed}: not an episode of {suite.name}")
    return [rows[seed] for seed in suite.seeds]


def _number(training: int | None) -> int:
    return -1 if training is None else training


def write_csv(path: Path, rows: Iterable[Episode]) -> None:
    """Writes rows, all at once; ``NOTHING`` where a column does not apply."""
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(HEADS)
    writer.writerows(astuple(row) for row in rows)
    write_text(path, text.getvalue())


def read_csv(path: Path) -> list[Episode]:
    """The rows of a file.

    Raises:
        ValueError: its columns are others, or a value is none.
    """
    with path.open(newline="", encoding="utf-8") as file:
        head, reader = tuple(next(csv.reader(file), ())), csv.DictReader(file, COLUMNS)
        if head != HEADS:
            raise ValueError(f"{path}: columns must be {', '.join(HEADS)}")
        try:
            return [
                Episode(**{name: _READ[name](text) for name, text in r.items()}) for r in reader
            ]
        except (KeyError, ValueError) as error:
            raise ValueError(f"{path}: {error}") from error


def _reader(kind: Any) -> Any:
    """From the text of a cell to a value of an annotated type."""
    optional = NoneType in get_args(kind)
    plain = next((one for one in get_args(kind) if one is not NoneType), kind)
    read = {"True": True, "False": False}.__getitem__ if plain is bool else plain
    return lambda text: None if optional and text == NOTHING else read(text)


_READ = {f.name: _reader(get_type_hints(Episode)[f.name]) for f in fields(Episode)}
