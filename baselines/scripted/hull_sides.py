"""The sides and ends of the vessel's convex hull, as a team sees them that pushes from above.

All positions are complex numbers u + iw in the vessel's frame, mirrored where the team pushes from
the -n side.
"""

import numpy as np

from asv_env.geometry import plane
from asv_env.params import BoatParams, VesselParams
from asv_env.polygons import upper_side
from asv_env.tasks.formation import Relations, holding_part
from asv_env.types import Complex, Float


class HullSides:
    """Heights of the side that faces the team, and the ends."""

    def __init__(self, vessel: VesselParams, boat: BoatParams) -> None:
        self._corners = plane(np.array(boat.corners))
        #: u of the ends, m
        self.stern, self.bow, _, _ = vessel.extents
        corners = vessel.corners
        self._above, self._below = (
            upper_side(corners),
            upper_side([(u, -w) for u, w in corners[::-1]]),
        )

    def height(self, u: Float, side: Float) -> Float:
        """Returns the heights w (W, ...) of the hull at u (W, ...), m; beyond an end that of it.

        ``side`` (W,) is the vessel's side that faces the team, +1 or -1.
        """
        sides = side.reshape(-1, *[1] * (u.ndim - 1))
        return np.where(sides < 0, np.interp(u, *self._below), np.interp(u, *self._above))

    def rooms(self, friction: float) -> tuple[float, float]:
        """Returns how far from the middle friction holds boats, on the +n and on the -n side, m."""
        above, below = (holding_part(*side, friction) for side in (self._above, self._below))
        return min(above[1], -above[0]), min(below[1], -below[0])

    def end(self, place: Complex) -> Float:
        """Returns -1 or +1 for places (...) beyond an end of the hull, 0 for those at its side."""
        beyond = place.real > self.bow
        return np.where(place.real < self.stern, -1.0, beyond * 1.0)

    def beyond(self, u: Float, end: Float) -> Float:
        """Returns how far u (...) lies beyond the end -1 or +1 (...), m."""
        return end * u - np.where(end < 0, -self.stern, self.bow)

    def clearance(self, relations: Relations, end: Float, side: Float) -> Float:
        """Returns the gaps (W, A) between boats and the hull's side or end where they are, m."""
        corners = self._corners_of(relations)
        beside = (corners.imag - self.height(corners.real, side)).min(axis=-1)
        return np.where(end == 0, beside, self.gap(relations, end))

    def gap(self, relations: Relations, end: Float) -> Float:
        """Returns the gaps (W, A) between boats and the end -1 or +1 of the hull, m."""
        return self.beyond(self._corners_of(relations).real, end[..., None]).min(axis=-1)

    def _corners_of(self, relations: Relations) -> Complex:
        """Returns the corners (W, A, C) of the boats, vessel frame, m."""
        bow = relations.heading[:, 1:] * relations.heading[:, :1].conj()
        corners: Complex = relations.boat[..., None] + self._corners * bow[..., None]
        return corners
