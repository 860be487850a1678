"""When an episode is over: the task is done, a body strayed, or the time is up.

A vessel is *delivered* by one of two criteria, ``TaskParams.delivery``:

- "holding": for ``delivery_time`` without a break it is at the goal pose and hardly moves over
  ground. In still water it is then about to stay: from 2 mm/s a free one coasts by 1.4 cm.
- "passing": it is at the goal pose for an instant, slow through the water, and comes no nearer,
  the paper's instant of smallest distance. A free vessel coasts by 6 cm from 1 cm/s, so that it
  need not stay.
"""

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
    return state.delivered_ticks >= delivery_ticks(params)


def delivery_ticks(params: EnvParams) -> int:
    """Returns the number of control ticks for which the vessel must be at its goal."""
    if params.task.delivery == "passing":
        return 1
    return max(1, round(params.task.delivery_time * params.clock.control))


def at_goal(relations: Relations, water: Complex, task: TaskParams) -> Bool:
    """Returns (W,) whether a tick counts for the delivery of the vessel.

    The vessel is within the tolerances of position and heading, and slow by the task's criterion;
    ``water`` is the velocity (W,) of the water at the vessel, m/s.
    """
    near = relations.goal_error <= task.position_tolerance
    if not near.any():
        return near
    slow = holds if task.delivery == "holding" else passes
    turned = np.abs(relations.heading_error) <= task.heading_tolerance
    return near & turned & slow(relations, water, task)


def holds(relations: Relations, water: Complex, task: TaskParams) -> Bool:
    """Returns (W,) whether the vessel hardly moves over ground.

    Water that flows past a hull that is held shakes it, so that speed and yaw rate may be larger
    by the factor 1 + c w / v, where w is the water's speed, c the ``water_tolerance`` and v the
    ``speed_tolerance``. The speed v + c w stays below w from w = v / (1 - c) on, 2.7 mm/s by
    default: in faster water a vessel that is carried along does not hold its pose.
    """
    factor = 1.0 + task.water_tolerance / task.speed_tolerance * np.abs(water)
    slow = np.abs(relations.velocity[:, 0]) < task.speed_tolerance * factor
    return slow & (np.abs(relations.yaw_rate[:, 0]) < task.yaw_rate_tolerance * factor)


def passes(relations: Relations, water: Complex, task: TaskParams) -> Bool:
    """Returns (W,) whether the vessel is slow through the local water and comes no nearer.

    It hardly turns, and its distance to the goal falls by less than ``nearing_tolerance``.
    """
    velocity = relations.velocity[:, 0]
    to_goal = relations.goal * relations.heading[:, 0]
    nearing = (velocity * to_goal.conj()).real
    slow = np.abs(velocity - water) < task.passing_speed
    slow &= np.abs(relations.yaw_rate[:, 0]) < task.passing_yaw_rate
    return slow & (nearing <= task.nearing_tolerance * relations.goal_error)


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
