"""Finished episodes on disk, kept one by one, so that a run can be stopped at any moment.

A database in the output folder holds the provenance of its episodes: suite, code and libraries.
Episodes follow from these alone. So an episode that is there is never run again, and episodes of
different provenance are never mixed.
"""

import json
import os
import sqlite3
import zlib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, closing, contextmanager
from dataclasses import asdict, astuple, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from asv_env.files import PERMISSION, SPACE, remove
from asv_env.geometry import wrap
from asv_env.types import Float
from baselines.rollout import trajectories
from baselines.rollout.episodes import Episode, PoseLog
from baselines.rollout.lock import lock

NAME = "episodes.sqlite"  #: file name of the database
POLICY = "policy "  #: prefix of a policy's name in the provenance
LAYOUT = 5  #: version of the database's layout: a new one wherever an old database would be misread
UNITS = (1e-3, 1e-3, 1e-4)  #: resolution of stored poses: m, m, rad
TABLES = """
CREATE TABLE IF NOT EXISTS provenance (name TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS episode (
    condition TEXT, policy TEXT, training INTEGER, seed INTEGER,
    row TEXT NOT NULL, log BLOB NOT NULL, checksum INTEGER NOT NULL,
    PRIMARY KEY (condition, policy, training, seed)
);
"""
SUFFIXES = ("", "-journal", "-wal", "-shm")  #: of the files that a database may consist of
REMEDY = "remove it, or begin again with --overwrite"
OF_RUN = "FROM episode WHERE condition = ? AND policy = ? AND training = ?"


@dataclass(frozen=True, order=True)
class RunKey:
    """Names a run: the episodes of one policy (one of its trainings) in one condition."""

    condition: str
    policy: str
    training: int


class Store:
    """The database of an output folder, which need not exist, and the lock of that folder.

    Its episodes have a provenance (suite, code and libraries, by name), and policies fingerprints.
    With ``replace``, those of others may be removed, and a damaged database; ``dropped`` names
    their policies. Every episode has a checksum, and all are compared when the database is opened.

    Raises:
        FileExistsError: the folder holds episodes of other provenance, or another run writes to it.
        OSError: the database is damaged, or cannot be written.
    """

    def __init__(
        self,
        folder: Path,
        provenance: Mapping[str, Any],
        policies: Mapping[str, Any],
        replace: bool,
    ) -> None:
        self._path = folder / NAME
        with ExitStack() as stack:
            stack.callback(lock(folder).release)
            self._base = stack.enter_context(self._opened(folder, provenance, policies, replace))
            self._open = stack.pop_all()

    @contextmanager
    def _opened(
        self,
        folder: Path,
        provenance: Mapping[str, Any],
        policies: Mapping[str, Any],
        replace: bool,
    ) -> Iterator[sqlite3.Connection]:
        shared = {"layout": LAYOUT, **provenance}
        own = {f"{POLICY}{name}": value for name, value in policies.items()}
        wanted = {name: json.dumps(v, sort_keys=True) for name, v in {**shared, **own}.items()}
        try:
            found, broken = _provenance(self._path), False
        except DamagedError:
            if not replace:
                raise
            found, broken = {}, True
        expected = dict.fromkeys(shared, "nothing") if found else {}
        before = {**wanted, **expected, **found}
        changed = [name for name in wanted if before[name] != wanted[name]]
        if changed and not replace:
            name = changed[0]
            raise FileExistsError(
                f"{folder} holds episodes of another {name} ({before[name]}, now {wanted[name]}): "
                "choose another folder with --out, or replace them with --overwrite"
            )
        if broken or set(changed) & set(shared):
            for suffix in SUFFIXES:
                remove(self._path.with_name(f"{NAME}{suffix}"))
            changed = list(found)
        self.dropped = tuple(n.removeprefix(POLICY) for n in changed if n.startswith(POLICY))
        if broken:  # then the trajectories say which there were
            self.dropped = trajectories.policies(folder)
        with _errors_named(self._path), closing(_connect(self._path)) as base:
            base.execute("PRAGMA locking_mode = EXCLUSIVE")
            base.executescript(TABLES)
            with base:
                for policy in self.dropped:
                    base.execute("DELETE FROM episode WHERE policy = ?", (policy,))
                base.executemany("REPLACE INTO provenance VALUES (?, ?)", wanted.items())
            yield base

    def close(self) -> None:
        """Closes the database, and gives the folder back."""
        self._open.close()

    def seeds(self, key: RunKey) -> set[int]:
        """Returns the seeds of the stored episodes of a run."""
        with _errors_named(self._path):
            found = self._base.execute(f"SELECT seed {OF_RUN}", astuple(key))
            return {seed for (seed,) in found}

    def add(self, key: RunKey, log: PoseLog) -> None:
        """Stores an episode; it is on disk when this returns."""
        where = (*astuple(key), log.episode.seed)
        row, blob = json.dumps(asdict(log.episode)), packed(log)
        values = (*where, row, blob, _checksum(*where, row, blob))
        with _errors_named(self._path), self._base:
            self._base.execute("REPLACE INTO episode VALUES (?, ?, ?, ?, ?, ?, ?)", values)

    def rows(self, key: RunKey, seeds: range) -> Iterator[Episode]:
        """Yields the stored episodes of a run that have these seeds, in their order."""
        query = f"SELECT row {OF_RUN} AND seed >= ? AND seed < ? ORDER BY seed"
        with _errors_named(self._path):
            for (row,) in self._base.execute(query, (*astuple(key), seeds.start, seeds.stop)):
                yield Episode(**json.loads(row))

    def log(self, key: RunKey, seed: int) -> PoseLog | None:
        """Returns the log of one episode, poses to the ``UNITS``; None if it is not there."""
        query = f"SELECT row, log {OF_RUN} AND seed = ?"
        with _errors_named(self._path):
            found = self._base.execute(query, (*astuple(key), seed)).fetchone()
            return None if found is None else unpacked(Episode(**json.loads(found[0])), found[1])


class DamagedError(OSError):
    """A file is not a database of episodes, or no longer a whole one."""


def _connect(path: Path) -> sqlite3.Connection:
    return sqlite3.connect(path, timeout=1.0, check_same_thread=False)


def _provenance(path: Path) -> dict[str, str]:
    """Returns the provenance of a database, as JSON by name; nothing of an empty one.

    Raises:
        DamagedError: it is not a whole database of episodes.
    """
    if not os.path.lexists(path):
        return {}
    if not path.is_file():
        raise DamagedError(f"{path} is not a file: {REMEDY}")
    with _errors_named(path), closing(_connect(path)) as base:
        ((answer,), *_) = base.execute("PRAGMA integrity_check(1)")
        if answer != "ok":
            raise ValueError(" ".join(answer.split()))
        tables = {name for (name,) in base.execute("SELECT name FROM sqlite_master")}
        if "provenance" not in tables:
            return {"layout": "an older one"} if tables else {}
        found = dict(base.execute("SELECT name, value FROM provenance"))
        if found.get("layout") == json.dumps(LAYOUT):
            _check(base.execute("SELECT * FROM episode"))
        return found


def _check(rows: Iterable[tuple[Any, ...]]) -> None:
    """Refuses episodes that differ from what was stored."""
    for *values, checksum in rows:
        if _checksum(*values) != checksum:
            raise ValueError(f"the episode of seed {values[3]} is not as it was stored")


def _checksum(*values: Any) -> int:
    """Returns a checksum of the columns of an episode."""
    *words, log = values
    return zlib.crc32(log, zlib.crc32(json.dumps(words).encode()))


@contextmanager
def _errors_named(path: Path) -> Iterator[None]:
    """Turns errors of the database into those that name its file and a remedy."""
    try:
        yield
    except (sqlite3.Error, ValueError, TypeError, zlib.error, OverflowError) as error:
        code = getattr(error, "sqlite_errorcode", 0) & 0xFF  # without its details
        if code in (sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED):
            raise FileExistsError(
                f"{path} is in use by another run: wait for it, or choose another folder with --out"
            ) from error
        if code in (sqlite3.SQLITE_FULL, sqlite3.SQLITE_IOERR):
            raise OSError(f"{path} cannot be written: {error}; {SPACE}") from error
        if code in (sqlite3.SQLITE_READONLY, sqlite3.SQLITE_PERM, sqlite3.SQLITE_CANTOPEN):
            raise PermissionError(f"{path} cannot be written: {error}; {PERMISSION}") from error
        raise DamagedError(
            f"{path} is damaged, or of something else ({error}): {REMEDY}"
        ) from error


def packed(log: PoseLog) -> bytes:
    """Returns goal, times of failure, sizes of boats, obstacles and poses as bytes.

    Poses are compressed differences of whole ``UNITS``.
    """
    whole = np.round(log.poses / UNITS).astype(np.int64)
    steps = np.diff(whole, axis=0, prepend=0)
    steps[1:, :, 2] = (steps[1:, :, 2] + 31416) % 62832 - 31416
    numbers = [*log.goal, *log.failed_at, *log.boat_size, len(log.obstacle)]
    head = np.array([*numbers, *log.obstacle.ravel()], dtype="<f8").tobytes()
    return head + zlib.compress(steps.astype("<i2").tobytes(), 9)


def unpacked(episode: Episode, blob: bytes) -> PoseLog:
    """Returns the log that was ``packed``."""
    team = episode.num_boats
    head = np.frombuffer(blob, "<f8", 4 + 2 * team)
    goal, failed_at, boat_size, (count,) = np.split(head, [3, 3 + team, 3 + 2 * team])
    rows = np.frombuffer(blob, "<f8", 5 * int(count), head.nbytes).reshape(-1, 5)
    packed_poses = blob[head.nbytes + rows.nbytes :]
    steps = np.frombuffer(zlib.decompress(packed_poses), "<i2").reshape(-1, 1 + team, 3)
    poses: Float = np.cumsum(steps, axis=0, dtype=np.int64) * np.array(UNITS)
    poses[..., 2] = wrap(poses[..., 2])
    known = goal.copy(), failed_at.copy(), rows.copy(), boat_size.copy()
    return PoseLog(episode, poses, *known)
