"""How numbers are written: one function for each kind, for the terminal and all pages."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

NOTHING = "–"
"""In a cell, where nothing applies."""
MINUS, HYPHEN = "−", "-"
KEYS = ("value", "low", "high")
"""Of an estimate in a summary."""
SMALLEST_P = 0.001
DIGITS = {"cm": 2, "s": 1, "rad": 3}
"""Behind the point, by unit; two where a unit is not listed."""


def share(value: float | None) -> str:
    """A share, in percent; nearly all is not rounded to all, nor hardly any to none."""
    if value is None:
        return NOTHING
    text = f"{value:.1%}"
    rounded_away = text in ("0.0%", "100.0%") and value not in (0.0, 1.0)
    return f"{value:.2%}" if rounded_away else text


def share_interval(estimate: Mapping[str, Any]) -> str:
    """The interval of a share."""
    low, high = (_percent(estimate[key]) for key in ("low", "high"))
    return NOTHING if NOTHING in (low, high) else f"{low}% to {high}%"


def share_estimate(estimate: Mapping[str, Any]) -> str:
    """A share with its interval, in percent."""
    bounds = (_percent(estimate[key]) for key in ("low", "high"))
    return with_interval(share(estimate["value"]), *bounds)


def points(estimate: Mapping[str, Any]) -> str:
    """A difference of two shares with its interval, in points of a percent."""
    return with_interval(*(_signed(estimate[key], 1, 100.0) for key in KEYS))


def quantity(value: float | None, unit: str, scale: float = 1.0) -> str:
    """A number with as many digits as its unit deserves.

    Args:
        value: in the unit of its column.
        unit: in which it is written; it is not added.
        scale: from the one to the other.
    """
    return NOTHING if value is None else _number(scale * value, DIGITS.get(unit, 2))


def estimate(found: Mapping[str, Any], unit: str, scale: float = 1.0) -> str:
    """A quantity with its interval."""
    return with_interval(*(quantity(found[key], unit, scale) for key in KEYS))


def difference(found: Mapping[str, Any], unit: str, scale: float = 1.0) -> str:
    """A difference of two quantities with its interval, each with its sign."""
    return with_interval(*(_signed(found[key], DIGITS.get(unit, 2), scale) for key in KEYS))


def p_value(value: float | None) -> str:
    """The p-value of a test."""
    if value is None:
        return NOTHING
    return f"< {SMALLEST_P}" if value < SMALLEST_P else f"{value:.3f}"


def with_interval(value: str, low: str, high: str) -> str:
    """A number, and its interval where it has one."""
    return value if NOTHING in (low, high) else f"{value} [{low}, {high}]"


def _percent(value: float | None) -> str:
    return NOTHING if value is None else f"{100 * value:.1f}"


def _signed(value: float | None, digits: int, scale: float) -> str:
    if value is None:
        return NOTHING
    text = _number(scale * value, digits)
    return f"+{text}" if float(f"{scale * value:.{digits}f}") > 0 else text


def _number(value: float, digits: int) -> str:
    """With the sign of a minus, unless it is rounded to nothing."""
    text = f"{value:.{digits}f}"
    return (text if float(text) else text.lstrip(HYPHEN)).replace(HYPHEN, MINUS)
