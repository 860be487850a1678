"""Finished episodes on disk, kept one by one, so that a run can be stopped at any moment.

A database in the output folder holds by which suite, code and libraries they were made. Episodes
follow from these alone, so what is there is never made again; what was made by others is never
mixed with it.
"""

from __future__ import annotations

import json
import sqlite3
import zlib
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from asv_env.geometry import wrap
from asv_env.types import Float
from baselines.rollout.episodes import Episode, PoseLog

NAME = "episodes.sqlite"
POLICY = "policy "
"""What the names of policies begin with, among the origins."""
LAYOUT = 2
"""Of the rows and logs in the database: another one wherever old ones would be misread."""
UNITS = (1e-3, 1e-3, 1e-4)
"""In which poses are kept: m, m, rad."""
TABLES = """
CREATE TABLE IF NOT EXISTS origin (name TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS episode (
    condition TEXT, policy TEXT, training INTEGER, seed INTEGER, row TEXT NOT NULL, log BLOB NOT NULL,
    PRIMARY KEY (condition, policy, training, seed)
);
"""


@dataclass(frozen=True, order=True)
class Series:
    """Episodes of one policy (one of its trainings) in one condition."""

    condition: str
    policy: str
    training: int


class Store:
    """The database of an output folder.

    Args:
        folder: need not exist.
        origin: by what the episodes are made, by name.
        policies: what the policies are made from, by name.
        replace: whether episodes of another origin or of other policies may be removed.

    Attributes:
        dropped: policies whose episodes have been removed.

    Raises:
        FileExistsError: the folder holds episodes of another origin, or another run writes to it.
        OSError: the database cannot be written.
    """

    def __init__(
        self, folder: Path, origin: Mapping[str, Any], policies: Mapping[str, Any], replace: bool
    ) -> None:
        self._path = folder / NAME
        shared = {name: _text(value) for name, value in origin.items()}
        own = {f"{POLICY}{name}": _text(value) for name, value in policies.items()}
        wanted = {"layout": _text(LAYOUT), **shared, **own}
        found = _origin(self._path)
        other = [name for name in wanted if found.get(name, wanted[name]) != wanted[name]]
        if other and not replace:
            name = other[0]
            raise FileExistsError(
                f"{folder} holds episodes of another {name} ({found[name]}, now {wanted[name]}): "
                "choose another folder with --out, or replace them with --overwrite"
            )
        if set(other) - set(own):
            self._path.unlink()
            other = [name for name in found if name.startswith(POLICY)]
        self.dropped = tuple(name.removeprefix(POLICY) for name in other)
        folder.mkdir(parents=True, exist_ok=True)
        with _named(self._path):
            self._base = sqlite3.connect(self._path, timeout=1.0)
            self._base.execute("PRAGMA locking_mode = EXCLUSIVE")
            self._base.executescript(TABLES)
            with self._base:
                for name in self.dropped:
                    self._base.execute("DELETE FROM episode WHERE policy = ?", (name,))
                self._base.executemany("REPLACE INTO origin VALUES (?, ?)", wanted.items())

    def close(self) -> None:
        """Leaves the database."""
        self._base.close()

    def seeds(self, series: Series) -> set[int]:
        """Of the episodes that are there."""
        query = "SELECT seed FROM episode WHERE condition = ? AND policy = ? AND training = ?"
        return {seed for (seed,) in self._base.execute(query, _key(series))}

    def add(self, series: Series, log: PoseLog) -> None:
        """Keeps an episode; it is on disk when this returns."""
        row = json.dumps(asdict(log.episode))
        values = (*_key(series), log.episode.seed, row, packed(log))
        with _named(self._path), self._base:
            self._base.execute("REPLACE INTO episode VALUES (?, ?, ?, ?, ?, ?)", values)

    def rows(self, series: Series, seeds: range) -> Iterator[Episode]:
        """Those of the episodes with these seeds that are there, in their order."""
        query = (
            "SELECT row FROM episode WHERE condition = ? AND policy = ? AND training = ? "
            "AND seed >= ? AND seed < ? ORDER BY seed"
        )
        for (row,) in self._base.execute(query, (*_key(series), seeds.start, seeds.stop)):
            yield Episode(**json.loads(row))

    def log(self, series: Series, seed: int) -> PoseLog | None:
        """One episode, poses to the ``UNITS``; None if it is not there."""
        query = (
            "SELECT row, log FROM episode "
            "WHERE condition = ? AND policy = ? AND training = ? AND seed = ?"
        )
        found = self._base.execute(query, (*_key(series), seed)).fetchone()
        return None if found is None else unpacked(Episode(**json.loads(found[0])), found[1])


def _text(value: Any) -> str:
    return json.dumps(value, sort_keys=True)


def _key(series: Series) -> tuple[str, str, int]:
    return series.condition, series.policy, series.training


@contextmanager
def _named(path: Path) -> Iterator[None]:
    """Errors of the database name its file, and say what can be done."""
    try:
        yield
    except sqlite3.DatabaseError as error:
        code = getattr(error, "sqlite_errorcode", None)
        if code in (sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED):
            raise FileExistsError(
                f"{path} is in use by another run: wait for it, or choose another folder with --out"
            ) from error
        if code == sqlite3.SQLITE_NOTADB:
            raise FileExistsError(
                f"{path} is not a database of episodes: remove it, or choose another --out"
            ) from error
        raise OSError(f"{path}: {error}") from error


def _origin(path: Path) -> dict[str, str]:
    """By what the episodes of a database were made; nothing of an empty one."""
    if not path.exists():
        return {}
    with _named(path), closing(sqlite3.connect(path, timeout=1.0)) as base:
        if not base.execute("SELECT 1 FROM sqlite_master WHERE name = 'origin'").fetchone():
            return {}
        return dict(base.execute("SELECT name, value FROM origin"))


def packed(log: PoseLog) -> bytes:
    """Poses as differences of whole ``UNITS``, compressed; then the goal and the failures."""
    whole = np.round(log.poses / UNITS).astype(np.int64)
    steps = np.diff(whole, axis=0, prepend=0)
    steps[1:, :, 2] = (steps[1:, :, 2] + 31416) % 62832 - 31416
    head = np.array([*log.goal, *log.failed_at], dtype="<f8").tobytes()
    return head + zlib.compress(steps.astype("<i2").tobytes(), 9)


def unpacked(episode: Episode, blob: bytes) -> PoseLog:
    """The reverse of ``packed``."""
    team = episode.num_boats
    head = np.frombuffer(blob, "<f8", 3 + team)
    steps = np.frombuffer(zlib.decompress(blob[head.nbytes :]), "<i2").reshape(-1, 1 + team, 3)
    poses: Float = np.cumsum(steps, axis=0, dtype=np.int64) * np.array(UNITS)
    poses[..., 2] = wrap(poses[..., 2])
    return PoseLog(episode, poses, head[:3].copy(), head[3:].copy())
