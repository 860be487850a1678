"""The page on the paper: tables that are put into it, each between two marks of its own.

So no number there is typed in.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from baselines.evaluate.publish import marks
from baselines.reproduce import fig10_trials
from baselines.reproduce.artefact import markdown, read_json

TABLES: dict[str, Callable[[dict[str, Any]], dict[str, Any]]] = {
    **dict.fromkeys(("turns", "reach", "plane", "calibration"), lambda table: table),
    "table": fig10_trials.short,
}
"""Names of the tables on the page, and the form in which each stands there."""


def borders(name: str) -> tuple[str, str]:
    """Returns the marks before and after a table."""
    by = "what follows is written by python -m baselines.reproduce"
    return f"<!-- {name}: {by} -->", f"<!-- {name}: up to here -->"


def check(text: str, names: list[str]) -> None:
    """Raises ValueError unless a page has the marks of these tables."""
    for name in names:
        marks.check(text, *borders(name))


def updated(text: str, folder: Path, names: list[str]) -> str:
    """Returns the text of a page with tables of a folder between their marks."""
    for name in names:
        content = markdown(TABLES[name](read_json(folder / f"{name}.json")))
        text = marks.replaced(text, *borders(name), content)
    return text
