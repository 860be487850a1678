"""What the figures draw over the plane: hulls, slots, arcs, angles. All in metres."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import FancyArrowPatch, Polygon
from numpy.typing import ArrayLike

from asv_env.params import EnvParams, HullParams
from asv_env.render.outlines import outline, placed
from asv_env.tasks import formation
from asv_env.types import Complex, Float
from baselines.evaluate.report import palette
from baselines.paper.arcs import ArcPath
from baselines.reproduce import style

STEPS = 200
"""Points by which a path or an arc is drawn."""


def plane(axes: Axes, labels: bool = True) -> None:
    """Makes the panel a map of the plane: one scale for x and y."""
    axes.set_aspect("equal", adjustable="box")
    if labels:
        axes.set_xlabel("$x$ (m)")
        axes.set_ylabel("$y$ (m)")


def pairs(points: Complex) -> Float:
    """Points (...,) of the plane as x and y (..., 2)."""
    return np.stack([points.real, points.imag], axis=-1)


def hull(axes: Axes, shape: HullParams, pose: ArrayLike, **patch: Any) -> None:
    """A hull at a pose (3,)."""
    looks: dict[str, Any] = {
        "fc": palette.PALE,
        "ec": palette.BLACK,
        "lw": 0.7,
        "zorder": 3,
        **patch,
    }
    corners = outline(shape, np.asarray(pose, dtype=np.float64))
    axes.add_patch(Polygon(corners, closed=True, **looks))


def goal(axes: Axes, params: EnvParams, pose: ArrayLike) -> None:
    """The vessel as it is to lie in the end."""
    hull(axes, params.vessel, pose, fc="none", ec=palette.VERMILLION, ls=(0, (3, 2)), lw=1.0)


def boats(axes: Axes, params: EnvParams, poses: Float, **patch: Any) -> None:
    """Boats at poses (A, 3)."""
    for pose, colour in zip(poses, style.boat_colours(len(poses)), strict=True):
        looks: dict[str, Any] = {"fc": colour, "lw": 0.3, "zorder": 5, **patch}
        hull(axes, params.boat, pose, **looks)


def slots(params: EnvParams, vessel: ArrayLike) -> Float:
    """Poses (A, 3) of boats that hold their slots round a vessel at a pose (3,)."""
    pose = np.asarray(vessel, dtype=np.float64)
    points = pairs(placed(formation.slots(params, params.num_boats), pose))
    facing = pose[2] + np.angle(formation.slot_direction(np.ones(1)))
    return np.concatenate([points, np.broadcast_to(facing, (len(points), 1))], axis=-1)


def crosses(axes: Axes, points: ArrayLike, colour: Any = palette.BLACK, size: float = 4.0) -> None:
    """Crosses at points (n, 2); those at infinity (the centre of a straight) are left out."""
    x, y = np.reshape(np.asarray(points, dtype=np.float64), (-1, 2)).T
    near = np.isfinite(x) & np.isfinite(y)
    axes.plot(x[near], y[near], "x", color=colour, ms=size, mew=0.9, zorder=7)


def path_points(path: ArcPath) -> Float:
    """Points (STEPS, 2) along one path."""
    return path.pose_at(np.linspace(0.0, float(path.total_length), STEPS))[:, :2]


def arrow(axes: Axes, tail: ArrayLike, head: ArrayLike, **patch: Any) -> None:
    """An arrow between two points (2,)."""
    looks: dict[str, Any] = {
        "arrowstyle": "-|>",
        "mutation_scale": 7.0,
        "shrinkA": 0.0,
        "shrinkB": 0.0,
        "lw": 0.9,
        "zorder": 6,
        **patch,
    }
    axes.add_patch(FancyArrowPatch(tuple(np.asarray(tail)), tuple(np.asarray(head)), **looks))


def ahead(pose: ArrayLike, distance: float) -> Float:
    """The point (2,) at a distance ahead of a pose (3,)."""
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
    gap: float = 0.05,
) -> None:
    """An angle: an arc with an arrow from one direction by a signed turn, and its name."""
    x, y = np.asarray(centre, dtype=np.float64)
    along = start + turn * np.linspace(0.0, 1.0, STEPS)
    axes.plot(x + radius * np.cos(along), y + radius * np.sin(along), color=colour, lw=0.8)
    last = np.stack([x + radius * np.cos(along[-6:]), y + radius * np.sin(along[-6:])], axis=-1)
    arrow(axes, last[0], last[-1], color=colour, lw=0.0, mutation_scale=6.0)
    middle, reach = start + turn / 2, radius + gap
    label(axes, (x + reach * np.cos(middle), y + reach * np.sin(middle)), name, colour)


def label(axes: Axes, point: ArrayLike, name: str, colour: str = palette.BLACK) -> None:
    """A name, in mathematical letters, with its middle at a point (2,)."""
    x, y = np.asarray(point, dtype=np.float64)
    axes.text(x, y, f"${name}$", color=colour, ha="center", va="center", zorder=8)
