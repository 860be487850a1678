"""Which figures an evaluation has, made from its rows, with what is to be said below each."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from asv_env.params import NOMINAL_LENGTH, EnvParams
from asv_env.render.outlines import outline
from asv_env.types import Float
from baselines.evaluate.conditions import Condition
from baselines.evaluate.report import figures, maps, palette
from baselines.evaluate.report.figures import Colours
from baselines.evaluate.results import Results
from baselines.evaluate.tables import formats
from baselines.paper.experiment import PAPER_HEADING, PAPER_POSITION
from baselines.rollout.episodes import PoseLog

ORIGIN = np.zeros(3)
"""Where every vessel begins."""


@dataclass(frozen=True)
class Chart:
    """A figure in a page.

    Attributes:
        name: unique in its section; letters and hyphens.
        title: above it.
        figure: what it shows.
        caption: how to read it.
        wide: whether it takes the whole width of the page.
    """

    name: str
    title: str
    figure: Figure
    caption: str
    wide: bool = False


def colours(policies: Sequence[str]) -> Colours:
    """One colour a policy, all over the page."""
    return {name: palette.SERIES[k % len(palette.SERIES)] for k, name in enumerate(policies)}


def overview(results: Results, summary: Mapping[str, Any]) -> Chart:
    """Success of each policy in each condition."""
    conditions = _grouped(results.suite.conditions)
    shares = {
        policy: np.array(
            [_bounds(summary["conditions"][condition.name], policy) for condition in conditions]
        )
        for policy in results.policies
    }
    controls = [condition.control for condition in conditions]
    caption = "Share of episodes in which the task was done, with its 95 % interval."
    if any(controls):
        caption += (
            " Bold: control conditions; a condition below one is the same with a disturbance. The thin "
            "upright strokes stand where the same policy stands in the control."
        )
    drawn = figures.overview(
        [condition.name for condition in conditions], controls, shares, colours(results.policies)
    )
    return Chart("overview", "Success in every condition", drawn, caption, wide=True)


def _bounds(entry: Mapping[str, Any], policy: str) -> list[float]:
    success = entry["policies"][policy]["success"]
    return [success["value"], success["low"], success["high"]]


def _grouped(conditions: Sequence[Condition]) -> list[Condition]:
    """Every disturbed condition after its control, else in their order."""
    names = {condition.name for condition in conditions}
    heads = [condition for condition in conditions if condition.control not in names]
    return [
        one for head in heads for one in (head, *(a for a in conditions if a.control == head.name))
    ]


def of_condition(
    results: Results, condition: Condition, logs: Mapping[str, Sequence[PoseLog]]
) -> Iterator[Chart]:
    """The figures of one condition.

    Args:
        results: of all.
        condition: one of them.
        logs: by policy, of the episodes that are replayed.
    """
    yield _profile(results, condition)
    yield _times(results, condition)
    failed = _failures(results, condition)
    if failed is not None:
        yield failed
    if condition.task != "approach":
        yield _clouds(results, condition)
        if condition.params.task.goal is None and results.suite.episodes > 1:
            yield _goals(results, condition)
        if any(logs.values()):
            yield _ways(results, condition, logs)


def _profile(results: Results, condition: Condition) -> Chart:
    scores = {policy: results.scores(condition.name, policy) for policy in results.policies}
    caption = (
        "Share of the episodes that are done within a time; failures never are. Bands: 95 % "
        "intervals (Wilson's), each of one time on its own, from the first success on."
    )
    figure = figures.profile(scores, _limit(condition), colours(results.policies))
    return Chart("profile", "Done within a time", figure, caption)


def _times(results: Results, condition: Condition) -> Chart:
    column, label = ("time_to_goal", "time to goal")
    if condition.task == "approach":
        column, label = ("time_to_closure", "time to closure")
    durations = {
        policy: results.column(condition.name, policy, column) for policy in results.policies
    }
    caption = (
        f"The {label} of the episodes that have one, whose number stands at the right. Dots: "
        "episodes (their height means nothing); below them the median (ring) and the range of the "
        "middle 50 % (thick) and 90 % (thin)."
    )
    figure = figures.times(durations, label, _limit(condition), colours(results.policies))
    return Chart("times", label.capitalize(), figure, caption)


def _failures(results: Results, condition: Condition) -> Chart | None:
    """Why episodes failed; None where none did."""
    rows = {
        policy: [row for training in results.rows[condition.name, policy] for row in training]
        for policy in results.policies
    }
    counts = {
        policy: Counter(row.cause for row in some if row.cause) for policy, some in rows.items()
    }
    if not any(counts.values()):
        return None
    episodes = {policy: len(some) for policy, some in rows.items()}
    caption = (
        "Failed episodes by cause, each excluding those before it: the darker, the earlier the "
        "episode went wrong. Numbers count episodes."
    )
    figure = figures.failures(counts, episodes)
    return Chart("failures", "Failures by cause", figure, caption, wide=True)


def _clouds(results: Results, condition: Condition) -> Chart:
    task, alike = condition.params.task, condition.params.vessel.length == NOMINAL_LENGTH
    figure = maps.clouds(
        {
            p: 100 * results.column(condition.name, p, "min_position_error")
            for p in results.policies
        },
        {p: results.column(condition.name, p, "heading_error_at_min") for p in results.policies},
        {p: results.success(condition.name, p) for p in results.policies},
        (100 * task.position_tolerance, task.heading_tolerance),
        (PAPER_POSITION, PAPER_HEADING) if alike else None,
        colours(results.policies),
    )
    caption = (
        "Smallest distance of the vessel to its goal, and its heading error at that instant. Full: "
        "delivered; open: failed. Box: the tolerances of a delivery. "
    )
    if alike:
        caption += (
            "Grey cross: mean and standard deviation of the paper's twelve trials with one goal in "
            f"its tank ({_given(PAPER_POSITION)} cm, {_given(PAPER_HEADING)} rad). "
        )
    caption += "The axes leave out far strays, whose number is given."
    return Chart("clouds", "Errors of placement", figure, caption, wide=True)


def _given(pair: tuple[float, float]) -> str:
    return f"{pair[0]:g} ± {pair[1]:g}".replace(formats.HYPHEN, formats.MINUS)


def _goals(results: Results, condition: Condition) -> Chart:
    first = results.policies[0]
    places = np.stack(
        [results.column(condition.name, first, name)[0] for name in ("goal_x", "goal_y")], axis=-1
    )
    success = {policy: results.success(condition.name, policy) for policy in results.policies}
    caption = "Where the goals were, seen from the vessel where it began (grey, to scale). "
    if len(places) > maps.SCATTERED:
        caption += (
            "In each cell the share of episodes that succeeded, in percent, and their number."
        )
    else:
        caption += "Dots: delivered; crosses: failed."
    if any(len(table) > 1 for table in success.values()):
        caption += " Of several trainings their mean counts."
    figure = maps.goals(
        places, success, _vessel(condition.params, ORIGIN),
        max(condition.params.task.goal_distance[1], float(np.abs(places).max())),
        colours(results.policies),
    )  # fmt: skip
    return Chart("goals", "Success by place of the goal", figure, caption, wide=True)


def _ways(results: Results, condition: Condition, logs: Mapping[str, Sequence[PoseLog]]) -> Chart:
    paths = {policy: [log.poses[:, 0, :2] for log in some] for policy, some in logs.items()}
    done = {policy: [log.episode.success for log in some] for policy, some in logs.items()}
    goal = None if condition.params.task.goal is None else np.array(condition.params.task.goal)
    figure = maps.ways(
        paths,
        done,
        _vessel(condition.params, ORIGIN),
        None if goal is None else _vessel(condition.params, goal),
        colours(results.policies),
    )
    caption = (
        "Way of the vessel's centre in the replayed episodes; where one failed it is dashed and "
        "ends in a cross. Grey: the vessel where it began"
    )
    caption += "." if goal is None else "; dashed outline: its goal."
    return Chart("ways", "Where the vessel went", figure, caption, wide=True)


def _limit(condition: Condition) -> float:
    limit = condition.params.task.time_limit
    assert limit is not None
    return limit


def _vessel(params: EnvParams, pose: Float) -> Float:
    return outline(params.vessel, pose)
