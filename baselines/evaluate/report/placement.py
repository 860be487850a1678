"""Figure of the errors with which the vessel is placed, one panel a policy; see ``svg``."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from asv_env.types import Bool, Float
from baselines.evaluate.report import palette, panels
from baselines.evaluate.report.panels import FEW

INSIDE = 0.9
"""Share of all errors that lie within the axes."""
LEAST = 1.5
"""Smallest reach of the axes, in tolerances."""
MOST = 2.0
"""Largest reach of the axes, in tolerances."""

Spread = tuple[float, float]
"""Mean and standard deviation."""


def errors(
    distance: Mapping[str, Float],
    heading: Mapping[str, Float],
    success: Mapping[str, Bool],
    tolerance: tuple[float, float],
    reference: tuple[Spread, Spread] | None,
) -> Figure:
    """Returns the errors of the vessel at the instant when it was nearest to its goal.

    Args:
        distance: by policy (S, E) of trainings and episodes, cm; NaN where there was no goal.
        heading: by policy (S, E), signed, rad.
        success: by policy (S, E).
        tolerance: of the task, cm and rad.
        reference: distance, cm, and heading error, rad, from elsewhere; None shows none.
    """
    near, turn = tolerance
    width, height = _reach(heading, turn), _reach(distance, near)
    if reference is not None:
        height = max(height, 1.05 * sum(reference[0]))
        width = max(width, 1.2 * abs(reference[1][0]))
    figure, axes_of = panels.by_policy(list(distance), 0.92)
    colours = palette.by_policy(distance)
    for policy, axes in axes_of.items():
        _references(axes, tolerance, reference)
        x, y = heading[policy].ravel(), distance[policy].ravel()
        inside = (np.abs(x) <= width) & (y <= height)
        done = success[policy].ravel()[inside]
        _marks(axes, x[inside], y[inside], done, colours[policy])
        axes.set_title(policy)
        outside = int((np.isfinite(y) & ~inside).sum())
        if outside:
            axes.set_title(f"{outside} outside", loc="right", color=palette.GREY, fontsize=8)
        axes.set(xlim=(-width, width), ylim=(0.0, height))
    panels.label(axes_of, "heading error [rad]", "smallest distance [cm]")
    return figure


def _reach(found: Mapping[str, Float], tolerance: float) -> float:
    """Returns the reach of an axis, which does not depend on a few extreme values."""
    values = np.abs(np.concatenate([trainings.ravel() for trainings in found.values()]))
    values = values[np.isfinite(values)]
    reached = 1.1 * float(np.quantile(values, INSIDE)) if len(values) else 0.0
    return min(max(reached, LEAST * tolerance), MOST * tolerance)


def _references(
    axes: Axes, tolerance: tuple[float, float], reference: tuple[Spread, Spread] | None
) -> None:
    """Draws the tolerances as a box, and results from elsewhere as a cross."""
    near, turn = tolerance
    box: dict[str, Any] = {"fc": palette.PALE, "ec": palette.GREY, "lw": 0.9, "alpha": 0.45}
    axes.add_patch(Rectangle((-turn, 0.0), 2 * turn, near, zorder=0.5, **box))
    if reference is not None:
        (y, y_spread), (x, x_spread) = reference
        cross: dict[str, Any] = {"fmt": "D", "ms": 4.5, "color": palette.GREY, "lw": 1.1}
        axes.errorbar(x, y, y_spread, x_spread, zorder=2, **cross)


def _marks(axes: Axes, x: Float, y: Float, done: Bool, colour: str) -> None:
    """Draws one mark an episode: full where it succeeded, open where it failed."""
    pixels = len(x) > FEW
    size, alpha = (2.6, 0.45) if pixels else (4.0, 0.7)
    style: dict[str, Any] = {"ls": "none", "marker": "o", "ms": size, "rasterized": pixels}
    axes.plot(x[~done], y[~done], mfc="none", mec=colour, mew=0.9, alpha=0.9, zorder=3, **style)
    axes.plot(x[done], y[done], mfc=colour, mew=0.0, alpha=alpha, zorder=3, **style)
