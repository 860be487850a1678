"""Episodes as trajectories, for imitation and offline learning.

Each is a compressed NPZ of its own, ``CONDITION/POLICY/SEED.npz`` in the folder ``trajectories``
(``CONDITION/POLICY/N/SEED.npz`` for training N of several). Its arrays are the fields of
``Trajectory``, and ``about``, () text, metadata in JSON: the episode's row, the purpose of its
seed, names and version of the observation's features, the action mode, the control rate in Hz.

``reward[t]`` and ``observation[t + 1]`` follow from ``action[t]`` at ``observation[t]``.
"""

import json
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import numpy as np

from asv_env.files import named, write
from asv_env.params import EnvParams
from asv_env.sensing import observation
from baselines.learned import npz
from baselines.rollout import seeds
from baselines.rollout.episodes import Episode, PoseLog, Trajectory

FOLDER = "trajectories"
METADATA = {
    "episode": dict,
    "purpose": str | None,
    "observation_names": list,
    "observation_version": int,
    "action_mode": str,
    "control_rate": int | float,
}
"""Metadata of a file, and their types."""


def folder(out: Path, condition: str, policy: str, training: int | None) -> Path:
    """Returns the folder for the trajectories of one run, in an output folder."""
    own = out / FOLDER / condition / policy
    return own if training is None else own / str(training)


def policies(out: Path) -> tuple[str, ...]:
    """Returns the names of the policies of which an output folder holds trajectories."""
    return tuple(sorted({own.name for own in (out / FOLDER).glob("*/*") if own.is_dir()}))


def remove(out: Path, policy: str) -> None:
    """Removes all trajectories of a policy from an output folder."""
    for own in (out / FOLDER).glob("*/*"):
        if own.name == policy:
            with named(own, "cannot be removed"):
                shutil.rmtree(own)


def path(folder: Path, seed: int) -> Path:
    """Returns the path of the trajectory of an episode."""
    return folder / f"{seed}.npz"


def files(folder: Path) -> list[Path]:
    """Returns all trajectories in a folder and its subfolders, none that is half written."""
    return sorted(file for file in folder.rglob("*.npz") if file.stem.isdigit())


def holds(folder: Path, row: Episode) -> bool:
    """Whether the trajectory of just this episode is in a folder."""
    try:
        return bool(about(path(folder, row.seed))["episode"] == asdict(row))
    except (FileNotFoundError, ValueError):
        return False


def save(folder: Path, log: PoseLog, params: EnvParams) -> None:
    """Writes the trajectory of a log, if it has one, all at once."""
    if log.trajectory is None:
        return
    arrays = {f.name: getattr(log.trajectory, f.name) for f in fields(Trajectory)}
    arrays["reward"] = arrays["reward"].astype(np.float32)
    metadata = {
        "episode": asdict(log.episode),
        "purpose": seeds.purpose(log.episode.seed),
        "observation_names": observation.column_names(observation.features(params)),
        "observation_version": observation.VERSION,
        "action_mode": params.action_mode,
        "control_rate": params.clock.control,
    }
    arrays["about"] = np.array(json.dumps(metadata))
    write(path(folder, log.episode.seed), lambda part: np.savez_compressed(part, **arrays))


def load(file: Path) -> tuple[Trajectory, dict[str, Any]]:
    """Returns a trajectory and its metadata.

    Raises:
        ValueError: the file is not a recorded trajectory.
        FileNotFoundError: there is no such file.
    """
    names = [f.name for f in fields(Trajectory)]
    arrays = _read(file, [*names, "about"])
    metadata = _metadata(file, arrays.pop("about"))
    _check(file, arrays)
    return Trajectory(**{**arrays, "terminated": bool(arrays["terminated"])}), metadata


def about(file: Path) -> dict[str, Any]:
    """Returns the metadata of a trajectory, as ``load`` does, but does not read its arrays."""
    return _metadata(file, _read(file, ["about"])["about"])


def _read(file: Path, names: Sequence[str]) -> dict[str, Any]:
    try:
        return npz.read(file, names)
    except ValueError as error:
        raise ValueError(f"{file} is not a recorded trajectory: {error}") from error


def _metadata(file: Path, text: Any) -> dict[str, Any]:
    """Returns the metadata that are written in a file; ValueError where they are others."""
    try:
        found = json.loads(str(text))
        wrong = [name for name, kind in METADATA.items() if not isinstance(found[name], kind)]
        episode = {f.name for f in fields(Episode)} - found["episode"].keys()
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
        reason = f"its metadata are damaged, {type(error).__name__}: {error}"
        raise ValueError(f"{file} is not a recorded trajectory: {reason}") from error
    if wrong or episode:
        missing = [*wrong, *sorted(episode)][0]
        raise ValueError(f"{file} is not a recorded trajectory: {missing!r} is wrong or missing")
    return dict(found)


def _check(file: Path, arrays: Mapping[str, Any]) -> None:
    """Refuses arrays that are not those of one episode."""
    shapes = {name: array.shape for name, array in arrays.items()}
    try:
        steps, boats, _ = shapes["action"]
        features = shapes["observation"][2]
        fits = shapes == {
            "observation": (steps + 1, boats, features),
            "action": (steps, boats, 2),
            "reward": (steps, boats),
            "motion": (steps + 1, 1 + boats, 6),
            "working": (steps + 1, boats),
            "goal": (steps + 1, 3),
            "obstacle": (len(arrays["obstacle"]), 5),
            "terminated": (),
        }
    except (ValueError, IndexError, TypeError):
        fits = False
    kinds = {name: "b" if name in ("working", "terminated") else "f" for name in arrays}
    if not fits or any(array.dtype.kind != kinds[name] for name, array in arrays.items()):
        raise ValueError(
            f"{file} is not a recorded trajectory: arrays of shapes {shapes} do not fit"
        )
