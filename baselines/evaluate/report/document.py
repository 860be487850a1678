"""Writes the report of an evaluation.

``charts`` makes the figures from the rows, ``replay`` packs episodes, and ``rendering`` fills words
and tables into the templates of the web page and of its Markdown version.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import asv_env
from asv_env import files
from baselines.evaluate.conditions import Condition
from baselines.evaluate.report import charts, palette, rendering, replay, svg
from baselines.evaluate.report.charts import Chart
from baselines.evaluate.report.replay import Cast
from baselines.evaluate.report.svg import Svg
from baselines.evaluate.results import Results
from baselines.evaluate.store import Store

FILES = ("report.html", "report.md")


def write(
    out: Path, results: Results, summary: Mapping[str, Any], store: Store, replays: int
) -> list[Path]:
    """Writes the report into the folder of a run, and returns its files.

    The page can replay the first episodes of each condition, ``replays`` in number, and up to as
    many later ones in which a policy failed; the store holds their pose logs.
    """
    players = replay.find(results, summary["policies"])
    sections = {
        condition.name: _section(results, store, condition, f"condition-{number}", players, replays)
        for number, condition in enumerate(results.suite.conditions)
    }
    seeds = {name: section["episodes"]["seeds"] for name, section in sections.items()}
    with svg.look():
        overview = _drawn(charts.overview(results, summary), "chart")
    page = rendering.render(
        "page.html",
        **rendering.content(results, summary),
        version=asv_env.__version__,
        colours=palette.by_policy(results.policies),
        overview=overview,
        sections=sections,
        embedded=_embedded(list(map(len, seeds.values())), results.suite.episodes),
        world=replay.world(results, players, seeds),
    )
    paths = [out / name for name in FILES]
    for path, text in zip(paths, (page, rendering.markdown(results, summary)), strict=True):
        files.write_text(path, text)
    return paths


def _section(
    results: Results, store: Store, condition: Condition, name: str, players: Cast, replays: int
) -> dict[str, Any]:
    """Returns the figures of a condition, and the data of its episodes that can be replayed."""
    seeds = replay.chosen(results, condition.name, players, replays)
    logs = replay.logs(store, condition.name, players, seeds)
    shown = {
        policy: [log for player in players.of(policy) for log in logs[player.key].values()]
        for policy in results.policies
    }
    with svg.look():
        drawn = [_drawn(chart, name) for chart in charts.of_condition(results, condition, shown)]
    return {"charts": drawn, "episodes": replay.episodes(condition, players, logs, seeds)}


def _drawn(chart: Chart, section: str) -> tuple[Chart, Svg]:
    return chart, svg.draw(chart.figure, f"{section}-{chart.name}")


def _embedded(numbers: Sequence[int], episodes: int) -> str:
    """Returns a sentence on the numbers of embedded episodes, one a condition."""
    low, high = min(numbers), max(numbers)
    if low == episodes:
        return f"All episodes of every condition are in this page ({low} of {episodes})."
    some = f"{low}" if low == high else f"{low} to {high}"
    return (
        f"{some} of {episodes} episodes of a condition are in this page, the first ones and some "
        "in which a policy failed; --replays N embeds more."
    )
