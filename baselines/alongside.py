"""How boats move beside a hull that moves.

Quantities are in the vessel's frame: u along it, w across it, boats on the +w side facing -w.
"""

from __future__ import annotations

import numpy as np

from asv_env.formation import Relations
from asv_env.geometry import direction
from asv_env.types import Complex, Float


def hull_velocity(relations: Relations, slot: Complex) -> tuple[Float, Float]:
    """Velocity (W, A) of the vessel at each slot: towards -w, and towards +u, m/s."""
    moves = (relations.velocity[:, 0] * relations.heading[:, 0].conj())[:, None]
    yaw_rate = relations.yaw_rate[:, :1]
    return -moves.imag - yaw_rate * slot.real, moves.real - yaw_rate * slot.imag


def turn_to(relations: Relations, heading: Float) -> Float:
    """Angle (W, A) by which boats have to turn to a heading (W, A) in the vessel's frame."""
    turn = direction(heading) * relations.heading[:, :1] / relations.heading[:, 1:]
    return np.arctan2(turn.imag, turn.real)
