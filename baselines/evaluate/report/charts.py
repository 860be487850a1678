"""Which figures an evaluation has, made from its rows, with what is to be said below each."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from asv_env.params import NOMINAL_LENGTH, EnvParams
from asv_env.render.scene import outline
from asv_env.types import Float
from baselines.evaluate.conditions import Arm
from baselines.evaluate.report import figures, maps, palette
from baselines.evaluate.report.figures import Colours
from baselines.evaluate.results import Results
from baselines.evaluate.tables import formats
from baselines.paper.experiment import PAPER_HEADING, PAPER_POSITION
from baselines.rollout.episodes import Track

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
    """Success of each policy in each arm."""
    arms = _grouped(results.suite.arms)
    shares = {
        policy: np.array([_bounds(summary["arms"][arm.name], policy) for arm in arms])
        for policy in results.policies
    }
    controls = [arm.control for arm in arms]
    caption = "Share of episodes in which the task was done, with its 95 % interval."
    if any(controls):
        caption += (
            " Bold: control arms; an arm below one is the same with a disturbance. The thin "
            "upright strokes stand where the same policy stands in the control."
        )
    drawn = figures.overview(
        [arm.name for arm in arms], controls, shares, colours(results.policies)
    )
    return Chart("overview", "Success in every arm", drawn, caption, wide=True)


def _bounds(entry: Mapping[str, Any], policy: str) -> list[float]:
    success = entry["policies"][policy]["success"]
    return [success["value"], success["low"], success["high"]]


def _grouped(arms: Sequence[Arm]) -> list[Arm]:
    """Every disturbed arm after its control, else in their order."""
    names = {arm.name for arm in arms}
    heads = [arm for arm in arms if arm.control not in names]
    return [one for head in heads for one in (head, *(a for a in arms if a.control == head.name))]


def of_arm(results: Results, arm: Arm, tracks: Mapping[str, Sequence[Track]]) -> Iterator[Chart]:
    """The figures of one arm.

    Args:
        results: of all.
        arm: one of them.
        tracks: by policy, of the episodes that are replayed.
    """
    yield _profile(results, arm)
    yield _times(results, arm)
    failed = _failures(results, arm)
    if failed is not None:
        yield failed
    if arm.task != "approach":
        yield _clouds(results, arm)
        if arm.params.task.goal is None and results.suite.episodes > 1:
            yield _goals(results, arm)
        if any(tracks.values()):
            yield _ways(results, arm, tracks)


def _profile(results: Results, arm: Arm) -> Chart:
    scores = {policy: results.scores(arm.name, policy) for policy in results.policies}
    caption = (
        "Share of the episodes that are done within a time; failures never are. Bands: 95 % "
        "intervals (Wilson's), each of one time on its own, from the first success on."
    )
    figure = figures.profile(scores, _limit(arm), colours(results.policies))
    return Chart("profile", "Done within a time", figure, caption)


def _times(results: Results, arm: Arm) -> Chart:
    column, label = ("time_to_goal", "time to goal")
    if arm.task == "approach":
        column, label = ("time_to_closure", "time to closure")
    durations = {policy: results.column(arm.name, policy, column) for policy in results.policies}
    caption = (
        f"The {label} of the episodes that have one, whose number stands at the right. Dots: "
        "episodes (their height means nothing); below them the median (ring) and the range of the "
        "middle 50 % (thick) and 90 % (thin)."
    )
    figure = figures.times(durations, label, _limit(arm), colours(results.policies))
    return Chart("times", label.capitalize(), figure, caption)


def _failures(results: Results, arm: Arm) -> Chart | None:
    """Why episodes failed; None where none did."""
    rows = {
        policy: [row for training in results.rows[arm.name, policy] for row in training]
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


def _clouds(results: Results, arm: Arm) -> Chart:
    task, alike = arm.params.task, arm.params.vessel.length == NOMINAL_LENGTH
    figure = maps.clouds(
        {p: 100 * results.column(arm.name, p, "min_position_error") for p in results.policies},
        {p: results.column(arm.name, p, "heading_error_at_min") for p in results.policies},
        {p: results.success(arm.name, p) for p in results.policies},
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


def _goals(results: Results, arm: Arm) -> Chart:
    first = results.policies[0]
    places = np.stack(
        [results.column(arm.name, first, name)[0] for name in ("goal_x", "goal_y")], axis=-1
    )
    success = {policy: results.success(arm.name, policy) for policy in results.policies}
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
        places, success, _vessel(arm.params, ORIGIN),
        max(arm.params.task.goal_distance[1], float(np.abs(places).max())),
        colours(results.policies),
    )  # fmt: skip
    return Chart("goals", "Success by place of the goal", figure, caption, wide=True)


def _ways(results: Results, arm: Arm, tracks: Mapping[str, Sequence[Track]]) -> Chart:
    paths = {policy: [track.poses[:, 0, :2] for track in some] for policy, some in tracks.items()}
    done = {policy: [track.episode.success for track in some] for policy, some in tracks.items()}
    goal = None if arm.params.task.goal is None else np.array(arm.params.task.goal)
    figure = maps.ways(
        paths,
        done,
        _vessel(arm.params, ORIGIN),
        None if goal is None else _vessel(arm.params, goal),
        colours(results.policies),
    )
    caption = (
        "Way of the vessel's centre in the replayed episodes; where one failed it is dashed and "
        "ends in a cross. Grey: the vessel where it began"
    )
    caption += "." if goal is None else "; dashed outline: its goal."
    return Chart("ways", "Where the vessel went", figure, caption, wide=True)


def _limit(arm: Arm) -> float:
    limit = arm.params.task.time_limit
    assert limit is not None
    return limit


def _vessel(params: EnvParams, pose: Float) -> Float:
    return outline(params.vessel, pose)
