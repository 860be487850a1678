"""Writes the report of an evaluation.

``charts`` makes figures of the rows with ``figures`` and ``maps``, ``replay`` packs episodes, and
``webpage`` and ``markdown`` combine them with the tables of the summary.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from baselines.evaluate.conditions import Condition
from baselines.evaluate.report import charts, markdown, replay, svg, webpage
from baselines.evaluate.report.replay import Player
from baselines.evaluate.report.webpage import Section
from baselines.evaluate.results import Results
from baselines.evaluate.store import Store

FILES = ("report.html", "report.md")


def write(
    out: Path, results: Results, summary: Mapping[str, Any], store: Store, replays: int
) -> list[Path]:
    """Writes the report.

    Args:
        out: folder of the run.
        results: all rows.
        summary: as in ``summary.json``.
        store: with the logs of the episodes.
        replays: number of first episodes of each condition that can be watched in the page; up to as
            many again are added in which a policy failed.

    Returns:
        The files.
    """
    players, floor = replay.players(results), replay.floor(summary["policies"])
    sections = {
        condition.name: _section(results, store, condition, number, players, floor, replays)
        for number, condition in enumerate(results.suite.conditions)
    }
    seeds = {name: section.episodes["seeds"] for name, section in sections.items()}
    colours = charts.colours(results.policies)
    texts = (
        webpage.document(
            results, summary, replay.world(results, players, floor, colours, seeds), sections
        ),
        markdown.document(results, summary),
    )
    paths = [out / name for name in FILES]
    for path, text in zip(paths, texts, strict=True):
        path.write_text(text, encoding="utf-8")
    return paths


def _section(
    results: Results,
    store: Store,
    condition: Condition,
    number: int,
    players: list[Player],
    floor: list[str],
    replays: int,
) -> Section:
    """What the page has of the ``number``-th condition."""
    seeds = replay.chosen(results, condition.name, floor, replays)
    found = replay.logs(store, condition.name, players, seeds)
    shown = {
        policy: [t for p in players if p.policy == policy for t in found[p.key].values()]
        for policy in results.policies
    }
    judged = [p.key for p in players if p.policy not in floor] or list(found)
    with svg.look():
        drawn = [
            webpage.drawn(chart, f"condition-{number}-{chart.name}")
            for chart in charts.of_condition(results, condition, shown)
        ]
    return Section(drawn, replay.episodes(condition, found, seeds, judged))
