"""When an episode is over: the task is done, a body strayed, or the time is up."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from asv_env.checks import TRUTH, values
from asv_env.params import EnvParams, TaskParams
from asv_env.tasks.formation import Relations
from asv_env.types import Bool, Complex, Ending, State


def ending(relations: Relations, state: State, water: Complex, params: EnvParams) -> Ending:
    """Returns how the worlds stand at the end of a control tick.

    Relations and state are true, the state's counters already advanced; ``water`` is the
    velocity (W,) of the water at the vessel, m/s.
    """
    task, forms = params.definition, {state.tick.shape: TRUTH}
    given = relations, state, water, params
    reached = values(forms, "success of task", task.name, task.success, *given)
    strayed = np.maximum.reduce(np.abs(state.motion[..., :2]), axis=(1, 2)) > params.task.arena
    return Ending(reached & ~strayed, strayed, state.tick >= params.time_limit_ticks)


def slots_occupied(relations: Relations, state: State, water: Complex, params: EnvParams) -> Bool:
    """Returns (W,) whether all slots have been occupied for ``hold_time``."""
    return state.occupied_ticks >= hold_ticks(params)


def hold_ticks(params: EnvParams) -> int:
    """Returns the number of control ticks for which all slots must be occupied."""
    return max(1, round(params.task.hold_time * params.clock.control))


def vessel_delivered(relations: Relations, state: State, water: Complex, params: EnvParams) -> Bool:
    """Returns (W,) whether the vessel is delivered to a goal that is final."""
    return delivered(relations, water, params.task) & state.anchored


def delivered(relations: Relations, water: Complex, task: TaskParams) -> Bool:
    """Returns (W,) whether the vessel is at the goal, slow, and comes no nearer.

    It is within the tolerances of position and heading, slow through the local water, hardly
    turning, and its distance to the goal falls by less than ``nearing_tolerance``: the paper's
    instant of smallest distance.
    """
    near = relations.goal_error <= task.position_tolerance
    if not near.any():
        return near
    velocity = relations.velocity[:, 0]
    to_goal = relations.goal * relations.heading[:, 0]
    nearing = (velocity * to_goal.conj()).real
    return (
        near
        & (np.abs(relations.heading_error) <= task.heading_tolerance)
        & (np.abs(velocity - water) < task.speed_tolerance)
        & (np.abs(relations.yaw_rate[:, 0]) < task.yaw_rate_tolerance)
        & (nearing <= task.nearing_tolerance * relations.goal_error)
    )


def why_not_grasped(summary: Mapping[str, Any], params: EnvParams) -> str:
    """Returns why the slots were not occupied for long enough."""
    if summary["strayed"]:
        return "strayed"
    return "no closure" if math.isinf(summary["time_to_closure"]) else "grasp not held"


def why_not_delivered(summary: Mapping[str, Any], params: EnvParams) -> str:
    """Returns why the vessel was not delivered."""
    if summary["strayed"] or math.isinf(summary["time_to_closure"]):
        return why_not_grasped(summary, params)
    if summary["min_position_error"] > params.task.position_tolerance:
        return "never near"
    if abs(summary["heading_error_at_min"]) > params.task.heading_tolerance:
        return "heading off"
    return "not settled"
