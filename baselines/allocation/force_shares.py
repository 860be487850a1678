"""Shares a wrench out over boats that can only push: bounded, regularised least squares.

With a column g of the wrench that each boat exerts per newton, the forces f minimise

    |G f - w|^2 + r |f - b|^2   subject to   0 <= f <= limit.

Without bounds above and with r -> 0 this is the non-negative least squares of Esposito, Feemster
and Smith (Cooperative manipulation on the water using a swarm of autonomous tugboats, ICRA 2008).
A wrench has three components, however many boats there are. So the dual is solved: with the
residual z = w - G f the forces are f = clip(b + G' z / r, 0, limit), and z is the root of the
gradient z - w + G f(z) of a convex function of three variables. Newton's method finds it in a few
steps, because the gradient is piecewise linear.
"""

import math
from typing import Any

import numpy as np

from asv_env.compiled import allocating, compiled
from asv_env.types import Float, given

Vector = tuple[float, float, float]  #: force along u and w, and moment
Symmetric = tuple[float, float, float, float, float, float]
"""Diagonal uu, ww, mm, and uw, um, wm of a symmetric matrix."""

RIDGE = 0.01
"""Weight r of the forces against the residual, where columns are of length about 1: a wrench that
one boat can exert by itself is exerted to within one per cent."""
STEPS = 50  #: most steps of Newton's method; teams need a handful
EXACT = 1e-11  #: size of the gradient, in units of the forces, at which the root is found
SHORTEST = 1e-6  #: shortest part of a step that is tried


def share(columns: Float, wrench: Float, bias: Float, limit: Float, ridge: float = RIDGE) -> Float:
    """Returns the forces (W, A) of boats for wrenches (W, 3).

    Args:
        columns: (W, A, 3) wrench per force of each boat.
        wrench: (W, 3) that is wanted.
        bias: (W, A) forces near which they are to stay.
        limit: (W, A) largest forces; 0 of a boat that takes no part.
        ridge: weight of the forces against the residual.
    """
    forces: Float = _share(given(columns), given(wrench), given(bias), given(limit), ridge)
    return forces


@allocating
def _share(columns: Float, wrench: Float, bias: Float, limit: Float, ridge: float) -> Float:
    worlds, team = limit.shape
    forces = np.zeros((worlds, team))
    for w in range(worlds):
        problem = columns[w], wrench[w], bias[w], limit[w], ridge
        size = abs(wrench[w, 0]) + abs(wrench[w, 1]) + abs(wrench[w, 2])
        for a in range(team):
            size += abs(bias[w, a])
        z = (0.0, 0.0, 0.0)
        value, gradient, matrix = _dual(problem, z)
        for _ in range(STEPS):
            if math.sqrt(_dot(gradient, gradient)) <= EXACT * size:
                break
            step, length = _solved(matrix, gradient), 1.0
            while length > SHORTEST:
                trial = z[0] - length * step[0], z[1] - length * step[1], z[2] - length * step[2]
                after, trial_gradient, trial_matrix = _dual(problem, trial)
                # The dual is convex: a step that has not passed its least value makes it smaller.
                if after < value or _dot(trial_gradient, step) >= 0.0:
                    break
                length /= 2
            z, value, gradient, matrix = trial, after, trial_gradient, trial_matrix
        for a in range(team):
            free = bias[w, a] + _dot(columns[w, a], z) / ridge
            forces[w, a] = min(max(free, 0.0), limit[w, a])
    return forces


@compiled
def _dot(one: Vector, other: Vector) -> float:
    return one[0] * other[0] + one[1] * other[1] + one[2] * other[2]


@compiled
def _dual(problem: Any, z: Vector) -> tuple[float, Vector, Symmetric]:
    """Returns value, gradient and second derivatives of the dual at z, see ``share``."""
    columns, wrench, bias, limit, ridge = problem
    value = 0.5 * _dot(z, z) - _dot(wrench, z)
    x, y, m = z[0] - wrench[0], z[1] - wrench[1], z[2] - wrench[2]
    xx, yy, mm, xy, xm, ym = 1.0, 1.0, 1.0, 0.0, 0.0, 0.0
    for a in range(len(bias)):
        g0, g1, g2 = columns[a, 0], columns[a, 1], columns[a, 2]
        free = bias[a] + (g0 * z[0] + g1 * z[1] + g2 * z[2]) / ridge
        force = min(max(free, 0.0), limit[a])
        value += ridge * force * (free - 0.5 * force)
        x, y, m = x + force * g0, y + force * g1, m + force * g2
        if 0.0 < free < limit[a]:
            xx, yy, mm = xx + g0 * g0 / ridge, yy + g1 * g1 / ridge, mm + g2 * g2 / ridge
            xy, xm, ym = xy + g0 * g1 / ridge, xm + g0 * g2 / ridge, ym + g1 * g2 / ridge
    return value, (x, y, m), (xx, yy, mm, xy, xm, ym)


@compiled
def _solved(matrix: Symmetric, right: Vector) -> Vector:
    """Returns the solution of three linear equations, positive definite, by Cholesky."""
    xx, yy, mm, xy, xm, ym = matrix
    a = math.sqrt(xx)
    b, c = xy / a, xm / a
    d = math.sqrt(yy - b * b)
    e = (ym - b * c) / d
    f = math.sqrt(mm - c * c - e * e)
    x = right[0] / a
    y = (right[1] - b * x) / d
    m = (right[2] - c * x - e * y) / f / f
    y = (y - e * m) / d
    return (x - b * y - c * m) / a, y, m
