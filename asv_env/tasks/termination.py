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

from asv_env.checks import TRUTH, values
from asv_env.params import EnvParams
from asv_env.tasks.formation import Relations, relate
from asv_env.types import Bool, Complex, Ending, State, frozen


def ending(state: State, ending: Ending, water: Complex, params: EnvParams) -> Ending:
    """Returns how the worlds stand at the end of a control tick, by the task's own success.

    The state is true and its counters are already advanced; ``ending`` is that without success, and
    ``water`` is the velocity (W,) of the water at the vessel, m/s.
    """
    task, forms = params.definition, {state.tick.shape: TRUTH}
    relations = frozen(relate(state.motion, state.goal, state.slot, state.side))
    known = relations, state, water, params
    reached = values(forms, "success of task", task.name, task.success, *known)
    return Ending(reached & ~ending.strayed, ending.strayed, ending.timed_out)


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


def why_not_grasped(summary: Mapping[str, Any], params: EnvParams) -> str:
    """Returns why the slots were not occupied for long enough."""
    if summary["strayed"]:
        return "strayed"
    return "no closure" if math.isinf(summary["time_to_closure"]) else "grasp not held"


def why_not_delivered(summary: Mapping[str, Any], params: EnvParams) -> str:
    """Returns why the vessel was not delivered.

    A team may move the vessel without closure, unless the goal waits for it.
    """
    far = summary["min_position_error"] > params.task.position_tolerance
    waits = far or params.task.goal_anchor == "closure"
    if summary["strayed"] or (waits and math.isinf(summary["time_to_closure"])):
        return why_not_grasped(summary, params)
    if far:
        return "never near"
    if abs(summary["heading_error_at_min"]) > params.task.heading_tolerance:
        return "heading off"
    return "not settled"
