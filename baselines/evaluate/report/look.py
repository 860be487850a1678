"""The look of figures follows from the program alone, not from the settings of its user."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from threading import RLock
from typing import Any

import matplotlib

_setting = RLock()


@contextmanager
def settings(own: Mapping[str, Any]) -> Iterator[None]:
    """Sets Matplotlib's own settings and some others, for the time of a block.

    Settings are those of the process: one thread at a time has them.
    """
    with _setting, matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(own)  # type: ignore[arg-type]
        yield
