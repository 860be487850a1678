"""Policies in a file: a multilayer perceptron that runs on NumPy alone.

The file is an NPZ of arrays ``weight_i`` (inputs, outputs) and ``bias_i`` (outputs,), and of
``about``, a JSON text with the fields of ``About``. Nothing in it is code: reading one is safe.
"""

from __future__ import annotations

import json
import zipfile
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from asv_env.checks import check_number, check_whole, choice
from asv_env.params import ACTION_MODES, EnvParams
from asv_env.sensing import observation
from asv_env.tasks import TASKS, formation
from asv_env.tasks.formation import relate
from asv_env.types import Action, Bool, Float, Observation, Sensed
from baselines.mirror import SideAway, SideMemory
from baselines.scripted.scripted_policy import ScriptedPolicy

FORMAT, SUFFIX = "asv-env policy 1", ".npz"
ACTIVATIONS: dict[str, Callable[[Float], Float]] = {
    "tanh": np.tanh,
    "relu": lambda x: np.maximum(x, 0.0),
}
UNREADABLE = (zipfile.BadZipFile, zlib.error, EOFError)
"""What reading a damaged NPZ raises."""
Layers = Sequence[tuple[Float, Float]]


@dataclass(frozen=True)
class About:
    """What a policy was made for.

    Attributes:
        tasks: for which it may be used.
        action_mode: what its actions mean, "tracking" or "thrusters".
        activation: between the layers, a key of ``ACTIVATIONS``.
        decide_every: control ticks for which an action is held.
        residual: share of a full action by which it corrects the scripted policy, which then acts
            too; 0 for a policy that acts alone.
        mirrors: whether it always finds the goal ahead of it, see ``sides``.
        observation_version: of ``asv_env.sensing.observation`` when it was trained.
        card: where it comes from: data, steps, seeds; free of form.
        format: of the file.
    """

    tasks: tuple[str, ...] = tuple(TASKS)
    action_mode: str = "tracking"
    activation: str = "tanh"
    decide_every: int = 1
    residual: float = 0.0
    mirrors: bool = False
    observation_version: int = observation.VERSION
    card: dict[str, Any] = field(default_factory=dict)
    format: str = FORMAT

    def __post_init__(self) -> None:
        if self.format != FORMAT:
            raise ValueError(f"format {self.format!r}: this version reads {FORMAT!r}")
        for task in self.tasks:
            choice("task", task, TASKS)
        choice("action_mode", self.action_mode, ACTION_MODES)
        choice("activation", self.activation, ACTIVATIONS)
        check_whole(self, "decide_every", 1)
        check_number(self, "residual", 0.0, 1.0)


@dataclass
class Held:
    """What a team remembers.

    Attributes:
        action: (W, A, 2) of the network.
        ticks: (W,) for which it has been held.
        script: what the scripted policy remembers that is corrected, if one is.
        sides: from which sides the teams push, if it mirrors.
    """

    action: Action
    ticks: np.ndarray
    script: Any = None
    sides: SideMemory | None = None


class NetworkPolicy:
    """A perceptron that all boats share, from each one's observation (K,) to its action (2,).

    Args:
        layers: (weight (inputs, outputs), bias (outputs,)) of each, from the first on.
        about: what it was made for.
        params: of the environment.

    Raises:
        ValueError: it was made for another task, other actions or other observations.
    """

    def __init__(self, layers: Layers, about: About, params: EnvParams) -> None:
        _check_fit(layers, about, params)
        self._layers = [(np.asarray(w, np.float32), np.asarray(b, np.float32)) for w, b in layers]
        self._activation = ACTIVATIONS[about.activation]
        self._decide_every = about.decide_every
        self._residual = about.residual
        self._params = params
        self._away = SideAway(params) if about.mirrors else None
        self._script = ScriptedPolicy(params) if about.residual else None

    def act(
        self, sensed: Sensed, observation: Observation, memory: Held | None, fresh: Bool
    ) -> tuple[Action, Held]:
        """See ``Policy.act``."""
        ticks = np.zeros(len(fresh), dtype=np.int64) if memory is None else memory.ticks + 1
        due = fresh | (ticks % self._decide_every == 0)
        if self._away is None:
            sides, action = None, self.forward(observation)
        else:
            seen, sides = self._away.see(sensed, memory.sides if memory else None, fresh)
            action = self.forward(observed(seen, self._params))
            action[..., 1] *= sides.side[:, None].astype(np.float32)
        if memory is not None:
            action = np.where(due[:, None, None], action, memory.action)
        held = Held(action, np.where(due, 0, ticks), sides=sides)
        if self._script is None:
            return action, held
        script = None if memory is None else memory.script
        acts, held.script = self._script.act(sensed, observation, script, fresh)
        return np.clip(acts + self._residual * action, -1.0, 1.0).astype(np.float32), held

    def forward(self, observation: Observation) -> Action:
        """What the network says (W, A, 2), in [-1, 1], to observations (W, A, K).

        One product of matrices a world, whose shape does not depend on W: a world's actions are
        the same to the bit in every batch.
        """
        x: Float = observation
        for number, (weight, bias) in enumerate(self._layers):
            x = np.matmul(self._activation(x) if number else x, weight) + bias
        return np.clip(x, -1.0, 1.0).astype(np.float32)


def observed(sensed: Sensed, params: EnvParams) -> Observation:
    """What boats observe (W, A, K) of what is sensed, such as a world seen from another side."""
    relations = relate(sensed.estimate, sensed.goal, sensed.slot, sensed.side)
    holds = formation.occupied(relations, params.task)
    return observation.observe(sensed, relations, holds, params)


def _check_fit(layers: Layers, about: About, params: EnvParams) -> None:
    if params.task.name not in about.tasks:
        raise ValueError(
            f"the policy is for the task {' or '.join(about.tasks)}, not for {params.task.name!r}"
        )
    if about.action_mode != params.action_mode:
        raise ValueError(
            f"the policy gives {about.action_mode!r} actions, the environment takes "
            f"{params.action_mode!r}: make it with action_mode={about.action_mode!r}"
        )
    if about.observation_version != observation.VERSION:
        raise ValueError(
            f"the policy observes by version {about.observation_version}, the environment by "
            f"version {observation.VERSION}: train it again, or use the asv-env of its time"
        )
    sizes = (len(layers[0][0]), layers[-1][0].shape[1])
    if sizes != (len(observation.NAMES), 2):
        raise ValueError(
            f"the policy maps {sizes[0]} numbers to {sizes[1]}: it must map an observation of "
            f"{len(observation.NAMES)} to an action of 2"
        )


def save(path: Path, layers: Layers, about: About) -> None:
    """Writes a policy file (``.npz``)."""
    np.savez_compressed(path, **told(asdict(about)), **arrays(layers))


def told(about: Mapping[str, Any]) -> dict[str, Any]:
    """What a policy file says of itself, as an array."""
    return {"about": np.array(json.dumps(about))}


def arrays(layers: Layers, prefix: str = "") -> dict[str, Any]:
    """Layers as arrays by their names in a policy file."""
    return {
        f"{prefix}{name}_{number}": np.asarray(array, dtype=np.float32)
        for number, layer in enumerate(layers)
        for name, array in zip(("weight", "bias"), layer, strict=True)
    }


def read(path: Path) -> tuple[Layers, About]:
    """Layers of a policy file, and what it says of itself.

    Raises:
        ValueError: it is not such a file, or of another format.
        FileNotFoundError: there is none.
    """
    with contents(path, FORMAT) as (about, file):
        return layers_in(file), about_of(about)


@contextmanager
def contents(path: Path, *formats: str) -> Iterator[tuple[dict[str, Any], Mapping[str, Any]]]:
    """What a policy file says of itself, and its arrays by name.

    Raises:
        ValueError: it is no policy file, or what is made of it in the context does not go.
        FileNotFoundError: there is none.
    """
    if path.is_file() and not zipfile.is_zipfile(path):
        raise ValueError(f"{path} is not a policy file: not an NPZ")
    try:
        with np.load(path, allow_pickle=False) as file:
            about = json.loads(str(file["about"]))
            if about["format"] not in formats:
                raise ValueError(f"its format is {about['format']!r}")
            yield about, file
    except (*UNREADABLE, KeyError, ValueError, TypeError, AttributeError) as error:
        raise ValueError(
            f"{path} is not a policy file of the format {formats[0]!r}: {error}"
        ) from error


def about_of(fields_of: Mapping[str, Any]) -> About:
    """From JSON."""
    return About(**{**fields_of, "tasks": tuple(fields_of.get("tasks", tuple(TASKS)))})


def layers_in(file: Mapping[str, Any], prefix: str = "") -> Layers:
    """Layers from arrays by name.

    Raises:
        ValueError: they are not those of a perceptron.
        KeyError: some are missing.
    """
    count = sum(name.startswith(f"{prefix}weight_") for name in file)
    layers = [(file[f"{prefix}weight_{n}"], file[f"{prefix}bias_{n}"]) for n in range(count)]
    _check_layers(layers)
    return layers


def _check_layers(layers: Layers) -> None:
    """Refuses weights and biases that are not those of a perceptron."""
    shapes = [(weight.shape, bias.shape) for weight, bias in layers]
    fits = all(len(weight) == 2 and bias == weight[1:] for weight, bias in shapes)
    if not (shapes and fits and all(b[0][0] == a[0][1] for a, b in pairwise(shapes))):
        raise ValueError(f"layers of shapes {shapes} do not fit")
    if not all(np.isfinite(array).all() for layer in layers for array in layer):
        raise ValueError("weights are not finite")


def load(path: Path, params: EnvParams) -> NetworkPolicy:
    """The policy of a file, for an environment.

    Raises:
        ValueError: not a policy file, or a policy for something else.
        FileNotFoundError: there is none.
    """
    layers, about = read(path)
    try:
        return NetworkPolicy(layers, about, params)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error
