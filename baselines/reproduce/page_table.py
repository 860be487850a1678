"""The table in a page for readers, between two marks, so that no number there is typed in."""

from typing import Any

from baselines.evaluate.publish import marks
from baselines.reproduce.artefact import cell, markdown

START = "<!-- what follows is written by python -m baselines.reproduce -->"
END = "<!-- up to here -->"


def check(text: str) -> None:
    """Raises ValueError unless a page can take the table; see ``marks.check``."""
    marks.check(text, START, END)


def updated(text: str, table: dict[str, Any]) -> str:
    """Returns the text of a page with the table of ``fig10_trials`` between its marks."""
    return marks.replaced(text, START, END, markdown(short(table)))


def short(table: dict[str, Any]) -> dict[str, Any]:
    """Returns the table with means and deviations in one column, and without the rest."""
    rows = [
        {
            "source": ", ".join(filter(None, (row["source"], row["policy"], row["scenario"]))),
            "trials": row["trials"],
            "closed": _percent(row["closed"]),
            "delivered": _percent(row["delivered"]),
            "smallest distance (cm)": _spread(row, "distance", "cm"),
            "heading error then (rad)": _spread(row, "heading", "rad"),
        }
        for row in table["rows"]
    ]
    return {"rows": rows, "notes": table["notes"]}


def _percent(fraction: float | None) -> str | None:
    return None if fraction is None else f"{fraction:.0%}"


def _spread(row: dict[str, Any], name: str, unit: str) -> str:
    mean, deviation = (_rounded(row[f"{name} {kind} ({unit})"]) for kind in ("mean", "sd"))
    return f"{mean} ± {deviation}"


def _rounded(value: float | None) -> str:
    """Returns as many digits as the paper gives."""
    return cell(value) if value is None else f"{round(value, 2) + 0.0:g}"
