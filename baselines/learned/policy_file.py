"""Policy files: a learned network, what it was made for, and a model card.

A file is an NPZ. ``weight_j`` (inputs, outputs) and ``bias_j`` (outputs,) are the layers of a
perceptron. ``policy`` is a JSON text: ``format`` is ``FORMAT``; ``metadata`` tells what the network
was made for, see ``Metadata``; ``model_card`` tells where it comes from (options, steps, seeds,
scores) in any form. Files of a network of sets have a format of their own, see ``team_policy``;
``load`` takes both.

Nothing in it is code: a file from a stranger can be read safely.
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from asv_env.files import write
from asv_env.params import EnvParams
from baselines.learned import npz, team_policy
from baselines.learned.network import Layers, Metadata, NetworkPolicy
from baselines.policy import Policy

LEARNED = Path(__file__).parent / "weights/learned.npz"  #: file of the policy ``learned``
FORMAT, SUFFIX = "asv-env policy 3", ".npz"


def save(path: Path, layers: Layers, metadata: Metadata, model_card: Mapping[str, Any]) -> None:
    """Writes a policy file, all at once; see ``asv_env.files.write``.

    Args:
        path: name of the file, ending in ``SUFFIX``.
        layers: those of the perceptron.
        metadata: what it was made for.
        model_card: where the policy comes from; anything that JSON can express.

    Raises:
        ValueError: the name ends in something else.
        OSError: the file cannot be written.
    """
    if path.suffix != SUFFIX:
        raise ValueError(f"{path}: a policy file ends in {SUFFIX}")
    policy = {"format": FORMAT, "metadata": asdict(metadata), "model_card": model_card}
    arrays = {
        f"{name}_{number}": np.asarray(array, dtype=np.float32)
        for number, layer in enumerate(layers)
        for name, array in zip(("weight", "bias"), layer, strict=True)
    }
    arrays["policy"] = np.array(json.dumps(policy))
    write(path, lambda part: np.savez_compressed(part, **arrays))  # type: ignore[arg-type]


def read(path: Path) -> tuple[Layers, Metadata, dict[str, Any]]:
    """Returns the layers of a policy file, what they were made for, and the model card.

    Raises:
        ValueError: the file is not a policy file, or of another format.
        FileNotFoundError: there is no such file.
    """
    try:
        arrays = npz.read(path)
        policy = json.loads(str(arrays.pop("policy")))
        if policy["format"] != FORMAT:
            raise ValueError(f"its format is {policy['format']!r}")
        if not isinstance(policy["model_card"], dict):
            raise ValueError("its model card is none")
        return _layers(arrays), _metadata(policy["metadata"]), policy["model_card"]
    except (KeyError, ValueError, TypeError, AttributeError, RecursionError) as error:
        reason = " ".join(str(error).split())
        raise ValueError(
            f"{path} is not a policy file of the format {FORMAT!r}: {reason}"
        ) from error


def load(path: Path, params: EnvParams) -> Policy:
    """Returns the policy of a file, of either format, for an environment.

    Raises:
        ValueError: the file is not a policy file, or its policy is for something else.
        FileNotFoundError: there is no such file.
    """
    is_team_policy = team_policy.is_team_policy(path)
    network = None if is_team_policy else read(path)[:2]
    try:
        if network is None:
            return team_policy.TeamPolicy(team_policy.read(path)[0], params)
        return NetworkPolicy(*network, params)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


def learned_policy(params: EnvParams) -> Policy:
    """Returns this package's policy for an environment; see ``load``.

    Raises:
        FileNotFoundError: the package has none.
    """
    if not LEARNED.exists():
        raise FileNotFoundError(
            f"the package has no {LEARNED.name} yet: train a policy (`python -m train.recipe`) and "
            "give its file, such as runs/train/recipe-0/policy.npz, instead of 'learned'"
        )
    return load(LEARNED, params)


def fingerprint() -> str:
    """Returns a digest of this package's policy."""
    content = LEARNED.read_bytes() if LEARNED.exists() else b""
    return hashlib.sha256(content).hexdigest()[:16]


def _layers(arrays: Mapping[str, Any]) -> Layers:
    depth = sum(name.startswith("weight_") for name in arrays)
    layers = [(arrays[f"weight_{n}"], arrays[f"bias_{n}"]) for n in range(depth)]
    _check(layers)
    return layers


def _metadata(fields: dict[str, Any]) -> Metadata:
    lists = {key: _words(fields[key]) for key in ("tasks", "observation")}
    return Metadata(**{**fields, **lists})


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
