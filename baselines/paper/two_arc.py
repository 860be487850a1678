"""Two circular arcs that carry the vessel to a pose: Eqs (9)-(15), in a form without poles.

An arc that turns the vessel by alpha_k displaces it by a chord c_k along e(t) = (sin t, -cos t),
t being the mean of the headings at its ends, and c_k = 2 rho_k sin(alpha_k / 2). Eqs (9)-(12) then
are alpha_1 + alpha_2 = h_f and goal = c_1 e(alpha_1/2) + c_2 e(alpha_1 + alpha_2/2), whose
solution is Eq (13).

Corrections to the printed equations: in Eq (12) the normal is (0, 1), not (1, 0). In Eqs (14) and
(15) the test is inverted and "- 2 pi" holds for positive angles only: motion along -n needs
alpha_k rho_k > 0, and otherwise alpha_k becomes alpha_k - 2 pi sign(alpha_k). With |alpha_k| <= pi
that is the case exactly where the chord c_k is negative.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asv_env.geometry import wrap
from asv_env.types import Float
from baselines.paper.arcs import ArcPath, pick
from baselines.paper.inputs import finite, finite_poses, positive

ROUNDING = 1e-12  #: relative; below it lengths and angles are rounding errors
SPOT_RADIUS = 1e-12  #: m, stands for radius 0
LEAST_DETOUR_TURN = 1e-9  #: rad, where the limit of an infinite detour is cut off
TOLERANCE = 1e-9  #: relative on radii, and rad on turns too small to count


def plan(goal: ArrayLike, alpha1: ArrayLike) -> ArcPath:
    """Two-arc path from (0, 0, 0) to `goal` whose first arc turns by `alpha1` (Eqs 9-15).

    The goal is (..., 3) m, m, rad; alpha1 (...) rad may be on any branch. Never refuses a radius;
    see `feasible`. Singular cases:
    alpha1 = 0 or alpha1 = h_f: that arc is a straight. Where it would have to be driven
    backwards, the limit (a full turn of infinite radius) is cut off at a remaining turn of 1e-9
    rad: finite, and far too long to use.
    h_f = 0: only alpha1 = 2 atan2(x_f, -y_f) reaches the goal; both arcs then share one radius.
    x_f = y_f = 0: a turn on the spot, given the radius 1e-12 m.

    The end is on the goal to the rounding error of the path's total length.

    Raises:
        ValueError: a number is not finite, or h_f = 0 and alpha1 is another than the one above.
    """
    goal, alpha1 = finite_poses("goal", goal), wrap(finite("alpha1", alpha1))
    alpha2 = wrap(goal[..., 2] - alpha1)
    e1, e2 = _chord_directions(alpha1, alpha2)
    determinant = _cross(e1, e2)
    parallel = np.abs(determinant) < ROUNDING
    distance = np.hypot(goal[..., 0], goal[..., 1])
    missed = parallel & (np.abs(_cross(goal, e1)) > ROUNDING * distance)
    if missed.any():
        wrong = np.broadcast_to(alpha1, missed.shape)[missed][0]
        x, y, _ = np.broadcast_to(goal, (*missed.shape, 3))[missed][0]
        raise ValueError(
            f"alpha1 = {wrong} cannot reach the goal ({x}, {y}) with unchanged heading: only "
            f"alpha1 = 2 atan2(x_f, -y_f) = {2 * np.arctan2(x, -y)} can"
        )
    # Equal halves give both arcs of the one-parameter family at h_f = 0 the same, largest radius.
    half = 0.5 * _dot(goal, e1)
    safe = np.where(parallel, 1.0, determinant)
    chord1 = np.where(parallel, half, _cross(goal, e2) / safe)
    chord2 = np.where(parallel, half, _cross(e1, goal) / safe)
    return _path(alpha1, chord1, alpha2, chord2, distance)


def shortest(goal: ArrayLike, min_radius: ArrayLike) -> ArcPath:
    """Shortest two-arc path from (0, 0, 0) to `goal` (..., 3) and radii of at least `min_radius`.

    At the optimum one of the two radii is the minimal one, so four values of alpha1 need testing
    (observed, not proved: docs/paper.md; the paper fixes alpha1 = 1 instead, which suits its own
    goal only). Where none of the four is feasible (goals near the start pose), the one
    with the largest smaller radius is returned: it ends on the goal, and `feasible` is False. A
    goal at the start pose gives a path of length zero.

    Raises:
        ValueError: a number is not finite, or min_radius <= 0.
    """
    goal, min_radius = finite_poses("goal", goal), positive("min_radius", min_radius)
    paths = _candidates(goal, min_radius)
    allowed = feasible(paths, min_radius)
    best = np.argmin(np.where(allowed, paths.total_length, np.inf), axis=0)
    widest = np.argmin(_tightness(paths).max(axis=-1), axis=0)
    return pick(paths, np.where(allowed.any(axis=0), best, widest))


def feasible(path: ArcPath, min_radius: ArrayLike) -> NDArray[np.bool_]:
    """Whether (...) the vessel stays under conditional closure along `path`.

    Boats on its +n side can turn the vessel only about points outside it, so every radius must be
    at least half its length, `min_radius` (...) m; turns below 1e-9 rad do not count. A segment of
    a full turn stands for a straight that would have to be driven backwards (see `plan`), which
    they cannot do.
    """
    least = positive("min_radius", min_radius)[..., None] * (1 - TOLERANCE)
    backwards = np.abs(path.turn) >= 2 * np.pi - 2 * LEAST_DETOUR_TURN  # cut off by `_path`
    return ~np.any((_tightness(path) * least > 1) | backwards, axis=-1)


def _tightness(path: ArcPath) -> Float:
    """Absolute curvature (..., n) 1/m; 0 where the segment hardly turns."""
    return np.where(np.abs(path.turn) > TOLERANCE, np.abs(path.curvature), 0.0)


def _candidates(goal: Float, min_radius: Float) -> ArcPath:
    """Paths (4, ...): one radius is +-min_radius, the other follows from the rest of the goal."""
    x, y, heading = np.moveaxis(goal, -1, 0)
    scale = np.hypot(x, y) + min_radius
    radius = np.multiply.outer([1.0, -1.0], np.broadcast_to(min_radius, scale.shape))
    cos, sin = np.cos(heading / 2), np.sin(heading / 2)
    firsts = _double_angle(x * cos + y * sin, x * sin - y * cos - 2 * radius * sin, scale)
    seconds = _double_angle(radius * (1 - np.cos(heading)) - x, y + radius * np.sin(heading), scale)
    alpha1 = np.concatenate(np.broadcast_arrays(firsts, seconds))
    alpha2 = wrap(heading - alpha1)
    e1, e2 = _chord_directions(alpha1, alpha2)
    known = 2 * radius * np.sin(alpha1[:2] / 2), 2 * radius * np.sin(alpha2[2:] / 2)
    rest2 = _dot(goal[..., :2] - known[0][..., None] * e1[:2], e2[:2])
    rest1 = _dot(goal[..., :2] - known[1][..., None] * e2[2:], e1[2:])
    chord1, chord2 = np.concatenate([known[0], rest1]), np.concatenate([rest2, known[1]])
    return _path(alpha1, chord1, alpha2, chord2, scale)


def _double_angle(sine: Float, cosine: Float, scale: Float) -> Float:
    """2 atan2, or 0 where both arguments vanish: one arc then does all, and alpha1 is free."""
    vanishing = np.hypot(sine, cosine) <= ROUNDING * scale
    return np.where(vanishing, 0.0, wrap(2 * np.arctan2(sine, cosine)))


def _path(alpha1: Float, chord1: Float, alpha2: Float, chord2: Float, scale: Float) -> ArcPath:
    """Path of forward arcs; a chord < 0: the other way round (Eqs 14-15, corrected)."""
    turn = np.stack(np.broadcast_arrays(alpha1, alpha2), axis=-1)
    chord = np.stack(np.broadcast_arrays(chord1, chord2), axis=-1)
    rounding = np.maximum(ROUNDING * scale[..., None], SPOT_RADIUS)
    chord = np.where(np.abs(chord) <= rounding, 0.0, chord)
    backwards = chord < 0
    size = np.where(backwards, np.maximum(np.abs(turn), LEAST_DETOUR_TURN), np.abs(turn))
    straight = size <= ROUNDING
    size, sign = np.where(straight, 0.0, size), np.where(turn < 0, -1.0, 1.0)
    chord = np.where((chord == 0) & ~straight, SPOT_RADIUS, chord)
    curvature = 2 * sign * np.sin(size / 2) / np.where(straight, 1.0, chord)
    swept = np.where(backwards, 2 * np.pi - size, size)
    length = np.where(straight, chord, swept / np.where(straight, 1.0, np.abs(curvature)))
    return ArcPath(np.zeros(3), curvature, length)


def _chord_directions(alpha1: Float, alpha2: Float) -> tuple[Float, Float]:
    def direction(angle: Float) -> Float:
        return np.stack([np.sin(angle), -np.cos(angle)], axis=-1)

    return direction(alpha1 / 2), direction(alpha1 + alpha2 / 2)


def _cross(a: Float, b: Float) -> Float:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def _dot(a: Float, b: Float) -> Float:
    return a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1]
