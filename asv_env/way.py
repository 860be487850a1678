"""How far it is to a pose for what cannot turn on the spot: the length of the shortest legal way.

A vessel that is pushed goes ahead or not at all, and turns on circles. The shortest way between two
poses is then a turn, a straight and a turn, or three turns (Dubins 1957).
"""

from __future__ import annotations

import numpy as np

from asv_env.types import Complex, Float

# First and last turn of LSL RSR LSR RSL, and of LRL RLR: +1 is left.
FIRST, LAST = np.array([[1.0], [-1.0], [1.0], [-1.0]]), np.array([[1.0], [-1.0], [-1.0], [1.0]])
OUTER = FIRST[:2]
FULL = 2 * np.pi
ROUNDING = 1e-9
"""Turns by less than a full one that are taken for none, rad."""


def shortest_way(goal: Complex, turn: Float, radius: float) -> Float:
    """Lengths (W,) m of the shortest ways from the origin, where they begin along +x.

    Args:
        goal: (W,) where they end, m.
        turn: (W,) by which their last direction differs from their first, rad.
        radius: of the tightest turn, m.
    """
    goal = goal / radius
    across = 1j * np.exp(1j * turn)
    gap = goal + LAST * across - 1j * FIRST  # between the centres of the first and the last circle
    distance, course = np.abs(gap), np.angle(gap)

    straight = distance.copy()
    crosses = distance[2:]  # a way between circles of different sense
    straight[2:] = np.sqrt(np.maximum(crosses**2 - 4.0, 0.0))
    leaves = course.copy()
    leaves[2:] += FIRST[2:] * np.arctan2(2.0, straight[2:])
    ways = np.empty((6, len(goal)))
    ways[:4] = straight + _turned(FIRST * leaves) + _turned(LAST * (turn - leaves))
    ways[2:4][crosses < 2.0] = np.inf

    near, toward = distance[:2], OUTER * course[:2]
    middle = FULL - 2.0 * np.arcsin(np.minimum(near / 4.0, 1.0))
    ways[4:] = _turned(toward + middle / 2) + middle + _turned(OUTER * turn - toward + middle / 2)
    ways[4:][near > 4.0] = np.inf
    shortest: Float = radius * ways.min(axis=0)
    return shortest


def _turned(angle: Float) -> Float:
    """Angles in [0, 2 pi), but for a rounding error."""
    turned: Float = np.mod(angle + ROUNDING, FULL) - ROUNDING
    return turned
