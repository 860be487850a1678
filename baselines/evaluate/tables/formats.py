"""The text of numbers: one function for each kind, for the terminal and all pages."""

from collections.abc import Mapping
from typing import Any

NOTHING = "–"  #: text of a cell that does not apply
MINUS, HYPHEN = "−", "-"
BOUNDS = ("low", "high")  #: keys of the interval of an estimate in a summary
KEYS = ("value", *BOUNDS)  #: keys of an estimate in a summary
SMALLEST_P = 0.001  #: the p-value below which only this bound is given
DECIMALS = {"cm": 2, "s": 1, "rad": 3}  #: number of decimals by unit; two where not listed


def share(value: float | None) -> str:
    """Returns a share in percent; only exactly none and all are written 0.0% and 100.0%."""
    if value is None:
        return NOTHING
    text = f"{value:.1%}"
    rounded_away = text in ("0.0%", "100.0%") and value not in (0.0, 1.0)
    return f"{value:.2%}" if rounded_away else text


def share_interval(estimate: Mapping[str, Any]) -> str:
    """Returns the interval of a share."""
    low, high = (_percent(estimate[key]) for key in BOUNDS)
    return NOTHING if NOTHING in (low, high) else f"{low}% to {high}%"


def share_estimate(estimate: Mapping[str, Any]) -> str:
    """Returns a share with its interval, in percent."""
    return with_interval(share(estimate["value"]), *(_percent(estimate[key]) for key in BOUNDS))


def points(estimate: Mapping[str, Any]) -> str:
    """Returns a difference of two shares with its interval, in percentage points."""
    return with_interval(*(_signed(estimate[key], 1, 100.0) for key in KEYS))


def quantity(value: float | None, unit: str, scale: float = 1.0) -> str:
    """Returns a number with the decimals of the unit in which it is written.

    The unit is no part of the text; ``scale`` is the factor from the unit of the column to it. The
    value is None where the column does not apply.
    """
    return NOTHING if value is None else _number(scale * value, DECIMALS.get(unit, 2))


def estimate(found: Mapping[str, Any], unit: str, scale: float = 1.0) -> str:
    """Returns a quantity with its interval; see ``quantity``."""
    return with_interval(*(quantity(found[key], unit, scale) for key in KEYS))


def difference(found: Mapping[str, Any], unit: str, scale: float = 1.0) -> str:
    """Returns a signed difference of two quantities with its interval; see ``quantity``."""
    return with_interval(*(_signed(found[key], DECIMALS.get(unit, 2), scale) for key in KEYS))


def p_value(value: float | None) -> str:
    """Returns the p-value of a test."""
    if value is None:
        return NOTHING
    return f"< {SMALLEST_P}" if value < SMALLEST_P else f"{value:.3f}"


def with_interval(value: str, low: str, high: str) -> str:
    """Returns a number, followed by its interval where it has one."""
    return value if NOTHING in (low, high) else f"{value} [{low}, {high}]"


def _percent(value: float | None) -> str:
    return NOTHING if value is None else f"{100 * value:.1f}"


def _signed(value: float | None, decimals: int, scale: float) -> str:
    if value is None:
        return NOTHING
    text = _number(scale * value, decimals)
    return f"+{text}" if float(f"{scale * value:.{decimals}f}") > 0 else text


def _number(value: float, decimals: int) -> str:
    """Returns a number with a typographic minus; what is rounded to zero has no sign."""
    text = f"{value:.{decimals}f}"
    return (text if float(text) else text.lstrip(HYPHEN)).replace(HYPHEN, MINUS)
