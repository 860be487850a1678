"""Push: boats that have grasped the vessel deliver it."""

from asv_env.tasks.reward import without
from asv_env.tasks.starts import in_slots
from asv_env.tasks.task import Task
from asv_env.tasks.termination import vessel_delivered, why_not_delivered

PUSH = Task(
    name="push",
    initial_states=in_slots,
    reward=without("closure"),
    success=vessel_delivered,
    cause=why_not_delivered,
    not_applicable=("time_to_closure", "closure_spread"),
    time_limit=120.0,
    starts_grasped=True,
)
