"""Episodes as trajectories, for imitation and offline learning.

Each is a compressed NPZ of its own, ``ARM/POLICY/SEED.npz`` below the folder ``trajectories``
(``ARM/POLICY/N/SEED.npz`` for the N-th of several trainings), with these arrays; T steps, A boats,
B = 1 + A bodies (the vessel first), K observed numbers:

==================  ======================  ========================================================
``observation``     (T + 1, A, K) float32   what each boat observed; the last at the end
``action``          (T, A, 2) float32       what it did, in [-1, 1]
``reward``          (T, A) float32
``motion``          (T + 1, B, 6) float64   the true state: x, y m, heading rad, vx, vy m/s,
                                            yaw rate rad/s
``working``         (T + 1, A) bool         whether a boat's thrusters work
``goal``            (T + 1, 3) float64      m, m, rad
``terminated``      () bool                 ended by success or straying; else by the clock
``about``           () text                 JSON: the episode's row, what its seed is for, the
                                            names of the observed numbers, the control rate in Hz
==================  ======================  ========================================================

``reward[t]`` and ``observation[t + 1]`` follow from ``action[t]`` at ``observation[t]``.
"""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import numpy as np

from asv_env.params import EnvParams
from asv_env.sensing import observation
from baselines.learned.network import UNREADABLE
from baselines.rollout import seeds
from baselines.rollout.episodes import Episode, PoseLog, Trajectory

FOLDER = "trajectories"


def folder(out: Path, condition: str, policy: str, training: int | None) -> Path:
    """Where the trajectories of some episodes lie, below a run's output folder."""
    own = out / FOLDER / condition / policy
    return own if training is None else own / str(training)


def remove(out: Path, policy: str) -> None:
    """Removes all trajectories of a policy below a run's output folder."""
    for own in (out / FOLDER).glob(f"*/{policy}"):
        shutil.rmtree(own)


def path(folder: Path, seed: int) -> Path:
    """Of the file of an episode."""
    return folder / f"{seed}.npz"


def clear(folder: Path) -> None:
    """Removes what runs that were killed have left half written."""
    for part in folder.glob("*.part"):
        part.unlink()


def holds(folder: Path, row: Episode) -> bool:
    """Whether the trajectory of just this episode is there."""
    try:
        return bool(about(path(folder, row.seed))["episode"] == asdict(row))
    except (FileNotFoundError, ValueError):
        return False


def save(folder: Path, log: PoseLog, params: EnvParams) -> None:
    """Writes the trajectory of a log, all at once; nothing of an episode with a policy error."""
    if log.trajectory is None:
        return
    arrays = {f.name: getattr(log.trajectory, f.name) for f in fields(Trajectory)}
    arrays["reward"] = arrays["reward"].astype(np.float32)
    told = {
        "episode": asdict(log.episode),
        "purpose": seeds.purpose(log.episode.seed),
        "observation_names": observation.NAMES,
        "observation_version": observation.VERSION,
        "action_mode": params.action_mode,
        "control_rate": params.clock.control,
    }
    folder.mkdir(parents=True, exist_ok=True)
    part = folder / f"{log.episode.seed}.{os.getpid()}.part"
    with part.open("wb") as file:
        np.savez_compressed(file, about=np.array(json.dumps(told)), **arrays)
    part.replace(path(folder, log.episode.seed))


def load(file: Path) -> tuple[Trajectory, dict[str, Any]]:
    """A trajectory, and what its file says about it.

    Raises:
        ValueError: not such a file.
        FileNotFoundError: there is none.
    """
    with _opened(file) as saved:
        arrays = {f.name: saved[f.name] for f in fields(Trajectory)}
    arrays["terminated"] = bool(arrays["terminated"])
    return Trajectory(**arrays), about(file)


def about(file: Path) -> dict[str, Any]:
    """What the file of a trajectory says about it; its arrays are not read.

    Raises:
        ValueError: not such a file.
        FileNotFoundError: there is none.
    """
    with _opened(file) as saved:
        told: dict[str, Any] = json.loads(str(saved["about"]))
    return told


@contextmanager
def _opened(file: Path) -> Iterator[Any]:
    """The file's arrays by name; whatever is wrong with it becomes a ValueError that names it."""
    try:
        with np.load(file, allow_pickle=False) as saved:
            yield saved
    except (*UNREADABLE, KeyError, ValueError) as error:
        raise ValueError(f"{file} is not a recorded trajectory: {error}") from error
