"""The table in a page for readers, between two marks, so that no number there is typed in."""

from __future__ import annotations

from typing import Any

from baselines.reproduce.artefact import cell, markdown

START = "<!-- what follows is written by python -m baselines.reproduce -->"
END = "<!-- up to here -->"


def check(text: str) -> None:
    """Whether a page can take the table.

    Raises:
        ValueError: it has not just one mark of each kind, in their order.
    """
    if text.count(START) != 1 or text.count(END) != 1 or text.index(START) > text.index(END):
        raise ValueError(f"the page needs a line {START!r} and below it a line {END!r}, once each")


def updated(text: str, table: dict[str, Any]) -> str:
    """The text of a page with the table of ``trials`` between its marks."""
    check(text)
    before, _, rest = text.partition(START)
    _, _, after = rest.partition(END)
    return f"{before}{START}\n\n{markdown(short(table))}\n{END}{after}"


def short(table: dict[str, Any]) -> dict[str, Any]:
    """The table of ``trials`` with means and deviations in one column, and without the rest."""
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


def _percent(share: float | None) -> str | None:
    return None if share is None else f"{share:.0%}"


def _spread(row: dict[str, Any], name: str, unit: str) -> str:
    mean, deviation = (_rounded(row[f"{name} {kind} ({unit})"]) for kind in ("mean", "sd"))
    return f"{mean} ± {deviation}"


def _rounded(value: float | None) -> str:
    """As many digits as the paper gives."""
    return cell(value) if value is None else f"{round(value, 2) + 0.0:g}"
