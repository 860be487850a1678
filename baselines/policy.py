"""What a policy is, the two simplest, and the registry of policies by name."""

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np

from asv_env.params import EnvParams
from asv_env.registry import Registry
from asv_env.types import Action, Bool, Observation, Sensed


class Policy(Protocol):
    """Interface of a policy, which decides for all boats (A) of all worlds (W) at once.

    A policy never touches the environment. Scripted policies read ``sensed``, learned ones
    ``observation``, which is computed from it. A policy keeps no state of its own: it returns its
    memory, and receives it again at the next tick.
    """

    def act(
        self, sensed: Sensed, observation: Observation, memory: Any, fresh: Bool
    ) -> tuple[Action, Any]:
        """Returns the actions of all boats for one control tick.

        Args:
            sensed: what the team knows: motion with its noise, slots, goal. Boats that sense for
                themselves have a world each here, see ``distributed``.
            observation: (W, A, K) float32, K features of each boat.
            memory: memory that the previous call returned; None at the first call.
            fresh: (W,) bool, worlds that have begun a new episode since the previous call; their
                memory is void.

        Returns:
            Action (W, A, 2) in [-1, 1], and the memory for the next call.
        """
        ...


MakePolicy = Callable[[EnvParams], Policy]
"""Policy factory: makes a policy for an environment; most are classes."""


def checked_action(action: Any, shape: tuple[int, ...]) -> Action:
    """Returns an action as float32 in [-1, 1] of the shape (W, A, 2), in memory of its own.

    What lies outside is clipped; what is not finite becomes NaN.

    Raises:
        ValueError: another shape.
        TypeError: not real numbers, masked ones, or nothing that NumPy can read.
    """
    kind = type(action).__name__
    if isinstance(action, np.ma.MaskedArray) and np.ma.is_masked(action):
        raise TypeError("action with masked numbers: fill them")
    try:
        array = np.asarray(action)
    except Exception as error:
        raise TypeError(f"action of type {kind} cannot be read: {error}") from error
    if array.dtype.kind not in "fiub":
        raise TypeError(f"action of type {kind} and dtype {array.dtype}: give real numbers")
    if array.shape != shape:
        raise ValueError(f"action of shape {array.shape}: must be {shape}, as (worlds, boats, 2)")
    numbers = array.astype(np.float64)
    numbers[~np.isfinite(array)] = np.nan
    return np.clip(numbers, -1.0, 1.0).astype(np.float32)


def decision(decided: Any, shape: tuple[int, ...]) -> tuple[Action, Any]:
    """Returns the action and the memory that a policy has returned.

    Raises:
        TypeError: not a pair, or not numbers; whatever reading them raises.
        ValueError: another shape than (W, A, 2).
    """
    if not (isinstance(decided, tuple) and len(decided) == 2):
        raise TypeError(f"act returned {type(decided).__name__}: return (action, memory)")
    action, memory = decided
    return checked_action(action, shape), memory


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
        """See ``Policy.act``; the memory is a Generator for each world."""
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
        "allocation": "baselines.allocation.allocation_policy:AllocationPolicy",
        "paper": "baselines.paper.paper_policy:PaperPolicy",
        "paper-tuned": "baselines.paper.tuned:tuned_paper",
        "learned": "baselines.learned.policy_file:learned_policy",
        "idle": Idle,
        "random": Random,
    },
)
"""Policy factories by name; the policies of this package are imported when they are asked for."""
