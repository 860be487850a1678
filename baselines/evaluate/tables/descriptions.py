"""The tables of a summary, each described once: its lines and its columns."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from baselines.evaluate.summary import COMPARED, MEASURES, TOLERANCES, WIDE
from baselines.evaluate.tables import formats
from baselines.evaluate.tables.formats import NOTHING
from baselines.evaluate.tables.table import Column, Table, tabulated
from baselines.rollout.episodes import CAUSES

TERMINAL = {
    "min_position_error": "smallest distance [cm]",
    "heading_error": "|heading| [rad]",
    "time_to_closure": "closure [s]",
    "time_to_goal": "delivery [s]",
}
"""The main measures, with headings that are short enough for a terminal."""


@dataclass(frozen=True)
class Line:
    """The subject of a line: a policy in a condition, and a comparison that may be empty."""

    condition: str
    policy: str
    entry: Mapping[str, Any]
    comparison: Mapping[str, Any]

    @property
    def found(self) -> Mapping[str, Any]:
        """The policy's part of the summary."""
        return self.entry["policies"][self.policy]


def results(summary: Mapping[str, Any]) -> Table:
    """Returns how often each policy succeeds, how near it brings the vessel, why it fails."""
    lines = _lines(summary)
    tolerances = dict.fromkeys(tolerance for line in lines for tolerance in line.found["placed"])
    position, heading = TOLERANCES[WIDE]
    caption = (
        "Success with its 95 % interval; the share of episodes in which the vessel was within so "
        "many tolerances of its goal pose when it was nearest, however fast; and why episodes "
        "failed. One tolerance is that of the task, 5 cm and 0.1 rad with the nominal vessel; "
        f"{WIDE} is {position:g} of position and {heading:g} of heading, 10 cm and 0.5 rad, on the "
        "scale of the paper's tank experiment."
    )
    failures = Column("failures", _failures, kind="words")
    heads = (CONDITION, POLICY, *SUCCESS, *map(_placed, tolerances), failures)
    return tabulated("results", caption, heads, lines)


def measures(summary: Mapping[str, Any]) -> Table:
    """Returns how far off each policy leaves the vessel, and how long it takes."""
    caption = (
        "Medians and interquartile means (IQM, of the middle half of the values) with their 95 % "
        "intervals, over the episodes to which a measure applies."
    )
    shown = [column for name in TERMINAL for column in _centres(_label(name), name=name)]
    return tabulated("measures", caption, (CONDITION, POLICY, *shown), _lines(summary))


def comparisons(summary: Mapping[str, Any]) -> Table:
    """Returns the differences of every policy from the first, in the same episodes."""
    caption = (
        f"Differences of each policy to {next(iter(summary['policies']))} within the same "
        "episodes, with their 95 % intervals; the probability to be done sooner in the same "
        "episode; and McNemar's p that both succeed equally often."
    )
    heads = (CONDITION, POLICY, *COMPARING)
    return tabulated("comparisons", caption, heads, _lines(summary, "comparisons"))


def controls(summary: Mapping[str, Any]) -> Table:
    """Returns the differences of every policy from itself in the control of a condition."""
    caption = (
        "Differences of each policy in a disturbed condition to itself in the control condition, "
        "episode by episode, with their 95 % intervals."
    )
    heads = (CONDITION, CONTROL, POLICY, *COMPARING)
    return tabulated("controls", caption, heads, _lines(summary, "against_control"))


def of_condition(summary: Mapping[str, Any], condition: str) -> Table:
    """Returns all measures in one condition, one a line: medians and interquartile means."""
    entry = summary["conditions"][condition]
    shown = [Column("measure", _label, kind="measure")]
    for policy in entry["policies"]:
        shown += _centres(policy, Line(condition, policy, entry, {}))
    found = {name for policy in entry["policies"].values() for name in policy}
    name = f"condition-{list(summary['conditions']).index(condition)}"
    caption = "Medians and IQM with their 95 % intervals."
    return tabulated(name, caption, shown, [name for name in MEASURES if name in found])


def text_table(summary: Mapping[str, Any]) -> str:
    """Returns the main results for a terminal, in ASCII."""
    medians = [Column(head, partial(_median, name=name)) for name, head in TERMINAL.items()]
    compared = Column("difference in success", _difference_in_success)
    heads = (CONDITION, POLICY, *SUCCESS, *medians, compared)
    return tabulated("terminal", "", heads, _lines(summary)).text


def in_order(causes: Iterable[str]) -> list[str]:
    """Returns causes of failure as they exclude each other; those of a user's task come last."""
    found = set(causes)
    return [*(cause for cause in CAUSES if cause in found), *sorted(found - set(CAUSES))]


def _lines(summary: Mapping[str, Any], comparisons: str | None = None) -> list[Line]:
    """Returns the lines of all policies, or of those that have comparisons of a kind."""
    return [
        Line(condition, policy, entry, entry[comparisons or "comparisons"].get(policy, {}))
        for condition, entry in summary["conditions"].items()
        for policy in entry[comparisons or "policies"]
    ]


def _label(name: str) -> str:
    """Returns the heading of a measure; one that is summarised by magnitude stands in bars."""
    measure = MEASURES[name]
    text = measure.label if measure.signed else f"|{measure.label}|"
    return f"{text} [{measure.unit}]" if measure.unit else text


def _centres(group: str, *known: Any, **named: Any) -> list[Column]:
    """Returns the columns of median and interquartile mean, given their line or their name."""
    iqm = Column("IQM [95 %]", partial(_iqm, *known, **named), group)
    return [Column("median", partial(_median, *known, **named), group), iqm]


def _median(line: Line, name: str) -> str:
    measure = MEASURES[name]
    return formats.quantity(line.found.get(name, {}).get("median"), measure.unit, measure.scale)


def _iqm(line: Line, name: str) -> str:
    found, measure = line.found.get(name), MEASURES[name]
    return formats.estimate(found["iqm"], measure.unit, measure.scale) if found else NOTHING


def _placed(tolerance: str) -> Column:
    """Returns the column of the share of episodes placed within so many tolerances."""

    def cell(line: Line) -> str:
        found = line.found["placed"].get(tolerance)
        return formats.share_estimate(found) if found else NOTHING

    return Column(tolerance.replace("0.5", "½"), cell, "placed within [tolerances]")


def _failures(line: Line) -> str:
    causes = line.found["causes"]
    return ", ".join(f"{causes[cause]} {cause}" for cause in in_order(causes)) or NOTHING


def _difference_in_success(line: Line) -> str:
    return formats.points(line.comparison["success"]) if line.comparison else NOTHING


def _difference(line: Line, name: str) -> str:
    found, measure = line.comparison.get(name), MEASURES[name]
    return formats.difference(found, measure.unit, measure.scale) if found else NOTHING


CONDITION = Column("condition", lambda line: line.condition, kind="shared")
CONTROL = Column("control", lambda line: line.entry["control"], kind="shared")
POLICY = Column("policy", lambda line: line.policy, kind="policy")
SUCCESS = (
    Column("success", lambda line: formats.share(line.found["success"]["value"])),
    Column("95 % interval", lambda line: formats.share_interval(line.found["success"])),
)
COMPARING = (
    Column("success [points]", _difference_in_success),
    Column("McNemar p", lambda line: formats.p_value(line.comparison["mcnemar"])),
    Column("done sooner", lambda line: formats.share_estimate(line.comparison["improvement"])),
    *(Column(_label(name), partial(_difference, name=name)) for name in COMPARED),
)
"""Columns of a comparison."""
