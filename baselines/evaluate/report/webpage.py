"""The report as one HTML page that needs nothing beside it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from string import Template
from typing import Any

import asv_env
from baselines.evaluate.report import charts, markup, svg, words
from baselines.evaluate.report.charts import Chart
from baselines.evaluate.report.figures import Colours
from baselines.evaluate.results import Results
from baselines.evaluate.tables import formats, table
from baselines.evaluate.tables.table import Table


@dataclass(frozen=True)
class Section:
    """What a page has of one condition.

    Attributes:
        charts: drawn, as HTML.
        episodes: that can be replayed; see ``replay.episodes``.
    """

    charts: Sequence[str]
    episodes: Mapping[str, Any]


def document(
    results: Results,
    summary: Mapping[str, Any],
    world: Mapping[str, Any],
    sections: Mapping[str, Section],
) -> str:
    """The whole page.

    Args:
        results: of all.
        summary: of them.
        world: of the replay; see ``replay.world``.
        sections: by condition.
    """
    colours = charts.colours(results.policies)
    comparison = _comparison(results, summary, colours)
    with svg.look():
        overview = drawn(charts.overview(results, summary), "overview", level=3)
    return Template(_file("page.html")).substitute(
        title=markup.text(summary["suite"]),
        about=markup.prose(summary["about"]),
        ran=markup.text(words.ran(results, summary)),
        facts=_facts(summary, colours),
        results=_table(table.results(summary), "results", colours)
        + _table(table.measures(summary), "measures", colours),
        overview=overview,
        nav=_nav(comparison),
        comparison=comparison,
        conditions="".join(
            _condition(results, summary, number, name, section, colours)
            for number, (name, section) in enumerate(sections.items())
        ),
        broken=_broken(results),
        embedded=markup.text(_embedded(results, sections)),
        methods="".join(f"<li>{markup.text(line)}</li>" for line in words.METHODS),
        style=_file("page.css"),
        script=_file("stage.js") + _file("replay.js"),
        world=markup.data(world),
        episodes="".join(
            f'<script type="application/json" data-condition="{markup.text(name)}">'
            f"{markup.data(section.episodes)}</script>\n"
            for name, section in sections.items()
        ),
    )


def drawn(chart: Chart, name: str, level: int = 4) -> str:
    """A chart as HTML, below a heading of a level; its name is unique in the page."""
    drawing = svg.inline(chart.figure, name, f"{chart.title}. {chart.caption}")
    return markup.figure(chart.title, drawing, chart.caption, chart.wide, level)


def _file(name: str) -> str:
    return (resources.files(__package__) / name).read_text(encoding="utf-8")


def _nav(comparison: str) -> str:
    """Links to the parts of the page."""
    parts = ("results", "comparison", "conditions", "replay", "methods")
    return "".join(
        f'<a href="#{part}">{part.capitalize()}</a>'
        for part in parts
        if comparison or part != "comparison"
    )


def _facts(summary: Mapping[str, Any], colours: Colours) -> str:
    """By what the numbers were made."""
    origin = summary["origin"]
    pairs = [
        ("policy", f"{markup.swatch(name, colours)} {_quiet(words.policy(prints, name))}")
        for name, prints in summary["policies"].items()
    ]
    pairs += [
        ("asv-env", f"{asv_env.__version__} {_quiet(origin['state of the code'])}"),
        ("set of episodes", _quiet(origin["set of episodes"])),
        (
            "libraries",
            _quiet(", ".join(f"{k} {v}" for k, v in origin["set of libraries"].items())),
        ),
    ]
    return markup.facts(pairs)


def _quiet(text: str) -> str:
    return f'<span class="quiet">{markup.text(text)}</span>'


def _table(shown: Table, name: str, colours: Colours, first: str = "") -> str:
    return markup.table(shown, colours, words.TABLES[name].format(first=first), f"table-{name}")


def _comparison(results: Results, summary: Mapping[str, Any], colours: Colours) -> str:
    """Policies beside the first, and disturbed conditions beside their controls."""
    first, parts = results.policies[0], []
    compared = table.comparisons(summary)
    if compared.rows:
        parts += [
            f"<h3>Compared with {markup.text(first)}</h3>",
            _table(compared, "comparisons", colours, first),
        ]
    disturbed = table.controls(summary)
    if disturbed.rows:
        parts += ["<h3>Compared with the control</h3>", _table(disturbed, "controls", colours)]
    if not parts:
        return ""
    return f'<section id="comparison"><h2>Comparison</h2>{"".join(parts)}</section>'


def _condition(
    results: Results,
    summary: Mapping[str, Any],
    number: int,
    name: str,
    section: Section,
    colours: Colours,
) -> str:
    """One condition, folded but for the first."""
    shares = "".join(
        f'<span class="share">{markup.swatch(policy, colours)} '
        f"<b>{formats.share(found['success']['value'])}</b></span>"
        for policy, found in summary["conditions"][name]["policies"].items()
    )
    about = markup.prose(words.conditions(results)[name])
    numbers = markup.table(
        table.of_condition(summary, name),
        colours,
        "Medians and IQM with their 95 % intervals.",
        f"table-condition-{number}",
    )
    link = f' <a class="watch" href="#condition={markup.address(name)}">Watch episodes of this condition</a>'
    watch = link if section.episodes["seeds"] else ""
    return (
        f'<details class="condition" id="condition-{number}"{" open" if number == 0 else ""}>'
        f"<summary><h3>{markup.text(name)}</h3>"
        f'<span class="shares">{shares}</span></summary>'
        f'<p class="about">{about}.{watch}</p>'
        f'<div class="charts">{"".join(section.charts)}</div>'
        f"<h4>All measures</h4>{numbers}</details>"
    )


def _broken(results: Results) -> str:
    """Names the episodes that policies have broken."""
    lines = words.broken(results)
    if not lines:
        return ""
    listed = "".join(f"<li>{markup.text(line)}</li>" for line in lines)
    return (
        '<section id="broken" class="broken"><h2>Broken episodes</h2>'
        f"<p>{markup.text(words.BROKEN)}</p><ul>{listed}</ul></section>"
    )


def _embedded(results: Results, sections: Mapping[str, Section]) -> str:
    """How many episodes can be watched."""
    numbers = [len(section.episodes["seeds"]) for section in sections.values()]
    low, high, count = min(numbers), max(numbers), results.suite.episodes
    if low == count:
        return f"All episodes of every condition are in this page ({count} of {count})."
    some = f"{low}" if low == high else f"{low} to {high}"
    return (
        f"{some} of {count} episodes of a condition are in this page, the first ones and some in which "
        "a policy failed; --replays N embeds more."
    )
