"""The scripted policy on paths of two arcs, or on Dubins paths: what the comparison drives."""

from collections.abc import Callable
from functools import partial

import numpy as np

from asv_env.params import EnvParams
from asv_env.types import Complex, Float
from baselines.paper import dubins, two_arc
from baselines.paper.arcs import ArcPath
from baselines.policy import MakePolicy
from baselines.scripted.gains import PathGains
from baselines.scripted.planner import SEGMENTS, PathPlanner
from baselines.scripted.scripted_policy import ScriptedPolicy

Planner = Callable[[Float, float], ArcPath]
"""Function from goals (W, 3) in the vessel's frame and the least radius, m, to paths."""


def least_radius(params: EnvParams) -> float:
    """Returns the radius, m, of the tightest arcs that the scripted policy drives."""
    gains = PathGains()
    return gains.widest_radius * gains.tightest_radius * params.vessel.length / 2


def two_arcs(goals: Float, radius: float) -> ArcPath:
    """Returns the shortest two arcs to poses (W, 3), and Dubins paths where there are none."""
    arcs, others = padded(two_arc.shortest(goals, radius)), dubins_paths(goals, radius)
    able = two_arc.feasible(arcs, radius)[:, None]
    return ArcPath(
        arcs.start,
        np.where(able, arcs.curvature, others.curvature),
        np.where(able, arcs.length, others.length),
    )


def dubins_paths(goals: Float, radius: float) -> ArcPath:
    """Returns the Dubins paths to poses (W, 3)."""
    return padded(dubins.shortest(goals, radius))


def padded(path: ArcPath) -> ArcPath:
    """Returns the same paths (W,) with as many segments as the policy remembers."""
    spare = ((0, 0), (0, SEGMENTS - path.length.shape[-1]))
    return ArcPath(path.start, np.pad(path.curvature, spare), np.pad(path.length, spare))


class GivenPaths(PathPlanner):
    """The scripted policy's timetable, on the paths of a planner.

    Args:
        params: of the environment.
        planner: of the paths.
    """

    def __init__(self, params: EnvParams, planner: Planner) -> None:
        vessel, _ = params.hulls()
        super().__init__(vessel, PathGains())
        self._planner, self._radius = planner, least_radius(params)

    def plan(self, goal: Complex, heading: Float) -> ArcPath:
        """See ``PathPlanner.plan``."""
        return self._planner(np.stack([goal.real, goal.imag, heading], axis=-1), self._radius)


def driving(planner: Planner, params: EnvParams) -> ScriptedPolicy:
    """Returns the scripted policy on the paths of a planner."""
    return ScriptedPolicy(params, planner=GivenPaths(params, planner))


PLANNERS: dict[str, MakePolicy] = {
    "two arcs": partial(driving, two_arcs),
    "Dubins": partial(driving, dubins_paths),
}
"""Policies by the planner of their paths."""
