"""Policy files: the networks of a learned policy, what each was made for, and a model card.

A file is an NPZ. ``phase_i_weight_j`` (inputs, outputs) and ``phase_i_bias_j`` (outputs,) are the
layers of network i. ``policy`` is a JSON text: ``format`` is ``FORMAT``; ``phases`` are the
``metadata``, ``patience`` and ``team_size`` of each network, see ``Phase``; ``model_card`` tells
where the policy comes from (options, steps, seeds, scores) in any form.

Nothing in it is code: a file from a stranger can be read safely.

The files in ``FOLDER``, where there are any, are the policy ``learned``; see ``docs/learned.md``.
"""

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from asv_env.checks import check_num_boats, finite
from asv_env.files import write
from asv_env.params import EnvParams
from asv_env.tasks.task import Task
from baselines.learned import npz, team_policy
from baselines.learned.network import Layers, Metadata, NetworkPolicy
from baselines.learned.phases import Phase, PhasedPolicy
from baselines.policy import Policy

FOLDER = Path(__file__).parent / "weights"  #: folder of the files that are part of this package
FORMAT, SUFFIX = "asv-env policy 2", ".npz"


def save(path: Path, phases: Sequence[Phase], model_card: Mapping[str, Any]) -> None:
    """Writes a policy file, all at once; see ``asv_env.files.write``.

    Args:
        path: name of the file, ending in ``SUFFIX``.
        phases: one network, or those that ``PhasedPolicy`` takes.
        model_card: where the policy comes from; anything that JSON can express.

    Raises:
        ValueError: the name ends in something else.
        OSError: the file cannot be written.
    """
    if path.suffix != SUFFIX:
        raise ValueError(f"{path}: a policy file ends in {SUFFIX}")
    kept = ("metadata", "patience", "team_size")
    described = [{key: asdict(phase)[key] for key in kept} for phase in phases]
    policy = {"format": FORMAT, "phases": described, "model_card": model_card}
    arrays = {
        f"phase_{number}_{name}_{depth}": np.asarray(array, dtype=np.float32)
        for number, phase in enumerate(phases)
        for depth, layer in enumerate(phase.layers)
        for name, array in zip(("weight", "bias"), layer, strict=True)
    }
    arrays["policy"] = np.array(json.dumps(policy))
    write(path, lambda part: np.savez_compressed(part, **arrays))  # type: ignore[arg-type]


def read(path: Path) -> tuple[list[Phase], dict[str, Any]]:
    """Returns the networks of a policy file, and its model card.

    Raises:
        ValueError: the file is not a policy file, or of another format.
        FileNotFoundError: there is no such file.
    """
    try:
        arrays = npz.read(path)
        policy = json.loads(str(arrays["policy"]))
        if policy["format"] != FORMAT:
            raise ValueError(f"its format is {policy['format']!r}")
        phases = [_phase(arrays, *item) for item in enumerate(policy["phases"])]
        if not isinstance(policy["model_card"], dict):
            raise ValueError("its model card is none")
        return phases, policy["model_card"]
    except (KeyError, ValueError, TypeError, AttributeError, RecursionError) as error:
        reason = " ".join(str(error).split())
        raise ValueError(
            f"{path} is not a policy file of the format {FORMAT!r}: {reason}"
        ) from error


def read_single(path: Path) -> tuple[Phase, dict[str, Any]]:
    """Returns the only network of a policy file, and its model card.

    Raises:
        ValueError: the file holds several networks, or see ``read``.
        FileNotFoundError: there is no such file.
    """
    phases, model_card = read(path)
    if len(phases) != 1:
        raise ValueError(f"{path} holds {len(phases)} networks: it must hold one")
    return phases[0], model_card


def load(path: Path, params: EnvParams) -> Policy:
    """Returns the policy of a file for an environment.

    Raises:
        ValueError: the file is not a policy file, or its policy is for something else.
        FileNotFoundError: there is no such file.
    """
    try:
        if team_policy.is_team_policy(path):
            return team_policy.TeamPolicy(team_policy.read(path)[0], params)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error
    phases, _ = read(path)
    try:
        if len(phases) == 1:
            return NetworkPolicy(phases[0].layers, phases[0].metadata, params)
        return PhasedPolicy(phases, params)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


def file_for(task: Task) -> Path:
    """Returns this package's file for a task: of all tasks with a goal it is the same."""
    return FOLDER / ("transport.npz" if task.has_goal else "approach.npz")


def learned_policy(params: EnvParams) -> Policy:
    """Returns this package's policy for the task of an environment; see ``load``.

    Raises:
        FileNotFoundError: the package has none for the task.
    """
    file = file_for(params.definition)
    if not file.exists():
        raise FileNotFoundError(
            f"the package has no {file.name} yet: train a policy (`python -m train --task approach`"
            ", `--task push`; docs/learned.md joins them) and give its file, such as "
            "runs/train/push-sb3-0/best.npz, instead of 'learned'"
        )
    return load(file, params)


def fingerprint() -> str:
    """Returns a digest of all files of this package."""
    files = sorted(FOLDER.glob(f"*{SUFFIX}"))
    return hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()[:16]


def _phase(arrays: Mapping[str, Any], number: int, fields: dict[str, Any]) -> Phase:
    prefix = f"phase_{number}_"
    depth = sum(name.startswith(f"{prefix}weight_") for name in arrays)
    layers = [(arrays[f"{prefix}weight_{n}"], arrays[f"{prefix}bias_{n}"]) for n in range(depth)]
    _check(layers)
    lists = {key: _words(fields["metadata"][key]) for key in ("tasks", "observation")}
    metadata = Metadata(**{**fields["metadata"], **lists})
    patience, team_size = fields["patience"], fields["team_size"]
    if patience is not None and (finite(patience) is None or patience <= 0):
        raise ValueError(f"patience = {patience!r}: must be a positive number")
    if team_size is not None:
        check_num_boats(team_size)
    return Phase(layers, metadata, patience, team_size)


def _words(value: Any) -> tuple[str, ...]:
    """Returns a list of names as a tuple."""
    if not isinstance(value, list) or not all(isinstance(word, str) for word in value):
        raise ValueError(f"{value!r} are not names")
    return tuple(value)


def _check(layers: Layers) -> None:
    """Refuses weights and biases that are not those of a perceptron."""
    shapes = [(weight.shape, bias.shape) for weight, bias in layers]
    fits = all(len(weight) == 2 and bias == weight[1:] for weight, bias in shapes)
    if not (shapes and fits and all(b[0][0] == a[0][1] for a, b in pairwise(shapes))):
        raise ValueError(f"layers of shapes {shapes} do not fit")
    if not all(array.dtype.kind == "f" for layer in layers for array in layer):
        raise ValueError("weights are not real numbers")
    if not all(np.isfinite(array).all() for layer in layers for array in layer):
        raise ValueError("weights are not finite")
