"""Gusts: a change of the current in time, everywhere alike in a world.

Each component of the velocity is an Ornstein-Uhlenbeck process with mean zero. From one control
tick of h s to the next it is exact (Gillespie, Phys. Rev. E 54, 2084, 1996): with time constant T,
standard deviation s and a normal number n,

    w' = k w + s sqrt(1 - k^2) n,   k = exp(-h / T)

An episode begins with gusts in their steady state.
"""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from asv_env.params import EnvParams
from asv_env.types import Float

BLOCK = 64  #: number of ticks for which normal numbers are drawn at once


class Gusts:
    """Gusts of ``num_worlds`` worlds, each with a Generator of its own."""

    def __init__(self, params: EnvParams, num_worlds: int) -> None:
        water = params.water
        #: whether there are any
        self.blow = water.gust_speed > 0.0
        #: (W, 2) velocity that they add to the current, m/s
        self.velocity: Float = np.zeros((num_worlds, 2))
        self._keep = math.exp(-1.0 / (params.clock.control * water.gust_time))
        self._spread = water.gust_speed
        self._numbers = np.zeros((num_worlds if self.blow else 0, BLOCK, 2))
        self._drawn = np.full(num_worlds, BLOCK)
        self._rngs: dict[int, np.random.Generator] = {}

    def reset(self, index: np.ndarray, rngs: Mapping[int, np.random.Generator]) -> None:
        """Begins episodes in the worlds ``index`` (n,), with Generators spawned from theirs.

        So the next episode does not depend on how long this one was.
        """
        if not self.blow:
            return
        for world in map(int, index):
            self._rngs[world] = rngs[world].spawn(1)[0]
        self._drawn[index] = BLOCK
        self.velocity[index] = self._spread * self._normal(index)

    def advance(self) -> None:
        """Advances all worlds by a control tick."""
        if self.blow:
            fresh = self._normal(np.arange(len(self.velocity)))
            self.velocity *= self._keep
            self.velocity += self._spread * math.sqrt(1.0 - self._keep**2) * fresh

    def _normal(self, index: np.ndarray) -> Float:
        """Returns normal numbers (n, 2) of the worlds ``index`` (n,)."""
        for world in map(int, index[self._drawn[index] == BLOCK]):
            self._numbers[world] = self._rngs[world].standard_normal((BLOCK, 2))
            self._drawn[world] = 0
        found: Float = self._numbers[index, self._drawn[index]]
        self._drawn[index] += 1
        return found

    def snapshot(self) -> dict[str, Any]:
        """Returns all that changes from tick to tick by name, for the simulation to copy."""
        names = ("velocity", "_numbers", "_drawn", "_rngs")
        return {name: vars(self)[name] for name in names} if self.blow else {}

    def restore(self, memory: dict[str, Any]) -> None:
        """Continues as the gusts did whose ``snapshot`` this is."""
        for name, value in memory.items():
            if name == "_rngs":
                self._rngs = value
            else:
                vars(self)[name][...] = value  # Compiled code holds on to these arrays.
