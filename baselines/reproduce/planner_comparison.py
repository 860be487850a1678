"""Two arcs against the Dubins path: the comparison that the paper leaves to future work."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from asv_env.params import EnvParams
from asv_env.tasks import starts
from asv_env.types import Complex, Float
from baselines.evaluate.report import palette
from baselines.paper import dubins, two_arc
from baselines.paper.arcs import ArcPath
from baselines.policy import MakePolicy
from baselines.reproduce import fig5_paths, style
from baselines.reproduce.artefact import Job
from baselines.reproduce.comparison_rows import rows_of
from baselines.reproduce.paper_environments import SCENARIOS, episodes, experiment
from baselines.scripted.gains import PathGains
from baselines.scripted.planner import SEGMENTS, PathPlanner
from baselines.scripted.scripted_policy import ScriptedPolicy

Planner = Callable[[Float, float], ArcPath]
"""Function from goals (W, 3) in the vessel's frame and the least radius, m, to paths."""
GOALS = 400  #: number of goals of the comparison by geometry; the first of them are also driven to
TIME = 240.0  #: time limit, s: detours take longer than the task's own
MEASURES = {
    "delivered": ("success", 1.0),
    "time to delivery (s)": ("time_to_goal", 1.0),
    "closure lost (times)": ("closure_lost", 1.0),
    "smallest distance (cm)": ("min_position_error", 100.0),
    "size of the heading error then (rad)": ("heading_error_at_min", 1.0),
    "path length / Dubins length": ("path_length_ratio", 1.0),
}
"""Column of an episode, of which the size is taken, and factor of each measure."""


def least_radius(params: EnvParams) -> float:
    """Returns the radius, m, of the tightest arcs that the scripted policy drives."""
    gains = PathGains()
    return gains.widest_radius * gains.tightest_radius * params.vessel.length / 2


def two_arcs(goals: Float, radius: float) -> ArcPath:
    """Returns the shortest two arcs to poses (W, 3), and Dubins paths where there are none."""
    arcs, others = padded(two_arc.shortest(goals, radius)), dubins_paths(goals, radius)
    able = two_arc.feasible(arcs, radius)[:, None]
    curvature = np.where(able, arcs.curvature, others.curvature)
    return ArcPath(arcs.start, curvature, np.where(able, arcs.length, others.length))


def dubins_paths(goals: Float, radius: float) -> ArcPath:
    """Returns the Dubins paths to poses (W, 3)."""
    return padded(dubins.shortest(goals, radius))


def padded(path: ArcPath) -> ArcPath:
    """Returns the same paths (W,) with as many segments as the policy remembers."""
    spare = ((0, 0), (0, SEGMENTS - path.length.shape[-1]))
    return ArcPath(path.start, np.pad(path.curvature, spare), np.pad(path.length, spare))


class GivenPaths(PathPlanner):
    """The scripted policy's timetable, on the paths of a planner."""

    def __init__(self, params: EnvParams, planner: Planner) -> None:
        vessel, _ = params.hulls()
        super().__init__(vessel, PathGains())
        self._planner, self._radius = planner, least_radius(params)

    def plan(self, goal: Complex, heading: Float) -> ArcPath:
        """See ``PathPlanner.plan``."""
        return self._planner(np.stack([goal.real, goal.imag, heading], axis=-1), self._radius)


def driving(planner: Planner, params: EnvParams) -> ScriptedPolicy:
    """Returns the scripted policy on the paths of a planner."""
    return ScriptedPolicy(params, planner=GivenPaths(params, planner))


PLANNERS: dict[str, MakePolicy] = {
    "two arcs": partial(driving, two_arcs),
    "Dubins": partial(driving, dubins_paths),
}
"""Policies by the planner of their paths."""


def push_to_random_goals(scenario: str) -> EnvParams:
    """Returns pushes from a formed closure to a random goal in each episode."""
    return experiment("push", scenario=scenario, goal=None, time_limit=TIME)


def goals(params: EnvParams, seeds: Sequence[int]) -> Float:
    """Returns the goals (n, 3) of the episodes with these seeds, m, m, rad."""
    return np.array([starts.sample(params, np.random.default_rng(s)).goal for s in seeds])


def compare(job: Job) -> dict[str, Any]:
    """Returns lengths by geometry for two minimal radii, and episodes by scenario and planner."""
    environments = {scenario: push_to_random_goals(scenario) for scenario in SCENARIOS}
    params, seeds = environments["nominal"], job.seeds(job.episodes)
    sampled = goals(params, job.seeds(GOALS))
    radii = (params.vessel.length / 2, least_radius(params))
    return {
        "lengths": {f"{radius:.2g}": fig5_paths.lengths(sampled, radius) for radius in radii},
        "episodes": {
            scenario: {
                name: episodes(make_policy, params, seeds, f"{name}, {scenario}")
                for name, make_policy in PLANNERS.items()
            }
            for scenario, params in environments.items()
        },
    }


def comparison_figure(job: Job, study: dict[str, Any]) -> Figure:
    """Two arcs against the Dubins path over goals drawn at random.

    (a) Share of goals over the length of two arcs as a multiple of the Dubins length, both with
    the minimal radius given; by geometry alone. Curves end below 1 where some goals cannot be
    reached. (b) Share of episodes over the time to delivery and (c) over the smallest distance to
    the goal, driven in simulation by the scripted policy from a formed closure; solid: exact
    measurement, dashed: scenario "noisy"; the same goals for both planners. The left half of the
    legend belongs to (a), the right half to (b) and (c).
    """
    figure, (ratio, time, distance) = style.panels(style.PAGE, 62.0, 1, 3, sharey=True)
    _draw_lengths(ratio, study["lengths"])
    for scenario, line in zip(SCENARIOS, ("-", "--"), strict=True):
        for name, colour in zip(PLANNERS, palette.SERIES, strict=False):
            rows = study["episodes"][scenario][name]
            label = f"{name}, {scenario}"
            draw_fractions(time, [row["time_to_goal"] for row in rows], color=colour, ls=line)
            nearest = [100 * row["min_position_error"] for row in rows]
            draw_fractions(distance, nearest, color=colour, ls=line, label=label)
    time.set_xlabel("time to delivery (s)")
    distance.set_xlabel("smallest distance (cm)")
    distance.set_xscale("log")
    distance.xaxis.set_major_formatter("{x:g}")
    style.legend(figure, ratio, distance)
    return figure


def _draw_lengths(axes: Axes, lengths: dict[str, dict[str, list[float | None]]]) -> None:
    looks = [(colour, line) for line in ("-", "--") for colour in (palette.PURPLE, palette.BLUE)]
    curves = [
        (name.replace("alpha1", r"$\alpha_1$") + rf", $\rho \geq {radius}$ m", values)
        for radius, by_choice in lengths.items()
        for name, values in by_choice.items()
    ]
    for (label, values), (colour, line) in zip(curves, looks, strict=True):
        draw_fractions(axes, values, color=colour, ls=line, label=label)
    axes.set_xscale("log")
    axes.set(xlabel="length / Dubins length", ylabel="share", xlim=(1, 50), ylim=(0, 1.02))
    axes.set_xticks([1, 2, 5, 10, 20, 50], ["1", "2", "5", "10", "20", "50"])
    axes.minorticks_off()


def draw_fractions(axes: Axes, values: Sequence[float | None], **line: Any) -> None:
    """Draws the fraction of all values that is at most so large; None counts as never."""
    known = np.sort([value for value in values if value is not None])
    rises = np.concatenate([known[:1], known])
    axes.plot(rises, np.arange(len(rises)) / len(values), drawstyle="steps-post", **line)


def table(job: Job, study: dict[str, Any]) -> dict[str, Any]:
    """Two arcs against the Dubins path, driven in simulation.

    Goals drawn at random, the same for both planners; from a formed closure.
    """
    rows = [
        {"scenario": scenario, **row}
        for scenario in SCENARIOS
        for row in rows_of(_paired(study["episodes"][scenario]))
    ]
    notes = [
        "All rows are simulation, over the goals to which a measure applies with both paths. "
        "Difference: Dubins less two arcs on the same goal, mean with its 95 % interval, and "
        f"median. Radii of the paths are at least {list(study['lengths'])[-1]} m, the Dubins "
        "length is that for S_x/2; where no two arcs are feasible, both drive the Dubins path. "
        f"Time limit {TIME:g} s.",
        "By geometry: " + "; ".join(_lengths_in_words(study["lengths"])) + ".",
    ]
    return {"rows": rows, "notes": notes}


def _paired(episodes: dict[str, list[dict[str, Any]]]) -> dict[str, dict[str, list[float]]]:
    """Returns values by planner and measure, of the goals to which it applies with all planners."""
    values: dict[str, dict[str, list[float]]] = {planner: {} for planner in episodes}
    for measure, (column, factor) in MEASURES.items():
        columns = [[row[column] for row in rows] for rows in episodes.values()]
        pairs = [pair for pair in zip(*columns, strict=True) if None not in pair]
        for k, planner in enumerate(episodes):
            values[planner][measure] = [factor * abs(pair[k]) for pair in pairs]
    return values


def _lengths_in_words(lengths: dict[str, dict[str, list[float | None]]]) -> list[str]:
    return [
        f"{name}, radius >= {radius} m: {len(known) / len(ratios):.1%} of {len(ratios)} goals, "
        f"median length {np.median(known):.3g} Dubins lengths"
        for radius, by_choice in lengths.items()
        for name, ratios in by_choice.items()
        for known in [[ratio for ratio in ratios if ratio is not None]]
    ]
