"""Policies that stable-baselines3 has saved.

Its files hold pickled Python objects: reading one runs whatever code is in it, so read only those
whose source you trust.
"""

from __future__ import annotations

from pathlib import Path
from pickle import PickleError
from typing import Any

import numpy as np

from asv_env.params import EnvParams
from asv_env.sensing.observation import column_names, features
from asv_env.types import Action, Bool, Observation, Sensed


class Sb3Policy:
    """The deterministic policy in a stable-baselines3 zip, of whichever algorithm.

    It either maps the observation (K,) of one boat to its action (2,), as trained on
    ``BoatVecEnv``, or that of the team (A, K) to (A, 2), as trained on ``gym.make``. Recurrent
    policies keep their state in the memory. Each world has a forward pass of its own, so that
    its actions do not depend on the batch.

    Such a file does not say for which task and which kind of action it was trained, nor whether
    its observations were normalised (``VecNormalize``): the environment has to be the same.

    Args:
        path: of the zip.
        params: of the environment.

    Raises:
        ValueError: not such a file, or spaces that do not match.
        FileNotFoundError: there is none.
        ImportError: stable-baselines3 is not installed.
    """

    def __init__(self, path: Path, params: EnvParams) -> None:
        try:
            from stable_baselines3.common.save_util import load_from_zip_file
        except ImportError as error:
            raise ImportError(f"{path} needs stable-baselines3: pip install '.[train]'") from error
        if not path.exists():
            raise FileNotFoundError(f"{path}: there is no such file")
        try:
            saved, weights, _ = load_from_zip_file(path, device="cpu")
            data: dict[str, Any] = saved or {}
            observes, acts = data["observation_space"], data["action_space"]
            _check_spaces(path, observes, acts, params)
            options = {**data["policy_kwargs"], **({"use_sde": True} if data["use_sde"] else {})}
            self._policy = data["policy_class"](observes, acts, lambda _: 0.0, **options)
            self._policy.load_state_dict(weights["policy"])
        except (KeyError, TypeError, RuntimeError, AttributeError, EOFError, PickleError) as error:
            raise ValueError(f"{path} is not a saved stable-baselines3 model: {error}") from error
        self._policy.set_training_mode(False)
        self._joint = len(observes.shape) > 1

    def act(
        self, sensed: Sensed, observation: Observation, memory: Any, fresh: Bool
    ) -> tuple[Action, Any]:
        """See ``Policy.act``. Remembers a recurrent policy's state for each world."""
        states = memory or [None] * len(fresh)
        rows = 1 if self._joint else observation.shape[1]
        decided = [
            self._policy.predict(boats, state, np.full(rows, new), deterministic=True)
            for boats, state, new in zip(observation, states, fresh, strict=True)
        ]
        action = np.stack([action for action, _ in decided]).astype(np.float32)
        return action, [state for _, state in decided]


def _check_spaces(path: Path, observes: Any, acts: Any, params: EnvParams) -> None:
    columns = len(column_names(features(params)))
    boat, team = (columns,), (params.num_boats, columns)
    spaces = {boat: (2,), team: (params.num_boats, 2)}
    if spaces.get(observes.shape) != acts.shape:
        known = " or ".join(f"{before} -> {after}" for before, after in spaces.items())
        raise ValueError(
            f"{path} maps observations {observes.shape} to actions {acts.shape}; with "
            f"{params.num_boats} boats it must be {known}"
        )
