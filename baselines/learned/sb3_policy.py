"""Policies that stable-baselines3 has saved.

Such a file holds pickled Python objects. Reading it runs whatever code is in it, so only files from
a trusted source should be read.
"""

from pathlib import Path
from pickle import PickleError
from typing import Any

import numpy as np

from asv_env.arguments import COMMANDS
from asv_env.params import EnvParams
from asv_env.sensing.observation import column_names, features
from asv_env.types import Action, Bool, Observation, Sensed


class Sb3Policy:
    """The deterministic policy of a stable-baselines3 model, whatever its algorithm.

    It maps either the observation (K,) of one boat to its action (2,), as trained on
    ``BoatVecEnv``, or that of the team (A, K) to (A, 2), as trained on ``gym.make``, or both with
    one axis, as with ``flat=True``. Discrete actions become the tracking actions for which they
    stand. Recurrent policies keep their state in the memory. Each world has a forward pass of its
    own, so that its actions do not depend on the batch.

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
        boat = (observation_size(params),)
        self._shape = (-1, *boat) if inputs.shape == boat else inputs.shape
        self._discrete = outputs.dtype.kind == "i"

    def act(
        self, sensed: Sensed, observation: Observation, memory: Any, fresh: Bool
    ) -> tuple[Action, Any]:
        """See ``Policy.act``; the memory is the state of a recurrent policy in each world."""
        states = memory or [None] * len(fresh)
        worlds, team = observation.shape[:2]
        rows = team if self._shape[0] == -1 else 1
        decided = [
            self._policy.predict(
                boats.reshape(self._shape), state, np.full(rows, new), deterministic=True
            )
            for boats, state, new in zip(observation, states, fresh, strict=True)
        ]
        action = np.stack([action for action, _ in decided])
        if self._discrete:
            action = COMMANDS[action]
        return action.reshape(worlds, team, 2).astype(np.float32), [state for _, state in decided]


def observation_size(params: EnvParams) -> int:
    """Returns the number of values that a boat observes."""
    return len(column_names(features(params)))


def _check_spaces(path: Path, inputs: Any, outputs: Any, params: EnvParams) -> None:
    """Refuses spaces that are neither those of a boat nor those of the team."""
    columns, team = observation_size(params), params.num_boats
    spaces = {(columns,): (2,), (team, columns): (team, 2), (team * columns,): (2 * team,)}
    discrete = {(columns,): (), (team, columns): (team,), (team * columns,): (team,)}
    allowed = discrete if outputs.dtype.kind == "i" else spaces
    if allowed.get(inputs.shape) != outputs.shape:
        known = " or ".join(f"{before} -> {after}" for before, after in allowed.items())
        raise ValueError(
            f"{path} maps observations {inputs.shape} to actions {outputs.shape}; with "
            f"{team} boats it must be {known}"
        )
    if allowed is discrete and params.action_mode != "tracking":
        raise ValueError(
            f"{path} gives discrete actions, which stand for tracking actions; the environment "
            f"takes {params.action_mode!r}: make it with action_mode='tracking'"
        )
