"""Speeds of the boats that push a vessel round a circle: Eq (16).

Eq (16) is the magnitude of the rigid-body velocity at a boat; its direction is perpendicular to
the line to the centre, not the vessel's normal (the paper gives none). Boats that keep pushing
along the normal need the component of that velocity along -n, `normal_speeds`.
"""

import numpy as np
from numpy.typing import ArrayLike

from asv_env.types import Float
from baselines.paper.inputs import finite, finite_points, numbers


def speeds(
    points: ArrayLike, centre: ArrayLike, vessel_position: ArrayLike, mean_speed: ArrayLike
) -> Float:
    """Speed (...) m/s of boats at points (..., 2) m of a vessel turning about `centre` (Eq 16).

    The vessel's centre, at ``vessel_position`` (..., 2) m, moves at ``mean_speed`` (...) m/s; an
    infinite coordinate of ``centre`` (..., 2) means a straight, with every speed the mean.

    Raises:
        ValueError: a number is NaN, or the vessel's centre is the centre of the circle.
    """
    points = finite_points("points", points)
    vessel_position = finite_points("vessel_position", vessel_position)
    centre = numbers("centre", centre)
    if np.isnan(centre).any() or centre.shape[-1:] != (2,):
        raise ValueError(f"centre must be (..., 2) without NaN, got {centre}: inf for a straight")
    radius = np.hypot(*np.moveaxis(vessel_position - centre, -1, 0))
    if (radius == 0).any():
        raise ValueError("centre is the vessel's own centre: Eq (16) needs a circle of radius > 0")
    straight = np.isinf(radius)
    distance = np.where(straight, 1.0, np.hypot(*np.moveaxis(points - centre, -1, 0)))
    return distance / np.where(straight, 1.0, radius) * finite("mean_speed", mean_speed)


def normal_speeds(u: ArrayLike, curvature: ArrayLike, mean_speed: ArrayLike) -> Float:
    """Component (...) m/s along -n of the velocity that Eq (16) measures: S (rho - u) / rho.

    Not negative for every boat along the vessel, at ``u`` m along its +x axis, if and only if the
    radius is at least half the vessel's length, which is the condition of conditional closure. The
    curvature is 1/rho, 1/m; 0 is a straight.
    """
    u, curvature = finite("u", u), finite("curvature", curvature)
    return finite("mean_speed", mean_speed) * (1 - curvature * u)
