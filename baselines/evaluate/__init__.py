"""Any policies on the same episodes, with honest statistics: ``python -m baselines.evaluate``.

``conditions`` and ``suites`` say what is run and ``entrants`` who takes part; ``workers`` run it, and
``store`` keeps every episode as it ends. ``results`` are the rows, ``statistics`` and ``summary``
say what they amount to, ``report`` shows it.
"""

from __future__ import annotations

from collections.abc import Sequence


def main(arguments: Sequence[str] | None = None) -> None:
    """Entry point of ``asv-evaluate`` and of ``python -m baselines.evaluate``."""
    from baselines.evaluate import command  # workers do without what it imports

    command.main(arguments)
