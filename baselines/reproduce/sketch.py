"""Hulls, slots, paths and angles over the plane, which the figures draw. All in metres."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import FancyArrowPatch, Polygon
from numpy.typing import ArrayLike

from asv_env.geometry import xy
from asv_env.params import EnvParams, HullParams
from asv_env.render.layout import outline, placed
from asv_env.tasks import formation
from asv_env.types import Float
from baselines.evaluate.report import palette
from baselines.paper.arcs import ArcPath
from baselines.reproduce import style

STEPS = 200  #: number of points by which a path or an arc is drawn


def plane(axes: Axes, labels: bool = True) -> None:
    """Makes the panel a map of the plane: one scale for x and y."""
    axes.set_aspect("equal", adjustable="box")
    if labels:
        axes.set_xlabel("$x$ (m)")
        axes.set_ylabel("$y$ (m)")


def hull(axes: Axes, shape: HullParams, pose: ArrayLike, **patch: Any) -> None:
    """Draws a hull at a pose (3,)."""
    looks: dict[str, Any] = {"fc": palette.PALE, "ec": palette.BLACK, "lw": 0.7, "zorder": 3}
    corners = outline(shape, np.asarray(pose, dtype=np.float64))
    axes.add_patch(Polygon(corners, closed=True, **(looks | patch)))


def goal(axes: Axes, params: EnvParams, pose: ArrayLike) -> None:
    """Draws the outline of the vessel at its goal pose (3,)."""
    hull(axes, params.vessel, pose, fc="none", ec=palette.VERMILLION, ls=(0, (3, 2)), lw=1.0)


def boats(axes: Axes, params: EnvParams, poses: Float, **patch: Any) -> None:
    """Draws boats at poses (A, 3)."""
    for pose, colour in zip(poses, style.boat_colours(len(poses)), strict=True):
        looks: dict[str, Any] = {"fc": colour, "lw": 0.3, "zorder": 5, **patch}
        hull(axes, params.boat, pose, **looks)


def slots(params: EnvParams, vessel: ArrayLike) -> Float:
    """Returns the poses (A, 3) of boats in their slots round a vessel at a pose (3,)."""
    pose = np.asarray(vessel, dtype=np.float64)
    points = xy(placed(formation.slots(params, params.num_boats), pose))
    heading = pose[2] + np.angle(formation.slot_direction(np.ones(1)))
    return np.concatenate([points, np.broadcast_to(heading, (len(points), 1))], axis=-1)


def crosses(axes: Axes, points: ArrayLike, colour: Any = palette.BLACK, size: float = 4.0) -> None:
    """Draws crosses at points (n, 2); those at infinity (centres of straights) are left out."""
    x, y = np.reshape(np.asarray(points, dtype=np.float64), (-1, 2)).T
    near = np.isfinite(x) & np.isfinite(y)
    axes.plot(x[near], y[near], "x", color=colour, ms=size, mew=0.225 * size, zorder=7)


def path_points(path: ArcPath) -> Float:
    """Returns points (STEPS, 2) along one path."""
    return path.pose_at(np.linspace(0.0, float(path.total_length), STEPS))[:, :2]


def arrow(axes: Axes, tail: ArrayLike, head: ArrayLike, **patch: Any) -> None:
    """Draws an arrow between two points (2,)."""
    looks: dict[str, Any] = {"arrowstyle": "-|>", "mutation_scale": 7.0, "lw": 0.9, "zorder": 6}
    ends = tuple(np.asarray(tail)), tuple(np.asarray(head))
    axes.add_patch(FancyArrowPatch(*ends, shrinkA=0.0, shrinkB=0.0, **(looks | patch)))


def ahead(pose: ArrayLike, distance: float) -> Float:
    """Returns the point (2,) at a distance ahead of a pose (3,)."""
    x, y, heading = np.asarray(pose, dtype=np.float64)
    return np.array([x + distance * np.cos(heading), y + distance * np.sin(heading)])


def angle(
    axes: Axes,
    centre: ArrayLike,
    start: float,
    turn: float,
    radius: float,
    name: str,
    colour: str = palette.BLACK,
) -> None:
    """Draws an angle, an arc with an arrow from one direction by a signed turn, and its name."""
    x, y = np.asarray(centre, dtype=np.float64)
    along = start + turn * np.linspace(0.0, 1.0, STEPS)
    axes.plot(x + radius * np.cos(along), y + radius * np.sin(along), color=colour, lw=0.8)
    last = np.stack([x + radius * np.cos(along[-6:]), y + radius * np.sin(along[-6:])], axis=-1)
    arrow(axes, last[0], last[-1], color=colour, lw=0.0, mutation_scale=6.0)
    middle, reach = start + turn / 2, radius + 0.05
    label(axes, (x + reach * np.cos(middle), y + reach * np.sin(middle)), name, colour)


def label(axes: Axes, point: ArrayLike, name: str, colour: str = palette.BLACK) -> None:
    """Writes a name in mathematical letters, centred at a point (2,)."""
    x, y = np.asarray(point, dtype=np.float64)
    axes.text(x, y, f"${name}$", color=colour, ha="center", va="center", zorder=8)
