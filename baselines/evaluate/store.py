"""Finished episodes on disk, kept one by one, so that a run can be stopped at any moment.

A database in the output folder holds the provenance of its episodes: suite, code and libraries.
Episodes follow from these alone. So an episode that is there is never run again, and episodes of
different provenance are never mixed.
"""

import json
import sqlite3
import zlib
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import asdict, astuple, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from asv_env.geometry import wrap
from asv_env.types import Float
from baselines.rollout.episodes import Episode, PoseLog

NAME = "episodes.sqlite"  #: file name of the database
POLICY = "policy "  #: prefix of a policy's name in the provenance
LAYOUT = 3  #: version of the database's layout: a new one wherever an old database would be misread
UNITS = (1e-3, 1e-3, 1e-4)  #: resolution of stored poses: m, m, rad
TABLES = """
CREATE TABLE IF NOT EXISTS provenance (name TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS episode (
    condition TEXT, policy TEXT, training INTEGER, seed INTEGER,
    row TEXT NOT NULL, log BLOB NOT NULL,
    PRIMARY KEY (condition, policy, training, seed)
);
"""
OF_RUN = "FROM episode WHERE condition = ? AND policy = ? AND training = ?"


@dataclass(frozen=True, order=True)
class RunKey:
    """Names a run: the episodes of one policy (one of its trainings) in one condition."""

    condition: str
    policy: str
    training: int


class Store:
    """The database of an output folder, which need not exist.

    Its episodes have a provenance (suite, code and libraries, by name), and policies fingerprints.
    With ``replace``, those of others may be removed; ``dropped`` names their policies.

    Raises:
        FileExistsError: the folder holds episodes of other provenance, or another run writes to it.
        OSError: the database cannot be written.
    """

    def __init__(
        self,
        folder: Path,
        provenance: Mapping[str, Any],
        policies: Mapping[str, Any],
        replace: bool,
    ) -> None:
        self._path = folder / NAME
        shared = {"layout": LAYOUT, **provenance}
        own = {f"{POLICY}{name}": value for name, value in policies.items()}
        wanted = {name: json.dumps(v, sort_keys=True) for name, v in {**shared, **own}.items()}
        found = _provenance(self._path)
        changed = [name for name in wanted if found.get(name, wanted[name]) != wanted[name]]
        if changed and not replace:
            name = changed[0]
            raise FileExistsError(
                f"{folder} holds episodes of another {name} ({found[name]}, now {wanted[name]}): "
                "choose another folder with --out, or replace them with --overwrite"
            )
        if set(changed) & set(shared):
            self._path.unlink()
            changed = list(found)
        self.dropped = tuple(n.removeprefix(POLICY) for n in changed if n.startswith(POLICY))
        folder.mkdir(parents=True, exist_ok=True)
        with _errors_named(self._path):
            self._base = sqlite3.connect(self._path, timeout=1.0)
            self._base.execute("PRAGMA locking_mode = EXCLUSIVE")
            self._base.executescript(TABLES)
            with self._base:
                for policy in self.dropped:
                    self._base.execute("DELETE FROM episode WHERE policy = ?", (policy,))
                self._base.executemany("REPLACE INTO provenance VALUES (?, ?)", wanted.items())

    def close(self) -> None:
        """Closes the database."""
        self._base.close()

    def seeds(self, key: RunKey) -> set[int]:
        """Returns the seeds of the stored episodes of a run."""
        return {seed for (seed,) in self._base.execute(f"SELECT seed {OF_RUN}", astuple(key))}

    def add(self, key: RunKey, log: PoseLog) -> None:
        """Stores an episode; it is on disk when this returns."""
        row = json.dumps(asdict(log.episode))
        values = (*astuple(key), log.episode.seed, row, packed(log))
        with _errors_named(self._path), self._base:
            self._base.execute("REPLACE INTO episode VALUES (?, ?, ?, ?, ?, ?)", values)

    def rows(self, key: RunKey, seeds: range) -> Iterator[Episode]:
        """Yields the stored episodes of a run that have these seeds, in their order."""
        query = f"SELECT row {OF_RUN} AND seed >= ? AND seed < ? ORDER BY seed"
        for (row,) in self._base.execute(query, (*astuple(key), seeds.start, seeds.stop)):
            yield Episode(**json.loads(row))

    def log(self, key: RunKey, seed: int) -> PoseLog | None:
        """Returns the log of one episode, poses to the ``UNITS``; None if it is not there."""
        query = f"SELECT row, log {OF_RUN} AND seed = ?"
        found = self._base.execute(query, (*astuple(key), seed)).fetchone()
        return None if found is None else unpacked(Episode(**json.loads(found[0])), found[1])


def _provenance(path: Path) -> dict[str, str]:
    """Returns the provenance of a database, as JSON by name; nothing of an empty one."""
    if not path.exists():
        return {}
    with _errors_named(path), closing(sqlite3.connect(path, timeout=1.0)) as base:
        tables = {name for (name,) in base.execute("SELECT name FROM sqlite_master")}
        if "provenance" in tables:
            return dict(base.execute("SELECT name, value FROM provenance"))
        return {"layout": "an older one"} if tables else {}


@contextmanager
def _errors_named(path: Path) -> Iterator[None]:
    """Turns errors of the database into those that name its file and a remedy."""
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


def packed(log: PoseLog) -> bytes:
    """Returns goal, times of failure, and poses as compressed differences of whole ``UNITS``."""
    whole = np.round(log.poses / UNITS).astype(np.int64)
    steps = np.diff(whole, axis=0, prepend=0)
    steps[1:, :, 2] = (steps[1:, :, 2] + 31416) % 62832 - 31416
    head = np.array([*log.goal, *log.failed_at], dtype="<f8").tobytes()
    return head + zlib.compress(steps.astype("<i2").tobytes(), 9)


def unpacked(episode: Episode, blob: bytes) -> PoseLog:
    """Returns the log that was ``packed``."""
    team = episode.num_boats
    head = np.frombuffer(blob, "<f8", 3 + team)
    steps = np.frombuffer(zlib.decompress(blob[head.nbytes :]), "<i2").reshape(-1, 1 + team, 3)
    poses: Float = np.cumsum(steps, axis=0, dtype=np.int64) * np.array(UNITS)
    poses[..., 2] = wrap(poses[..., 2])
    return PoseLog(episode, poses, head[:3].copy(), head[3:].copy())
