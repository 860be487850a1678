"""The tables of a summary, each described once."""

from collections.abc import Mapping
from functools import partial
from typing import Any

from baselines.evaluate.summary import MEASURES
from baselines.evaluate.tables import columns
from baselines.evaluate.tables.columns import CONDITION, CONTROL, POLICY, SUCCESS, Column, Line
from baselines.evaluate.tables.table import Table, tabulated

TERMINAL = {
    "min_position_error": "smallest distance [cm]",
    "heading_error": "|heading| [rad]",
    "time_to_closure": "closure [s]",
    "time_to_goal": "delivery [s]",
}
"""The main measures, with headings that are short enough for a terminal."""


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
    return tabulated("results", caption, heads, _lines(summary))


def measures(summary: Mapping[str, Any]) -> Table:
    """Returns how far off each policy leaves the vessel, and how long it takes."""
    caption = (
        "Medians and interquartile means (IQM, of the middle half of the values) with their 95 % "
        "intervals, over the episodes to which a measure applies."
    )
    shown = [column for name in TERMINAL for column in columns.centres(name)]
    return tabulated("measures", caption, (CONDITION, POLICY, *shown), _lines(summary))


def comparisons(summary: Mapping[str, Any]) -> Table:
    """Returns the differences of every policy from the first, in the same episodes."""
    caption = (
        f"Differences of each policy to {next(iter(summary['policies']))} within the same "
        "episodes, with their 95 % intervals; the probability to be done sooner in the same "
        "episode; and McNemar's p that both succeed equally often."
    )
    heads = (CONDITION, POLICY, *columns.comparing())
    return tabulated("comparisons", caption, heads, _compared(summary, "comparisons"))


def controls(summary: Mapping[str, Any]) -> Table:
    """Returns the differences of every policy from itself in the control of a condition."""
    caption = (
        "Differences of each policy in a disturbed condition to itself in the control condition, "
        "episode by episode, with their 95 % intervals."
    )
    heads = (CONDITION, CONTROL, POLICY, *columns.comparing())
    return tabulated("controls", caption, heads, _compared(summary, "against_control"))


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
    return tabulated(name, caption, shown, [name for name in MEASURES if name in found])


def text_table(summary: Mapping[str, Any]) -> str:
    """Returns the main results for a terminal, in ASCII."""
    medians = [Column(head, partial(columns.median, name=name)) for name, head in TERMINAL.items()]
    compared = Column("difference in success", columns.difference_in_success)
    heads = (CONDITION, POLICY, *SUCCESS, *medians, compared)
    return tabulated("terminal", "", heads, _lines(summary)).text


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
