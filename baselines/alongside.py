"""How boats move beside a hull that moves: what the phases of the scripted policy share.

Quantities are in the vessel's frame: u along it, w across it, boats on the +w side facing -w.
"""

from __future__ import annotations

import numpy as np

from asv_env.formation import Relations
from asv_env.geometry import direction
from asv_env.types import Complex, Float

SLOW = 0.03
"""Speed below which the course of a boat is not told from its heading, m/s."""

LARGEST_DRIFT = 0.5


def hull_velocity(relations: Relations, slot: Complex) -> tuple[Float, Float]:
    """Velocity (W, A) of the vessel at each slot: towards -w, and towards +u, m/s."""
    moves = (relations.velocity[:, 0] * relations.heading[:, 0].conj())[:, None]
    yaw_rate = relations.yaw_rate[:, :1]
    return -moves.imag - yaw_rate * slot.real, moves.real - yaw_rate * slot.imag


def drift(relations: Relations) -> Float:
    """Angle (W, A) from a boat's heading to its course, as boats skid in curves; 0 at rest."""
    velocity = relations.velocity[:, 1:] * relations.heading[:, 1:].conj()
    angle = np.arctan2(velocity.imag, np.maximum(velocity.real, SLOW))
    return np.where(velocity.real > SLOW, np.clip(angle, -LARGEST_DRIFT, LARGEST_DRIFT), 0.0)


def turn_to(relations: Relations, heading: Float) -> Float:
    """Angle (W, A) by which boats have to turn to a heading (W, A) in the vessel's frame."""
    turn = direction(heading) * relations.heading[:, :1] / relations.heading[:, 1:]
    return np.arctan2(turn.imag, turn.real)
