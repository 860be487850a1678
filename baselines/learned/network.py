"""A multilayer perceptron as a policy, on NumPy alone, and what it was made for."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from asv_env.checks import check_numbers, check_whole, choice
from asv_env.params import EnvParams
from asv_env.sensing import observation
from asv_env.sensing.observation import DEFAULT, VERSION, Feature, observe
from asv_env.tasks import TASKS
from asv_env.tasks.task import Task
from asv_env.types import Action, Bool, Float, Int, Observation, Sensed
from baselines.scripted.scripted_policy import ScriptedPolicy

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

    With ``residual`` it corrects the scripted policy, which then acts too; else it acts alone.
    """

    tasks: tuple[str, ...] = tuple(TASKS)  #: names of the tasks in which it may be used
    action_mode: str = "tracking"  #: what its actions mean, "tracking" or "thrusters"
    activation: str = "tanh"  #: function between the layers, a key of ``ACTIVATIONS``
    action_repeat: int = 1  #: control ticks between two decisions
    residual: float = 0.0  #: fraction of a full action by which it corrects the scripted policy
    observation: tuple[str, ...] = tuple(f.name for f in DEFAULT)  #: features, in their order
    observation_version: int = VERSION  #: version of the observation when it was trained

    def __post_init__(self) -> None:
        choice("action_mode", self.action_mode, ("tracking", "thrusters"))
        choice("activation", self.activation, ACTIVATIONS)
        check_whole(self, "action_repeat", 1)
        check_numbers(self, "residual", 0.0, 1.0)

    def serves(self, task: Task) -> bool:
        """Returns whether the network may be used in a task, or in one of the same kind."""
        known = [TASKS[name] for name in self.tasks if name in TASKS]
        kinds = {(one.starts_grasped, one.has_goal) for one in known}
        return task.name in self.tasks or (task.starts_grasped, task.has_goal) in kinds


@dataclass
class NetworkMemory:
    """What a network policy remembers from one control tick to the next."""

    action: Action  #: (W, A, 2) latest action of the network
    ticks: Int  #: (W,) control ticks since the network decided
    scripted: Any = None  #: memory of the scripted policy that is corrected, if one is


class NetworkPolicy:
    """A perceptron that all boats share, from each one's observation (K,) to its action (2,).

    Raises:
        ValueError: it was made for another task, other actions or other observations.
    """

    def __init__(self, layers: Layers, metadata: Metadata, params: EnvParams) -> None:
        _check_fit(metadata, params)
        self._features = _features(metadata, params)
        _check_sizes(layers, self._features)
        self._observes = self._features != observation.features(params)
        self._layers = [(np.asarray(w, np.float32), np.asarray(b, np.float32)) for w, b in layers]
        self._activate = ACTIVATIONS[metadata.activation]
        self._metadata, self._params = metadata, params
        self._scripted = ScriptedPolicy(params) if metadata.residual else None

    def act(
        self, sensed: Sensed, observation: Observation, memory: NetworkMemory | None, fresh: Bool
    ) -> tuple[Action, NetworkMemory]:
        """See ``Policy.act``."""
        if memory is None:
            none = np.zeros((len(fresh), 1, 2), dtype=np.float32)
            memory = NetworkMemory(none, np.full(len(fresh), -1))
        seen = observe(self._features, sensed, self._params) if self._observes else observation
        action = self.forward(seen)
        ticks = memory.ticks + 1
        due = fresh | (ticks % self._metadata.action_repeat == 0)
        action = np.where(due[:, None, None], action, memory.action)
        after = NetworkMemory(action, np.where(due, 0, ticks))
        if self._scripted is None:
            return action, after
        scripted, after.scripted = self._scripted.act(sensed, observation, memory.scripted, fresh)
        corrected = np.clip(scripted + self._metadata.residual * action, -1.0, 1.0)
        return corrected.astype(np.float32), after

    def forward(self, observation: Observation) -> Action:
        """Returns the network's outputs (W, A, 2), clipped to [-1, 1], for observations (W, A, K).

        Each world is one product of matrices, whose shape does not depend on W: a world's actions
        are the same to the bit in every batch.
        """
        x: Float = observation
        for number, (weight, bias) in enumerate(self._layers):
            x = np.matmul(self._activate(x) if number else x, weight) + bias
        return np.clip(x, -1.0, 1.0).astype(np.float32)


def _features(metadata: Metadata, params: EnvParams) -> tuple[Feature, ...]:
    """Returns the features that a network observes: the environment's own, or registered ones."""
    own = {feature.name: feature for feature in observation.features(params)}
    return tuple(own.get(name) or observation.FEATURES.find(name) for name in metadata.observation)


def _check_fit(metadata: Metadata, params: EnvParams) -> None:
    """Refuses metadata of a network that was made for something else than an environment."""
    task, tasks = params.definition, " or ".join(metadata.tasks)
    if not metadata.serves(task):
        raise ValueError(f"the policy is for the task {tasks}, not for {task.name!r}")
    if metadata.action_mode != params.action_mode:
        raise ValueError(
            f"the policy gives {metadata.action_mode!r} actions, the environment takes "
            f"{params.action_mode!r}: make it with action_mode={metadata.action_mode!r}"
        )
    if metadata.observation_version != VERSION:
        raise ValueError(
            f"the policy observes by version {metadata.observation_version}, the environment by "
            f"version {VERSION}: train it again, or use the asv-env of its time"
        )


def _check_sizes(layers: Layers, features: tuple[Feature, ...]) -> None:
    """Refuses layers that do not lead from an observation by some features to an action."""
    inputs, outputs = len(layers[0][0]), layers[-1][0].shape[1]
    columns = len(observation.column_names(features))
    if (inputs, outputs) != (columns, 2):
        raise ValueError(
            f"the policy maps {inputs} numbers to {outputs}: it must map an observation of "
            f"{columns} to an action of 2"
        )
