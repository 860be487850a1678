"""Figures of an evaluation over the plane of errors and over the water, a panel a policy.

Arrays by policy have the shape (S, E) of trainings and episodes; colours are by policy too. All
are made in the ``look`` of ``svg``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon, Rectangle

from asv_env.types import Bool, Float
from baselines.evaluate.report import palette
from baselines.evaluate.report.figures import FEW, FULL, HALF, Colours

COLUMNS = 4
"""Most panels side by side; five policies have three and two."""
TITLE, FOOT, LEFT = 0.28, 0.5, 0.75
"""Inches above, below and left of the panels."""
GAP = 0.1
"""Inches round the panels where they have several rows."""
INSIDE = 0.9
"""Share of all errors that the axes reach, within ``LEAST`` and ``MOST`` tolerances."""
LEAST, MOST = 1.5, 2.0
Spread = tuple[float, float]
"""Mean and standard deviation."""
SCATTERED, CELLS = 250, 7
"""Goals up to which each has a mark; if there are more, cells along each side of their plane."""


def clouds(
    distance: Mapping[str, Float],
    heading: Mapping[str, Float],
    success: Mapping[str, Bool],
    tolerance: tuple[float, float],
    reference: tuple[Spread, Spread] | None,
    colours: Colours,
) -> Figure:
    """Where the vessel was, compared with its goal, when it was nearest.

    Args:
        distance: by policy (S, E), cm; NaN where there was no goal.
        heading: by policy (S, E), signed, rad.
        success: by policy (S, E).
        tolerance: of the task, cm and rad.
        reference: distance and heading error of others, cm and rad; None shows none.
        colours: by policy.
    """
    near, turn = tolerance
    wide, high = _reach(heading, turn), _reach(distance, near)
    if reference is not None:
        high, wide = max(high, 1.05 * sum(reference[0])), max(wide, 1.2 * abs(reference[1][0]))
    figure, panels = _panels(list(distance), 0.92)
    for policy, axes in panels.items():
        _tolerance(axes, tolerance)
        if reference is not None:
            _cross(axes, *reference)
        x, y = heading[policy].ravel(), distance[policy].ravel()
        done = success[policy].ravel()
        inside = (np.abs(x) <= wide) & (y <= high)
        _marks(axes, x[inside], y[inside], done[inside], colours[policy])
        strays = int((np.isfinite(y) & ~inside).sum())
        axes.set_title(policy)
        if strays:
            axes.set_title(f"{strays} outside", loc="right", color=palette.GREY, fontsize=8)
        axes.set_xlim(-wide, wide)
        axes.set_ylim(0.0, high)
    _label(panels, "heading error [rad]", "smallest distance [cm]")
    return figure


def _reach(found: Mapping[str, Float], unit: float) -> float:
    """How far an axis reaches, whatever a few strays do; ``unit`` is the tolerance."""
    values = np.abs(np.concatenate([table.ravel() for table in found.values()]))
    values = values[np.isfinite(values)]
    reached = 1.1 * float(np.quantile(values, INSIDE)) if len(values) else 0.0
    return min(max(reached, LEAST * unit), MOST * unit)


def _tolerance(axes: Axes, tolerance: tuple[float, float]) -> None:
    """The box within which the vessel is delivered, once at rest."""
    near, turn = tolerance
    box = Rectangle(
        (-turn, 0.0),
        2 * turn,
        near,
        fc=palette.PALE,
        ec=palette.GREY,
        lw=0.9,
        alpha=0.45,
        zorder=0.5,
    )
    axes.add_patch(box)


def _cross(axes: Axes, distance: Spread, heading: Spread) -> None:
    """Means and standard deviations of others."""
    axes.errorbar(
        heading[0], distance[0], distance[1], heading[1],
        fmt="D", ms=4.5, color=palette.GREY, lw=1.1, zorder=2,
    )  # fmt: skip


def _marks(axes: Axes, x: Float, y: Float, done: Bool, colour: str) -> None:
    """Full where the episode succeeded, open where it failed."""
    pixels = len(x) > FEW
    size, alpha = (2.6, 0.45) if pixels else (4.0, 0.7)
    looks: dict[str, Any] = {"ls": "none", "marker": "o", "ms": size, "rasterized": pixels}
    looks["zorder"] = 3
    axes.plot(x[~done], y[~done], mfc="none", mec=colour, mew=0.9, alpha=0.9, **looks)
    axes.plot(x[done], y[done], mfc=colour, mew=0.0, alpha=alpha, **looks)


def goals(
    places: Float, success: Mapping[str, Bool], outline: Float, reach: float, colours: Colours
) -> Figure:
    """Success by where the goal was.

    Args:
        places: (E, 2) of the goals from where the vessel began, m.
        success: by policy (S, E).
        outline: (n, 2) of the vessel where it began, m.
        reach: largest distance of a goal along either axis, m.
        colours: by policy.
    """
    figure, panels = _panels(list(success), 1.0)
    for policy, axes in panels.items():
        share = success[policy].mean(axis=0)
        if len(places) > SCATTERED:
            _cells(axes, places, share, reach, colours[policy])
        else:
            _verdicts(axes, places, share >= 0.5, colours[policy])
        axes.add_patch(Polygon(outline, fc=palette.PALE, ec=palette.BLACK, lw=0.9, zorder=2))
        axes.set_title(f"{policy}, {success[policy].mean():.1%}")
        _sea(axes, -1.06 * reach, 1.06 * reach, -1.06 * reach, 1.06 * reach)
    _label(panels, "goal x [m]", "goal y [m]")
    return figure


def _verdicts(axes: Axes, places: Float, done: Bool, colour: str) -> None:
    """A mark for every goal: full where it was reached, a cross where not."""
    axes.plot(*places[done].T, "o", ms=5.0, mew=0.0, color=colour, alpha=0.8, zorder=3)
    axes.plot(*places[~done].T, "x", ms=5.5, mew=1.4, color=palette.BLACK, zorder=4)


def _cells(axes: Axes, places: Float, share: Float, reach: float, colour: str) -> None:
    """Shares in percent, and numbers of goals, in the cells of a grid."""
    side = 2 * reach / CELLS
    cell = np.clip(np.floor((places + reach) / side), 0, CELLS - 1).astype(int)
    axes.grid(visible=False)
    for column, row in np.unique(cell, axis=0):
        here = (cell == (column, row)).all(axis=1)
        found, x, y = share[here].mean(), column * side - reach, row * side - reach
        tint = 0.08 + 0.72 * found
        axes.add_patch(Rectangle((x, y), side, side, fc=colour, alpha=tint, ec="none", zorder=1))
        axes.text(
            x + side / 2, y + 0.56 * side, f"{100 * found:.0f}", fontsize=8, zorder=3,
            ha="center", va="center", color=palette.BLACK,
        )  # fmt: skip
        axes.text(
            x + side / 2, y + 0.24 * side, f"{here.sum()}", fontsize=5.5, zorder=3,
            ha="center", va="center", color=palette.BLACK,
        )  # fmt: skip


def ways(
    paths: Mapping[str, Sequence[Float]],
    success: Mapping[str, Sequence[bool]],
    outline: Float,
    goal: Float | None,
    colours: Colours,
) -> Figure:
    """Where the vessel went.

    Args:
        paths: by policy, one an episode: (T, 2) of its centre, m.
        success: by policy, of each episode.
        outline: (n, 2) of the vessel where it began, m.
        goal: (n, 2) the same at the goal, where all episodes share one.
        colours: by policy.
    """
    figure, panels = _panels(list(paths), 1.0)
    hulls = outline if goal is None else np.concatenate([outline, goal])
    west, east, south, north = _bounds([p for some in paths.values() for p in some], hulls)
    for policy, axes in panels.items():
        pixels = len(paths[policy]) > FEW // 10
        for path, done in zip(paths[policy], success[policy], strict=True):
            colour, line = (colours[policy], "-") if done else (palette.GREY, (0, (3, 2)))
            axes.plot(*path.T, color=colour, ls=line, lw=0.9, alpha=0.6, rasterized=pixels)
            if not done:
                axes.plot(*path[-1], "x", color=palette.BLACK, ms=5.0, mew=1.2, zorder=4)
        axes.add_patch(Polygon(outline, fc=palette.PALE, ec=palette.BLACK, lw=0.9, zorder=1))
        if goal is not None:
            axes.add_patch(
                Polygon(goal, fc="none", ec=palette.BLACK, lw=1.2, ls=(0, (3, 2)), zorder=5)
            )
        axes.set_title(policy)
        _sea(axes, west, east, south, north)
    _label(panels, "x [m]", "y [m]")
    return figure


def _bounds(paths: Sequence[Float], hulls: Float) -> tuple[float, float, float, float]:
    """Of a square round all of the way: west, east, south, north."""
    points = np.concatenate([*paths, hulls])
    low, high = points.min(axis=0), points.max(axis=0)
    middle, half = (low + high) / 2, 0.54 * float((high - low).max())
    return middle[0] - half, middle[0] + half, middle[1] - half, middle[1] + half


def _sea(axes: Axes, west: float, east: float, south: float, north: float) -> None:
    axes.set_aspect("equal")
    axes.set_xlim(west, east)
    axes.set_ylim(south, north)


def _panels(policies: Sequence[str], aspect: float) -> tuple[Figure, dict[str, Axes]]:
    """A figure with a panel a policy, high as ``aspect`` says of their width."""
    count = len(policies)
    columns = count if count <= COLUMNS else -(-count // 2)
    rows = -(-count // columns)
    width = HALF if count == 1 else min(FULL, columns * 3.6)
    high = TITLE + aspect * ((width - LEFT) / columns - 0.06)
    figure = Figure(figsize=(width, rows * high + (rows + 1) / 2 * FOOT))
    figure.set_layout_engine("constrained", h_pad=GAP if rows > 1 else 0.04)
    grid = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    axes = list(grid.flat)
    for left in axes[count:]:
        left.remove()
    return figure, dict(zip(policies, axes, strict=False))


def _label(panels: Mapping[str, Axes], x: str, y: str) -> None:
    """Names the axes below and left of all panels."""
    for axes in panels.values():
        place = axes.get_subplotspec()
        assert place is not None
        axes.set_xlabel(x)
        if place.is_first_col():
            axes.set_ylabel(y)
        axes.tick_params(labelbottom=True)
