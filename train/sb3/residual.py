"""Worlds in which the scripted policy acts and the learner corrects it."""

from typing import Any

import numpy as np

from asv_env.envs.sb3 import BoatVecEnv, RowObservation
from asv_env.types import Action, Bool, Observation
from baselines.scripted.scripted_policy import ScriptedPolicy


class ResidualVecEnv(BoatVecEnv):
    """A ``BoatVecEnv`` whose actions, scaled, are added to those of the scripted policy."""

    def __init__(self, *args: Any, scale: float, **options: Any) -> None:
        super().__init__(*args, **options)
        self._scale, self._scripted = scale, ScriptedPolicy(self.params)
        self._memory: Any = None
        self._fresh = np.ones(self.num_worlds, dtype=np.bool_)

    def reset(self) -> RowObservation:
        """See ``BoatVecEnv.reset``."""
        self._fresh[...] = True
        return super().reset()

    def step_async(self, actions: Action) -> None:
        """Takes the corrections (W A, 2) of the next step."""
        sensed = self.simulation.sensed
        unused = np.empty(0, dtype=np.float32)  # the scripted policy reads what is sensed
        scripted, self._memory = self._scripted.act(sensed, unused, self._memory, self._fresh)
        super().step_async(scripted.reshape(-1, 2) + self._scale * np.asarray(actions))

    def step_wait(self) -> tuple[RowObservation, Observation, Bool, list[dict[str, Any]]]:
        """See ``BoatVecEnv.step_wait``."""
        seen, reward, done, infos = super().step_wait()
        self._fresh = done.reshape(self.num_worlds, -1)[:, 0].copy()
        return seen, reward, done, infos
