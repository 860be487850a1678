"""What results must not depend on: the state of the process, set by its user or by a policy."""

import gc
import locale
import os
import signal
import sys
import threading
import warnings
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from typing import Any

SIGNALS = [
    getattr(signal, name)
    for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGALRM")
    if hasattr(signal, name)
]  #: signals whose handlers are put back


class Terminated(KeyboardInterrupt):
    """A signal was received, which is named and ends a command as Ctrl-C does."""


@contextmanager
def neutral() -> Iterator[None]:
    """Keeps warnings that the user has turned into errors from ending what is not theirs.

    Other filters stay as they are: they change no result.
    """
    if not any(action == "error" for action, *_ in warnings.filters):
        yield
        return
    with warnings.catch_warnings():
        warnings.simplefilter("default")
        yield


@contextmanager
def restored() -> Iterator[None]:
    """Puts back at the end what a policy may have changed, so that no other one meets it.

    These are the current folder, the standard streams, the filters of warnings, the locale, the
    garbage collector, the limit of recursion, handlers of signals and which are blocked, an alarm
    that was set, and torch's default type and number of threads.
    """
    with ExitStack() as stack:
        stack.callback(_set_streams, sys.stdout, sys.stderr)
        stack.callback(gc.enable if gc.isenabled() else gc.disable)
        stack.callback(_attempt, sys.setrecursionlimit, sys.getrecursionlimit())
        stack.callback(_attempt, locale.setlocale, locale.LC_ALL, locale.setlocale(locale.LC_ALL))
        with suppress(OSError):  # a folder that was removed
            stack.callback(_attempt, os.chdir, os.getcwd())
        if threading.current_thread() is threading.main_thread():
            for number in SIGNALS:
                stack.callback(_attempt, signal.signal, number, signal.getsignal(number))
            if hasattr(signal, "pthread_sigmask"):  # where there are alarms too
                blocked = signal.pthread_sigmask(signal.SIG_BLOCK, [])
                stack.callback(signal.pthread_sigmask, signal.SIG_SETMASK, blocked)
                if not any(signal.getitimer(signal.ITIMER_REAL)):
                    stack.callback(signal.setitimer, signal.ITIMER_REAL, 0.0)
        stack.callback(_set_torch, *_torch_state())
        stack.callback(_set_filters, list(warnings.filters))
        yield


def _attempt(function: Any, *arguments: Any) -> None:
    with suppress(OSError, ValueError, TypeError, locale.Error):
        function(*arguments)


def _set_streams(*streams: Any) -> None:
    sys.stdout, sys.stderr = (_open(stream, number) for number, stream in enumerate(streams, 1))


def _open(stream: Any, number: int) -> Any:
    """Returns a standard stream, opened again if it was closed."""
    if stream is None or not getattr(stream, "closed", False):
        return stream
    try:
        return open(number, "w", encoding="utf-8", errors="backslashreplace", closefd=False)
    except OSError:
        return None


def _set_filters(filters: list[Any]) -> None:
    if warnings.filters != filters:
        warnings.filters[:] = filters  # type: ignore[index]
        warnings._filters_mutated()  # type: ignore[attr-defined]


def _torch_state() -> tuple[Any, Any]:
    torch = sys.modules.get("torch")
    return (torch.get_default_dtype(), torch.get_num_threads()) if torch else (None, None)


def _set_torch(dtype: Any, threads: Any) -> None:
    """Puts back torch's settings, its own first ones where it was not imported before."""
    torch = sys.modules.get("torch")
    if torch is None:
        return
    torch.set_default_dtype(dtype or torch.float32)
    if threads is not None and torch.get_num_threads() != threads:
        torch.set_num_threads(threads)
