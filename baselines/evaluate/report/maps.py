"""Figures over the water, a panel a policy, in the style of ``svg``.

Arrays by policy have the shape (S, E) of trainings and episodes.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon, Rectangle

from asv_env.types import Bool, Float
from baselines.evaluate.report import palette, panels
from baselines.evaluate.report.panels import FEW

SCATTERED = 250
"""Largest number of goals that are drawn as marks; more are counted in cells."""
CELLS = 7
"""Number of cells along each side of the plane of goals."""
DASHED = (0, (3, 2))
"""Style of the lines of failed episodes and of goals."""


def goals(places: Float, success: Mapping[str, Bool], hull: Float, reach: float) -> Figure:
    """Returns the success by position of the goal.

    Args:
        places: (E, 2) positions of the goals relative to the vessel's initial pose, m.
        success: by policy (S, E).
        hull: (n, 2) outline of the vessel at its initial pose, m.
        reach: largest distance of a goal along either axis, m.
    """
    figure, axes_of = panels.by_policy(list(success), 1.0)
    colours = palette.by_policy(success)
    for policy, axes in axes_of.items():
        share = success[policy].mean(axis=0)
        if len(places) > SCATTERED:
            _cells(axes, places, share, reach, colours[policy])
        else:
            reached, missed = places[share >= 0.5].T, places[share < 0.5].T
            axes.plot(*reached, "o", ms=5.0, mew=0.0, color=colours[policy], alpha=0.8, zorder=3)
            axes.plot(*missed, "x", ms=5.5, mew=1.4, color=palette.BLACK, zorder=4)
        _hull(axes, hull)
        axes.set_title(f"{policy}, {success[policy].mean():.1%}")
        _square(axes, np.zeros(2), 1.06 * reach)
    panels.label(axes_of, "goal x [m]", "goal y [m]")
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
    figure, axes_of = panels.by_policy(list(paths), 1.0)
    colours = palette.by_policy(paths)
    points = [path for some in paths.values() for path in some]
    points += [hull] if goal is None else [hull, goal]
    low, high = (bound(np.concatenate(points), axis=0) for bound in (np.min, np.max))
    for policy, axes in axes_of.items():
        pixels = len(paths[policy]) > FEW // 10
        for path, done in zip(paths[policy], success[policy], strict=True):
            colour, line = (colours[policy], "-") if done else (palette.GREY, DASHED)
            axes.plot(*path.T, color=colour, ls=line, lw=0.9, alpha=0.6, rasterized=pixels)
            if not done:
                axes.plot(*path[-1], "x", color=palette.BLACK, ms=5.0, mew=1.2, zorder=4)
        _hull(axes, hull)
        if goal is not None:
            axes.add_patch(Polygon(goal, fc="none", ec=palette.BLACK, lw=1.2, ls=DASHED, zorder=5))
        axes.set_title(policy)
        axes.locator_params(nbins=6)
        _square(axes, (low + high) / 2, 0.54 * float((high - low).max()))
    panels.label(axes_of, "x [m]", "y [m]")
    return figure


def _hull(axes: Axes, hull: Float) -> None:
    axes.add_patch(Polygon(hull, fc=palette.PALE, ec=palette.BLACK, lw=0.9, zorder=1))


def _square(axes: Axes, centre: Float, half: float) -> None:
    """Shows a square of the water: its centre (2,) and half its side, m."""
    x, y = centre
    axes.set_aspect("equal")
    axes.set(xlim=(x - half, x + half), ylim=(y - half, y + half))
