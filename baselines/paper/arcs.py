"""Paths of circular arcs and straights, driven by a vessel that is pushed along -n."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asv_env.geometry import direction, wrap, xy
from asv_env.types import Complex, Float
from baselines.paper.inputs import finite, finite_poses, not_negative


def advance(pose: ArrayLike, curvature: ArrayLike, distance: ArrayLike) -> Float:
    """Returns the poses (..., 3) m, m, rad after driving arcs of (...) m, heading not wrapped.

    The curvature (...) 1/m is the heading rate dh/ds; 0 is straight along -n = (sin h, -cos h).
    """
    pose = np.asarray(pose, dtype=np.float64)
    turn = np.multiply(curvature, distance, dtype=np.float64)
    displacement = _chord(pose[..., 2], turn, distance)
    x, y = pose[..., 0] + displacement.real, pose[..., 1] + displacement.imag
    return np.stack(np.broadcast_arrays(x, y, pose[..., 2] + turn), axis=-1)


def _chord(heading: Float, turn: Float, length: ArrayLike) -> Complex:
    """Chord (...) m of an arc, along the mean of the tangents at its ends, -n = -i exp(ih)."""
    return length * np.sinc(turn / (2 * np.pi)) * -1j * direction(heading + turn / 2)


@dataclass(frozen=True, eq=False)
class ArcPath:
    """A path of n segments of constant curvature, for any number of vessels.

    The heading h is the vessel's own; it moves along -n, n = (-sin h, cos h), as boats on its +n
    side push it. Curvature = 1/rho, where rho is the signed distance of the circle's centre from
    the vessel's centre along the vessel's own +x axis (C_x in the paper), so dh/ds = curvature.
    Only forward motion can be expressed: a path is always legal to push.

    Raises:
        ValueError: a number is not finite, a length is negative, or the shapes do not fit.
    """

    start: Float  #: (..., 3) m, m, rad
    curvature: Float  #: (..., n) 1/m, signed; 0 is straight
    length: Float  #: (..., n) m, >= 0

    def __post_init__(self) -> None:
        start = finite_poses("start", self.start)
        curvature, length = finite("curvature", self.curvature), not_negative("length", self.length)
        if not all(array.shape[-1:] > (0,) for array in (curvature, length)):
            raise ValueError(
                "curvature and length must have a last axis of one segment or more, got shapes "
                f"{curvature.shape} and {length.shape}"
            )
        curvature, length = np.broadcast_arrays(curvature, length)
        batch = np.broadcast_shapes(start.shape[:-1], length.shape[:-1])
        for name, array in (("start", start), ("curvature", curvature), ("length", length)):
            object.__setattr__(self, name, np.broadcast_to(array, batch + array.shape[-1:]))

    def __getitem__(self, index: Any) -> Self:
        """Selects along the leading axes, e.g. the paths of some worlds."""
        index = index if isinstance(index, tuple) else (index,)
        if any(i is Ellipsis for i in index):
            raise ValueError("index the leading axes only, without an ellipsis")
        return type(self)(self.start[index], self.curvature[index], self.length[index])

    @property
    def total_length(self) -> Float:
        """Length (...) m of each path."""
        return self.length.sum(axis=-1)

    @property
    def turn(self) -> Float:
        """Signed change of heading (..., n) rad over each segment (the paper's alpha_k)."""
        return self.curvature * self.length

    @property
    def joints(self) -> Float:
        """Poses (..., n + 1, 3) at the start, between the segments and at the end."""
        before = self.start[..., 2:] + np.cumsum(self.turn, axis=-1) - self.turn
        chords = _chord(before, self.turn, self.length)
        steps = np.stack([chords.real, chords.imag, self.turn], axis=-1)
        joints = np.cumsum(np.concatenate([self.start[..., None, :], steps], axis=-2), axis=-2)
        joints[..., 2] = wrap(joints[..., 2])
        return joints

    @property
    def end(self) -> Float:
        """Last pose (..., 3) m, m, rad, heading in (-pi, pi]."""
        return self.joints[..., -1, :]

    @property
    def centres(self) -> Float:
        """Centres (..., n, 2) m of the circles; both coordinates are inf where straight."""
        straight = np.abs(self.curvature) < np.finfo(np.float64).tiny
        radius = 1 / np.where(straight, 1.0, self.curvature)
        poses = self.joints[..., :-1, :]
        centres = poses[..., :2] + radius[..., None] * xy(direction(poses[..., 2]))
        return np.where(straight[..., None], np.inf, centres)

    def pose_at(self, s: ArrayLike) -> Float:
        """Returns the poses (..., 3) m, m, rad at the distances s (...) m, clipped to the path.

        s broadcasts against the leading axes as NumPy does: for 20 distances on each of 256
        paths, s (20, 256), or s (256, 20) on `path[:, None]`.
        """
        s = np.clip(self._distances(s), 0.0, self.total_length)
        here = self._segments.take(self._flat_segment_at(s), axis=0)
        pose = advance(here[..., :3], here[..., 3], s - here[..., 4])
        pose[..., 2] = wrap(pose[..., 2])
        return pose

    def segment_at(self, s: ArrayLike) -> NDArray[np.intp]:
        """Returns the segment (...) at the distance s (...) m; a joint belongs to the next one."""
        s = self._distances(s)
        joints = np.moveaxis(np.cumsum(self.length[..., :-1], axis=-1), -1, 0)
        return sum((s >= joint for joint in joints), np.zeros(s.shape, dtype=np.intp))

    def curvature_at(self, s: ArrayLike) -> Float:
        """Returns the curvature (...) 1/m at the distance s (...) m; see `segment_at`."""
        return self.curvature.take(self._flat_segment_at(s))

    @cached_property
    def _segments(self) -> Float:
        """Rows, one a segment of all paths: first pose, curvature, path length before it in m."""
        begin = np.cumsum(self.length, axis=-1) - self.length
        columns = [self.joints[..., :-1, :], self.curvature[..., None], begin[..., None]]
        return np.concatenate(columns, axis=-1).reshape(-1, 5)

    def _flat_segment_at(self, s: ArrayLike) -> NDArray[np.intp]:
        """Returns `segment_at`, counted over the segments of all paths (...)."""
        first = np.arange(0, self.length.size, self.length.shape[-1])
        return first.reshape(self.length.shape[:-1]) + self.segment_at(s)

    def _distances(self, s: ArrayLike) -> Float:
        s, batch = finite("s", s), self.length.shape[:-1]
        try:
            np.broadcast_shapes(s.shape, batch)
        except ValueError as error:
            raise ValueError(
                f"s of shape {s.shape} does not broadcast with paths of shape {batch}: put the "
                "axis of the distances first, or index the paths with path[:, None]"
            ) from error
        return s


def pick(paths: ArcPath, index: ArrayLike) -> ArcPath:
    """Chooses one path along the first axis of `paths` (m, ...) for each entry of `index` (...)."""
    chosen = np.asarray(index)[None, ..., None]
    arrays = (paths.start, paths.curvature, paths.length)
    return ArcPath(*(np.take_along_axis(array, chosen, axis=0)[0] for array in arrays))
