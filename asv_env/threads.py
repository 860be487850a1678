"""Threads over worlds: compiled loops give up the interpreter's lock, so they run side by side."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from itertools import count

from asv_env.checks import Whole

WORLDS_PER_THREAD = 64  #: fewest worlds for which another thread pays
RANGES = 8  #: ranges of worlds a thread takes one after the other, at most
MOST_THREADS = 256  #: largest number of threads


def cores() -> int:
    """Returns the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def checked(num_threads: int | None, num_worlds: int) -> int:
    """Returns a number of threads; for None all cores for many worlds, and one for few.

    Raises:
        ValueError: not a whole number from 1 to ``MOST_THREADS``.
    """
    if num_threads is None:
        return max(1, min(cores(), num_worlds // WORLDS_PER_THREAD, MOST_THREADS))
    return Whole(1, MOST_THREADS).checked("num_threads", num_threads)


def spread(task: Callable[[int, int, int], None], num_worlds: int, num_threads: int) -> None:
    """Calls ``task(first, last, thread)`` for ranges of worlds that make up all, side by side.

    There are more ranges than threads, and each thread takes the next one when it has done its
    last: some worlds have more contacts than others.
    """
    if num_threads == 1:
        task(0, num_worlds, 0)
        return
    ranges = min(num_threads * RANGES, max(num_threads, num_worlds // WORLDS_PER_THREAD))
    following = count()

    def work(thread: int) -> None:
        while (turn := next(following)) < ranges:
            task(num_worlds * turn // ranges, num_worlds * (turn + 1) // ranges, thread)

    pool = _pool(num_threads - 1, os.getpid())
    others = [pool.submit(work, thread) for thread in range(1, num_threads)]
    work(0)
    for other in others:
        other.result()


@cache
def _pool(threads: int, process: int) -> ThreadPoolExecutor:
    """Returns the threads beside the caller's own; a forked process has none of its parent's."""
    return ThreadPoolExecutor(threads, thread_name_prefix=f"worlds-{process}")
