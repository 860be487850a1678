"""Fig. 5, and which poses two arcs reach, by paths of which length."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from asv_env.geometry import wrap
from asv_env.params import EnvParams
from asv_env.presets import make_params
from asv_env.types import Float
from baselines.evaluate.report import palette
from baselines.paper import dubins, two_arc
from baselines.paper.arcs import ArcPath, advance
from baselines.reproduce import sketch, style
from baselines.reproduce.artefact import Job
from baselines.reproduce.fig1_2_definitions import ALPHA1

CORRECTED_GOAL = (0.0, 0.3, 1.6)  #: goal (m, m, rad) for which alpha_1 = 1 has to be corrected
HEADINGS = ((0.1, "0.1"), (np.pi / 4, r"\pi/4"), (np.pi / 2, r"\pi/2"), (np.pi, r"\pi"))
"""Final headings of the maps, rad, and how they are written."""
REACH = 1.5  #: half the side of the maps, m
CELLS = 150  #: number of cells along each side of the maps
GOALS = 40_000  #: number of random goals of the table
PERCENTILES = (50, 75, 95)
LONGEST = 10.0  #: ratio of the length to the Dubins length at which the colours of the maps end


def correction(job: Job) -> Figure:
    """A path whose first arc must be corrected, and the corrected path.

    Goal {0 m, 0.3 m, 1.6 rad}, alpha_1 = 1. (a) Without the rule of signs the vessel would have
    to move towards +n on its first arc, where boats cannot push it (dotted). (b) The same centres
    with alpha_1 - 2 pi (Eqs. (14) and (15); their test is inverted with respect to the paper's).
    Black: start; grey: hulls along the path; red: goal; crosses: the centres C_1 and C_2 and the
    switching point.
    """
    params = make_params("push")
    path = two_arc.plan(np.array(CORRECTED_GOAL), ALPHA1)
    figure, (wrong, right) = style.panels(style.PAGE, 88.0, 1, 2, sharex=True, sharey=True)
    for axes, lengths in ((wrong, uncorrected_lengths(path)), (right, path.length)):
        _draw_arcs(axes, params, path, lengths)
        sketch.plane(axes)
        axes.label_outer()
    wrong.set(xlim=(-1.15, 0.5), ylim=(-0.75, 0.7))
    return figure


def uncorrected_lengths(path: ArcPath) -> Float:
    """Returns signed lengths (n,) of the arcs before Eqs (14)-(15); below 0 means towards +n."""
    return wrap(path.turn) / path.curvature


def _draw_arcs(axes: Axes, params: EnvParams, path: ArcPath, lengths: Float) -> None:
    pose = path.start
    sketch.hull(axes, params.vessel, pose, ec=palette.BLACK, zorder=2)
    for curvature, length in zip(path.curvature, lengths, strict=True):
        poses = advance(pose, curvature, length * np.linspace(0.0, 1.0, sketch.STEPS))
        colour, line = (palette.BLUE, "-") if length >= 0 else (palette.VERMILLION, ":")
        axes.plot(*poses[:, :2].T, color=colour, ls=line, lw=1.4, zorder=6)
        middle = sketch.STEPS // 2
        sketch.arrow(axes, poses[middle - 1, :2], poses[middle + 1, :2], color=colour)
        for fraction in np.linspace(0.0, 1.0, 1 + max(1, round(abs(length) / 0.35)))[1:]:
            still = advance(pose, curvature, fraction * length)
            sketch.hull(axes, params.vessel, still, fc="none", ec=palette.GREY, lw=0.4, zorder=1)
        pose = poses[-1]
    sketch.goal(axes, params, CORRECTED_GOAL)
    sketch.crosses(axes, np.concatenate([path.centres, path.joints[1:2, :2]]))
    for k, centre in enumerate(path.centres, start=1):
        sketch.label(axes, centre - (0.07, 0.0), f"C_{k}")


def feasibility(job: Job) -> Figure:
    """Poses that two arcs reach under conditional closure, by length.

    Colour: length of the path over that of the Dubins path, radii of at least S_x/2 = 0.2 m; grey:
    no such path. One column for each final heading h_f; the vessel starts at the origin. (a-d)
    alpha_1 = 1 as in the paper. (e-h) alpha_1 chosen for the shortest path.
    """
    params = make_params("push")
    least = params.vessel.length / 2
    figure, axes = style.panels(style.PAGE, 96.0, 2, len(HEADINGS), sharex=True, sharey=True)
    looks: dict[str, Any] = {"cmap": f"{style.MAP}_r", "norm": LogNorm(1.0, LONGEST)}
    for column, (heading, text) in enumerate(HEADINGS):
        goals = grid(heading)
        for row, ratio in enumerate(ratios(goals, least).values()):
            panel = axes[row * len(HEADINGS) + column]
            panel.set_facecolor(palette.PALE)
            cells = panel.pcolormesh(goals[..., 0], goals[..., 1], ratio, rasterized=True, **looks)
            sketch.hull(panel, params.vessel, np.zeros(3), fc="none", lw=0.5)
            sketch.plane(panel)
            panel.label_outer()
            panel.set_xticks([-1, 0, 1])
            if row == 0:
                panel.set_title(f"$h_f = {text}$ rad")
    bar = figure.colorbar(cells, ax=axes, extend="max", pad=0.01, format="%g")
    bar.set_label("length / Dubins length")
    bar.set_ticks([1, 2, 5, 10], minor=False)
    bar.minorticks_off()
    return figure


def grid(heading: float) -> Float:
    """Returns goal poses (CELLS, CELLS, 3) over the plane; none lies at the start itself."""
    steps = (np.arange(CELLS) + 0.5) * 2 * REACH / CELLS - REACH
    x, y = np.meshgrid(steps, steps)
    return np.stack([x, y, np.full_like(x, heading)], axis=-1)


def ratios(goals: Float, min_radius: float) -> dict[str, Float]:
    """Returns ratios (...) of the length to that of Dubins: alpha_1 = 1, and the shortest arcs.

    Goals (..., 3) are in the vessel's frame, m, m, rad; no heading is exactly 0. A ratio is NaN
    where a radius is below the minimum, m.
    """
    arcs = two_arc.plan(goals, ALPHA1), two_arc.shortest(goals, min_radius)
    shortest, names = dubins.length(goals, min_radius), ("alpha1 = 1", "alpha1 chosen")
    return {
        name: np.where(two_arc.feasible(path, min_radius), path.total_length / shortest, np.nan)
        for name, path in zip(names, arcs, strict=True)
    }


def lengths(goals: Float, min_radius: float) -> dict[str, list[float | None]]:
    """Returns ``ratios`` as lists (n,), with None for NaN."""
    found = ratios(goals, min_radius)
    return {name: [None if np.isnan(r) else float(r) for r in f] for name, f in found.items()}


def first_turns(job: Job) -> dict[str, Any]:
    """How often two arcs are feasible, and how long they are, by the choice of the first turn.

    Goals at random within 1.5 m along each axis, with any heading.
    """
    far, least = np.array([REACH, REACH, np.pi]), make_params("push").vessel.length / 2
    goals = np.random.default_rng(job.seed).uniform(-far, far, (GOALS, 3))
    rows = [
        {
            "first turn": name,
            "feasible": f"{np.isfinite(ratio).mean():.1%}",
            **{f"{p} %": float(np.nanpercentile(ratio, p)) for p in PERCENTILES},
        }
        for name, ratio in ratios(goals, least).items()
    ]
    notes = [
        f"{GOALS:,} goals, least radius S_x/2 = {least:g} m. Percentiles of the length over the "
        "Dubins length, where two arcs are feasible."
    ]
    return {"rows": rows, "notes": notes}
