"""Tables of a summary: one description of each, for the terminal and for pages."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from baselines.evaluate.summary import MEASURES
from baselines.evaluate.tables import columns, formats
from baselines.evaluate.tables.columns import NAMES, SUCCESS, Column, Line
from baselines.evaluate.tables.formats import NOTHING

TERMINAL = {
    "min_position_error": "smallest distance [cm]",
    "heading_error": "|heading| [rad]",
    "time_to_closure": "closure [s]",
    "time_to_goal": "delivery [s]",
}
"""The main measures, with heads that are short enough for a terminal."""


@dataclass(frozen=True)
class Table:
    """Cells of text.

    Attributes:
        columns: the first ones name what a line is about.
        rows: of as many cells.
    """

    columns: tuple[Column, ...]
    rows: tuple[tuple[str, ...], ...]

    @property
    def titles(self) -> list[str]:
        """Of the columns."""
        return [column.title for column in self.columns]


def results(summary: Mapping[str, Any]) -> Table:
    """How often each policy succeeds, how near it brings the vessel, and why it fails."""
    tolerances = dict.fromkeys(
        tolerance
        for entry in summary["conditions"].values()
        for policy in entry["policies"].values()
        for tolerance in policy["placed"]
    )
    placed = [columns.placed(tolerance) for tolerance in tolerances]
    return table(
        (*NAMES, *SUCCESS, *placed, Column("failures", columns.failures, words=True)),
        _lines(summary),
    )


def measures(summary: Mapping[str, Any]) -> Table:
    """How far off each policy leaves the vessel, and how long it takes."""
    shown = [column for name in TERMINAL for column in columns.centres(name)]
    return table((*NAMES, *shown), _lines(summary))


def comparisons(summary: Mapping[str, Any]) -> Table:
    """Every policy less the first, in the same episodes."""
    lines = [
        Line(condition, policy, entry, compared)
        for condition, entry in summary["conditions"].items()
        for policy, compared in entry["comparisons"].items()
    ]
    return table((*NAMES, *columns.comparing()), lines)


def controls(summary: Mapping[str, Any]) -> Table:
    """Every policy in a disturbed condition less the same policy in its control."""
    lines = [
        Line(condition, policy, entry, compared)
        for condition, entry in summary["conditions"].items()
        for policy, compared in entry["against_control"].items()
    ]
    control = Column("control", lambda line: line.entry["control"], words=True)
    return table((NAMES[0], control, NAMES[1], *columns.comparing()), lines)


def of_condition(summary: Mapping[str, Any], condition: str) -> Table:
    """All measures in one condition, one a line: their medians and interquartile means."""
    entry = summary["conditions"][condition]
    shown = [Column("measure", columns.headed, words=True)]
    for policy in entry["policies"]:
        line = Line(condition, policy, entry)
        for head, cell in (("median", columns.median), ("IQM [95 %]", columns.iqm)):
            shown.append(Column(head, partial(cell, line), policy))
    found = {name for policy in entry["policies"].values() for name in policy}
    return table(shown, [name for name in MEASURES if name in found])


def table(heads: Iterable[Column], lines: Sequence[Any]) -> Table:
    """The lines of a table; columns in which nothing stands are left out."""
    cells = {column: [column.cell(line) for line in lines] for column in heads}
    kept = {c: texts for c, texts in cells.items() if any(text != NOTHING for text in texts)}
    return Table(tuple(kept), tuple(zip(*kept.values(), strict=True)))


def _lines(summary: Mapping[str, Any]) -> list[Line]:
    return [
        Line(condition, policy, entry, entry["comparisons"].get(policy))
        for condition, entry in summary["conditions"].items()
        for policy in entry["policies"]
    ]


def text_table(summary: Mapping[str, Any]) -> str:
    """For the terminal: medians, and the difference of each policy to the first."""
    medians = [Column(head, partial(columns.median, name=name)) for name, head in TERMINAL.items()]
    compared = Column("difference in success", columns.difference_in_success)
    shown = table((*NAMES, *SUCCESS, *medians, compared), _lines(summary))
    lines = [shown.titles, *shown.rows]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    text = "\n".join(
        "  ".join(
            cell.ljust(width) if number < 2 else cell.rjust(width)
            for number, (cell, width) in enumerate(zip(line, widths, strict=True))
        ).rstrip()
        for line in lines
    )
    return text.replace(formats.MINUS, formats.HYPHEN).replace(NOTHING, formats.HYPHEN)
