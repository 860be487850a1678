"""Errors of policies: each ends the episode in which it happens, and no other."""

from typing import Any

import numpy as np

from asv_env.types import Action, Bool, Observation, Sensed
from baselines.policy import Policy


class PolicyError(Exception):
    """A policy raised while it decided for several worlds, nobody knows in which of them."""


class GuardedPolicy:
    """A policy whose useless actions become zeros, and are reported.

    Args:
        policy: the policy.

    Attributes:
        errors: what was wrong with the last decision, by world.
    """

    def __init__(self, policy: Policy) -> None:
        self._policy = policy
        self.errors: dict[int, str] = {}

    def act(
        self, sensed: Sensed, observation: Observation, memory: Any, fresh: Bool
    ) -> tuple[Action, Any]:
        """See ``Policy.act``.

        Raises:
            PolicyError: the policy raised, and there are several worlds.
        """
        shape = (*sensed.slot.shape, 2)
        try:
            action, memory = self._policy.act(sensed, observation, memory, fresh)
            action = checked_action(action, shape)
        except Exception as error:
            if len(fresh) > 1:
                raise PolicyError from error
            text = f"{type(error).__name__}: {error}"
            self.errors = {0: " ".join(text.split())}  # one line of a table
            return np.zeros(shape, dtype=np.float32), None
        finite = np.asarray(np.isfinite(action).all(axis=(1, 2)))
        self.errors = {
            world: f"action not finite at tick {sensed.tick[world]}"
            for world in map(int, np.flatnonzero(~finite))
        }
        return np.where(finite[:, None, None], action, np.float32(0.0)), memory


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
