"""Commands that end with a message instead of a traceback where something is wrong."""

import os
import signal
import sys
import threading
from _thread import interrupt_main
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import tyro
from tyro.constructors import PrimitiveConstructorSpec

from asv_env.numerics import numerics
from asv_env.text import one_line
from baselines.rollout.process_state import Terminated, neutral

LONGEST = 1000  #: largest number of characters of a line of a message
AGAIN = 0.01  #: time after which a signal that was lost comes again, s
FilePath = Annotated[
    Path,
    PrimitiveConstructorSpec[Path](
        nargs=1,
        metavar="PATH",
        instance_from_str=lambda given: Path(os.path.expanduser(given[0])),
        is_instance=lambda given: isinstance(given, Path),
        str_from_instance=lambda path: [str(path)],
    ),
]
"""Path as an option: shells leave the ``~`` of ``--out=~/run`` to the program."""
ENDING = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
"""Signals that end a command; the second comes when its terminal is closed."""


@contextmanager
def steady() -> Iterator[None]:
    """Runs a block as a command of its own, also within another program.

    NumPy treats errors of numbers as when a program begins, warnings are no errors, and
    signals of ``ENDING`` raise ``Terminated``, unless the program handles them. Of signals only the
    main thread hears. Where nobody reads what is printed any more, as with ``| head``, the command
    ends without a word.
    """
    with neutral(), numerics(), _read_or_over(), ExitStack() as stack:
        if threading.current_thread() is threading.main_thread():
            for number in ENDING:
                if signal.getsignal(number) is signal.SIG_DFL:
                    stack.callback(signal.signal, number, signal.signal(number, _terminate))
            stack.callback(setattr, sys, "unraisablehook", sys.unraisablehook)
            sys.unraisablehook = partial(_hear_again, sys.unraisablehook)
        yield


@contextmanager
def _read_or_over() -> Iterator[None]:
    try:
        yield
    except BrokenPipeError:
        _discard_output()
        sys.exit(1)


def _discard_output() -> None:
    """Sends the standard output nowhere, so that what is still in it is no error at the end."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)


def _terminate(number: int, _: Any) -> None:
    raise Terminated(signal.Signals(number).name)


@contextmanager
def unbroken() -> Iterator[None]:
    """Runs a block to its end before a signal ends the command.

    For libraries that, stopped in the middle of a file, fail with an error of their own.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    heard: list[int] = []
    with ExitStack() as stack:
        for number in (signal.SIGINT, *ENDING):
            if signal.getsignal(number) is not None:  # else it is handled by C code
                before = signal.signal(number, lambda number, _: heard.append(number))
                stack.callback(signal.signal, number, before)
        yield
    if heard:
        signal.raise_signal(heard[0])


def _hear_again(report: Callable[[Any], object], unraisable: Any) -> None:
    """Has a signal come again that came in a callback of a C library, where errors are lost."""
    error = unraisable.exc_value
    if isinstance(error, KeyboardInterrupt):
        number = signal.Signals[str(error)] if isinstance(error, Terminated) else signal.SIGINT
        threading.Timer(AGAIN, interrupt_main, (number,)).start()
    else:
        report(unraisable)


def command(function: Callable[..., object], program: str) -> Callable[..., None]:
    """Returns a ``main`` that calls a function with what a command line gives as its arguments.

    Where the function raises a ValueError, OSError or ImportError, the program exits with it.
    """

    def main(arguments: Sequence[str] | None = None) -> None:
        try:
            with steady():
                tyro.cli(function, args=arguments, prog=program)
        except (ValueError, OSError, ImportError) as error:
            sys.exit(f"{program}: {one_line(str(error), LONGEST)}")
        except KeyboardInterrupt:
            sys.exit(f"{program}: stopped; give the same command to continue")

    return main


def say(text: object) -> None:
    """Prints a text, whatever the standard output is: nothing, closed, or of a small alphabet."""
    stream = sys.stdout
    if stream is None:
        return
    encoding = getattr(stream, "encoding", None) or "utf-8"
    try:
        plain = str(text).encode(encoding, "backslashreplace").decode(encoding)
        print(plain, file=stream, flush=True)
    except BrokenPipeError:  # what is still to be done is done all the same
        _discard_output()
    except (OSError, ValueError):
        pass
