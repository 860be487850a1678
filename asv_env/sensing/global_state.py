"""The global state, for centralised critics: one vector for each world, in the world frame.

It holds the truth, not the measurement. Lengths are divided by the half-width of the arena,
speeds by those of a full tracking action, thrust by that of a motor; headings are given as
cosine and sine.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from asv_env.geometry import direction, xy
from asv_env.params import EnvParams
from asv_env.params.obstacle_params import grouping
from asv_env.sensing.nearest_obstacles import OBSTACLES, OF_OBSTACLE, fill_obstacles
from asv_env.tasks.termination import delivery_ticks, hold_ticks
from asv_env.types import Bool, Float, Observation, State, given

REACH = 1.5  #: bound of positions, arena half-widths: hulls may hang over the arena's edge
FASTEST = 4.0  #: bound of velocities, full tracking actions
POSE_BOUND = (REACH, REACH, 1.0, 1.0)
FLAGS = (1.0,) * 6
MOTION_BOUND = (*POSE_BOUND, FASTEST, FASTEST, FASTEST)


@dataclass(frozen=True)
class Part:
    """A part of the global state."""

    name: str  #: what it describes
    bound: tuple[float, ...]  #: largest magnitude of each of its values, which are clipped to it
    values: Callable[[State, EnvParams], Float | Bool]  #: to (W, n, values), scaled
    per_boat: bool = False  #: whether n is the number of boats, not 1


def _pose(pose: Float, params: EnvParams) -> list[Float]:
    e = direction(pose[..., 2])
    arena = params.task.arena
    return [pose[..., 0] / arena, pose[..., 1] / arena, e.real, e.imag]


def _motion(motion: Float, params: EnvParams) -> Float:
    boat = params.boat
    velocity = [motion[..., 3] / boat.full_speed, motion[..., 4] / boat.full_speed]
    turning = motion[..., 5] / boat.full_yaw_rate
    return np.stack([*_pose(motion, params), *velocity, turning], axis=-1)


def _task(state: State, params: EnvParams) -> Float:
    occupied = state.occupied_ticks / hold_ticks(params)
    delivered = state.delivered_ticks / delivery_ticks(params)
    flags = [state.side, state.closed, state.aground, state.anchored, occupied, delivered]
    return np.stack(flags, axis=-1)[:, None]


def _thrust(state: State, params: EnvParams) -> Float:
    return state.thrust / (params.boat.thrust * params.variation.largest_thrust)


def _obstacles(state: State, params: EnvParams) -> Float:
    """Returns the nearest obstacles (W, 1, n) to the vessels, in their frames."""
    found = np.zeros((len(state.goal), len(OF_OBSTACLE) * OBSTACLES))
    known = given(state.obstacle), grouping(params).groups
    fill_obstacles(*known, given(state.motion[:, 0]), found)
    arena = params.task.arena
    scaled: Float = found / np.tile((arena, arena, 1.0), OBSTACLES)
    return scaled[:, None]


PARTS = (
    Part("motion of the vessel", MOTION_BOUND, lambda s, p: _motion(s.motion[:, :1], p)),
    Part("goal", POSE_BOUND, lambda s, p: np.stack(_pose(s.goal[:, None], p), axis=-1)),
    Part("side, closure, aground, goal final, fractions of hold and delivery time", FLAGS, _task),
    # The nearest points of the nearest obstacles in the vessel's frame, each with a flag.
    Part("obstacles", (2 * REACH, 2 * REACH, 1.0) * OBSTACLES, _obstacles),
    Part("motion of the boats", MOTION_BOUND, lambda s, p: _motion(s.motion[:, 1:], p), True),
    # In the vessel's frame; the slot of a failed boat may lie anywhere in the arena.
    Part("slots", (2 * REACH, 2 * REACH), lambda s, p: xy(s.slot / p.task.arena), True),
    Part("thrust", (1.0, 1.0), _thrust, True),
    Part("touching the vessel, another hull", (1.0, 1.0), lambda s, p: s.touching, True),
    Part("thrusters work", (1.0,), lambda s, p: s.working[..., None], True),
)


def global_state_bound(num_boats: int) -> Observation:
    """Returns the largest magnitude (S,) of every value for a team, float32."""
    bounds = [np.tile(part.bound, num_boats if part.per_boat else 1) for part in PARTS]
    return np.concatenate(bounds).astype(np.float32)


def global_state(state: State, params: EnvParams) -> Observation:
    """Returns the global state (W, S) of every world, float32, within +-``global_state_bound``.

    First come the vessel, the goal and the task, then each part that has values for all boats.
    """
    parts = [part.values(state, params).reshape(len(state.goal), -1) for part in PARTS]
    values = np.concatenate(parts, axis=1, dtype=np.float32)
    bound = global_state_bound(params.num_boats)
    return np.clip(values, -bound, bound)
