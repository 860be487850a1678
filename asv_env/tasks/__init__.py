"""What is to be done: initial states, reward, termination, metrics.

``task`` says what a task is; the built-in ones are made of the functions of the other modules.
"""

from asv_env.registry import Registry
from asv_env.tasks.approach import APPROACH
from asv_env.tasks.push import PUSH
from asv_env.tasks.reward import Term, Transition
from asv_env.tasks.task import InitialStates, Metric, Task
from asv_env.tasks.transport import TRANSPORT

TASKS: Registry[Task] = Registry(
    "task",
    {task.name: task for task in (APPROACH, PUSH, TRANSPORT)},
    lambda thing: isinstance(thing, Task),
)
"""Tasks by name; ``TASKS.register(task.name, task)`` adds one's own."""

__all__ = [
    "APPROACH", "PUSH", "TASKS", "TRANSPORT", "InitialStates", "Metric", "Task", "Term",
    "Transition",
]  # fmt: skip
