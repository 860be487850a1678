"""Reads the ``summary.json`` of a run, and writes its report in Markdown."""

import json
from pathlib import Path
from typing import Any

from baselines.evaluate.report import rendering
from baselines.evaluate.results import Results

NAME = "summary.json"
REMEDY = "put back a copy of it, or give the command of its evaluation again"
KNOWN = {"suite": str, "episodes": int, "provenance": dict, "policies": dict, "conditions": dict}
"""Fields that are read of a summary, and their types."""


def read(file: Path) -> dict[str, Any]:
    """Returns a summary.

    Raises:
        ValueError: the file is damaged, or not one.
        FileNotFoundError: there is none.
    """
    if not file.exists():
        raise FileNotFoundError(f"{file} does not exist: is its folder that of a run?")
    try:
        found = json.loads(file.read_bytes().decode())
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{file} is damaged ({error}): {REMEDY}") from error
    if not isinstance(found, dict):
        raise ValueError(f"{file} is no summary of a run: {REMEDY}")
    wrong = [name for name, kind in KNOWN.items() if not isinstance(found.get(name), kind)]
    if wrong:
        raise ValueError(f"{file} is no summary of a run, its {wrong[0]!r} is not one: {REMEDY}")
    return found


def markdown(file: Path, results: Results, summary: dict[str, Any]) -> str:
    """Returns the report of results and the summary of a file; ValueError where it does not fit."""
    try:
        return rendering.markdown(results, summary)
    except Exception as error:  # a field is missing, or of another type
        raise ValueError(
            f"{file} does not fit its episodes ({type(error).__name__}: {error}): {REMEDY}"
        ) from error
