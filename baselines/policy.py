"""What a policy is, and the two simplest."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from asv_env.params import EnvParams
from asv_env.types import Action, Bool, Observation, Sensed


class Policy(Protocol):
    """Decides for all boats of all worlds; never touches the environment.

    A scripted policy reads ``sensed``, a learned one ``observation``, which is computed from
    it. What a policy wants to remember it returns, and gets back at the next tick.
    """

    def act(
        self, sensed: Sensed, observation: Observation, memory: Any, fresh: Bool
    ) -> tuple[Action, Any]:
        """One decision.

        Args:
            sensed: what the boats measure.
            observation: (W, A, K) float32.
            memory: what the last call returned; None at the first.
            fresh: (W,) worlds that have begun a new episode since, whose memory is void.

        Returns:
            Action (W, A, 2) in [-1, 1], and the memory for the next call.
        """
        ...


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
    """Uniform random actions; the same in the same world at the same tick."""

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
            rngs[world] = np.random.default_rng(_fingerprint(self._seed, sensed, world))
        action = np.stack([rng.uniform(-1.0, 1.0, (team, 2)) for rng in rngs])
        return action.astype(np.float32), rngs


def _fingerprint(seed: int, sensed: Sensed, world: int) -> list[int]:
    """Seed words from the way an episode begins, so that they do not depend on the batch."""
    return [seed, *sensed.estimate[world].view(np.uint64).ravel().tolist()]
