"""What a policy is, the two simplest, and the registry of policies by name."""

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np

from asv_env.params import EnvParams
from asv_env.registry import Registry
from asv_env.types import Action, Bool, Observation, Sensed


class Policy(Protocol):
    """Decides for all boats of all worlds; never touches the environment.

    A scripted policy reads ``sensed``, a learned one ``observation``, which is computed from
    it. A policy returns what it remembers, and receives it at the next tick.
    """

    def act(
        self, sensed: Sensed, observation: Observation, memory: Any, fresh: Bool
    ) -> tuple[Action, Any]:
        """Returns one decision for all boats.

        Args:
            sensed: what the boats measure.
            observation: (W, A, K) float32.
            memory: what the last call returned; None at the first.
            fresh: (W,) worlds in which a new episode has begun since, so that memory is void.

        Returns:
            Action (W, A, 2) in [-1, 1], and the memory for the next call.
        """
        ...


MakePolicy = Callable[[EnvParams], Policy]
"""Policy factory: makes a policy for an environment; most are classes."""


def checked_action(action: Any, shape: tuple[int, ...]) -> Action:
    """Returns an action as float32 of the shape (W, A, 2).

    Raises:
        ValueError: another shape.
        TypeError: not numbers.
    """
    try:
        array = np.asarray(action, dtype=np.float32)
    except (TypeError, ValueError) as error:
        raise TypeError(f"action of type {type(action).__name__}: give numbers") from error
    if array.shape != shape:
        raise ValueError(f"action of shape {array.shape}: must be {shape}, as (worlds, boats, 2)")
    return array


class Idle:
    """Does nothing."""

    def __init__(self, params: EnvParams) -> None:
        del params

    def act(
        self, sensed: Sensed, observation: Observation, memory: Any, fresh: Bool
    ) -> tuple[Action, Any]:
        """See ``Policy.act``."""
        return np.zeros((*sensed.slot.shape, 2), dtype=np.float32), None


class Random:
    """Uniform random actions; the same in the same episode at the same tick."""

    def __init__(self, params: EnvParams, seed: int = 0) -> None:
        del params
        self._seed = seed

    def act(
        self, sensed: Sensed, observation: Observation, memory: Any, fresh: Bool
    ) -> tuple[Action, Any]:
        """See ``Policy.act``. Remembers a Generator for each world."""
        worlds, team = sensed.slot.shape
        rngs = memory or [None] * worlds
        for world in map(int, np.flatnonzero(fresh | (memory is None))):
            initial = sensed.estimate[world].view(np.uint64).ravel()  # whatever the batch
            rngs[world] = np.random.default_rng([self._seed, *initial.tolist()])
        action = np.stack([rng.uniform(-1.0, 1.0, (team, 2)) for rng in rngs])
        return action.astype(np.float32), rngs


POLICIES: Registry[MakePolicy] = Registry(
    "policy",
    {
        "scripted": "baselines.scripted.scripted_policy:ScriptedPolicy",
        "paper": "baselines.paper.paper_policy:PaperPolicy",
        "learned": "baselines.learned.shipped:learned_policy",
        "idle": Idle,
        "random": Random,
    },
)
"""Policy factories by name; the policies of this package are imported when they are asked for."""
