"""Runs episodes in several processes.

loky, a part of joblib, starts the processes. Each of them has one thread, and gets policies and
parameters as objects, so that classes and tasks of a notebook reach them. Within
``joblib.parallel_config("dask")`` the same jobs run on a Dask cluster.

What is sent is a batch of episodes that all begin together, and a killed run loses only these.
Workers end with the process that started them, even if it was killed, and leave Ctrl-C to it. They
also end with the comparison: those of the next one import modules as they are then. When one dies,
the batches that were running are run again one by one, which finds the policy that is to blame; all
others are finished.
"""

import math
import multiprocessing
import os
import re
import signal
import sys
import threading
import time
import traceback
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, replace
from multiprocessing import resource_tracker
from pathlib import Path
from typing import Any, Self

import cloudpickle
from joblib import Parallel, delayed, effective_n_jobs
from joblib.externals.loky import process_executor
from joblib.externals.loky.process_executor import BrokenProcessPool, ProcessPoolExecutor
from joblib.parallel import LokyBackend, get_active_backend

from asv_env.params import EnvParams
from asv_env.text import described, one_line
from baselines.evaluate import policy_sources
from baselines.evaluate.conditions import Suite
from baselines.evaluate.policy_sources import PolicySource, importing
from baselines.evaluate.store import RunKey
from baselines.rollout import runner, trajectories
from baselines.rollout.episodes import Label, PoseLog
from baselines.rollout.process_state import neutral, restored

POLL = 0.5  #: time between two looks of a worker at whether its parent is alive, s
WATCH = "watch of the parent"  #: name of the thread that looks
LONGEST = 500  #: largest number of characters of an error of a worker
ENVIRONMENT = {**dict.fromkeys(LokyBackend.MAX_NUM_THREADS_VARS, "1"), "PYTHONSAFEPATH": "1"}
"""Variables of a worker: one thread, and modules of the current folder only where its parent has
them too."""
KILLED = "SIGKILL"  #: the signal that ends a process when memory runs out

Batch = tuple[list[PoseLog], str]
"""Result of a batch: its logs, and what was wrong, "" nothing."""


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
        run = (self.source.factory, self.params, self.seeds, self.num_envs, self.label)
        for log in runner.run(*run, self.record is not None):
            if self.record is not None:
                trajectories.save(self.record, log, self.params)
            yield replace(log, trajectory=None)

    def batches(self, workers: int) -> Iterator[Self]:
        """Yields the job in parts whose episodes all run side by side, at least one a worker."""
        size = max(1, min(self.num_envs, -(-len(self.seeds) // workers)))
        for first in range(0, len(self.seeds), size):
            yield replace(self, seeds=self.seeds[first : first + size])

    def __str__(self) -> str:
        first, last = self.seeds[0], self.seeds[-1]
        seeds = f"seed {first}" if first == last else f"seeds {first} to {last}"
        return f"{self.key.policy}, {self.key.condition}, {seeds}"


def check_fit(policies: Mapping[str, Sequence[PolicySource]], suite: Suite, workers: int) -> None:
    """Checks policies as ``policy_sources.check_fit``, in a process that they may crash.

    It is this one where ``run`` would run the episodes in it, or elsewhere.

    Raises:
        ValueError: a policy does not fit, cannot be sent to a process, or ends it.
    """
    if _runs_here(workers) or not _has_own_pool():
        policy_sources.check_fit(policies, suite)
        return
    pool = ProcessPoolExecutor(1, env=ENVIRONMENT)
    name = ""
    try:
        with _starting():
            ready = pool.submit(os.getpid)
        ready.result()
        for name, trainings in policies.items():
            with _starting():
                begun = pool.submit(_check, _packed(name, ({name: trainings}, suite)), os.getpid())
            if wrong := begun.result():
                raise ValueError(wrong)
    except BrokenProcessPool as error:
        raise ValueError(
            f"{name}: its process {_death(error)}, as it was made or decided for the first time"
            if name
            else f"no worker process can be started, it {_death(error)}: use workers=0"
        ) from error
    finally:
        pool.shutdown(wait=True, kill_workers=True)


def _runs_here(workers: int) -> bool:
    """Returns whether everything runs in this process."""
    in_threads = getattr(get_active_backend()[0], "uses_threads", False)
    return workers == 0 or in_threads or multiprocessing.current_process().daemon


def _has_own_pool() -> bool:
    """Returns whether processes are started here, not by a backend of joblib that can do it."""
    backend = get_active_backend()[0]
    return isinstance(backend, LokyBackend) or not backend.supports_return_generator


def _packed(name: str, content: Any) -> bytes:
    """Returns what is sent to a worker; ValueError where it cannot be."""
    try:
        return bytes(cloudpickle.dumps(content))
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        raise ValueError(
            f"{name}: the policy or the task cannot be sent to another process "
            f"({described(error)}): use workers=0, which runs it in this one"
        ) from error


def _check(packed: bytes, parent: int) -> str:
    """Returns what is wrong with a policy, "" nothing."""
    _watch_parent(parent)
    try:
        with importing():
            policies, suite = cloudpickle.loads(packed)
        policy_sources.check_fit(policies, suite)
    except BaseException as error:
        return one_line(str(error), LONGEST) if isinstance(error, ValueError) else described(error)
    return ""


def run(jobs: Sequence[Job], workers: int) -> Iterator[tuple[RunKey, PoseLog]]:
    """Begins jobs in their order; yields episodes as they, or their batches, end.

    Without workers everything runs in this process, as a debugger wants it; so it does where this
    process may not start others, or joblib runs it in threads. An active joblib backend other than
    loky that returns results as they come, such as Dask, decides how many workers there are.

    Raises:
        WorkerError: a worker has failed or was killed; all others have done their work.
    """
    if _runs_here(workers):
        yield from _run_here(jobs)
        return
    local = _has_own_pool()
    batches = [b for job in jobs for b in job.batches(workers if local else effective_n_jobs())]
    try:
        packed = [_packed(str(job), job) for job in jobs]
    except ValueError as error:
        raise WorkerError(str(error)) from error
    yield from _run_local(deque(batches), workers, packed) if local else _run_elsewhere(batches)


def _run_here(jobs: Sequence[Job]) -> Iterator[tuple[RunKey, PoseLog]]:
    for job in jobs:
        with restored():
            for log in job.run():
                yield job.key, log


def _run_elsewhere(batches: Sequence[Job]) -> Iterator[tuple[RunKey, PoseLog]]:
    """Yields the episodes of batches that run where joblib decides."""
    tasks = [
        delayed(_run_numbered)(k, _packed(str(b), b), os.getpid()) for k, b in enumerate(batches)
    ]
    options = {"return_as": "generator_unordered", "batch_size": 1, "max_nbytes": None}
    for number, done in Parallel(**options)(tasks):
        yield from _logs(batches[number], done)


def _run_local(
    waiting: deque[Job], workers: int, packed: Sequence[bytes]
) -> Iterator[tuple[RunKey, PoseLog]]:
    """Yields the episodes of batches; a run of which a batch kills its worker is left out."""
    dead: dict[RunKey, str] = {}
    while waiting:
        running: dict[Future[Batch], Job] = {}
        before = len(waiting)
        try:
            yield from _in_pool(waiting, running, workers, packed)
        except BrokenProcessPool as broken:
            if len(waiting) == before:
                raise WorkerError(f"no worker process can be started: {_death(broken)}") from broken
            for suspect in running.values():
                if suspect.key in dead:
                    continue
                try:
                    yield from _in_pool(deque([suspect]), {}, 1, packed)
                except BrokenProcessPool as error:
                    dead.setdefault(suspect.key, f"{suspect}: its process {_death(error)}")
            waiting = deque(batch for batch in waiting if batch.key not in dead)
    if dead:
        raise WorkerError("\n".join(dead.values()))


def _in_pool(
    waiting: deque[Job], running: dict[Future[Batch], Job], workers: int, packed: Sequence[bytes]
) -> Iterator[tuple[RunKey, PoseLog]]:
    """Yields the episodes of batches that run in processes of their own.

    Those that have begun are moved from ``waiting`` to ``running`` until they are done. Every
    process imports the modules of all jobs (``packed``) first, as this one has done, so that no
    policy depends on which others have run in its process.
    """
    number = min(workers, len(waiting))
    pool = ProcessPoolExecutor(number, initializer=_load, initargs=(packed,), env=ENVIRONMENT)
    try:
        while waiting or running:
            while waiting and len(running) < workers:
                with _starting():
                    begun = pool.submit(_run_batch, _packed("", waiting[0]), os.getpid())
                running[begun] = waiting.popleft()
            broken = None
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                error = future.exception()
                if isinstance(error, BrokenProcessPool):
                    broken = error
                else:
                    yield from _logs(running.pop(future), future.result())
            if broken:
                raise broken
    finally:
        pool.shutdown(wait=True, kill_workers=True)


def _logs(batch: Job, done: Batch) -> Iterator[tuple[RunKey, PoseLog]]:
    logs, wrong = done
    for log in logs:
        yield batch.key, log
    if wrong:
        raise WorkerError(f"{batch}: {wrong}")


@contextmanager
def _starting() -> Iterator[None]:
    """Surrounds what starts processes, which need streams to flush, and inherit blocked signals.

    So Ctrl-C does not reach them; the main thread of this process hears of it afterwards.

    Raises:
        OSError: none can be started, by the limits of the system or because this process ends.
    """
    with ExitStack() as stack:
        if hasattr(signal, "pthread_sigmask"):
            resource_tracker.ensure_running()  # which would unblock them
            before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
            stack.callback(signal.pthread_sigmask, signal.SIG_SETMASK, before)
        for name in ("stdout", "stderr"):
            if getattr(sys, name) is None or getattr(getattr(sys, name), "closed", False):
                stack.callback(setattr, sys, name, getattr(sys, name))
                setattr(sys, name, stack.enter_context(open(os.devnull, "w")))
        try:
            yield
        except BrokenProcessPool:
            raise
        except (RuntimeError, OSError) as error:
            raise OSError(
                f"no worker process can be started ({described(error)}): use workers=0"
            ) from error


def _death(error: BaseException) -> str:
    """Returns how a worker died."""
    found = re.search(r"\b(\w+)\((-?\d+)\)", str(error))
    if found is None:
        return f"has failed: {described(error)}"
    name, code = found.groups()
    if name == KILLED:
        return f"was killed ({name}); if memory has run out, use smaller --num-envs or --workers"
    return f"was ended by the signal {name}" if int(code) < 0 else f"ended with exit code {code}"


def _load(packed: Sequence[bytes]) -> None:
    """Imports the modules of all jobs; the batches report what is wrong with them."""
    with importing():
        for job in packed:
            with suppress(BaseException):
                cloudpickle.loads(job)


def _run_numbered(number: int, packed: bytes, parent: int) -> tuple[int, Batch]:
    return number, _run_batch(packed, parent)


def _run_batch(packed: bytes, parent: int) -> Batch:
    """Runs a batch, whose failures are only text: errors of others may not be sendable."""
    _watch_parent(parent)
    logs: list[PoseLog] = []
    try:
        with importing():
            job: Any = cloudpickle.loads(packed)
        with neutral(), restored():
            logs.extend(job.run())
    except (ValueError, OSError, ImportError) as error:
        return logs, one_line(str(error), LONGEST)
    except BaseException as error:
        return logs, "".join(traceback.format_exception(error))
    return logs, ""


def _watch_parent(parent: int) -> None:
    """Has a worker of the process ``parent`` leave Ctrl-C to it, and end with it and not before.

    Loky replaces workers that grow by 300 MB, and warns of it. To compile takes as much.
    """
    if os.getppid() != parent:
        return
    process_executor._MAX_MEMORY_LEAK_SIZE = math.inf
    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    if WATCH not in {thread.name for thread in threading.enumerate()}:
        threading.Thread(target=_watch, args=(parent,), name=WATCH, daemon=True).start()


def _watch(parent: int) -> None:
    """Ends this process when its parent is gone."""
    while os.getppid() == parent:
        time.sleep(POLL)
    os._exit(1)
