"""What is left of an episode: its row, where the hulls were, and all that a learner may want."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Any

from asv_env.params import EnvParams
from asv_env.types import Action, Bool, Float, Observation
from baselines.paper import dubins

POSE_LOG_EVERY = 2
"""Control ticks between two poses of a recorded log."""


@dataclass(frozen=True)
class Label:
    """What a row says of itself besides what happened.

    Attributes:
        policy: its name.
        training_seed: which of its trainings it comes from; None where there is one or none.
        condition: the condition's name in its suite.
        scenario: what disturbed the world.
    """

    policy: str
    training_seed: int | None = None
    condition: str = ""
    scenario: str = "nominal"


@dataclass(frozen=True)
class Episode:
    """One row of ``episodes.csv``; None where a column does not apply.

    Attributes:
        seed: of the episode.
        policy: its name.
        training_seed: which of the policy's trainings it comes from.
        condition: the condition's name in its suite.
        task: "approach", "push" or "transport".
        scenario: what disturbed the world.
        num_boats: team size.
        success: whether the task was done in time.
        cause: of a failure; see ``causes``.
        goal_x: of the goal from where the vessel began, m.
        goal_y: the same, m.
        goal_heading: the same, rad.
        position_error: of the vessel at the end, m.
        heading_error: of the vessel at the end, signed, rad.
        min_position_error: smallest distance of the vessel to its goal, m.
        heading_error_at_min: signed, at the instant of smallest distance, rad.
        time_to_closure: until all slots were held, s.
        closure_spread: between the first and the last boat to hold its slot, s.
        time_to_goal: until the delivery, s.
        duration: of the episode, s.
        path_length_ratio: way of the vessel over the shortest path of bounded curvature.
        effort: seconds of full thrust, averaged over the motors.
        collisions: times that a boat began to touch another one or a wall.
        closure_lost: times that closure was lost.
        episode_return: sum of the team's mean reward.
        error: what was wrong with the policy where that ended the episode.
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
"""Why an episode failed, each excluding those before it: the policy raised or gave an action of
no use; a body left the arena; the vessel was never in closure; the slots were not held for long
enough (approach); the vessel never came within the tolerance of position; its heading was off
when it was nearest; it was there, but not at rest."""


@dataclass(frozen=True)
class Trajectory:
    """All that a learner may want of one episode of T steps.

    Attributes:
        observation: (T + 1, A, K) float32; that at the end included.
        action: (T, A, 2) float32 in [-1, 1].
        reward: (T, A).
        motion: (T + 1, B, 6) of the true state; see ``State``.
        working: (T + 1, A) whether a boat's thrusters work.
        goal: (T + 1, 3) m, m, rad.
        terminated: whether the episode ended by what happened in it, not by the clock.
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
    """Where the hulls of one episode were.

    Attributes:
        episode: its row.
        poses: (T, B, 3) x m, y m, heading rad, row 0 of B the vessel; one every
            ``POSE_LOG_EVERY`` control ticks, and the last.
        goal: (3,) pose, m, m, rad.
        failed_at: (A,) time at which a boat's thrusters died, s; inf never.
        trajectory: all steps, where that was asked for.
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
    """The row of an episode.

    Args:
        seed: of the episode.
        label: what it says of itself.
        params: of the environment.
        ended: its ``metrics.summary``, and its ``duration``, s.
        goal: (3,) m, m, rad.
        side: of the vessel that was pushed, +1.0 or -1.0.
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
    kept: dict[str, Any] = {
        column: None
        if column in definition.not_applicable or _is_nan(values[column])
        else values[column]
        for column in COLUMNS
    }
    return Episode(**kept)


def _is_nan(value: Any) -> bool:
    return isinstance(value, float) and math.isnan(value)
