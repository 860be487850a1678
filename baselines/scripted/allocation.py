"""Control allocation: which boat at the side exerts which part of a force and a moment."""

import numpy as np

from asv_env.types import Bool, Float

TINY = 1e-6
"""Floor of divisors, m or m^2."""


def allocate(
    forward: Float, moment: Float, position: Float, pushing: Bool, reserve: float, contact: float
) -> tuple[Float, Float]:
    """Allocates force and moment to boats that can only push.

    The moment has priority: where it asks for more force than the speed does, the vessel gets
    faster. A vessel that is too fast is left alone.

    Args:
        forward: (W,) force towards -n that the speed asks for, N; negative where it is too high.
        moment: (W,) wanted, N m.
        position: (W, A) of the boats along the hull, m.
        pushing: (W, A) boats that take part.
        reserve: force that may always be used for the moment, N.
        contact: least force of all boats together, N.

    Returns:
        Force of each boat (W, A), N, and the moment (W,) that results, N m.
    """
    lever = np.where(pushing, position, 0.0)
    pushers = np.maximum(pushing.sum(axis=1), 1)
    levers = np.maximum((lever**2).sum(axis=1), TINY)
    per_moment = pushers * np.maximum(np.abs(lever).max(axis=1), TINY) / levers
    limit = np.maximum(forward, reserve) / per_moment
    moment = np.clip(moment, -limit, limit)
    total = np.maximum(np.maximum(forward, 0.0), per_moment * np.abs(moment))
    force = (total / pushers)[:, None] - (moment / levers)[:, None] * lever
    least = (contact / pushers)[:, None]
    surplus = np.minimum(forward / pushers, 0.0)[:, None]
    force = np.maximum(force, least) + np.where(surplus < 0, surplus - least, 0.0)
    force = np.where(pushing, force, 0.0)
    return force, -(force * lever).sum(axis=1)
