"""Tables of a summary: one description of each, for the terminal and for pages."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import groupby
from typing import Any

from baselines.evaluate.summary import MEASURES
from baselines.evaluate.tables import columns, formats
from baselines.evaluate.tables.columns import CONDITION, CONTROL, POLICY, SUCCESS, Column, Line
from baselines.evaluate.tables.formats import NOTHING

TERMINAL = {
    "min_position_error": "smallest distance [cm]",
    "heading_error": "|heading| [rad]",
    "time_to_closure": "closure [s]",
    "time_to_goal": "delivery [s]",
}
"""The main measures, with headings that are short enough for a terminal."""


@dataclass(frozen=True)
class Table:
    """Cells of text under headings.

    Attributes:
        name: unique among the tables of a report.
        caption: what the table shows, in a sentence.
        columns: its columns; the first ones name the subject of a line.
        rows: its lines, each with a cell for every column.
    """

    name: str
    caption: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[str, ...], ...]

    @property
    def titles(self) -> list[str]:
        """Headings in a single line."""
        return [column.title for column in self.columns]

    @property
    def groups(self) -> list[tuple[str, list[Column]]]:
        """Adjacent columns by the heading that they have in common, which may be empty."""
        pairs = groupby(self.columns, key=lambda column: column.group)
        return [(group, list(some)) for group, some in pairs]

    @property
    def bodies(self) -> list[list[list[tuple[Column, str]]]]:
        """Lines by what they share, each line as pairs of column and cell."""
        lines = [list(zip(self.columns, row, strict=True)) for row in self.rows]
        shared = groupby(lines, key=lambda line: [t for c, t in line if c.kind == "shared"])
        return [list(some) for _, some in shared]

    @property
    def markdown(self) -> str:
        """The table in Markdown."""
        left = [column.title for column in self.columns if column.kind != "number"]
        return grid(self.titles, self.rows, left)


def grid(heads: Sequence[str], rows: Iterable[Sequence[str]], left: Collection[str] = ()) -> str:
    """Returns cells as a table in Markdown.

    Args:
        heads: headings of the columns.
        rows: lines with a cell for every column.
        left: headings of the columns that are flush left, not right.
    """
    rules = [":--" if head in left else "--:" for head in heads]
    lines = [[" ".join(cell.replace("|", "\\|").split()) for cell in row] for row in (heads, *rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in (lines[0], rules, *lines[1:]))


def results(summary: Mapping[str, Any]) -> Table:
    """Returns how often each policy succeeds, how near it brings the vessel, why it fails."""
    tolerances = dict.fromkeys(
        tolerance
        for entry in summary["conditions"].values()
        for policy in entry["policies"].values()
        for tolerance in policy["placed"]
    )
    caption = (
        "Success with its 95 % interval; the share of episodes in which the vessel was within so "
        "many tolerances of its goal pose when it was nearest, at rest or not; and why episodes "
        "failed."
    )
    placed = [columns.placed(tolerance) for tolerance in tolerances]
    failures = Column("failures", columns.failures, kind="words")
    heads = (CONDITION, POLICY, *SUCCESS, *placed, failures)
    return _table("results", caption, heads, _lines(summary))


def measures(summary: Mapping[str, Any]) -> Table:
    """Returns how far off each policy leaves the vessel, and how long it takes."""
    caption = (
        "Medians and interquartile means (IQM, of the middle half of the values) with their 95 % "
        "intervals, over the episodes to which a measure applies."
    )
    shown = [column for name in TERMINAL for column in columns.centres(name)]
    return _table("measures", caption, (CONDITION, POLICY, *shown), _lines(summary))


def comparisons(summary: Mapping[str, Any]) -> Table:
    """Returns the differences of every policy from the first, in the same episodes."""
    caption = (
        f"Differences of each policy to {next(iter(summary['policies']))} within the same "
        "episodes, with their 95 % intervals; the probability to be done sooner in the same "
        "episode; and McNemar's p that both succeed equally often."
    )
    heads = (CONDITION, POLICY, *columns.comparing())
    return _table("comparisons", caption, heads, _compared(summary, "comparisons"))


def controls(summary: Mapping[str, Any]) -> Table:
    """Returns the differences of every policy from itself in the control of a condition."""
    caption = (
        "Differences of each policy in a disturbed condition to itself in the control condition, "
        "episode by episode, with their 95 % intervals."
    )
    heads = (CONDITION, CONTROL, POLICY, *columns.comparing())
    return _table("controls", caption, heads, _compared(summary, "against_control"))


def of_condition(summary: Mapping[str, Any], condition: str) -> Table:
    """Returns all measures in one condition, one a line: medians and interquartile means."""
    entry = summary["conditions"][condition]
    shown = [Column("measure", columns.label, kind="measure")]
    for policy in entry["policies"]:
        line = Line(condition, policy, entry, {})
        shown.append(Column("median", partial(columns.median, line), policy))
        shown.append(Column("IQM [95 %]", partial(columns.iqm, line), policy))
    found = {name for policy in entry["policies"].values() for name in policy}
    name = f"condition-{list(summary['conditions']).index(condition)}"
    caption = "Medians and IQM with their 95 % intervals."
    return _table(name, caption, shown, [name for name in MEASURES if name in found])


def text_table(summary: Mapping[str, Any]) -> str:
    """Returns the main results for a terminal, in ASCII."""
    medians = [Column(head, partial(columns.median, name=name)) for name, head in TERMINAL.items()]
    compared = Column("difference in success", columns.difference_in_success)
    heads = (CONDITION, POLICY, *SUCCESS, *medians, compared)
    shown = _table("terminal", "", heads, _lines(summary))
    lines = [shown.titles, *shown.rows]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    text = "\n".join(
        "  ".join(
            cell.rjust(width) if column.kind == "number" else cell.ljust(width)
            for column, cell, width in zip(shown.columns, line, widths, strict=True)
        ).rstrip()
        for line in lines
    )
    return text.replace(formats.MINUS, formats.HYPHEN).replace(NOTHING, formats.HYPHEN)


def _table(name: str, caption: str, heads: Iterable[Column], subjects: Sequence[Any]) -> Table:
    """Returns the table with a line a subject; columns without any content are left out."""
    cells = {column: [column.cell(subject) for subject in subjects] for column in heads}
    kept = {c: texts for c, texts in cells.items() if any(text != NOTHING for text in texts)}
    return Table(name, caption, tuple(kept), tuple(zip(*kept.values(), strict=True)))


def _lines(summary: Mapping[str, Any]) -> list[Line]:
    return [
        Line(condition, policy, entry, entry["comparisons"].get(policy, {}))
        for condition, entry in summary["conditions"].items()
        for policy in entry["policies"]
    ]


def _compared(summary: Mapping[str, Any], key: str) -> list[Line]:
    return [
        Line(condition, policy, entry, comparison)
        for condition, entry in summary["conditions"].items()
        for policy, comparison in entry[key].items()
    ]
