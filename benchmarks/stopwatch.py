"""The time that an environment's steps spend in ``pymunk.Space.step``."""

import contextlib
import functools
import math
import time
import timeit
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any
from unittest import mock

import pymunk


@dataclass
class Sample:
    """One measurement.

    Attributes:
        steps: number of steps of all worlds.
        seconds: duration, without the stopwatch's own time.
        bare: part of it that was spent in ``Space.step``, s; NaN without one.
        touching: fraction of the boats that touch something at its end; NaN if unknown.
    """

    steps: int
    seconds: float
    bare: float = math.nan
    touching: float = math.nan


class Stopwatch:
    """Adds up the time spent in a function.

    Attributes:
        seconds: so far, with the part of the overhead that falls between the readings.
        calls: so far.
    """

    def __init__(self) -> None:
        self.restart()
        self._inside, self._whole = self._overhead()

    def around(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """Returns the function, timed."""

        @functools.wraps(function)
        def timed(*arguments: Any) -> Any:
            start = time.perf_counter()
            result = function(*arguments)
            self.seconds += time.perf_counter() - start
            self.calls += 1
            return result

        return timed

    def restart(self) -> None:
        """Sets time and calls to zero."""
        self.seconds, self.calls = 0.0, 0

    def sample(self, steps: int, seconds: float, touching: float) -> Sample:
        """Returns a measurement, with the time of the stopwatch itself taken off."""
        bare = self.seconds - self.calls * self._inside
        return Sample(steps, seconds - self.calls * self._whole, bare, touching)

    def _overhead(self, tries: int = 20, calls: int = 20_000) -> tuple[float, float]:
        """Returns the additional seconds of a call: between the two readings, and in all."""

        def nothing(space: object, dt: float) -> None:
            pass

        names = {"nothing": nothing, "timed": self.around(nothing)}
        inside, whole, plain = [], [], []
        for _ in range(tries):
            self.restart()
            plain.append(timeit.timeit("nothing(None, 0.0)", globals=names, number=calls))
            whole.append(timeit.timeit("timed(None, 0.0)", globals=names, number=calls))
            inside.append(self.seconds)
        self.restart()
        # The fastest try is the one that the rest of the machine disturbed least.
        return (min(inside) - min(plain)) / calls, (min(whole) - min(plain)) / calls


@contextlib.contextmanager
def timed_space_steps() -> Iterator[Stopwatch]:
    """Wraps ``pymunk.Space.step``; environments made inside are timed."""
    watch = Stopwatch()
    with mock.patch.object(pymunk.Space, "step", watch.around(pymunk.Space.step)):
        yield watch
