"""Episodes as trajectories, for imitation and offline learning.

Each is a compressed NPZ of its own, ``CONDITION/POLICY/SEED.npz`` in the folder ``trajectories``
(``CONDITION/POLICY/N/SEED.npz`` for training N of several). Its arrays are the fields of
``Trajectory``, and ``about``, () text, metadata in JSON: the episode's row, the purpose of its
seed, names and version of the observation's features, the action mode, the control rate in Hz.

``reward[t]`` and ``observation[t + 1]`` follow from ``action[t]`` at ``observation[t]``.
"""

import json
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import numpy as np

from asv_env.files import named, write
from asv_env.params import EnvParams
from asv_env.sensing import observation
from baselines.learned.policy_file import UNREADABLE
from baselines.rollout import seeds
from baselines.rollout.episodes import Episode, PoseLog, Trajectory

FOLDER = "trajectories"


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
    with _open(file) as saved:
        arrays = {f.name: saved[f.name] for f in fields(Trajectory)}
    return Trajectory(**{**arrays, "terminated": bool(arrays["terminated"])}), about(file)


def about(file: Path) -> dict[str, Any]:
    """Returns the metadata of a trajectory, as ``load`` does, but does not read its arrays."""
    with _open(file) as saved:
        metadata: dict[str, Any] = json.loads(str(saved["about"]))
    return metadata


@contextmanager
def _open(file: Path) -> Iterator[Any]:
    """Yields a file's arrays by name; whatever is wrong with it raises a ValueError naming it."""
    try:
        with np.load(file, allow_pickle=False) as saved:
            yield saved
    except (*UNREADABLE, KeyError, ValueError) as error:
        raise ValueError(f"{file} is not a recorded trajectory: {error}") from error
