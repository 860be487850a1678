"""The charts of an evaluation: which figures there are, made from its rows, and their captions."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import chain
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from asv_env.params import NOMINAL_LENGTH
from asv_env.render.layout import outline
from asv_env.types import Float
from baselines.evaluate.conditions import Condition
from baselines.evaluate.report import policy_panels, single_panel
from baselines.evaluate.results import Results
from baselines.evaluate.tables import formats
from baselines.paper.paper_numbers import PAPER_HEADING, PAPER_POSITION
from baselines.rollout.episodes import PoseLog


@dataclass(frozen=True)
class Chart:
    """A figure with a heading and a caption."""

    name: str  #: letters and hyphens, unique in its section
    title: str  #: heading
    figure: Figure
    caption: str  #: how to read it
    wide: bool = True  #: whether it takes the whole width of the page


def overview(results: Results, summary: Mapping[str, Any]) -> Chart:
    """Returns the chart of the success of each policy in each condition."""
    conditions = _grouped(results.suite.conditions)
    found = [summary["conditions"][condition.name]["policies"] for condition in conditions]
    shares = {
        policy: np.array([[each[policy]["success"][k] for k in formats.KEYS] for each in found])
        for policy in results.policies
    }
    controls = [condition.control for condition in conditions]
    caption = "Share of episodes in which the task was done, with its 95 % interval."
    if any(controls):
        caption += (
            " Bold: control conditions; a condition below one adds a disturbance to it. The thin "
            "upright strokes show the success of the same policy in the control."
        )
    names = [condition.name for condition in conditions]
    figure = single_panel.overview(names, controls, shares)
    return Chart("overview", "Success in every condition", figure, caption)


def _grouped(conditions: Sequence[Condition]) -> list[Condition]:
    """Returns the conditions with every disturbed one after its control."""
    place: dict[str | None, int] = {each.name: number for number, each in enumerate(conditions)}

    def key(each: Condition) -> tuple[int, bool]:
        return place.get(each.control, place[each.name]), each.control in place

    return sorted(conditions, key=key)


def of_condition(
    results: Results, condition: Condition, logs: Mapping[str, Sequence[PoseLog]]
) -> Iterator[Chart]:
    """Yields the charts of one condition, given the logs to be replayed by policy."""
    yield _profile(results, condition)
    yield _times(results, condition)
    yield from _failures(results, condition)
    if condition.params.definition.has_goal:
        yield _errors(results, condition)
        if condition.params.task.goal is None and results.suite.episodes > 1:
            yield _goals(results, condition)
        if any(logs.values()):
            yield _paths(results, condition, logs)


def _profile(results: Results, condition: Condition) -> Chart:
    scores = results.by_policy(results.scores, condition.name)
    caption = (
        "Share of the episodes that are done within a time; failures never are. Bands: 95 % "
        "intervals (Wilson's), each of one time on its own, from the first success on."
    )
    figure = single_panel.profile(scores, condition.params.task.time_limit)
    return Chart("profile", "Done within a time", figure, caption, wide=False)


def _times(results: Results, condition: Condition) -> Chart:
    label = "time to goal" if condition.params.definition.has_goal else "time to closure"
    caption = (
        f"The {label} of the episodes that have one, with their number at the right. Dots: "
        "episodes (their height means nothing); below them the median (ring) and the range of the "
        "middle 50 % (thick) and 90 % (thin)."
    )
    columns = results.by_policy(results.column, condition.name, label.replace(" ", "_"))
    figure = single_panel.times(columns, label, condition.params.task.time_limit)
    return Chart("times", label.capitalize(), figure, caption, wide=False)


def _failures(results: Results, condition: Condition) -> Iterator[Chart]:
    """Yields the chart of the causes of failure, if any episode failed."""
    rows = {p: list(chain(*results.rows[condition.name, p])) for p in results.policies}
    counts = {p: Counter(row.cause for row in some if row.cause) for p, some in rows.items()}
    if not any(counts.values()):
        return
    caption = (
        "Failed episodes by cause, each excluding those before it: the darker, the earlier the "
        "episode went wrong. Numbers count episodes."
    )
    figure = single_panel.failures(counts, {policy: len(some) for policy, some in rows.items()})
    yield Chart("failures", "Failures by cause", figure, caption)


def _errors(results: Results, condition: Condition) -> Chart:
    task = condition.params.task
    paper = condition.params.vessel.length == NOMINAL_LENGTH
    columns = partial(results.by_policy, results.column, condition.name)
    figure = policy_panels.errors(
        {policy: 100 * metres for policy, metres in columns("min_position_error").items()},
        columns("heading_error_at_min"),
        results.by_policy(results.success, condition.name),
        (100 * task.position_tolerance, task.heading_tolerance),
        (PAPER_POSITION, PAPER_HEADING) if paper else None,
    )
    trials = (
        "Grey cross: mean and standard deviation of the paper's twelve trials with one goal in "
        f"its tank ({_spread(PAPER_POSITION)} cm, {_spread(PAPER_HEADING)} rad). "
    )
    caption = (
        "Smallest distance of the vessel to its goal, and its heading error at that instant. Full: "
        f"delivered; open: failed. Box: the tolerances of a delivery. {trials if paper else ''}"
        "Distant episodes lie outside the axes; their number is given."
    )
    return Chart("errors", "Errors of placement", figure, caption)


def _spread(pair: tuple[float, float]) -> str:
    return f"{pair[0]:g} ± {pair[1]:g}".replace(formats.HYPHEN, formats.MINUS)


def _goals(results: Results, condition: Condition) -> Chart:
    first = results.policies[0]
    x, y = (results.column(condition.name, first, name)[0] for name in ("goal_x", "goal_y"))
    places = np.stack([x, y], axis=-1)
    success = results.by_policy(results.success, condition.name)
    caption = "Positions of the goals relative to the vessel's initial pose (grey, to scale). "
    if len(places) > policy_panels.SCATTERED:
        caption += "In each cell: the percentage of episodes that succeeded, and their number."
    else:
        caption += "Dots: delivered; crosses: failed."
    if any(len(trainings) > 1 for trainings in success.values()):
        caption += " Several trainings count with their mean."
    reach = max(condition.params.task.goal_distance[1], float(np.abs(places).max()))
    figure = policy_panels.goals(places, success, _hull(condition), reach)
    return Chart("goals", "Success by place of the goal", figure, caption)


def _paths(results: Results, condition: Condition, logs: Mapping[str, Sequence[PoseLog]]) -> Chart:
    paths = {policy: [log.poses[:, 0, :2] for log in some] for policy, some in logs.items()}
    done = {policy: [log.episode.success for log in some] for policy, some in logs.items()}
    pose = condition.params.task.goal
    goal = None if pose is None else _hull(condition, pose)
    figure = policy_panels.paths(paths, done, _hull(condition), goal)
    caption = (
        "Path of the vessel's centre in the replayed episodes, dashed and with a cross at its end "
        "where the episode failed. Grey: the vessel's initial pose"
    )
    caption += "." if goal is None else "; dashed outline: its goal."
    return Chart("paths", "Paths of the vessel", figure, caption)


def _hull(condition: Condition, pose: Sequence[float] = (0.0, 0.0, 0.0)) -> Float:
    """Returns the outline (n, 2) of the vessel at a pose, m; by default where it begins."""
    return outline(condition.params.vessel, np.array(pose))
