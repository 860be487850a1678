"""The global view for centralised critics: one vector a world, in the world's frame.

The truth, not what was measured. Lengths are divided by the half-width of the arena, speeds by
those of a full tracking action, thrust by that of a motor; headings come as cosine and sine.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from asv_env.geometry import direction
from asv_env.params import EnvParams
from asv_env.physics.autopilot import FULL_SPEED, FULL_YAW_RATE
from asv_env.types import Bool, Float, Observation, State

REACH = 1.5
"""Largest distance along an axis that the view tells, arena half-widths: hulls may overhang."""
FASTEST = 4.0
"""Largest speed that the view tells, full tracking actions."""
POSE_BOUND = (REACH, REACH, 1.0, 1.0)
MOTION_BOUND = (*POSE_BOUND, FASTEST, FASTEST, FASTEST)


@dataclass(frozen=True)
class Part:
    """A row of the table.

    Attributes:
        name: what is told.
        bound: to which the scaled values are clipped, on both sides; one for each value.
        of: (State, EnvParams) -> (W, n, values), scaled.
        of_boats: whether n is the number of boats; else it is 1.
    """

    name: str
    bound: tuple[float, ...]
    of: Callable[[State, EnvParams], Float | Bool]
    of_boats: bool = False


def _pose(pose: Float, params: EnvParams) -> list[Float]:
    e = direction(pose[..., 2])
    arena = params.task.arena
    return [pose[..., 0] / arena, pose[..., 1] / arena, e.real, e.imag]


def _goal(state: State, params: EnvParams) -> Float:
    return np.stack(_pose(state.goal[:, None], params), axis=-1)


def _motion(motion: Float, params: EnvParams) -> Float:
    velocity = [motion[..., 3] / FULL_SPEED, motion[..., 4] / FULL_SPEED]
    return np.stack([*_pose(motion, params), *velocity, motion[..., 5] / FULL_YAW_RATE], axis=-1)


def _slots(state: State, params: EnvParams) -> Float:
    """Slots in the vessel's frame; that of a failed boat may lie anywhere in the arena."""
    slot = state.slot / params.task.arena
    return np.stack([slot.real, slot.imag], axis=-1)


def _task(state: State, params: EnvParams) -> Float:
    ticks = max(1, round(params.task.hold_time * params.clock.control))
    flags = [state.side, state.closed, state.anchored, state.held / ticks]
    return np.stack(flags, axis=-1)[:, None]


PARTS = (
    Part("motion of the vessel", MOTION_BOUND, lambda s, p: _motion(s.motion[:, :1], p)),
    Part("goal", POSE_BOUND, _goal),
    Part("side, closure, goal final, share of the time that slots must be held", (1.0,) * 4, _task),
    Part("motion of the boats", MOTION_BOUND, lambda s, p: _motion(s.motion[:, 1:], p), True),
    Part("slots of the boats", (2 * REACH, 2 * REACH), _slots, True),
    Part(
        "thrust",
        (1.0, 1.0),
        lambda s, p: s.thrust / (p.boat.thrust * (1 + p.variation.thrust)),
        True,
    ),
    Part("touching the vessel, another hull", (1.0, 1.0), lambda s, p: s.touching, True),
    Part("thrusters work", (1.0,), lambda s, p: s.working[..., None], True),
)


def global_state_bound(num_boats: int) -> Observation:
    """Largest magnitude (S,) of every value of the view of a team, float32."""
    bounds = [np.tile(part.bound, num_boats if part.of_boats else 1) for part in PARTS]
    return np.concatenate(bounds).astype(np.float32)


def global_state_size(num_boats: int) -> int:
    """S, the number of values of the view of a team."""
    return len(global_state_bound(num_boats))


def global_state(state: State, params: EnvParams) -> Observation:
    """The view (W, S) of every world, float32, within +-``global_state_bound``.

    First the vessel, the goal and the task, then each of the parts of all the boats.

    Args:
        state: the truth.
        params: the environment's.
    """
    worlds = len(state.goal)
    parts = [part.of(state, params).reshape(worlds, -1) for part in PARTS]
    view = np.concatenate(parts, axis=1, dtype=np.float32)
    bound = global_state_bound(params.num_boats)
    return np.clip(view, -bound, bound)
