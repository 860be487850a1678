"""Any policies on the same episodes, with honest statistics.

From Python: ``baselines.evaluate.compare``; from the command line: ``python -m
baselines.evaluate``. ``api`` checks a ``request``, runs what is missing in ``workers``, and
``store`` keeps every episode as it ends. ``results`` are the rows, ``statistics`` and ``summary``
evaluate them, ``report`` shows them.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from baselines.evaluate.api import compare as compare
    from baselines.evaluate.command import main as main

_MODULES = {"compare": "api", "main": "command"}


def __getattr__(name: str) -> Any:
    """Imports ``compare`` and ``main`` on demand: workers do without what they import."""
    if name in _MODULES:
        return getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
