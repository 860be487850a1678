"""Columns of tables: a heading, and the text of a cell for a policy in a condition."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal

from baselines.evaluate.summary import COMPARED, MEASURES
from baselines.evaluate.tables import formats
from baselines.evaluate.tables.formats import NOTHING
from baselines.rollout.episodes import CAUSES

Kind = Literal["number", "words", "policy", "measure", "shared"]


@dataclass(frozen=True)
class Line:
    """The subject of one line of a table.

    Attributes:
        condition: its name.
        policy: its name.
        entry: the condition's part of the summary.
        comparison: the comparison that the line shows; empty where it shows none.
    """

    condition: str
    policy: str
    entry: Mapping[str, Any]
    comparison: Mapping[str, Any]

    @property
    def found(self) -> Mapping[str, Any]:
        """The policy's part of the summary."""
        return self.entry["policies"][self.policy]


@dataclass(frozen=True)
class Column:
    """A column of a table.

    Attributes:
        head: its heading.
        cell: returns the text of its cell from the subject of a line.
        group: heading above those of adjacent columns that belong together; may be empty.
        kind: "number", flush right; "words", flush left; "policy" or "measure", a name; "shared",
            a name that all lines of a condition have in common.
    """

    head: str
    cell: Callable[[Any], str]
    group: str = ""
    kind: Kind = "number"

    @property
    def title(self) -> str:
        """The heading in a table with a single line of headings."""
        return f"{self.group}: {self.head}" if self.group else self.head


CONDITION = Column("condition", lambda line: line.condition, kind="shared")
CONTROL = Column("control", lambda line: line.entry["control"], kind="shared")
POLICY = Column("policy", lambda line: line.policy, kind="policy")
SUCCESS = (
    Column("success", lambda line: formats.share(line.found["success"]["value"])),
    Column("95 % interval", lambda line: formats.share_interval(line.found["success"])),
)


def label(name: str) -> str:
    """Returns the heading of a measure; one that is summarised by magnitude stands in bars."""
    measure = MEASURES[name]
    text = measure.label if measure.signed else f"|{measure.label}|"
    return f"{text} [{measure.unit}]" if measure.unit else text


def centres(name: str) -> list[Column]:
    """Returns the columns of a measure: its median, and its interquartile mean with interval."""
    return [
        Column("median", partial(median, name=name), label(name)),
        Column("IQM [95 %]", partial(iqm, name=name), label(name)),
    ]


def median(line: Line, name: str) -> str:
    """Returns the median of a measure."""
    measure = MEASURES[name]
    return formats.quantity(line.found.get(name, {}).get("median"), measure.unit, measure.scale)


def iqm(line: Line, name: str) -> str:
    """Returns the interquartile mean of a measure with its interval."""
    found, measure = line.found.get(name), MEASURES[name]
    return formats.estimate(found["iqm"], measure.unit, measure.scale) if found else NOTHING


def placed(tolerance: str) -> Column:
    """Returns the column of the share of episodes placed within so many tolerances."""

    def cell(line: Line) -> str:
        found = line.found["placed"].get(tolerance)
        return formats.share_estimate(found) if found else NOTHING

    return Column(tolerance.replace("0.5", "½"), cell, "placed within [tolerances]")


def failures(line: Line) -> str:
    """Returns the causes by which the policy failed, each with its count."""
    causes = line.found["causes"]
    return ", ".join(f"{causes[cause]} {cause}" for cause in in_order(causes)) or NOTHING


def in_order(causes: Iterable[str]) -> list[str]:
    """Returns causes of failure as they exclude each other; those of a user's task come last."""
    found = set(causes)
    return [*(cause for cause in CAUSES if cause in found), *sorted(found - set(CAUSES))]


def comparing() -> list[Column]:
    """Returns the columns of a comparison."""
    return [
        Column("success [points]", difference_in_success),
        Column("McNemar p", lambda line: formats.p_value(line.comparison["mcnemar"])),
        Column("done sooner", lambda line: formats.share_estimate(line.comparison["improvement"])),
        *(Column(label(name), partial(_difference, name=name)) for name in COMPARED),
    ]


def difference_in_success(line: Line) -> str:
    """Returns the difference in success with its interval, in percentage points."""
    return formats.points(line.comparison["success"]) if line.comparison else NOTHING


def _difference(line: Line, name: str) -> str:
    found, measure = line.comparison.get(name), MEASURES[name]
    return formats.difference(found, measure.unit, measure.scale) if found else NOTHING
