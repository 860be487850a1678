"""Figures with a panel a policy: errors of placement, and maps of goals and paths.

They are made in the style of ``svg``. Arrays by policy have the shape (S, E) of trainings and
episodes.
"""

from collections.abc import Collection, Iterable, Mapping, Sequence
from itertools import chain, cycle
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon, Rectangle

from asv_env.types import Bool, Float
from baselines.evaluate.report import palette
from baselines.evaluate.report.svg import FEW, HALF

FULL = 10.9  #: width of a row of panels, inches
COLUMNS = 4  #: largest number of panels side by side; five policies have three and two
TITLE = 0.28  #: space above a panel, inches
FOOT = 0.5  #: space below a panel, inches
LEFT = 0.75  #: space left of the panels, inches
GAP = 0.1  #: space around the panels where there are several rows of them, inches
INSIDE = 0.9  #: share of all errors that lie within the axes
LEAST = 1.5  #: smallest reach of the axes, in tolerances
MOST = 2.0  #: largest reach of the axes, in tolerances
SCATTERED = 250  #: largest number of goals that are drawn as marks; more are counted in cells
CELLS = 7  #: number of cells along each side of the plane of goals
DASHED = (0, (3, 2))  #: style of the lines of failed episodes and of goals

Spread = tuple[float, float]  #: mean and standard deviation
Panels = Iterable[tuple[str, Axes, str]]  #: policies with their panels and colours


def errors(
    distance: Mapping[str, Float],
    heading: Mapping[str, Float],
    success: Mapping[str, Bool],
    tolerance: tuple[float, float],
    reference: tuple[Spread, Spread] | None,
) -> Figure:
    """Returns the errors of the vessel at the instant when it was nearest to its goal.

    Args:
        distance: by policy, cm; NaN where there was no goal.
        heading: by policy, signed, rad.
        success: by policy.
        tolerance: of the task, cm and rad.
        reference: distance, cm, and heading error, rad, from elsewhere; None shows none.
    """
    width, height = _reach(heading, tolerance[1]), _reach(distance, tolerance[0])
    if reference is not None:
        height = max(height, 1.05 * sum(reference[0]))
        width = max(width, 1.2 * abs(reference[1][0]))
    figure, panels = _panels(distance, 0.92, "heading error [rad]", "smallest distance [cm]")
    for policy, axes, colour in panels:
        _references(axes, tolerance, reference)
        x, y = heading[policy].ravel(), distance[policy].ravel()
        inside = (np.abs(x) <= width) & (y <= height)
        _marks(axes, x[inside], y[inside], success[policy].ravel()[inside], colour)
        axes.set_title(policy)
        if outside := int((np.isfinite(y) & ~inside).sum()):
            axes.set_title(f"{outside} outside", loc="right", color=palette.GREY, fontsize=8)
        axes.set(xlim=(-width, width), ylim=(0.0, height))
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


def goals(places: Float, success: Mapping[str, Bool], hull: Float, reach: float) -> Figure:
    """Returns the success by position of the goal.

    Args:
        places: (E, 2) positions of the goals relative to the vessel's initial pose, m.
        success: by policy.
        hull: (n, 2) outline of the vessel at its initial pose, m.
        reach: largest distance of a goal along either axis, m.
    """
    figure, panels = _panels(success, 1.0, "goal x [m]", "goal y [m]")
    for policy, axes, colour in panels:
        share = success[policy].mean(axis=0)
        if len(places) > SCATTERED:
            _cells(axes, places, share, reach, colour)
        else:
            reached, missed = places[share >= 0.5].T, places[share < 0.5].T
            axes.plot(*reached, "o", ms=5.0, mew=0.0, color=colour, alpha=0.8, zorder=3)
            axes.plot(*missed, "x", ms=5.5, mew=1.4, color=palette.BLACK, zorder=4)
        _hull(axes, hull)
        axes.set_title(f"{policy}, {success[policy].mean():.1%}")
        _square(axes, np.zeros(2), 1.06 * reach)
    return figure


def _cells(axes: Axes, places: Float, share: Float, reach: float, colour: str) -> None:
    """Writes shares in percent, and numbers of goals, into the cells of a grid."""
    side = 2 * reach / CELLS
    cell = np.clip(np.floor((places + reach) / side), 0, CELLS - 1).astype(int)
    text: dict[str, Any] = {"ha": "center", "va": "center", "color": palette.BLACK, "zorder": 3}
    axes.grid(visible=False)
    for column, row in np.unique(cell, axis=0):
        here = (cell == (column, row)).all(axis=1)
        found, x, y = share[here].mean(), column * side - reach, row * side - reach
        tint = 0.08 + 0.72 * found
        axes.add_patch(Rectangle((x, y), side, side, fc=colour, alpha=tint, ec="none", zorder=1))
        axes.text(x + side / 2, y + 0.56 * side, f"{100 * found:.0f}", fontsize=8, **text)
        axes.text(x + side / 2, y + 0.24 * side, f"{here.sum()}", fontsize=5.5, **text)


def paths(
    paths: Mapping[str, Sequence[Float]],
    success: Mapping[str, Sequence[bool]],
    hull: Float,
    goal: Float | None,
) -> Figure:
    """Returns the paths of the vessel.

    Args:
        paths: by policy, one an episode: (T, 2) positions of its centre, m.
        success: by policy, of each episode.
        hull: (n, 2) outline of the vessel at its initial pose, m.
        goal: (n, 2) the outline at the goal, m; None where every episode has its own goal.
    """
    figure, panels = _panels(paths, 1.0, "x [m]", "y [m]")
    points = np.concatenate([*chain(*paths.values()), hull, *([] if goal is None else [goal])])
    low, high = points.min(axis=0), points.max(axis=0)
    for policy, axes, own in panels:
        pixels = len(paths[policy]) > FEW // 10
        for path, done in zip(paths[policy], success[policy], strict=True):
            colour, line = (own, "-") if done else (palette.GREY, DASHED)
            axes.plot(*path.T, color=colour, ls=line, lw=0.9, alpha=0.6, rasterized=pixels)
            if not done:
                axes.plot(*path[-1], "x", color=palette.BLACK, ms=5.0, mew=1.2, zorder=4)
        _hull(axes, hull)
        if goal is not None:
            axes.add_patch(Polygon(goal, fc="none", ec=palette.BLACK, lw=1.2, ls=DASHED, zorder=5))
        axes.set_title(policy)
        axes.locator_params(nbins=6)
        _square(axes, (low + high) / 2, 0.54 * float((high - low).max()))
    return figure


def _hull(axes: Axes, hull: Float) -> None:
    axes.add_patch(Polygon(hull, fc=palette.PALE, ec=palette.BLACK, lw=0.9, zorder=1))


def _square(axes: Axes, centre: Float, half: float) -> None:
    """Shows a square of the water: its centre (2,) and half its side, m."""
    x, y = centre
    axes.set_aspect("equal")
    axes.set(xlim=(x - half, x + half), ylim=(y - half, y + half))


def _panels(policies: Collection[str], aspect: float, x: str, y: str) -> tuple[Figure, Panels]:
    """Returns a figure with labelled panels, each ``aspect`` times as high as it is wide."""
    count = len(policies)
    columns = count if count <= COLUMNS else -(-count // 2)
    rows = -(-count // columns)
    width = HALF if count == 1 else min(FULL, columns * 3.6)
    height = TITLE + aspect * ((width - LEFT) / columns - 0.06)
    figure = Figure(figsize=(width, rows * height + (rows + 1) / 2 * FOOT))
    figure.set_layout_engine("constrained", h_pad=GAP if rows > 1 else 0.04)
    axes = list(figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True).flat)
    for number, panel in enumerate(axes):
        panel.set(xlabel=x, ylabel="" if number % columns else y)
        panel.tick_params(labelbottom=True)
    for unused in axes[count:]:
        unused.remove()
    return figure, zip(policies, axes, cycle(palette.SERIES), strict=False)
