"""Transport: boats anywhere round the vessel grasp and deliver it."""

from asv_env.tasks.reward import TERMS
from asv_env.tasks.starts import scattered
from asv_env.tasks.task import Task
from asv_env.tasks.termination import vessel_delivered, why_not_delivered

TRANSPORT = Task(
    name="transport",
    initial_states=scattered,
    reward=TERMS,
    success=vessel_delivered,
    cause=why_not_delivered,
)
