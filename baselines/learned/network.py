"""A multilayer perceptron as a policy, on NumPy alone."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from asv_env.params import EnvParams
from asv_env.sensing import observation
from asv_env.sensing.observation import Feature
from asv_env.tasks import formation
from asv_env.types import Action, Bool, Float, Int, Observation, Sensed
from baselines.learned.metadata import ACTIVATIONS, Layers, Metadata
from baselines.mirror import PushSide, PushSideSelector
from baselines.scripted.scripted_policy import ScriptedPolicy


@dataclass
class NetworkMemory:
    """What a network policy remembers from one control tick to the next."""

    action: Action  # (W, A, 2) latest action of the network
    ticks: Int  # (W,) control ticks since the network decided
    scripted: Any = None  # memory of the scripted policy that is corrected, if one is
    push_side: PushSide | None = None  # sides of the teams, for mirror images


class NetworkPolicy:
    """A perceptron that all boats share, from each one's observation (K,) to its action (2,).

    Raises:
        ValueError: it was made for another task, other actions or other observations.
    """

    def __init__(self, layers: Layers, metadata: Metadata, params: EnvParams) -> None:
        _check_fit(metadata, params)
        self._features = _features(metadata, params)
        _check_sizes(layers, self._features)
        self._observes = metadata.mirrors or self._features != observation.features(params)
        self._layers = [(np.asarray(w, np.float32), np.asarray(b, np.float32)) for w, b in layers]
        self._activate = ACTIVATIONS[metadata.activation]
        self._action_repeat = metadata.action_repeat
        self._residual = metadata.residual
        self._params = params
        self._side = PushSideSelector(params) if metadata.mirrors else None
        self._scripted = ScriptedPolicy(params) if metadata.residual else None

    def act(
        self, sensed: Sensed, observation: Observation, memory: NetworkMemory | None, fresh: Bool
    ) -> tuple[Action, NetworkMemory]:
        """See ``Policy.act``."""
        if memory is None:
            none = np.zeros((len(fresh), 1, 2), dtype=np.float32)
            memory = NetworkMemory(none, np.full(len(fresh), -1))
        action, push_side = self._decide(sensed, observation, memory, fresh)
        ticks = memory.ticks + 1
        due = fresh | (ticks % self._action_repeat == 0)
        action = np.where(due[:, None, None], action, memory.action)
        after = NetworkMemory(action, np.where(due, 0, ticks), push_side=push_side)
        if self._scripted is None:
            return action, after
        scripted, after.scripted = self._scripted.act(sensed, observation, memory.scripted, fresh)
        corrected = np.clip(scripted + self._residual * action, -1.0, 1.0)
        return corrected.astype(np.float32), after

    def _decide(
        self, sensed: Sensed, observation: Observation, memory: NetworkMemory, fresh: Bool
    ) -> tuple[Action, PushSide | None]:
        """Returns the network's action now (W, A, 2), and the sides from which teams push."""
        push_side = None
        if self._side is not None:
            sensed, push_side = self._side.view(sensed, memory.push_side, fresh)
        if self._observes:
            observation = observe(sensed, self._features, self._params)
        action = self.forward(observation)
        if push_side is not None:
            action[..., 1] *= push_side.side[:, None].astype(np.float32)
        return action, push_side

    def forward(self, observation: Observation) -> Action:
        """Returns the network's outputs (W, A, 2), clipped to [-1, 1], for observations (W, A, K).

        Each world is one product of matrices, whose shape does not depend on W: a world's actions
        are the same to the bit in every batch.
        """
        x: Float = observation
        for number, (weight, bias) in enumerate(self._layers):
            x = np.matmul(self._activate(x) if number else x, weight) + bias
        return np.clip(x, -1.0, 1.0).astype(np.float32)


def observe(sensed: Sensed, features: tuple[Feature, ...], params: EnvParams) -> Observation:
    """Returns observations (W, A, K) by some features, of a mirror image for instance."""
    relations = formation.relate(sensed.estimate, sensed.goal, sensed.slot, sensed.side)
    occupied = formation.occupied(relations, params.task)
    return observation.observe(features, sensed, relations, occupied, params)


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
    if metadata.observation_version != observation.VERSION:
        raise ValueError(
            f"the policy observes by version {metadata.observation_version}, the environment by "
            f"version {observation.VERSION}: train it again, or use the asv-env of its time"
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
