"""Shortest path of bounded curvature (Dubins 1957), with which two-arc paths are compared.

All six words, the two of three turns (RLR, LRL) included, which the paper leaves out; what it
calls maximal curvature S_x/2 is the minimal radius. The car's direction of travel is the vessel's
-n, psi = h - pi/2, so that a left turn has positive curvature.
"""

import numpy as np
from numpy.typing import ArrayLike

from asv_env.geometry import wrap
from asv_env.types import Float
from baselines.paper.arcs import ArcPath, pick
from baselines.paper.inputs import finite_poses, positive

ROUNDING = 1e-13  #: relative, of lengths and turns
# First and last side of LSL RSR LSR RSL, outer side of LRL RLR; +1 is left.
_CSC_SIDES = (np.array([1.0, -1.0, 1.0, -1.0]), np.array([1.0, -1.0, -1.0, 1.0]))
_CCC_SIDES = np.array([1.0, -1.0])


def shortest(goal: ArrayLike, min_radius: ArrayLike) -> ArcPath:
    """Shortest path from (0, 0, 0) to `goal` (..., 3) with radii of at least `min_radius` (...) m.

    One always exists. It has three segments, of which unused ones have length 0, as all have to a
    goal at the start pose. ValueError: a number is not finite, or min_radius <= 0.
    """
    goal, radius = finite_poses("goal", goal), positive("min_radius", min_radius)
    batch = np.broadcast_shapes(goal.shape[:-1], radius.shape)
    goal, radius = np.broadcast_to(goal, (*batch, 3)), np.broadcast_to(radius, batch)
    csc, ccc = _turn_straight_turn(goal, radius), _three_turns(goal, radius)
    curvature, length = (np.concatenate(pair) for pair in zip(csc, ccc, strict=True))
    paths = ArcPath(np.zeros(3), curvature, np.where(np.isfinite(length), length, 0.0))
    return pick(paths, np.argmin(length.sum(axis=-1), axis=0))


def length(goal: ArrayLike, min_radius: ArrayLike) -> Float:
    """Returns the length (...) m of the shortest path to `goal` (..., 3); see `shortest`."""
    return shortest(goal, min_radius).total_length


def _turn_straight_turn(goal: Float, radius: Float) -> tuple[Float, Float]:
    """Curvatures and lengths (4, ..., 3) of LSL RSR LSR RSL; length inf where there is none.

    The centres are d t + R (s3 - s1) n apart, with d the length of the straight, t its direction
    and n its left normal. Within the rounding error a course without a turn is preferred.
    """
    s1, s3 = (np.multiply.outer(side, np.ones_like(radius)) for side in _CSC_SIDES)
    across_gap, start, end = _between_centres(goal, radius, s1, s3)
    offset = radius * (s3 - s1)
    distance = np.hypot(across_gap[..., 0], across_gap[..., 1])
    rounding = ROUNDING * (np.hypot(goal[..., 0], goal[..., 1]) + radius)
    excess = distance - np.abs(offset)
    straight = np.sqrt(np.maximum(excess, 0.0)) * np.sqrt(distance + np.abs(offset))
    course = np.arctan2(across_gap[..., 1], across_gap[..., 0]) - np.arctan2(offset, straight)
    slack = rounding / np.maximum(distance, rounding / np.pi)
    course = np.where(np.abs(wrap(course - start)) <= slack, start, course)
    course = np.where(np.abs(wrap(course - end)) <= slack, end, course)
    turns = _positive_turn(s1 * (course - start)), _positive_turn(s3 * (end - course))
    lengths = np.stack([radius * turns[0], straight, radius * turns[1]], axis=-1)
    curvatures = np.stack([s1 / radius, np.zeros_like(s1), s3 / radius], axis=-1)
    return curvatures, np.where((excess >= -rounding)[..., None], lengths, np.inf)


def _three_turns(goal: Float, radius: Float) -> tuple[Float, Float]:
    """Curvatures and lengths (2, ..., 3) of LRL and RLR; length inf where there is none.

    The outer centres are 4 R sin(m/2) apart for a middle turn m, of which only m >= pi can be best.
    """
    side = np.multiply.outer(_CCC_SIDES, np.ones_like(radius))
    across_gap, start, end = _between_centres(goal, radius, side, side)
    sine = np.hypot(across_gap[..., 0], across_gap[..., 1]) / (4 * radius)
    middle = 2 * np.pi - 2 * np.arcsin(np.minimum(sine, 1.0))
    mean = np.arctan2(across_gap[..., 1], across_gap[..., 0])
    first = _positive_turn(side * (mean - start) + middle / 2)
    last = _positive_turn(side * (end - mean) + middle / 2)
    lengths = radius[..., None] * np.stack([first, middle, last], axis=-1)
    curvatures = np.stack([side, -side, side], axis=-1) / radius[..., None]
    return curvatures, np.where((sine <= 1)[..., None], lengths, np.inf)


def _between_centres(
    goal: Float, radius: Float, s1: Float, s3: Float
) -> tuple[Float, Float, Float]:
    """Vector (m, ..., 2) from the first circle's centre to the last's, and the end courses psi."""
    start, end = np.full(goal.shape[:-1], -np.pi / 2), goal[..., 2] - np.pi / 2
    # The left normal of the course psi = h - pi/2 is (cos h, sin h), the vessel's long axis.
    axis = np.stack([np.cos(goal[..., 2]), np.sin(goal[..., 2])], axis=-1)
    first = (radius * s1)[..., None] * np.array([1.0, 0.0])
    return goal[..., :2] + (radius * s3)[..., None] * axis - first, start, end


def _positive_turn(angle: Float) -> Float:
    """Angle in [0, 2 pi), where a rounding error below 0 is not taken for a full turn."""
    turn = np.mod(angle, 2 * np.pi)
    return np.where(2 * np.pi - turn < 2 * np.pi * ROUNDING, 0.0, turn)
