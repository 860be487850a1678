"""One episode of one policy as the page holds it: its outcome, and its poses as text."""

import base64
import math
import zlib
from typing import Any

import numpy as np

from asv_env.params import EnvParams
from asv_env.types import Float
from baselines.evaluate.tables import formats
from baselines.rollout.episodes import POSE_LOG_EVERY, Episode, PoseLog

RATE = 2.5
"""Approximate number of poses a second that are kept; those between are interpolated."""
UNITS = (1e-3, 1e-3, 1e-3)
"""Resolution of the poses: m, m, rad."""


def take(params: EnvParams, log: PoseLog) -> dict[str, Any]:
    """Returns the data of one episode of one policy."""
    row, poses = log.episode, thinned(params, log.poses)
    has_goal = params.definition.has_goal
    return {
        "success": row.success,
        "verdict": verdict(row, has_goal),
        "outcome": outcome(row, has_goal),
        "end": row.duration,
        "closure": row.time_to_closure,
        "goal": [round(x, 4) for x in log.goal.tolist()] if has_goal else None,
        "failures": [time if math.isfinite(time) else None for time in log.failed_at.tolist()],
        "frames": len(poses),
        "poses": pack(poses),
    }


def thinned(params: EnvParams, poses: Float) -> Float:
    """Returns every so many poses (T, B, 3) of a log, and the last one, of the episode's end."""
    return np.concatenate([poses[:-1][:: _stride(params)], poses[-1:]])


def interval(params: EnvParams) -> float:
    """Returns the time between two poses that are kept, s."""
    return _stride(params) * POSE_LOG_EVERY / params.clock.control


def _stride(params: EnvParams) -> int:
    return max(1, round(params.clock.control / POSE_LOG_EVERY / RATE))


def pack(poses: Float) -> str:
    """Returns poses (T, B, 3) as text.

    They are whole multiples of ``UNITS``, body by body and axis by axis. Hulls move steadily, so
    second differences in time are small; signs are folded in (0, -1, 1, -2 ... become 0, 1, 2,
    3 ...). All low bytes come first, then all high ones, compressed, in base 64.
    """
    steady = np.concatenate([poses[..., :2], np.unwrap(poses[..., 2:], axis=0)], axis=-1)
    whole = np.moveaxis(np.round(steady / UNITS).astype(np.int64), 0, -1)
    second = np.diff(np.diff(whole, prepend=0), prepend=0)
    unsigned = ((second << 1) ^ (second >> 63)).astype("<u2")
    planes = unsigned.reshape(-1, 1).view(np.uint8).T
    return base64.b64encode(zlib.compress(planes.tobytes(), 9)).decode()


def verdict(row: Episode, has_goal: bool) -> str:
    """Returns how an episode ended, in a few words."""
    if row.success:
        return "delivered" if has_goal else "slots held"
    return f"failed: {row.cause}"


def outcome(row: Episode, has_goal: bool) -> str:
    """Returns how an episode ended, with its time and errors."""
    if row.error is not None:
        return f"policy error: {row.error}"
    text = verdict(row, has_goal)
    if row.success:
        text += f" after {formats.quantity(row.duration, 's')} s"
        if row.position_error is not None:
            near = formats.quantity(row.position_error, "cm", 100)
            text += f", {near} cm and {formats.quantity(row.heading_error, 'rad')} rad off"
    elif row.min_position_error is not None:
        text += f"; at its nearest {formats.quantity(row.min_position_error, 'cm', 100)} cm away"
    return text
