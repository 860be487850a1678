"""Figures of success by condition and of failures by cause; made in the style of ``svg``."""

from collections.abc import Mapping, Sequence
from itertools import cycle

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from asv_env.types import Float
from baselines.evaluate.report import palette, panels
from baselines.evaluate.report.panels import FIFTHS, PERCENT, WIDE
from baselines.evaluate.tables.columns import in_order
from baselines.rollout.episodes import CAUSES

MARKS = ("o", "s", "D", "^", "v", "P")
"""Marks of the policies, in order."""
STEP = 0.2
"""Height of a policy's row in a condition, inches."""
LABELLED = 2.5
"""Smallest share of a cause whose bar has room for its number, percent."""
RAMP = ("#6f5a8e", "#96598c", "#b9607f", "#d1716d", "#dc8a5c", "#dca858", "#d3c56a")
"""Colours of the causes of failure: the darker, the earlier the episode went wrong."""


def overview(
    conditions: Sequence[str],
    controls: Sequence[str | None],
    shares: Mapping[str, Float],
) -> Figure:
    """Returns the success of every policy in every condition.

    Args:
        conditions: C names, a disturbed one after its control.
        controls: control of each condition; None for one that is a control.
        shares: by policy (C, 3): success and the bounds of its interval, 0 to 1.
    """
    height = STEP * len(shares) + 0.16
    figure, axes = panels.single(WIDE, 0.9 + height * len(conditions))
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
    panels.label_rows(axes, conditions)
    _emphasise_controls(axes, controls)
    axes.set(xlim=PERCENT, xticks=FIFTHS, xlabel="success [%]")
    panels.legend(figure, axes)
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
    """Returns the shares of episodes that failed, by cause.

    Args:
        counts: by policy, number of failures by cause.
        episodes: by policy, number of all episodes.
    """
    figure, axes = panels.single(WIDE, 1.05 + 0.38 * len(counts))
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
    panels.label_rows(axes, list(counts))
    axes.set(xlim=PERCENT, xticks=FIFTHS, xlabel="episodes failed [%]")
    panels.legend(figure, axes, columns=7)
    return figure


def _readable(colour: str) -> str:
    """Returns the colour of text on a colour."""
    red, green, blue = to_rgb(colour)
    return "#111111" if 0.3 * red + 0.6 * green + 0.1 * blue > 0.5 else "#fefefe"
