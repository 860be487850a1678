"""Columns of tables: a head, and what stands below it for a policy in a condition.

All cells are text, so that the same number looks the same everywhere.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from baselines.evaluate.summary import COMPARED, MEASURES
from baselines.evaluate.tables import formats
from baselines.evaluate.tables.formats import NOTHING
from baselines.rollout.episodes import CAUSES


@dataclass(frozen=True)
class Line:
    """What one line of a table is about.

    Attributes:
        condition: its name.
        policy: its name.
        entry: the condition's part of the summary.
        compared: the comparison that the line shows, if it shows one.
    """

    condition: str
    policy: str
    entry: Mapping[str, Any]
    compared: Mapping[str, Any] | None = None

    @property
    def found(self) -> Mapping[str, Any]:
        """The policy's part of the summary."""
        return self.entry["policies"][self.policy]


@dataclass(frozen=True)
class Column:
    """A column of a table.

    Attributes:
        head: above it.
        cell: its text, for a line.
        group: above the heads of several columns that belong together.
        words: whether its cells are words, not numbers.
    """

    head: str
    cell: Callable[[Any], str]
    group: str = ""
    words: bool = False

    @property
    def title(self) -> str:
        """The head where there is only one line of them."""
        return f"{self.group}: {self.head}" if self.group else self.head


def headed(name: str) -> str:
    """The head of a measure."""
    measure = MEASURES[name]
    label = measure.label if measure.signed else f"|{measure.label}|"
    return f"{label} [{measure.unit}]" if measure.unit else label


def centres(name: str) -> list[Column]:
    """Of a measure: median, and interquartile mean with its interval."""
    return [
        Column("median", partial(median, name=name), headed(name)),
        Column("IQM [95 %]", partial(iqm, name=name), headed(name)),
    ]


def median(line: Line, name: str) -> str:
    """Of a measure."""
    measure = MEASURES[name]
    found = line.found.get(name, {}).get("median")
    return formats.quantity(found, measure.unit, measure.scale)


def iqm(line: Line, name: str) -> str:
    """Interquartile mean of a measure, and its interval."""
    found, measure = line.found.get(name), MEASURES[name]
    if found is None:
        return NOTHING
    return formats.estimate(found["iqm"], measure.unit, measure.scale)


def placed(tolerance: str) -> Column:
    """Share of the episodes placed within so many tolerances."""

    def cell(line: Line) -> str:
        found = line.found["placed"].get(tolerance)
        return NOTHING if found is None else formats.share_estimate(found)

    return Column(tolerance.replace("0.5", "½"), cell, "placed within [tolerances]")


def failures(line: Line) -> str:
    """How often the policy failed by which cause."""
    causes = line.found["causes"]
    return ", ".join(f"{causes[cause]} {cause}" for cause in CAUSES if cause in causes) or NOTHING


def comparing() -> list[Column]:
    """What a comparison says."""
    return [
        Column("success [points]", difference_in_success),
        Column("McNemar p", lambda line: formats.p_value((line.compared or {}).get("mcnemar"))),
        Column("done sooner", _improvement),
        *map(_difference, COMPARED),
    ]


def difference_in_success(line: Line) -> str:
    """In points, with its interval."""
    return NOTHING if line.compared is None else formats.points(line.compared["success"])


def _improvement(line: Line) -> str:
    found = line.compared
    return NOTHING if found is None else formats.share_estimate(found["improvement"])


def _difference(name: str) -> Column:
    measure = MEASURES[name]

    def cell(line: Line) -> str:
        found = (line.compared or {}).get(name)
        return NOTHING if found is None else formats.difference(found, measure.unit, measure.scale)

    return Column(headed(name), cell)


NAMES = (
    Column("condition", lambda line: line.condition, words=True),
    Column("policy", lambda line: line.policy, words=True),
)
SUCCESS = (
    Column("success", lambda line: formats.share(line.found["success"]["value"])),
    Column("95 % interval", lambda line: formats.share_interval(line.found["success"])),
)
