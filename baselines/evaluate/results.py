"""Rows of finished episodes, by condition, policy and training; and ``episodes.csv``."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import Any, get_type_hints

import numpy as np
import pandas as pd

from asv_env.types import Bool, Float
from baselines.evaluate.conditions import Condition, Suite
from baselines.rollout.episodes import COLUMNS, Episode
from baselines.rollout.files import write_text

HEADS = tuple("arm" if name == "condition" else name for name in COLUMNS)
"""Heads of the columns of ``episodes.csv``: those of the published version 1 files."""
DTYPES: dict[Any, str] = {
    **{int: "int64", float: "float64", bool: "bool", str: "str"},
    **{int | None: "Int64", float | None: "float64", str | None: "object"},
}
"""Types of pandas columns by those of the fields of an episode."""
DTYPE = {name: DTYPES[kind] for name, kind in get_type_hints(Episode).items()}


@dataclass(frozen=True)
class Results:
    """All episodes of a comparison.

    Attributes:
        suite: suite that was run, with as many episodes as were run.
        policies: names, in order; the others are compared with the first.
        rows: by condition and policy: S trainings (1 of a scripted policy) of E episodes each.
    """

    suite: Suite
    policies: tuple[str, ...]
    rows: Mapping[tuple[str, str], Sequence[Sequence[Episode]]]

    def column(self, condition: str, policy: str, name: str) -> Float:
        """Returns the numbers (S, E) of a column, NaN where it does not apply."""
        rows = self.rows[condition, policy]
        values = [[getattr(row, name) for row in training] for training in rows]
        return np.array(values, dtype=np.float64)

    def success(self, condition: str, policy: str) -> Bool:
        """Returns whether the task was done, (S, E)."""
        return self.column(condition, policy, "success") > 0

    def placed(self, condition: str, policy: str, tolerance: float) -> Bool:
        """Returns whether the vessel was placed within a number of tolerances, (S, E).

        It is judged at the instant at which the vessel was nearest to its goal, as in the paper,
        at rest or not.
        """
        by_name = {one.name: one for one in self.suite.conditions}
        task = by_name[condition].params.task
        distance = self.column(condition, policy, "min_position_error")
        heading = np.abs(self.column(condition, policy, "heading_error_at_min"))
        placed: Bool = (distance <= tolerance * task.position_tolerance) & (
            heading <= tolerance * task.heading_tolerance
        )
        return placed

    def scores(self, condition: str, policy: str) -> Float:
        """Returns the time until the task was done (S, E), s; infinite where it was not."""
        duration = self.column(condition, policy, "duration")
        return np.where(self.success(condition, policy), duration, np.inf)

    def __iter__(self) -> Iterator[Episode]:
        """Yields all rows, by condition, policy, training and seed."""
        for condition in self.suite.conditions:
            for policy in self.policies:
                for training in self.rows[condition.name, policy]:
                    yield from training


def of_rows(suite: Suite, rows: Iterable[Episode]) -> Results:
    """Returns results from rows in any order, such as those of a file.

    Raises:
        ValueError: rows that are not those of the suite's first episodes, or not the same ones
            for every policy and in every condition.
    """
    rows = sorted(rows, key=lambda row: row.seed)
    if not rows:
        raise ValueError(f"there are no episodes of {suite.name}")
    suite = suite.first(rows[-1].seed - suite.seed + 1)
    found: dict[str, dict[str, dict[int, list[Episode]]]] = {}
    for row in rows:
        trainings = found.setdefault(row.policy, {}).setdefault(row.condition, {})
        trainings.setdefault(-1 if row.training_seed is None else row.training_seed, []).append(row)
    kept = {}
    for policy, conditions in found.items():
        numbers = sorted(next(iter(conditions.values())))
        wanted = {condition.name: numbers for condition in suite.conditions}
        if {name: sorted(trainings) for name, trainings in conditions.items()} != wanted:
            raise ValueError(f"{policy}: its conditions are not those of {suite.name}")
        for condition in suite.conditions:
            trainings = conditions[condition.name]
            kept[condition.name, policy] = [trainings[number] for number in numbers]
            for training in trainings.values():
                _check(suite, condition, training)
    return Results(suite, tuple(found), kept)


def _check(suite: Suite, condition: Condition, rows: Sequence[Episode]) -> None:
    """Refuses rows of one training in one condition that are not those of the suite."""
    if [row.seed for row in rows] != list(suite.seeds):
        raise ValueError(f"{condition.name}: seeds are not the first ones of {suite.name}")
    wanted = (condition.task_name, condition.scenario_name, condition.params.num_boats)
    for row in rows:
        if (row.task, row.scenario, row.num_boats) != wanted:
            raise ValueError(f"{condition.name}, seed {row.seed}: not an episode of {suite.name}")


def frame(rows: Iterable[Episode]) -> pd.DataFrame:
    """Returns rows as a table with typed columns, missing where a column does not apply."""
    return pd.DataFrame([astuple(row) for row in rows], columns=COLUMNS).astype(DTYPE)


def write_csv(path: Path, rows: Iterable[Episode]) -> None:
    """Writes rows, all at once; a cell is empty where a column does not apply."""
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(HEADS)
    writer.writerows(astuple(row) for row in rows)
    write_text(path, text.getvalue())


def read_csv(path: Path) -> list[Episode]:
    """Returns the rows of a file.

    Raises:
        ValueError: it has other columns, or a value of another type.
    """
    if path.read_text(encoding="utf-8").partition("\n")[0] != ",".join(HEADS):
        raise ValueError(f"{path}: columns must be {', '.join(HEADS)}")
    try:
        read = pd.read_csv(
            path, names=COLUMNS, header=0, dtype=DTYPE, keep_default_na=False, na_values=[""]
        )
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error
    cells = read.astype(object).where(read.notna(), None)
    return [Episode(*row) for row in cells.itertuples(index=False)]
