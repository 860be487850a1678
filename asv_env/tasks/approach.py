"""Approach: boats anywhere round the vessel occupy all slots for a second."""

from asv_env.tasks.reward import Term, success, without
from asv_env.tasks.starts import scattered
from asv_env.tasks.task import Task
from asv_env.tasks.termination import slots_occupied, why_not_grasped

APPROACH = Task(
    name="approach",
    initial_states=scattered,
    reward=tuple(
        Term("success", success) if term.name == "success" else term
        for term in without("delivery", "precision")
    ),
    success=slots_occupied,
    cause=why_not_grasped,
    not_applicable=(
        *("goal_x", "goal_y", "goal_heading", "position_error", "heading_error"),
        *("min_position_error", "heading_error_at_min", "time_to_goal", "path_length_ratio"),
    ),
    time_limit=120.0,
    has_goal=False,
)
