"""Records of an episode: its row, the poses of its hulls, and its trajectory."""

import math
from dataclasses import dataclass, fields
from typing import Any

from asv_env.checks import FunctionError, called
from asv_env.params import EnvParams
from asv_env.text import one_line, shown
from asv_env.types import Action, Bool, Float, Observation
from baselines.paper import dubins

POSE_LOG_EVERY = 2  #: control ticks between two poses of a log


@dataclass(frozen=True)
class Label:
    """Names the run to which a row belongs."""

    policy: str
    training_seed: int | None = None  #: number of its training; None where there is one or none
    condition: str = ""  #: name of the condition in its suite
    scenario: str = "nominal"


@dataclass(frozen=True)
class Episode:
    """One row of ``episodes.csv``; None where a column does not apply."""

    seed: int
    policy: str
    training_seed: int | None
    condition: str
    task: str
    scenario: str
    num_boats: int  #: team size
    success: bool  #: whether the task was done in time
    cause: str | None  #: cause of a failure; see ``CAUSES``
    goal_x: float | None  #: x of the goal in the vessel's initial frame, m
    goal_y: float | None  #: y of the goal in that frame, m
    goal_heading: float | None  #: heading of the goal in that frame, rad
    position_error: float | None  #: distance of the vessel from its goal at the end, m
    heading_error: float | None  #: signed heading error of the vessel at the end, rad
    min_position_error: float | None  #: smallest distance of the vessel from its goal, m
    heading_error_at_min: float | None  #: signed heading error at that instant, rad
    time_to_closure: float | None  #: time until all slots were occupied, s
    closure_spread: float | None  #: time from the first boat in its slot to the last, s
    time_to_goal: float | None  #: time until the delivery, s
    duration: float  #: duration of the episode, s
    path_length_ratio: float | None  #: path length of the vessel over that of the Dubins path
    effort: float  #: seconds of full thrust, averaged over the motors
    #: number of times that a boat began to touch another one, or any hull an obstacle or a wall
    collisions: int
    closure_lost: int  #: number of times that closure was lost
    episode_return: float  #: sum of the team's mean reward
    error: str | None  #: what was wrong with the policy, where that ended the episode


COLUMNS = tuple(f.name for f in fields(Episode))
CAUSES = (
    *("policy error", "strayed", "no closure", "grasp not held"),
    *("never near", "heading off", "not settled"),
)
"""Causes of failure of the built-in tasks, each excluding those before it: the policy raised or
gave no usable action; a body left the arena; closure was never formed, nor did the vessel come near
its goal without; the slots were not occupied for long enough (Approach); the vessel never came
within the position tolerance; its heading was off when it was nearest; it was there, but too fast,
or left before it was delivered."""


@dataclass(frozen=True)
class Trajectory:
    """One episode of T steps, with A boats, B = 1 + A bodies (the vessel first) and K features."""

    observation: Observation  #: (T + 1, A, K) float32 of each boat, the last at the end
    action: Action  #: (T, A, 2) float32 in [-1, 1]
    reward: Float  #: (T, A), float32 in files
    motion: Float  #: (T + 1, B, 6) true x, y m, heading rad, vx, vy m/s, yaw rate rad/s
    working: Bool  #: (T + 1, A) whether a boat's thrusters work
    goal: Float  #: (T + 1, 3) m, m, rad
    obstacle: Float  #: (M, 5) obstacles, as in ``asv_env.types.State``
    terminated: bool  #: whether success or straying ended the episode, not the time limit


@dataclass(frozen=True)
class PoseLog:
    """Poses of the hulls in an episode, every ``POSE_LOG_EVERY`` control ticks and at the end."""

    episode: Episode
    poses: Float  #: (T, B, 3) x m, y m, heading rad, the vessel first
    goal: Float  #: (3,) pose, m, m, rad
    failed_at: Float  #: (A,) time at which a boat's thrusters died, s; inf never
    obstacle: Float  #: (M, 5) obstacles, as in ``asv_env.types.State``
    boat_size: Float  #: (A,) factor on the lengths of each boat
    trajectory: Trajectory | None = None  #: all steps, where they are recorded


def _cause(ended: dict[str, Any], params: EnvParams) -> str:
    """Returns why an episode failed, in the words of the task, which may be a user's."""
    task = params.definition
    cause = called("cause of task", task.name, task.cause, ended, params)
    if not isinstance(cause, str) or not cause:
        raise FunctionError(f"cause of task {task.name!r} returned {shown(cause)}: must be a text")
    return one_line(cause)


def row(
    label: Label, params: EnvParams, ended: dict[str, Any], goal: Float, side: float
) -> Episode:
    """Returns the row of an episode.

    ``ended`` holds its ``metrics.summary``, its ``seed``, ``duration``, s, and ``error``. ``goal``
    is (3,) m, m, rad, ``side`` +1.0 or -1.0, the side of the vessel that was pushed.
    """
    error, definition = ended["error"], params.definition
    relative = goal if side > 0 else goal * (1.0, -1.0, -1.0)
    shortest = float(dubins.length(relative, params.vessel.size / 2))
    success = ended["is_success"] and error is None
    cause = None if success else "policy error" if error else _cause(ended, params)
    values: dict[str, Any] = {
        **ended,
        **vars(label),
        "task": definition.name,
        "num_boats": params.num_boats,
        "success": success,
        "cause": cause,
        **dict(zip(("goal_x", "goal_y", "goal_heading"), goal.tolist(), strict=True)),
        "path_length_ratio": ended["path_length"] / shortest if shortest > 0 else None,
    }
    for column in COLUMNS:
        value = values[column]
        if column in definition.not_applicable or (isinstance(value, float) and math.isinf(value)):
            values[column] = None
    return Episode(**{column: values[column] for column in COLUMNS})
