"""Paths of circular arcs and straights, driven by a vessel that is pushed along -n."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asv_env.geometry import wrap
from asv_env.types import Float

Array = Float


def finite(name: str, value: ArrayLike) -> Array:
    """Return `value` as float64 array; ValueError if an element is NaN or infinite."""
    array = np.asarray(value, dtype=np.float64)
    bad = array[~np.isfinite(array)]
    if bad.size:
        raise ValueError(f"{name} must be finite, got {bad[0]}: replace NaN and infinity")
    return array


def positive(name: str, value: ArrayLike) -> Array:
    """Return `value` as float64 array; ValueError unless every element is finite and > 0."""
    array = finite(name, value)
    bad = array[array <= 0]
    if bad.size:
        raise ValueError(f"{name} must be positive, got {bad[0]}: use a value above 0")
    return array


def finite_poses(name: str, value: ArrayLike) -> Array:
    """Return `value` as finite poses (..., 3): x m, y m, heading rad."""
    array = finite(name, value)
    if array.ndim == 0 or array.shape[-1] != 3:
        raise ValueError(f"{name} must have shape (..., 3) as x, y, heading, got {array.shape}")
    return array


def advance(pose: ArrayLike, curvature: ArrayLike, distance: ArrayLike) -> Array:
    """Drive a vessel along one arc.

    The chord of an arc points along the mean of its two tangents, which needs no division by the
    curvature and so has no singular case.

    Args:
        pose: (..., 3) m, m, rad.
        curvature: (...) 1/m, heading rate dh/ds; 0 is straight along -n = (sin h, -cos h).
        distance: (...) m.

    Returns:
        (..., 3) pose after the arc, heading not wrapped.
    """
    pose, distance = np.asarray(pose, dtype=np.float64), np.asarray(distance, dtype=np.float64)
    half_turn = 0.5 * np.asarray(curvature) * distance
    chord = distance * np.sinc(half_turn / np.pi)
    middle = pose[..., 2] + half_turn
    x = pose[..., 0] + chord * np.sin(middle)
    y = pose[..., 1] - chord * np.cos(middle)
    return np.stack(np.broadcast_arrays(x, y, middle + half_turn), axis=-1)


@dataclass(frozen=True, eq=False)
class ArcPath:
    """A path of n segments of constant curvature, for any number of vessels.

    The pose heading h is the vessel's; it moves along -n, n = (-sin h, cos h), as boats on its +n
    side push it. Curvature = 1/rho, where rho is the signed distance of the circle's centre from
    the vessel's centre along the vessel's own +x axis (C_x in the paper), so dh/ds = curvature.
    Only forward motion can be expressed: a path is always legal to push.

    Attributes:
        start: (..., 3) m, m, rad.
        curvature: (..., n) 1/m, signed; 0 is straight.
        length: (..., n) m, >= 0.

    Raises:
        ValueError: a number is not finite, a length is negative, or the shapes do not fit.
    """

    start: Array
    curvature: Array
    length: Array

    def __post_init__(self) -> None:
        start = finite_poses("start", self.start)
        curvature, length = finite("curvature", self.curvature), finite("length", self.length)
        if curvature.ndim == 0 or length.ndim == 0:
            raise ValueError("curvature and length must have a last axis of segments")
        if (length < 0).any():
            raise ValueError(
                f"length must not be negative, got {length.min()}: the vessel is only pushed ahead"
            )
        curvature, length = np.broadcast_arrays(curvature, length)
        batch = np.broadcast_shapes(start.shape[:-1], length.shape[:-1])
        for name, array in (("start", start), ("curvature", curvature), ("length", length)):
            object.__setattr__(self, name, np.broadcast_to(array, batch + array.shape[-1:]))

    def __getitem__(self, index: Any) -> ArcPath:
        """Select along the leading axes, e.g. the paths of some worlds."""
        index = index if isinstance(index, tuple) else (index,)
        if any(i is Ellipsis for i in index):
            raise ValueError("index the leading axes only, without an ellipsis")
        return ArcPath(self.start[index], self.curvature[index], self.length[index])

    @property
    def total_length(self) -> Array:
        """(...) m."""
        total: Array = self.length.sum(axis=-1)
        return total

    @property
    def turn(self) -> Array:
        """(..., n) rad: signed change of heading over each segment (the paper's alpha_k)."""
        return self.curvature * self.length

    @property
    def joints(self) -> Array:
        """(..., n + 1, 3): poses at the start, between the segments and at the end."""
        poses = [self.start]
        for k in range(self.length.shape[-1]):
            poses.append(advance(poses[-1], self.curvature[..., k], self.length[..., k]))
        joints = np.stack(poses, axis=-2)
        joints[..., 2] = wrap(joints[..., 2])
        return joints

    @property
    def end(self) -> Array:
        """(..., 3) m, m, rad: the last pose, heading in (-pi, pi]."""
        return self.joints[..., -1, :]

    @property
    def centres(self) -> Array:
        """(..., n, 2) m: centres of the circles; both coordinates inf where straight."""
        straight = self.curvature == 0
        radius = 1 / np.where(straight, 1.0, self.curvature)
        poses = self.joints[..., :-1, :]
        heading = poses[..., 2]
        axis = np.stack([np.cos(heading), np.sin(heading)], axis=-1)
        centres = poses[..., :2] + radius[..., None] * axis
        return np.where(straight[..., None], np.inf, centres)

    def pose_at(self, s: ArrayLike) -> Array:
        """(..., 3) m, m, rad: pose after the distance s (...) m, held within the path."""
        left = np.clip(finite("s", s), 0.0, self.total_length)
        pose = self.start
        for k in range(self.length.shape[-1]):
            step = np.minimum(left, self.length[..., k])
            pose = advance(pose, self.curvature[..., k], step)
            left = left - step
        return np.concatenate([pose[..., :2], wrap(pose[..., 2:])], axis=-1)

    def segment_at(self, s: ArrayLike) -> NDArray[np.intp]:
        """(...): index of the segment at the distance s (...) m; a joint belongs to the next."""
        joints = np.cumsum(self.length, axis=-1)[..., :-1]
        segment: NDArray[np.intp] = (finite("s", s)[..., None] >= joints).sum(axis=-1)
        return segment

    def curvature_at(self, s: ArrayLike) -> Array:
        """(...) 1/m: curvature at the distance s (...) m; a joint belongs to the next segment."""
        segment = self.segment_at(s)[..., None]
        curvature = np.broadcast_to(self.curvature, segment.shape[:-1] + self.curvature.shape[-1:])
        return np.take_along_axis(curvature, segment, axis=-1)[..., 0]


def pick(paths: ArcPath, index: ArrayLike) -> ArcPath:
    """Choose one path along the first axis of `paths` (m, ...) for each entry of `index` (...)."""
    chosen = np.asarray(index)[None, ..., None]

    start, curvature, length = (
        np.take_along_axis(array, chosen, axis=0)[0]
        for array in (paths.start, paths.curvature, paths.length)
    )
    return ArcPath(start, curvature, length)
