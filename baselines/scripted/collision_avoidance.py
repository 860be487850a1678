"""How boats keep clear of each other on the approach, in the vessel's frame."""

from __future__ import annotations

import numpy as np

from asv_env.types import Bool, Complex

STARBOARD = np.exp(0.8j)
"""Turn of the velocity by which boats avoid each other, so that no two hold each other up."""
TINY = 1e-9
"""Floor of the distance between boats, m."""


def avoidance_velocity(boat: Complex, reach: float, speed: float) -> Complex:
    """Velocity (W, A) m/s of boats (W, A) away from those within ``reach``, m.

    It grows from 0 to ``speed``, m/s, as the distance shrinks to 0.
    """
    away = boat[:, :, None] - boat[:, None, :]
    distance = np.abs(away)
    nearness = np.maximum(1.0 - distance / reach, 0.0)
    repulsion: Complex = (nearness * away / np.maximum(distance, TINY)).sum(axis=2)
    return speed * STARBOARD * repulsion


def sidestep(target: Complex, boat: Complex, obstacle: Bool, width: float, limit: float) -> Complex:
    """Shift (W, A) m of the boats' targets along the hull, to clear failed boats in the row.

    Args:
        target: (W, A) where boats want to be, m.
        boat: (W, A) where they are, m.
        obstacle: (W, A) boats that lie in the row of the slots and cannot move.
        width: distance along the hull to keep from them, m.
        limit: largest shift, m.
    """
    offset = target.real[:, :, None] - boat.real[:, None, :]
    overlap = np.maximum(width - np.abs(offset), 0.0) * obstacle[:, None, :]
    shift: Complex = np.clip((np.sign(offset) * overlap).sum(axis=2), -limit, limit) + 0j
    return shift
