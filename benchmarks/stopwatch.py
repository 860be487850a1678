"""The time that is spent in some functions."""

import time
import timeit
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any


class Stopwatch:
    """Adds up the time spent in functions, each without that of the timed ones that it calls.

    Attributes:
        seconds: so far, by the names under which functions are timed.
        calls: so far, by the same names.
    """

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Sets times and calls to zero."""
        self.seconds: dict[str, float] = defaultdict(float)
        self.calls: Counter[str] = Counter()
        self._running: list[str] = []
        self._since = time.perf_counter()

    def timed(self, name: str, function: Callable[..., Any]) -> Callable[..., Any]:
        """Returns the function, whose time is added to that of ``name``."""

        def call(*args: Any, **kwargs: Any) -> Any:
            self._charge()
            self._running.append(name)
            try:
                return function(*args, **kwargs)
            finally:
                self._charge()
                self._running.pop()
                self.calls[name] += 1

        return call

    def timed_iterator(self, name: str, function: Callable[..., Any]) -> Callable[..., Any]:
        """Returns a function that yields, whose time is added to that of ``name``."""

        def call(*args: Any, **kwargs: Any) -> Iterator[Any]:
            following = self.timed(name, partial(next, function(*args, **kwargs), None))
            while (item := following()) is not None:
                yield item

        return call

    def overhead(self, tries: int = 20, calls: int = 20_000) -> tuple[float, float]:
        """Returns the additional seconds of a timed call: those that it is charged, and all."""

        def nothing(space: object, dt: float) -> None:
            pass

        names = {"nothing": nothing, "timed": self.timed("nothing", nothing)}
        inside, whole, plain = [], [], []
        for _ in range(tries):
            self.restart()
            plain.append(timeit.timeit("nothing(None, 0.0)", globals=names, number=calls))
            whole.append(timeit.timeit("timed(None, 0.0)", globals=names, number=calls))
            inside.append(self.seconds["nothing"])
        self.restart()
        # The fastest try is the one that the rest of the machine disturbed least.
        return (min(inside) - min(plain)) / calls, (min(whole) - min(plain)) / calls

    def _charge(self) -> None:
        """Adds the time since the last reading to the function that runs."""
        now = time.perf_counter()
        if self._running:
            self.seconds[self._running[-1]] += now - self._since
        self._since = now
