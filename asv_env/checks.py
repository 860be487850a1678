"""Checks of parameters, whose errors name the value and what it may be."""

import difflib
import math
from collections.abc import Iterable, Sequence
from numbers import Integral, Real
from typing import Any

TINY = 1e-9  #: smallest value of a parameter that must be positive


class UnknownNameError(ValueError, KeyError):
    """A name that is not known; the message gives the nearest one."""

    __str__ = Exception.__str__


def choice(kind: str, value: object, known: Iterable[str]) -> str:
    """Returns ``value`` if it is one of the known names.

    Raises:
        UnknownNameError: with the nearest known name.
    """
    names = list(known)
    if value in names:
        return str(value)
    listed = ", ".join(map(repr, names))
    raise UnknownNameError(f"unknown {kind} {value!r}.{nearest(value, names)} Known: {listed}.")


def nearest(value: object, names: Sequence[str]) -> str:
    """Returns " Did you mean ...?" with the name that is most like a value, or nothing."""
    near = difflib.get_close_matches(str(value), names, n=1, cutoff=0.4)
    return f" Did you mean {near[0]!r}?" if near else ""


def is_finite(value: Any) -> bool:
    """Returns whether a value is a real, finite number."""
    if isinstance(value, bool) or not isinstance(value, Real):
        return False
    try:
        return math.isfinite(value)
    except OverflowError:
        return False


def check_numbers(owner: object, names: str, low: float, high: float = math.inf) -> None:
    """Refuses fields, named with spaces between, that are not finite numbers in [low, high]."""
    for name in names.split():
        value = getattr(owner, name)
        if not (is_finite(value) and low <= value <= high):
            raise ValueError(
                f"{type(owner).__name__}.{name} = {value!r}: must be a finite number in "
                f"[{low:g}, {high:g}]"
            )


def check_pair(owner: object, name: str, low: float, what: str, ordered: bool = False) -> None:
    """Refuses a field that is not two finite numbers of at least ``low``."""
    value = getattr(owner, name)
    fine = isinstance(value, Sequence) and len(value) == 2 and all(map(is_finite, value))
    if not fine or min(value) < low or (ordered and value[0] > value[1]):
        raise ValueError(
            f"{type(owner).__name__}.{name} = {value!r}: must be {what}, two finite numbers of "
            f"at least {low:g}"
        )


def check_interval(owner: object, name: str, low: float) -> None:
    """Refuses a field that is not (smallest, largest), both at least ``low``."""
    check_pair(owner, name, low, "(smallest, largest)", ordered=True)


def check_whole(owner: object, names: str, low: int) -> None:
    """Refuses fields, named in one text, that are not whole numbers of at least ``low``."""
    for name in names.split():
        value = getattr(owner, name)
        if isinstance(value, bool) or not isinstance(value, Integral) or value < low:
            raise ValueError(
                f"{type(owner).__name__}.{name} = {value!r}: must be a whole number of at least "
                f"{low}"
            )


def check_num_boats(num_boats: Any) -> int:
    """Returns a team size.

    Raises:
        ValueError: not a whole number from 2 to 100.
    """
    whole = isinstance(num_boats, Integral) and not isinstance(num_boats, bool)
    if not whole or not 2 <= num_boats <= 100:
        raise ValueError(f"num_boats = {num_boats!r}: must be a whole number from 2 to 100")
    return int(num_boats)
