"""Pictures of trajectories over the plane."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from asv_env.params import EnvParams, HullParams
from asv_env.scene import placed
from asv_env.types import Float
from baselines.episodes import Track

BOATS = matplotlib.colormaps["tab10"]
VESSEL, GOAL, FAILED = "#3b3226", "#c2452d", "#9a9a9a"
STILLS = 6


def save_picture(path: Path, tracks: Sequence[Track], params: EnvParams) -> None:
    """Saves one panel a policy: its first episode in full, and where all vessels went.

    Args:
        path: of the picture; its ending says the format.
        tracks: of all policies' episodes.
        params: of the environment.
    """
    policies = list(dict.fromkeys(track.episode.policy for track in tracks))
    figure = Figure(figsize=(6.2 * len(policies), 6.4), layout="constrained")
    axes = figure.subplots(1, len(policies), squeeze=False, sharex=True, sharey=True)[0]
    for panel, policy in zip(axes, policies, strict=True):
        own = sorted(
            (track for track in tracks if track.episode.policy == policy),
            key=lambda track: track.episode.seed,
        )
        _draw_policy(panel, own, params)
        delivered = sum(track.episode.success for track in own)
        panel.set_title(f"{policy}: {delivered} of {len(own)} episodes successful")
        panel.set_xlabel("x [m]")
    axes[0].set_ylabel("y [m]")
    axes[0].legend(loc="upper right", fontsize=8, framealpha=0.9)
    figure.savefig(path, dpi=130)


def _draw_policy(axes: Axes, tracks: Sequence[Track], params: EnvParams) -> None:
    for track in tracks:
        way = VESSEL if track.episode.success else FAILED
        axes.plot(*track.poses[:, 0, :2].T, color=way, alpha=0.15, linewidth=0.8, zorder=2)
    example = tracks[0]
    for boat in range(1, example.poses.shape[1]):
        colour = BOATS((boat - 1) % 10)
        axes.plot(*example.poses[:, boat, :2].T, color=colour, linewidth=1.1, zorder=3)
        axes.plot(*example.poses[0, boat, :2], "o", color=colour, markersize=5, zorder=5)
    for still in np.linspace(0, len(example.poses) - 1, STILLS).astype(int):
        _draw_hull(axes, example.poses[still, 0], params, VESSEL, 0.16 if still else 0.45)
        for boat in range(1, example.poses.shape[1]):
            _draw_boat(axes, example.poses[still, boat], params, BOATS((boat - 1) % 10))
    axes.plot(
        *example.poses[:, 0, :2].T,
        color=VESSEL,
        linewidth=1.6,
        zorder=4,
        label=f"vessel (seed {example.episode.seed})",
    )
    if params.task.name != "approach":
        corners = outline(params.vessel, example.goal)
        axes.add_patch(
            Polygon(
                corners, closed=True, fill=False, ec=GOAL, ls="--", lw=1.6, zorder=6, label="goal"
            )
        )
    axes.set_aspect("equal", adjustable="box")
    axes.grid(alpha=0.25)


def _draw_hull(axes: Axes, pose: Float, params: EnvParams, colour: str, alpha: float) -> None:
    corners = outline(params.vessel, pose)
    axes.add_patch(Polygon(corners, closed=True, fc=colour, ec=colour, alpha=alpha, zorder=1))


def _draw_boat(axes: Axes, pose: Float, params: EnvParams, colour: tuple[float, ...]) -> None:
    corners = outline(params.boat, pose)
    axes.add_patch(Polygon(corners, closed=True, fc=colour, ec="none", alpha=0.55, zorder=3))


def outline(hull: HullParams, pose: Float) -> Float:
    """Corners (..., n, 2) of hulls at poses (..., 3), m."""
    points = placed(np.array(hull.outline) @ np.array([1, 1j]), pose)
    return np.stack([points.real, points.imag], axis=-1)
