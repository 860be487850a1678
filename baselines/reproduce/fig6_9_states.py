"""Figs. 6 to 9: single runs as selected states and as complete trajectories."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from asv_env.params import EnvParams
from asv_env.render.layout import outline
from baselines.evaluate.report import palette
from baselines.reproduce import sketch, style
from baselines.reproduce.artefact import Job
from baselines.reproduce.paper_environments import experiment, simulation
from baselines.reproduce.single_runs import GOALS, Run

FAR = 1.5  #: distance from the vessel beyond which the centre of a circle is left out, m


def simulation_states(job: Job, study: dict[str, Any], arrivals: dict[str, Any]) -> Figure:
    """Selected states of a simulation with ten boats.

    Policy "paper", preset ``paper_simulation``, T_goal = 30 s, alpha_1 = 1, goal {0.55 m, -0.95 m,
    0.1 rad} from the pose at closure (red, dashed). White noise of variance 0.05 at each step of
    50 Hz: taken as rad^2 on the angle of each boat in Eq. (3), and as cm^2 on its x and y, of
    which the paper gives no unit. The policy's boats keep below 4 cm/s; those that start far
    away come later than T_goal. Coloured crosses: targets; coloured lines: paths of the boats so
    far; black: path of the vessel; light blue: planned path; black crosses: circles' centres and
    switching point. Shown is the run of median smallest distance among the trials that came to
    closure.
    """
    run = Run.read(study)
    states = (0, run.closure // 2, run.closure, (run.closure + run.switch) // 2, run.switch, -1)
    return _states(run, simulation(), states)


def experiment_states(job: Job, study: dict[str, Any]) -> Figure:
    """Key states of a run of the experiment with four boats, in simulation.

    Policy "paper", preset ``experiment`` (tracking 20 Hz, control 10 Hz), sigma = 1, T_goal = 80 s,
    alpha_1 = 1, goal {0.55 m, -0.95 m, 0.1 rad} from the pose at closure (red, dashed). (a) start,
    with the targets (coloured crosses); (b) approach; (c) closure, and the path that is computed
    then (light blue); (d) switch to the second circle; (e) motors off, 20 cm from the goal; (f)
    end. Coloured lines: paths of the boats so far; black: path of the vessel; black crosses:
    circles' centres and switching point. Shown is the run of median smallest distance.
    """
    run = Run.read(study)
    states = (0, run.closure // 2, run.closure, run.switch, run.stop, -1)
    return _states(run, experiment(), states)


def _states(run: Run, params: EnvParams, states: Sequence[int]) -> Figure:
    figure, axes = style.panels(style.PAGE, 128.0, 2, 3, sharex=True, sharey=True)
    indices = [state % len(run.times) for state in states]
    for panel, index in zip(axes, indices, strict=True):
        _draw_paths(panel, run, params, index)
        if index >= run.closure:
            _draw_plan(panel, run, params)
        else:
            slots = sketch.slots(params, run.poses[index, 0])
            for slot, colour in zip(slots, style.boat_colours(len(slots)), strict=True):
                sketch.crosses(panel, slot[:2], colour, 3.5 if params.num_boats < 8 else 2.2)
        sketch.plane(panel)
        panel.label_outer()
        panel.set_title(f"{run.times[index]:.0f} s", loc="right")
    _frame(axes[0], run, params, indices[-1])
    return figure


def complete_simulations(job: Job, study: list[dict[str, Any]]) -> Figure:
    """Complete trajectories of eight boats and the vessel in simulation.

    Policy "paper", preset ``paper_simulation`` without noise, alpha_1 = 1. Goals from the pose at
    closure (red, dashed): (a) {0.55 m, -0.95 m, 0.1 rad}; (b) {0.6 m, 0.7 m, -1.6 rad}, on the
    side from which the boats push. Pale boats: at the start and at closure; open hull: at closure;
    light blue: planned path; black: path of the vessel; crosses: circles' centres and switching
    point. Shown are the runs of median smallest distance.
    """
    figure, axes = style.panels(style.PAGE, 96.0, 1, 2)
    for panel, values, goal in zip(axes, study, GOALS, strict=True):
        _draw_complete(panel, Run.read(values), simulation(num_boats=8, goal=goal))
    return figure


def complete_experiment(job: Job, study: dict[str, Any]) -> Figure:
    """Complete trajectories of the run of Fig. 8, in simulation.

    Colours: the boats, hulls at the start, at closure and at the end; black: path of the vessel;
    light blue: planned path; red, dashed: goal; crosses: circles' centres and switching point.
    """
    figure, (axes,) = style.panels(style.COLUMN, 96.0)
    _draw_complete(axes, Run.read(study), experiment())
    return figure


def _draw_complete(axes: Axes, run: Run, params: EnvParams) -> None:
    last = len(run.times) - 1
    _draw_paths(axes, run, params, last)
    _draw_plan(axes, run, params)
    for index in (0, run.closure):
        sketch.hull(axes, params.vessel, run.poses[index, 0], fc="none", lw=0.5)
        sketch.boats(axes, params, run.poses[index, 1:], alpha=0.45)
    sketch.plane(axes)
    _frame(axes, run, params, last)


def _draw_paths(axes: Axes, run: Run, params: EnvParams, index: int) -> None:
    """Draws the state at an index, and the paths that led there."""
    for boat, colour in enumerate(style.boat_colours(params.num_boats), start=1):
        axes.plot(*run.poses[: index + 1, boat, :2].T, color=colour, lw=0.8, zorder=2)
    axes.plot(*run.poses[: index + 1, 0, :2].T, color=palette.BLACK, lw=0.8, zorder=4)
    sketch.hull(axes, params.vessel, run.poses[index, 0])
    sketch.boats(axes, params, run.poses[index, 1:])


def _draw_plan(axes: Axes, run: Run, params: EnvParams) -> None:
    sketch.goal(axes, params, run.goal)
    sketch.crosses(axes, run.marks)
    if run.path is not None:
        axes.plot(*sketch.path_points(run.path).T, color=palette.SKY, lw=0.9, zorder=4)


def _frame(axes: Axes, run: Run, params: EnvParams, index: int) -> None:
    """Sets limits that hold all that is drawn."""
    ends = outline(params.vessel, np.stack([run.goal, run.poses[index, 0]])).reshape(-1, 2)
    near = run.marks[np.hypot(*(run.marks - run.poses[run.closure, 0, :2]).T) < FAR]
    points = np.concatenate([run.poses[..., :2].reshape(-1, 2), ends, near])
    low, high = points.min(axis=0) - 0.1, points.max(axis=0) + 0.1
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
