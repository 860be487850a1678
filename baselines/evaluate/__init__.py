"""Any policies on the same episodes, with honest statistics.

From Python: ``baselines.evaluate.compare``; from the command line: ``python -m
baselines.evaluate``. ``api`` checks a request, lets ``execution`` run what is missing in its
workers, and ``store`` keeps every episode as it ends. ``results`` are the rows, ``statistics`` and
``summary`` evaluate them, ``report`` shows them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from baselines.evaluate.api import compare as compare


def main(arguments: Sequence[str] | None = None) -> None:
    """Entry point of ``asv-evaluate`` and of ``python -m baselines.evaluate``."""
    from baselines.evaluate import command

    command.main(arguments)


def __getattr__(name: str) -> Any:
    """Imports ``compare`` when it is asked for: workers do without what it imports."""
    if name == "compare":
        from baselines.evaluate.api import compare

        return compare
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
