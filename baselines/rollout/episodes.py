"""Records of an episode: its row, the poses of its hulls, and its trajectory."""

import math
from dataclasses import dataclass, fields
from typing import Any

from asv_env.params import EnvParams
from asv_env.types import Action, Bool, Float, Observation
from baselines.paper import dubins

POSE_LOG_EVERY = 2
"""Control ticks between two poses of a log."""


@dataclass(frozen=True)
class Label:
    """Names the run to which a row belongs.

    Attributes:
        policy: name of the policy.
        training_seed: number of its training; None where there is one or none.
        condition: name of the condition in its suite.
        scenario: name of the scenario.
    """

    policy: str
    training_seed: int | None = None
    condition: str = ""
    scenario: str = "nominal"


@dataclass(frozen=True)
class Episode:
    """One row of ``episodes.csv``; None where a column does not apply.

    Attributes:
        seed: seed of the episode.
        policy: name of the policy.
        training_seed: number of the policy's training.
        condition: name of the condition in its suite.
        task: name of the task.
        scenario: name of the scenario.
        num_boats: team size.
        success: whether the task was done in time.
        cause: cause of a failure; see ``CAUSES``.
        goal_x: x of the goal in the vessel's initial frame, m.
        goal_y: y of the goal in that frame, m.
        goal_heading: heading of the goal in that frame, rad.
        position_error: distance of the vessel from its goal at the end, m.
        heading_error: signed heading error of the vessel at the end, rad.
        min_position_error: smallest distance of the vessel from its goal, m.
        heading_error_at_min: signed heading error at that instant, rad.
        time_to_closure: time until all slots were occupied, s.
        closure_spread: time from the first boat in its slot to the last, s.
        time_to_goal: time until the delivery, s.
        duration: duration of the episode, s.
        path_length_ratio: path length of the vessel over that of the Dubins path to the goal.
        effort: seconds of full thrust, averaged over the motors.
        collisions: number of times that a boat began to touch another one or a wall.
        closure_lost: number of times that closure was lost.
        episode_return: sum of the team's mean reward.
        error: what was wrong with the policy, where that ended the episode.
    """

    seed: int
    policy: str
    training_seed: int | None
    condition: str
    task: str
    scenario: str
    num_boats: int
    success: bool
    cause: str | None
    goal_x: float | None
    goal_y: float | None
    goal_heading: float | None
    position_error: float | None
    heading_error: float | None
    min_position_error: float | None
    heading_error_at_min: float | None
    time_to_closure: float | None
    closure_spread: float | None
    time_to_goal: float | None
    duration: float
    path_length_ratio: float | None
    effort: float
    collisions: int
    closure_lost: int
    episode_return: float
    error: str | None


COLUMNS = tuple(f.name for f in fields(Episode))
CAUSES = (
    *("policy error", "strayed", "no closure", "grasp not held"),
    *("never near", "heading off", "not settled"),
)
"""Causes of failure of the built-in tasks, each excluding those before it: the policy raised or
gave no usable action; a body left the arena; closure was never formed; the slots were not occupied
for long enough (Approach); the vessel never came within the position tolerance; its heading was
off when it was nearest; it was there, but not at rest."""


@dataclass(frozen=True)
class Trajectory:
    """One episode of T steps, step by step.

    Attributes:
        observation: (T + 1, A, K) float32, that at the end included.
        action: (T, A, 2) float32 in [-1, 1].
        reward: (T, A).
        motion: (T + 1, B, 6) true motion; see ``State``.
        working: (T + 1, A) whether a boat's thrusters work.
        goal: (T + 1, 3) m, m, rad.
        terminated: whether success or straying ended the episode, not the time limit.
    """

    observation: Observation
    action: Action
    reward: Float
    motion: Float
    working: Bool
    goal: Float
    terminated: bool


@dataclass(frozen=True)
class PoseLog:
    """The poses of the hulls in one episode.

    Attributes:
        episode: row of the episode.
        poses: (T, B, 3) x m, y m, heading rad, row 0 of B the vessel; one every
            ``POSE_LOG_EVERY`` control ticks, and the last.
        goal: (3,) pose, m, m, rad.
        failed_at: (A,) time at which a boat's thrusters died, s; inf never.
        trajectory: all steps, where they are recorded.
    """

    episode: Episode
    poses: Float
    goal: Float
    failed_at: Float
    trajectory: Trajectory | None = None


def row(
    seed: int,
    label: Label,
    params: EnvParams,
    ended: dict[str, Any],
    goal: Float,
    side: float,
    error: str | None,
) -> Episode:
    """Returns the row of an episode.

    Args:
        seed: seed of the episode.
        label: run to which it belongs.
        params: parameters of the environment.
        ended: its ``metrics.summary``, and its ``duration``, s.
        goal: (3,) m, m, rad.
        side: side of the vessel that was pushed, +1.0 or -1.0.
        error: what was wrong with the policy, if anything.
    """
    definition = params.definition
    relative = goal if side > 0 else goal * (1.0, -1.0, -1.0)
    shortest = float(dubins.length(relative, params.vessel.length / 2))
    success = ended["is_success"] and error is None
    values: dict[str, Any] = {
        **ended,
        **vars(label),
        "seed": seed,
        "task": definition.name,
        "num_boats": params.num_boats,
        "success": success,
        "cause": None if success else "policy error" if error else definition.cause(ended, params),
        **dict(zip(("goal_x", "goal_y", "goal_heading"), goal.tolist(), strict=True)),
        "path_length_ratio": ended["path_length"] / shortest if shortest > 0 else None,
        "error": error,
    }
    for column in COLUMNS:
        value = values[column]
        if column in definition.not_applicable or (isinstance(value, float) and math.isnan(value)):
            values[column] = None
    return Episode(**{column: values[column] for column in COLUMNS})
