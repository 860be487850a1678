"""Episodes over several processes.

A worker takes a job at a time and hands every episode over as soon as it ends. It computes on one
thread, and goes when the process that started it is gone.
"""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import threading
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any

import cloudpickle

from baselines.evaluate.conditions import Condition
from baselines.evaluate.policy_sources import PolicySource
from baselines.evaluate.store import Series
from baselines.rollout import runner, trajectories
from baselines.rollout.episodes import Label, PoseLog

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


class WorkerError(RuntimeError):
    """A worker has failed or was killed."""


@dataclass(frozen=True)
class Job:
    """Episodes to run.

    Attributes:
        series: to which they belong.
        condition: condition.
        source: of the policy.
        fingerprint: of the source when it was checked.
        label: of the rows.
        seeds: one an episode.
        num_envs: worlds side by side.
        record: folder for trajectories; None keeps none.
    """

    series: Series
    condition: Condition
    source: PolicySource
    fingerprint: str
    label: Label
    seeds: tuple[int, ...]
    num_envs: int
    record: Path | None = None

    def run(self) -> Iterator[PoseLog]:
        """Tracks in the order in which the episodes end, trajectories saved.

        Raises:
            ValueError: the policy has become another one since.
        """
        if self.source.fingerprint() != self.fingerprint:
            raise ValueError(f"{self.source.word} has changed since the run began: start it again")
        params, keep = self.condition.params, self.record is not None
        for log in runner.run(
            self.source.make, params, self.seeds, self.num_envs, self.label, keep
        ):
            if self.record is not None:
                trajectories.save(self.record, log, params)
            yield log


def run(jobs: Sequence[Job], workers: int) -> Iterator[tuple[Series, PoseLog]]:
    """Runs jobs; yields episodes as they end.

    Args:
        jobs: in the order in which they are begun.
        workers: processes; 0 runs everything in this one, as a debugger wants it.

    Raises:
        WorkerError: a worker has failed or was killed.
    """
    if workers == 0:
        for job in jobs:
            for log in job.run():
                yield job.series, log
        return
    todo = list(reversed(jobs))
    with _pool(min(workers, len(jobs))) as pool:
        while pool:
            for connection in wait(list(pool)):
                assert isinstance(connection, Connection)
                message = _received(connection, pool[connection])
                if message is not None:
                    yield message
                elif todo:
                    with _alive(pool[connection]):
                        connection.send_bytes(cloudpickle.dumps(todo.pop()))
                else:
                    del pool[connection]
                    connection.close()


def _received(connection: Connection, process: BaseProcess) -> tuple[Series, PoseLog] | None:
    """A finished episode, or None where a worker asks for a job."""
    with _alive(process):
        message: Any = connection.recv()
    if isinstance(message, str):
        raise WorkerError(f"a worker failed:\n{message}")
    return message


@contextmanager
def _alive(process: BaseProcess) -> Iterator[None]:
    """Says how a process ended that does not answer."""
    try:
        yield
    except (EOFError, OSError) as error:
        process.join()
        raise WorkerError(
            f"a worker ended with exit code {process.exitcode}; if memory ran out, use smaller "
            "--num-envs or --workers"
        ) from error


@contextmanager
def _pool(workers: int) -> Iterator[dict[Connection, BaseProcess]]:
    """Processes by the connection to each, which ask for a job with None."""
    context = multiprocessing.get_context("spawn")
    pool: dict[Connection, BaseProcess] = {}
    with _inherited():
        for _ in range(workers):
            ours, theirs = context.Pipe()
            process: BaseProcess = context.Process(target=_work, args=(theirs,), daemon=True)
            process.start()
            theirs.close()
            pool[ours] = process
    started = list(pool.values())
    try:
        yield pool
    finally:
        for process in started:
            process.terminate()


@contextmanager
def _inherited() -> Iterator[None]:
    """What workers find: one thread, and no interest in Ctrl-C, which is for the parent alone."""
    before = {name: os.environ.get(name) for name in THREADS}
    heard = signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.environ.update(dict.fromkeys(THREADS, "1"))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, heard)
        for name, value in before.items():
            os.environ.pop(name) if value is None else os.environ.update({name: value})


def _work(connection: Connection) -> None:
    """What a worker does."""
    threading.Thread(target=_leave_with_parent, daemon=True).start()
    while True:
        try:
            connection.send(None)
            job = pickle.loads(connection.recv_bytes())
        except (EOFError, OSError):
            return  # Nothing is left to do, or nobody to do it for.
        try:
            for log in job.run():
                connection.send((job.series, log))
        except Exception:
            connection.send(traceback.format_exc())
            return


def _leave_with_parent() -> None:
    """Ends this process when the one that started it is gone, even if it was killed."""
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)
