"""Where the vessel is to go and how fast: the path of arcs to its goal, and its timetable."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from asv_env.geometry import direction
from asv_env.params import VesselParams
from asv_env.types import Complex, Float
from baselines.paper import dubins
from baselines.paper.arcs import ArcPath
from baselines.paper.coasting import coasting_distance, coasting_speed

SEGMENTS = 4
"""Of the paths."""
CHOICES = 3
"""Radii, and lengths of the straight end, that are tried."""
FARTHEST = 100.0
"""Way up to which the timetable reaches, lengths of the vessel."""


@dataclass(frozen=True)
class RouteGains:
    """What is asked of a path, and of the speed on it.

    Attributes:
        radius: of the widest arcs that are considered, half-lengths of the vessel.
        tightest: of the tightest ones, in parts of that.
        tight: cost of an arc tighter by a half-length, lengths of way.
        runout: straight end of the path, lengths of the vessel, where it is longest.
        short: cost of one shorter by a length, lengths of way.
        speed: of the vessel on its path, m/s.
        braking: share of the speed from which the vessel would coast to rest.
        passing: speed at the goal, m/s; slow enough to count as delivered.
    """

    radius: float = 3.8
    tightest: float = 0.56
    tight: float = 0.75
    runout: float = 0.36
    short: float = 2.2
    speed: float = 0.069
    braking: float = 0.36
    passing: float = 0.0072


class Router:
    """Plans paths and their timetable for a vessel.

    Args:
        vessel: as it is in the water.
        gains: what is asked of a path.

    Raises:
        ValueError: the vessel has no linear drag across and would never come to rest.
    """

    def __init__(self, vessel: VesselParams, gains: RouteGains) -> None:
        if vessel.sway[0] <= 0:
            raise ValueError(
                f"vessel.sway = {vessel.sway}: without linear drag the vessel never comes to "
                "rest, and the scripted policy cannot stop it; give a value above 0"
            )
        self._vessel, self.gains = vessel, gains
        self._beyond = coasting_distance(vessel, gains.passing / gains.braking)
        way = np.linspace(0.0, FARTHEST * vessel.length, 5000)
        slowness = 1.0 / self.speed(way)
        steps = np.diff(way) * (slowness[1:] + slowness[:-1]) / 2
        self._timetable = way, np.concatenate([[0.0], np.cumsum(steps)])

    def plan(self, goal: Complex, turn: Float) -> ArcPath:
        """Paths (W,) of ``SEGMENTS`` segments to goals (W,) with headings (W,), vessel's frame.

        Tried are shortest paths of bounded curvature with a straight behind them, on which the
        vessel recovers from the turn and slows down. Wide arcs and long straights are easier to
        follow than tight and short ones: the cost is the way and what these are worth.
        """
        gains, length = self.gains, self._vessel.length
        radii = gains.radius * np.linspace(1.0, gains.tightest, CHOICES)
        runouts = gains.runout * np.linspace(1.0, 0.0, CHOICES)
        radius, runout = (grid.reshape(-1, 1) for grid in np.meshgrid(radii, runouts))
        cost = gains.tight * (gains.radius - radius) + gains.short * (gains.runout - runout)
        before = goal + 1j * runout * length * direction(turn)
        heading = np.broadcast_to(turn, before.shape)
        poses = np.stack([before.real, before.imag, heading], axis=-1)
        paths = dubins.shortest(poses, radius * length / 2)
        straight = np.broadcast_to(runout * length, before.shape)[..., None]
        ways = np.concatenate([paths.length, straight], axis=-1)
        curvatures = np.concatenate([paths.curvature, np.zeros_like(straight)], axis=-1)
        best = np.argmin(ways.sum(axis=-1) + length * cost, axis=0), np.arange(len(goal))
        return ArcPath(np.zeros(3), curvatures[best], ways[best])

    def speed(self, left: Float) -> Float:
        """Speed (...) m/s of the vessel at ways (...) in m before its goal.

        Nobody can brake it: it is led to rest a little beyond the goal at a share of the speed at
        which it would coast there.
        """
        coasting = coasting_speed(self._vessel, np.maximum(left + self._beyond, 0.0))
        return np.minimum(self.gains.speed, self.gains.braking * coasting)

    def time(self, left: Float) -> Float:
        """Time (...) s that the vessel takes for the way (...) in m that is left."""
        return np.interp(left, *self._timetable)
