"""What a learned policy consists of: networks, and what each was made for."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from asv_env.checks import check_numbers, check_whole, choice
from asv_env.params import ACTION_MODES
from asv_env.sensing.observation import DEFAULT, VERSION
from asv_env.tasks import TASKS
from asv_env.tasks.task import Task
from asv_env.types import Float

Layers = Sequence[tuple[Float, Float]]
"""(weight (inputs, outputs), bias (outputs,)) of each layer of a network, from the first on."""
ACTIVATIONS: dict[str, Callable[[Float], Float]] = {
    "tanh": np.tanh,
    "relu": lambda x: np.maximum(x, 0.0),
}
"""Functions between the layers, by name."""


@dataclass(frozen=True)
class Metadata:
    """What a network was made for.

    Attributes:
        tasks: names of the tasks in which it may be used.
        action_mode: what its actions mean, "tracking" or "thrusters".
        activation: function between the layers, a key of ``ACTIVATIONS``.
        action_repeat: control ticks between two decisions.
        residual: fraction of a full action by which it corrects the scripted policy, which then
            acts too; 0 for a policy that acts alone.
        mirrors: whether it sees the mirror image of worlds in which the goal lies behind the
            team; see ``baselines.mirror``.
        observation: names of the features that it observes, in their order.
        observation_version: ``asv_env.sensing.observation.VERSION`` when it was trained.
    """

    tasks: tuple[str, ...] = tuple(TASKS)
    action_mode: str = "tracking"
    activation: str = "tanh"
    action_repeat: int = 1
    residual: float = 0.0
    mirrors: bool = False
    observation: tuple[str, ...] = tuple(feature.name for feature in DEFAULT)
    observation_version: int = VERSION

    def __post_init__(self) -> None:
        choice("action_mode", self.action_mode, ACTION_MODES)
        choice("activation", self.activation, ACTIVATIONS)
        check_whole(self, "action_repeat", 1)
        check_numbers(self, "residual", 0.0, 1.0)

    def serves(self, task: Task) -> bool:
        """Returns whether the network may be used in a task, or in one of the same kind."""
        kinds = {_kind(TASKS[name]) for name in self.tasks if name in TASKS}
        return task.name in self.tasks or _kind(task) in kinds


def _kind(task: Task) -> tuple[bool, bool]:
    return task.starts_grasped, task.has_goal


@dataclass(frozen=True)
class Phase:
    """One network of a policy, and when it acts.

    Attributes:
        patience: time after which an attempt is given up, s for a vessel of 0.40 m, if any.
        team_size: number of boats of the only teams that use this network; None for a network
            of all teams that have none of their own.
    """

    layers: Layers
    metadata: Metadata
    patience: float | None = None
    team_size: int | None = None
