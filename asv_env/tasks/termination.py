"""When an episode is over: reached, strayed, timed out."""

from __future__ import annotations

import numpy as np

from asv_env.params import EnvParams, TaskParams
from asv_env.tasks.formation import Relations
from asv_env.types import Bool, Complex, Ending, State


def ending(relations: Relations, state: State, water: Complex, params: EnvParams) -> Ending:
    """How the worlds stand at the end of a control tick.

    Args:
        relations: of the true motion.
        state: with the counters already advanced.
        water: (W,) velocity of the water at the vessel, m/s.
        params: the environment's.
    """
    if params.task.name == "approach":
        reached = state.held >= max(1, round(params.task.hold_time * params.clock.control))
    else:
        reached = delivered(relations, water, params.task) & state.anchored
    reach = np.maximum.reduce(np.abs(state.motion[..., :2]), axis=(1, 2))
    strayed = reach > params.task.arena
    return Ending(reached & ~strayed, strayed, state.tick >= params.time_limit_ticks)


def delivered(relations: Relations, water: Complex, task: TaskParams) -> Bool:
    """(W,) whether the vessel is at the goal, settled, and comes no nearer.

    It is within the tolerances of position and heading, slow through the local water, hardly
    turning, and its distance to the goal falls by less than ``nearing_tolerance``: the paper's
    instant of minimal distance.
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
