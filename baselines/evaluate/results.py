"""Rows of finished episodes, by condition, policy and training; and ``episodes.csv``."""

import csv
import io
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass
from itertools import chain, product
from pathlib import Path
from typing import Any, TypeVar, get_type_hints

import numpy as np
import pandas as pd

from asv_env.files import write_text
from asv_env.types import Bool, Float
from baselines.evaluate.conditions import Condition, Suite
from baselines.rollout import typed_csv
from baselines.rollout.episodes import COLUMNS, Episode

T = TypeVar("T")
OPTIONAL = [name for name, kind in get_type_hints(Episode).items() if kind not in (int, float, str)]
"""Columns whose cells may be empty."""


@dataclass(frozen=True)
class Results:
    """All episodes of a comparison.

    Rows by condition and policy are S trainings (1 of a scripted policy) of E episodes each.
    """

    suite: Suite  #: the suite that was run, with as many episodes as were run
    policies: tuple[str, ...]  #: names, in order; the others are compared with the first
    rows: Mapping[tuple[str, str], Sequence[Sequence[Episode]]]

    def column(self, condition: str, policy: str, name: str) -> Float:
        """Returns the numbers (S, E) of a column, NaN where it does not apply."""
        rows = self.rows[condition, policy]
        values = [[getattr(row, name) for row in training] for training in rows]
        return np.array(values, dtype=np.float64)

    def success(self, condition: str, policy: str) -> Bool:
        """Returns whether the task was done, (S, E)."""
        return self.column(condition, policy, "success") > 0

    def placed(
        self, condition: str, policy: str, position: float = 1.0, heading: float = 1.0
    ) -> Bool:
        """Returns whether the vessel was, when nearest to its goal, within so many tolerances.

        The result has the shape (S, E); position and heading are multiples of the task's
        tolerances. As in the paper, the vessel may be moving.
        """
        task = next(c.params.task for c in self.suite.conditions if c.name == condition)
        distance = self.column(condition, policy, "min_position_error")
        turn = np.abs(self.column(condition, policy, "heading_error_at_min"))
        near: Bool = distance <= position * task.position_tolerance
        return near & (turn <= heading * task.heading_tolerance)

    def scores(self, condition: str, policy: str) -> Float:
        """Returns the time until the task was done (S, E), s; infinite where it was not."""
        duration = self.column(condition, policy, "duration")
        return np.where(self.success(condition, policy), duration, np.inf)

    def by_policy(self, method: Callable[..., T], condition: str, *more: Any) -> dict[str, T]:
        """Returns what a method, such as ``success``, gives for each policy in a condition."""
        return {policy: method(condition, policy, *more) for policy in self.policies}

    def __iter__(self) -> Iterator[Episode]:
        """Yields all rows, by condition, policy, training and seed."""
        for condition, policy in product(self.suite.conditions, self.policies):
            yield from chain.from_iterable(self.rows[condition.name, policy])


def of_rows(suite: Suite, rows: Iterable[Episode]) -> Results:
    """Returns results from rows in any order, such as those of a file.

    Raises:
        ValueError: rows that are not those of the suite's first episodes, or not the same ones
            for every policy and in every condition.
    """
    rows = sorted(rows, key=lambda row: row.seed)
    if not rows:
        raise ValueError(f"there are no episodes of {suite.name}")
    if not suite.seed <= rows[-1].seed < suite.seed + len(rows):
        raise ValueError(f"seed {rows[-1].seed}: seeds are not the first ones of {suite.name}")
    suite = suite.first(rows[-1].seed - suite.seed + 1)
    found: dict[str, dict[tuple[str, int], list[Episode]]] = {}
    for row in rows:
        number = -1 if row.training_seed is None else row.training_seed
        found.setdefault(row.policy, {}).setdefault((row.condition, number), []).append(row)
    kept = {}
    for policy, trainings in found.items():
        numbers = sorted({number for _, number in trainings})
        if set(trainings) != set(product([c.name for c in suite.conditions], numbers)):
            raise ValueError(f"{policy}: its conditions are not those of {suite.name}")
        for condition in suite.conditions:
            kept[condition.name, policy] = [trainings[condition.name, k] for k in numbers]
            for training in kept[condition.name, policy]:
                _check(suite, condition, training)
    return Results(suite, tuple(found), kept)


def _check(suite: Suite, condition: Condition, rows: Sequence[Episode]) -> None:
    """Refuses rows of a training in a condition that are not the suite's."""
    if [row.seed for row in rows] != list(suite.seeds):
        raise ValueError(f"{condition.name}: seeds are not the first ones of {suite.name}")
    wanted = (condition.task_name, condition.scenario_name, condition.params.num_boats)
    for row in rows:
        if (row.task, row.scenario, row.num_boats) != wanted:
            raise ValueError(f"{condition.name}, seed {row.seed}: not an episode of {suite.name}")


def frame(rows: Iterable[Episode]) -> pd.DataFrame:
    """Returns rows as a table with typed columns, missing where a column does not apply."""
    return pd.DataFrame([astuple(row) for row in rows], columns=COLUMNS).astype(
        typed_csv.dtypes(Episode)
    )


def write_csv(path: Path, rows: Iterable[Episode]) -> None:
    """Writes rows, all at once; a cell is empty where a column does not apply."""
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    writer.writerows(astuple(row) for row in rows)
    write_text(path, text.getvalue())


def read_csv(path: Path) -> list[Episode]:
    """Returns the rows of a file.

    Raises:
        ValueError: it has other columns, values of other types, or is damaged.
        FileNotFoundError: there is none.
    """
    try:
        read = typed_csv.read(path, Episode, COLUMNS, "", OPTIONAL)
    except ValueError as error:
        raise ValueError(f"{path} is damaged, or holds no episodes: {error}") from error
    cells = read.astype(object).where(read.notna(), None)
    return [Episode(*row) for row in cells.itertuples(index=False)]
