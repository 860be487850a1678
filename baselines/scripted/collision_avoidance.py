"""How boats keep clear of each other on the approach, in the vessel's frame."""

import numpy as np

from asv_env.types import Bool, Complex

STARBOARD = np.exp(0.8j)
"""Turn of the velocity by which boats avoid each other, so that no two hold each other up."""
TINY = 1e-9
"""Floor of the distance between boats, m."""


def avoidance_velocity(boat: Complex, reach: float, speed: float) -> Complex:
    """Returns the velocity (W, A) m/s of boats (W, A) away from those within ``reach``, m.

    It grows from 0 to ``speed``, m/s, as the distance shrinks to 0.
    """
    away = boat[:, :, None] - boat[:, None, :]
    distance = np.abs(away)
    nearness = np.maximum(1.0 - distance / reach, 0.0)
    return speed * STARBOARD * (nearness * away / np.maximum(distance, TINY)).sum(axis=2)


def sidestep(target: Complex, boat: Complex, obstacle: Bool, width: float, limit: float) -> Complex:
    """Returns shifts (W, A) m of the boats' targets along the hull, to clear failed boats.

    ``obstacle`` (W, A) marks these among the boats (W, A). Targets keep the distance ``width`` from
    them along the hull, but are shifted by ``limit`` at most, m.
    """
    offset = target.real[:, :, None] - boat.real[:, None, :]
    overlap = np.maximum(width - np.abs(offset), 0.0) * obstacle[:, None, :]
    return np.clip((np.sign(offset) * overlap).sum(axis=2), -limit, limit) + 0j
