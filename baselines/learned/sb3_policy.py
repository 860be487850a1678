"""Policies that stable-baselines3 has saved.

Such a file holds pickled Python objects. Reading it runs whatever code is in it, so only files from
a trusted source should be read.
"""

from pathlib import Path
from pickle import PickleError
from typing import Any

import numpy as np

from asv_env.params import EnvParams
from asv_env.sensing.observation import column_names, features
from asv_env.types import Action, Bool, Observation, Sensed


class Sb3Policy:
    """The deterministic policy of a stable-baselines3 model, whatever its algorithm.

    It maps either the observation (K,) of one boat to its action (2,), as trained on
    ``BoatVecEnv``, or that of the team (A, K) to (A, 2), as trained on ``gym.make``. Recurrent
    policies keep their state in the memory. Each world has a forward pass of its own, so that
    its actions do not depend on the batch.

    The file does not record the task, the kind of action or a normalisation of observations
    (``VecNormalize``): the environment must be that of the training.

    Raises:
        ValueError: the file is not a model, or its spaces do not match.
        FileNotFoundError: there is no such file.
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
            inputs, outputs = data["observation_space"], data["action_space"]
            _check_spaces(path, inputs, outputs, params)
            options = {**data["policy_kwargs"], **({"use_sde": True} if data["use_sde"] else {})}
            self._policy = data["policy_class"](inputs, outputs, lambda _: 0.0, **options)
            self._policy.load_state_dict(weights["policy"])
        except (KeyError, TypeError, RuntimeError, AttributeError, EOFError, PickleError) as error:
            raise ValueError(f"{path} is not a saved stable-baselines3 model: {error}") from error
        self._policy.set_training_mode(False)
        # Every prediction would set it again, module by module, which takes half of its time.
        self._policy.set_training_mode = lambda mode: None
        self._joint = len(inputs.shape) > 1

    def act(
        self, sensed: Sensed, observation: Observation, memory: Any, fresh: Bool
    ) -> tuple[Action, Any]:
        """See ``Policy.act``; the memory is the state of a recurrent policy in each world."""
        states = memory or [None] * len(fresh)
        rows = 1 if self._joint else observation.shape[1]
        decided = [
            self._policy.predict(boats, state, np.full(rows, new), deterministic=True)
            for boats, state, new in zip(observation, states, fresh, strict=True)
        ]
        action = np.stack([action for action, _ in decided]).astype(np.float32)
        return action, [state for _, state in decided]


def _check_spaces(path: Path, inputs: Any, outputs: Any, params: EnvParams) -> None:
    """Refuses spaces that are neither those of a boat nor those of the team."""
    columns = len(column_names(features(params)))
    boat, team = (columns,), (params.num_boats, columns)
    spaces = {boat: (2,), team: (params.num_boats, 2)}
    if spaces.get(inputs.shape) != outputs.shape:
        known = " or ".join(f"{before} -> {after}" for before, after in spaces.items())
        raise ValueError(
            f"{path} maps observations {inputs.shape} to actions {outputs.shape}; with "
            f"{params.num_boats} boats it must be {known}"
        )
