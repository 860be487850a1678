"""Commands that end with a message instead of a traceback where something is wrong."""

import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
import tyro

FLOATS: dict[str, Any] = {**dict.fromkeys(("divide", "over", "invalid"), "warn"), "under": "ignore"}
"""What NumPy does about errors of numbers when a program begins."""


@contextmanager
def steady() -> Iterator[None]:
    """Runs a block as a command of its own, also within another program.

    NumPy treats errors of numbers as when a program begins, and a process that is asked to
    terminate stops as by Ctrl-C. Of signals only the main thread hears.
    """
    with np.errstate(**FLOATS):
        if threading.current_thread() is not threading.main_thread():
            yield
            return
        before = signal.signal(signal.SIGTERM, _interrupt)
        try:
            yield
        finally:
            signal.signal(signal.SIGTERM, before if before is not None else signal.SIG_DFL)


def _interrupt(*_: Any) -> None:
    raise KeyboardInterrupt


def command(function: Callable[..., object], program: str) -> Callable[..., None]:
    """Returns a ``main`` that calls a function with what a command line gives as its arguments.

    Where the function raises a ValueError, OSError or ImportError, the program exits with it.
    """

    def main(arguments: Sequence[str] | None = None) -> None:
        try:
            with steady():
                tyro.cli(function, args=arguments, prog=program)
        except (ValueError, OSError, ImportError) as error:
            sys.exit(f"{program}: {error}")
        except KeyboardInterrupt:
            sys.exit(f"{program}: stopped; give the same command to continue")

    return main
