"""Figures of one panel: success by condition, failures by cause, and the time that episodes take.

They are made in the style of ``svg``. Arrays by policy have the shape (S, E) of trainings and
episodes.
"""

from collections.abc import Mapping, Sequence
from itertools import cycle
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from asv_env.types import Float
from baselines.evaluate import statistics
from baselines.evaluate.report import palette
from baselines.evaluate.report.svg import FEW, HALF
from baselines.evaluate.tables.descriptions import in_order
from baselines.rollout.episodes import CAUSES

WIDE = 8.6  #: width of a figure of bars, inches
HEIGHT = 3.5  #: height of the figures of times, inches
PERCENT = (0.0, 100.0)  #: limits of an axis in percent
FIFTHS = range(0, 101, 20)  #: ticks of an axis in percent
MARKS = ("o", "s", "D", "^", "v", "P")  #: marks of the policies, in order
STEP = 0.2  #: height of a policy's row in a condition, inches
LABELLED = 2.5  #: smallest share of a cause whose bar has room for its number, percent
RAMP = ("#6f5a8e", "#96598c", "#b9607f", "#d1716d", "#dc8a5c", "#dca858", "#d3c56a")
"""Colours of the causes of failure: the darker, the earlier the episode went wrong."""
POINTS = 121  #: number of times at which a profile is computed
PERCENTILES = (5, 25, 50, 75, 95)  #: ends of the thin and of the thick line, the ring between


def overview(
    conditions: Sequence[str], controls: Sequence[str | None], shares: Mapping[str, Float]
) -> Figure:
    """Returns the success of every policy in every condition.

    Args:
        conditions: C names, a disturbed one after its control.
        controls: control of each condition; None for one that is a control.
        shares: by policy (C, 3): success and the bounds of its interval, 0 to 1.
    """
    height = STEP * len(shares) + 0.16
    figure, axes = _single(WIDE, 0.9 + height * len(conditions))
    colours = palette.by_policy(shares)
    for number, (policy, share) in enumerate(shares.items()):
        rows = np.arange(len(conditions)) + (number - (len(shares) - 1) / 2) * STEP / height
        value, low, high = 100 * share.T
        axes.hlines(rows, low, high, color=colours[policy], lw=1.8, alpha=0.55, clip_on=False)
        axes.plot(
            value, rows, MARKS[number % len(MARKS)], color=colours[policy], ms=5.0, mew=0.0,
            label=policy, clip_on=False, zorder=3,
        )  # fmt: skip
        for row, control in zip(rows, controls, strict=True):
            if control in conditions:
                reference = value[conditions.index(control)]
                axes.vlines(reference, row - 0.09, row + 0.09, color=colours[policy], lw=0.9)
    _label_rows(axes, conditions)
    _emphasise_controls(axes, controls)
    axes.set(xlim=PERCENT, xticks=FIFTHS, xlabel="success [%]")
    _legend(figure, axes)
    return figure


def _emphasise_controls(axes: Axes, controls: Sequence[str | None]) -> None:
    """Sets controls in bold, with a stronger line above them than above other conditions."""
    labels = axes.get_yticklabels()
    for row, (label, control) in enumerate(zip(labels, controls, strict=True)):
        strong = any(controls) and control is None
        label.set_fontweight("bold" if strong else "normal")
        if row:
            axes.axhline(row - 0.5, color=palette.GREY if strong else palette.PALE, lw=0.8)


def failures(counts: Mapping[str, Mapping[str, int]], episodes: Mapping[str, int]) -> Figure:
    """Returns the shares of failed episodes: by policy, failures by cause, and all episodes."""
    figure, axes = _single(WIDE, 1.05 + 0.38 * len(counts))
    rows, total = range(len(counts)), np.array([episodes[policy] for policy in counts])
    left = np.zeros(len(counts))
    ramp, others = dict(zip(CAUSES, RAMP, strict=True)), cycle(palette.SERIES)
    for cause in in_order(cause for causes in counts.values() for cause in causes):
        colour = ramp.get(cause) or next(others)
        found = np.array([counts[policy].get(cause, 0) for policy in counts])
        widths = 100 * found / total
        drawn = axes.barh(rows, widths, 0.58, left, color=colour, label=cause, ec="#ffffff", lw=0.8)
        texts = [str(n) if width > LABELLED else "" for n, width in zip(found, widths, strict=True)]
        axes.bar_label(drawn, texts, label_type="center", fontsize=8, color=_readable(colour))
        left += widths
    _label_rows(axes, list(counts))
    axes.set(xlim=PERCENT, xticks=FIFTHS, xlabel="episodes failed [%]")
    _legend(figure, axes, columns=7)
    return figure


def _readable(colour: str) -> str:
    """Returns the colour of text on a colour."""
    red, green, blue = to_rgb(colour)
    return "#111111" if 0.3 * red + 0.6 * green + 0.1 * blue > 0.5 else "#fefefe"


def profile(scores: Mapping[str, Float], limit: float) -> Figure:
    """Returns the share of the episodes that are done within a time, up to a limit, s.

    Scores are the times until the task was done, s; infinite where it never was.
    """
    figure, axes = _single(HALF, HEIGHT)
    times = np.linspace(0.0, limit, POINTS)
    for (policy, trainings), colour in zip(scores.items(), cycle(palette.SERIES), strict=False):
        share, low, high = (100 * values for values in statistics.profile(trainings, times))
        axes.fill_between(
            times, low, high, where=share > 0, color=colour, alpha=0.15, lw=0.0, step="post"
        )
        axes.step(times, share, where="post", color=colour, label=policy, clip_on=False)
    axes.set(xlim=(0.0, limit), xlabel="time [s]")
    axes.set(ylim=PERCENT, yticks=FIFTHS, ylabel="episodes done [%]")
    _legend(figure, axes)
    return figure


def times(durations: Mapping[str, Float], label: str, limit: float) -> Figure:
    """Returns the times of all episodes that have one, with the spread of the middle ones.

    Durations are in s, NaN where an episode has none; the axis has a label and a limit, s.
    """
    figure, axes = _single(HALF, HEIGHT)
    rng = np.random.default_rng(0)  # scatters the marks of a row in height
    rows = zip(durations.values(), cycle(palette.SERIES), strict=False)
    for row, (trainings, colour) in enumerate(rows):
        present = trainings[np.isfinite(trainings)]
        _spread(axes, row, present, colour, rng)
        axes.annotate(
            f"{len(present)} of {trainings.size}", (1.0, row),
            xycoords=("axes fraction", "data"), xytext=(6, 0), textcoords="offset points",
            va="center", color=palette.GREY, fontsize=8,
        )  # fmt: skip
    _label_rows(axes, list(durations))
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


def _single(width: float, height: float) -> tuple[Figure, Axes]:
    """Returns a figure of one panel; sizes in inches."""
    figure = Figure(figsize=(width, height), layout="constrained")
    return figure, figure.subplots()


def _legend(figure: Figure, axes: Axes, columns: int = 5) -> None:
    """Puts the legend above the panel."""
    handles, labels = axes.get_legend_handles_labels()
    above: Any = "outside upper left"  # missing from the type stubs
    figure.legend(handles, labels, loc=above, ncols=min(columns, len(labels)))


def _label_rows(axes: Axes, labels: Sequence[str]) -> None:
    """Labels one row a label, from the top down."""
    axes.set_yticks(range(len(labels)), labels)
    axes.set_ylim(len(labels) - 0.5, -0.5)
    axes.grid(visible=False, axis="y")
