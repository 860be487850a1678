"""Runs episodes in several processes, by joblib.

joblib starts the processes (its backend is loky), gives each of them one thread, and sends them
policies and parameters as objects, so that classes and tasks of a notebook reach them. Within
``joblib.parallel_config("dask")`` the same jobs run on a Dask cluster.

What joblib does not do is done here. joblib returns a task as a whole, so a task is a batch of
episodes that all begin together, and a killed run loses only these. Workers end with the process
that started them, even if it was killed, and leave Ctrl-C to it. They also end with the comparison:
those of the next one import modules as they are then. A single worker is this process itself.
"""

import os
import re
import signal
import threading
import time
import traceback
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Self

from joblib import Parallel, delayed, effective_n_jobs, parallel_config
from joblib.externals.loky import get_reusable_executor
from joblib.externals.loky.process_executor import BrokenProcessPool
from joblib.parallel import LokyBackend, get_active_backend

from asv_env.params import EnvParams
from baselines.evaluate.policy_sources import PolicySource
from baselines.evaluate.store import RunKey
from baselines.rollout import runner, trajectories
from baselines.rollout.episodes import Label, PoseLog

POLL = 0.5  #: time between two looks of a worker at whether its parent is alive, s
WATCH = "watch of the parent"  #: name of the thread that looks


class WorkerError(RuntimeError):
    """A worker has failed or was killed."""


@dataclass(frozen=True)
class Job:
    """Episodes of one run."""

    key: RunKey  #: run to which they belong
    params: EnvParams
    source: PolicySource
    fingerprint: str  #: that of the source when it was checked
    label: Label  #: names of policy and condition, for the rows
    seeds: Sequence[int]  #: one an episode
    num_envs: int  #: worlds side by side
    record: Path | None = None  #: folder for trajectories; None records none

    def run(self) -> Iterator[PoseLog]:
        """Yields logs as the episodes end, trajectories saved; ValueError if the policy changed."""
        if self.source.fingerprint() != self.fingerprint:
            raise ValueError(f"{self.source.word} has changed since the run began: start it again")
        run = (self.source.make, self.params, self.seeds, self.num_envs, self.label)
        for log in runner.run(*run, self.record is not None):
            if self.record is not None:
                trajectories.save(self.record, log, self.params)
            yield replace(log, trajectory=None)

    def batches(self, workers: int) -> Iterator[Self]:
        """Yields the job in parts whose episodes all run side by side, at least one a worker."""
        size = max(1, min(self.num_envs, -(-len(self.seeds) // workers)))
        for first in range(0, len(self.seeds), size):
            yield replace(self, seeds=self.seeds[first : first + size])


def run(jobs: Sequence[Job], workers: int) -> Iterator[tuple[RunKey, PoseLog]]:
    """Begins jobs in their order; yields episodes as they, or their batches, end.

    Without workers everything runs in this process, as a debugger wants it. An active joblib
    backend other than loky decides for itself how many there are.

    Raises:
        WorkerError: a worker has failed or was killed.
    """
    if workers == 0:
        yield from _run_here(jobs)
        return
    try:
        yield from _run(jobs, workers)
    except BrokenProcessPool as error:
        codes = ", ".join(re.findall(r"\w+\(-?\d+\)", str(error))) or "unknown"
        raise WorkerError(
            f"a worker ended with exit code {codes}; if memory ran out, use smaller --num-envs "
            "or --workers"
        ) from error
    except Exception as error:
        text = "".join(traceback.format_exception(error))
        raise WorkerError(f"a worker failed:\n{text}") from error


def _run_here(jobs: Sequence[Job]) -> Iterator[tuple[RunKey, PoseLog]]:
    for job in jobs:
        for log in job.run():
            yield job.key, log


def _run(jobs: Sequence[Job], workers: int) -> Iterator[tuple[RunKey, PoseLog]]:
    backend, _ = get_active_backend()
    local = isinstance(backend, LokyBackend)
    workers = workers if local else effective_n_jobs()
    batches = [batch for job in jobs for batch in job.batches(workers)]
    if local and min(workers, len(batches)) <= 1:
        yield from _run_here(jobs)
        return
    tasks = [delayed(_run_batch)(batch, os.getpid()) for batch in batches]
    options = {"return_as": "generator_unordered", "batch_size": 1, "max_nbytes": None}
    if local:
        with parallel_config("loky", inner_max_num_threads=1):
            pool = Parallel(n_jobs=min(workers, len(tasks)), **options)
    else:
        pool = Parallel(**options)
    for key, logs in pool(tasks):
        for log in logs:
            yield key, log
    if local:  # joblib itself ends the workers of a run that is broken off
        get_reusable_executor(reuse=True).shutdown(wait=True, kill_workers=True)


def _run_batch(job: Job, parent: int) -> tuple[RunKey, list[PoseLog]]:
    """Runs a batch; a worker of the process ``parent`` leaves Ctrl-C to it, and ends with it."""
    if os.getppid() == parent:
        if threading.current_thread() is threading.main_thread():
            signal.signal(signal.SIGINT, signal.SIG_IGN)
        if WATCH not in {thread.name for thread in threading.enumerate()}:
            threading.Thread(target=_watch, args=(parent,), name=WATCH, daemon=True).start()
    return job.key, list(job.run())


def _watch(parent: int) -> None:
    """Ends this process when its parent is gone."""
    while os.getppid() == parent:
        time.sleep(POLL)
    os._exit(1)
