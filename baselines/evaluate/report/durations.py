"""Figures of the time that episodes take; made in the style of ``svg``.

Arrays by policy have the shape (S, E) of trainings and episodes.
"""

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from asv_env.types import Float
from baselines.evaluate import statistics
from baselines.evaluate.report import palette, panels
from baselines.evaluate.report.panels import FEW, FIFTHS, HALF, PERCENT

HEIGHT = 3.5
"""Height of the figures, inches."""
POINTS = 121
"""Number of times at which a profile is computed."""
PERCENTILES = (5, 25, 50, 75, 95)
"""Ends of the thin line and of the thick one, and the ring between them."""


def profile(scores: Mapping[str, Float], limit: float) -> Figure:
    """Returns the share of the episodes that are done within a time.

    Args:
        scores: by policy (S, E): time until the task was done, s; infinite where it never was.
        limit: time limit of an episode, s.
    """
    figure, axes = panels.single(HALF, HEIGHT)
    times = np.linspace(0.0, limit, POINTS)
    colours = palette.by_policy(scores)
    for policy, trainings in scores.items():
        share, low, high = (100 * values for values in statistics.profile(trainings, times))
        colour = colours[policy]
        axes.fill_between(
            times, low, high, where=share > 0, color=colour, alpha=0.15, lw=0.0, step="post"
        )
        axes.step(times, share, where="post", color=colour, label=policy, clip_on=False)
    axes.set(xlim=(0.0, limit), xlabel="time [s]")
    axes.set(ylim=PERCENT, yticks=FIFTHS, ylabel="episodes done [%]")
    panels.legend(figure, axes)
    return figure


def times(durations: Mapping[str, Float], label: str, limit: float) -> Figure:
    """Returns the times of all episodes that have one, with the spread of the middle ones.

    Args:
        durations: by policy (S, E), s; NaN where an episode has none.
        label: of the axis.
        limit: time limit of an episode, s.
    """
    figure, axes = panels.single(HALF, HEIGHT)
    colours = palette.by_policy(durations)
    rng = np.random.default_rng(0)  # scatters the marks of a row in height
    for row, (policy, trainings) in enumerate(durations.items()):
        present = trainings[np.isfinite(trainings)]
        _spread(axes, row, present, colours[policy], rng)
        axes.annotate(
            f"{len(present)} of {trainings.size}", (1.0, row),
            xycoords=("axes fraction", "data"), xytext=(6, 0), textcoords="offset points",
            va="center", color=palette.GREY, fontsize=8,
        )  # fmt: skip
    panels.label_rows(axes, list(durations))
    axes.set(xlim=(0.0, limit), xlabel=f"{label} [s]")
    return figure


def _spread(axes: Axes, row: float, values: Float, colour: str, rng: np.random.Generator) -> None:
    """Draws values as marks, and below them their middle 90 and 50 % and the median."""
    if not len(values):
        return
    heights = row - 0.14 + 0.14 * (2 * rng.random(len(values)) - 1)
    pixels = len(values) > FEW
    axes.plot(values, heights, "o", ms=3.0, mew=0.0, color=colour, alpha=0.45, rasterized=pixels)
    lowest, low, middle, high, highest = np.percentile(values, PERCENTILES)
    axes.hlines(row + 0.22, lowest, highest, color=colour, lw=1.4)
    axes.hlines(row + 0.22, low, high, color=colour, lw=6.0, capstyle="butt")
    axes.plot([middle], [row + 0.22], "o", ms=4.6, mfc="#ffffff", mec=colour, mew=1.4, zorder=4)
