"""Figures of an evaluation: how often, how fast, and why not. From plain arrays to a figure.

Arrays by policy have the shape (S, E) of trainings and episodes; colours are by policy too. All
are made in the ``look`` of ``svg``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from asv_env.types import Float
from baselines.evaluate import statistics
from baselines.evaluate.report import palette
from baselines.rollout.episodes import CAUSES

HALF, WIDE, FULL = 5.3, 8.6, 10.9
"""Widths, inches: of two figures side by side, of bars, and of panels side by side."""
TALL = 3.5
"""Height of those side by side, inches."""
MARKS = ("o", "s", "D", "^", "v", "P")
POINTS = 121
"""Times at which a profile is drawn."""
FEW = 400
"""Marks of a panel up to which they are kept as lines, not as pixels."""
PERCENT, FIFTHS = (0.0, 100.0), range(0, 101, 20)
PERCENTILES = (5, 25, 50, 75, 95)
RAMP = ("#6f5a8e", "#96598c", "#b9607f", "#d1716d", "#dc8a5c", "#dca858", "#d3c56a")
"""Of the causes of failure: the darker, the earlier the episode went wrong."""

Colours = Mapping[str, str]


def overview(
    conditions: Sequence[str],
    controls: Sequence[str | None],
    shares: Mapping[str, Float],
    colours: Colours,
) -> Figure:
    """Success of every policy in every condition.

    Args:
        conditions: names, a disturbed one after its control.
        controls: of each condition; None of one that is not disturbed.
        shares: by policy (A, 3): success and the bounds of its interval.
        colours: by policy.
    """
    step = 0.2
    tall = step * len(shares) + 0.16
    figure, axes = _axes(WIDE, 0.9 + tall * len(conditions))
    for number, (policy, share) in enumerate(shares.items()):
        offset = (number - (len(shares) - 1) / 2) * step / tall
        rows = np.arange(len(conditions)) + offset
        value, low, high = 100 * share.T
        axes.hlines(rows, low, high, color=colours[policy], lw=1.8, alpha=0.55, clip_on=False)
        axes.plot(
            value, rows, MARKS[number % len(MARKS)], color=colours[policy], ms=5.0, mew=0.0,
            label=policy, clip_on=False, zorder=3,
        )  # fmt: skip
        _control_lines(axes, conditions, controls, value, offset, colours[policy])
    _separate(axes, controls)
    axes.set_yticks(np.arange(len(conditions)), conditions)
    for label, control in zip(axes.get_yticklabels(), controls, strict=True):
        label.set_fontweight("bold" if any(controls) and control is None else "normal")
    axes.set_ylim(len(conditions) - 0.5, -0.5)
    axes.grid(visible=False, axis="y")
    axes.set(xlim=PERCENT, xticks=FIFTHS, xlabel="success [%]")
    _legend(figure, axes)
    return figure


def _control_lines(
    axes: Axes,
    conditions: Sequence[str],
    controls: Sequence[str | None],
    values: Float,
    offset: float,
    colour: str,
) -> None:
    """Beside every disturbed condition, where the policy stands in its control."""
    for row, control in enumerate(controls):
        if control in conditions:
            there = values[conditions.index(control)]
            axes.vlines(there, row + offset - 0.09, row + offset + 0.09, color=colour, lw=0.9)


def _separate(axes: Axes, controls: Sequence[str | None]) -> None:
    """A line between two conditions, a stronger one above a control."""
    for row, control in list(enumerate(controls))[1:]:
        strong = any(controls) and control is None
        axes.axhline(row - 0.5, color=palette.GREY if strong else palette.PALE, lw=0.8)


def profile(scores: Mapping[str, Float], limit: float, colours: Colours) -> Figure:
    """Share of the episodes that are done within a time.

    Args:
        scores: by policy (S, E): time until done, s; infinite where it never was.
        limit: of an episode, s.
        colours: by policy.
    """
    figure, axes = _axes(HALF, TALL)
    at = np.linspace(0.0, limit, POINTS)
    for policy, table in scores.items():
        share, low, high = statistics.profile(table, at)
        axes.fill_between(
            at, 100 * low, 100 * high, where=share > 0, color=colours[policy], alpha=0.15, lw=0.0,
            step="post",
        )  # fmt: skip
        axes.step(at, 100 * share, where="post", color=colours[policy], label=policy, clip_on=False)
    axes.set_xlim(0.0, limit)
    axes.set_xlabel("time [s]")
    axes.set(ylim=PERCENT, yticks=FIFTHS, ylabel="episodes done [%]")
    _legend(figure, axes)
    return figure


def times(durations: Mapping[str, Float], label: str, limit: float, colours: Colours) -> Figure:
    """How long it took where it was done: every episode, and the spread of the middle ones.

    Args:
        durations: by policy (S, E), s; NaN where it was not done.
        label: what took so long.
        limit: of an episode, s.
        colours: by policy.
    """
    figure, axes = _axes(HALF, TALL)
    rng = np.random.default_rng(0)  # of where in its row a mark lies, which means nothing
    for row, (policy, table) in enumerate(durations.items()):
        present = table[np.isfinite(table)]
        _spread(axes, row, present, colours[policy], rng)
        axes.annotate(
            f"{len(present)} of {table.size}", (1.0, row), xycoords=("axes fraction", "data"),
            xytext=(6, 0), textcoords="offset points", va="center", color=palette.GREY, fontsize=8,
        )  # fmt: skip
    axes.set_yticks(np.arange(len(durations)), list(durations))
    axes.set_ylim(len(durations) - 0.5, -0.5)
    axes.set_xlim(0.0, limit)
    axes.grid(visible=False, axis="y")
    axes.set_xlabel(f"{label} [s]")
    return figure


def _spread(axes: Axes, row: float, values: Float, colour: str, rng: np.random.Generator) -> None:
    """Values as marks, and below them the range of their middle 90 and 50 % and the median."""
    if not len(values):
        return
    heights = row - 0.14 + 0.14 * (2 * rng.random(len(values)) - 1)
    pixels = len(values) > FEW
    axes.plot(values, heights, "o", ms=3.0, mew=0.0, color=colour, alpha=0.45, rasterized=pixels)
    lowest, low, middle, high, highest = np.percentile(values, PERCENTILES)
    axes.hlines(row + 0.22, lowest, highest, color=colour, lw=1.4)
    axes.hlines(row + 0.22, low, high, color=colour, lw=6.0, capstyle="butt")
    axes.plot([middle], [row + 0.22], "o", ms=4.6, mfc="#ffffff", mec=colour, mew=1.4, zorder=4)


def failures(counts: Mapping[str, Mapping[str, int]], episodes: Mapping[str, int]) -> Figure:
    """What share of the episodes failed by which cause.

    Args:
        counts: by policy, number of failures by cause.
        episodes: by policy, number of all.
    """
    figure, axes = _axes(WIDE, 1.05 + 0.38 * len(counts))
    left = np.zeros(len(counts))
    for cause, colour in zip(CAUSES, RAMP, strict=True):
        found = np.array([counts[policy].get(cause, 0) for policy in counts])
        if not found.any():
            continue
        widths = 100 * found / np.array([episodes[policy] for policy in counts])
        axes.barh(
            range(len(counts)), widths, 0.58, left, color=colour, label=cause, ec="#ffffff", lw=0.8
        )
        for row, (number, start, width) in enumerate(zip(found, left, widths, strict=True)):
            if width > 2.5:
                axes.text(
                    start + width / 2, row, str(number), ha="center", va="center", fontsize=8,
                    color=_readable(colour),
                )  # fmt: skip
        left += widths
    axes.set_yticks(range(len(counts)), list(counts))
    axes.set_ylim(len(counts) - 0.5, -0.5)
    axes.grid(visible=False, axis="y")
    axes.set(xlim=PERCENT, xticks=FIFTHS, xlabel="episodes failed [%]")
    _legend(figure, axes, columns=7)
    return figure


def _readable(colour: str) -> str:
    """Of text on a colour."""
    red, green, blue = to_rgb(colour)
    return "#111111" if 0.3 * red + 0.6 * green + 0.1 * blue > 0.5 else "#fefefe"


def _axes(width: float, height: float) -> tuple[Figure, Axes]:
    figure = Figure(figsize=(width, height), layout="constrained")
    return figure, figure.subplots()


def _legend(figure: Figure, axes: Axes, columns: int = 5) -> None:
    """Above the panel."""
    handles, labels = axes.get_legend_handles_labels()
    above: Any = "outside upper left"  # which the stubs do not know with handles and labels
    figure.legend(handles, labels, loc=above, ncols=min(columns, len(labels)))
