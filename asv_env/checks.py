"""Checks of parameters, which make values of them; errors name the value and what it may be.

A field of a dataclass states what it may be in its annotation, such as ``Annotated[float,
Number(0.0, 1.0)]``, and ``check_fields`` replaces what was given by Python's own floats, ints,
texts and tuples. Any finite real number is taken, of NumPy too, and any sequence or array of them.
"""

import difflib
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from numbers import Integral, Real
from typing import Any, NoReturn, get_args, get_type_hints

import numpy as np

from asv_env.text import LONGEST, described, shown

TINY = 1e-9  #: smallest value of a parameter that must be positive
LARGEST_TEAM = 100  #: largest number of boats
REAL, COMPLEX, TRUTH = "biuf", "c", "b"  #: kinds of numbers, as in ``dtype.kind``
NUMBERS = {REAL: "real", COMPLEX: "complex", TRUTH: "bool"}  #: their names in messages


class UnknownNameError(ValueError, KeyError):
    """A name that is not known; the message gives the nearest one."""

    __str__ = Exception.__str__


class UnknownOptionError(UnknownNameError, TypeError):
    """An option that is not known, in the words that Python has for it."""


class FunctionError(ValueError):
    """A function of a task or an observation has failed, or has returned what it must not."""


def called(kind: str, name: str, function: Callable[..., Any], *arguments: Any) -> Any:
    """Returns what a user's function returns.

    Raises:
        FunctionError: it fails; the message names it.
    """
    try:
        return function(*arguments)
    except Exception as error:
        raise _failed(kind, name, error) from error


def _failed(kind: str, name: str, error: Exception) -> FunctionError:
    return FunctionError(f"{kind} {name!r} failed: {described(error)}")


def values(
    forms: Mapping[tuple[int, ...], str],
    kind: str,
    name: str,
    function: Callable[..., Any],
    *arguments: Any,
) -> np.ndarray:
    """Returns what a user's function returns, an array.

    Args:
        forms: shapes that it may have, each with the kinds of its numbers as in ``dtype.kind``.
        kind: what the function is, for messages.
        name: name of that.
        function: the user's function.
        arguments: those of the function.

    Raises:
        FunctionError: it fails, or returns something else.
    """
    try:
        array = function(*arguments)
        if type(array) is not np.ndarray:
            array = np.asarray(array)
    except Exception as error:
        raise _failed(kind, name, error) from error
    if array.dtype.kind not in forms.get(array.shape, ""):
        allowed = " or ".join(f"{NUMBERS[numbers]} {shape}" for shape, numbers in forms.items())
        raise FunctionError(
            f"{kind} {name!r} returned {array.dtype} {array.shape}: must be {allowed}"
        )
    return array


def plain(value: Any) -> Any:
    """Returns the Python number, text or list of a NumPy scalar or an array; others as they are."""
    if not hasattr(type(value), "__array__"):
        return value
    try:
        return np.asarray(value).tolist()
    except Exception:  # an array of another library that cannot be read: the check refuses it
        return value


def choice(kind: str, value: object, known: Iterable[str]) -> str:
    """Returns the known name that ``value`` is.

    Raises:
        UnknownNameError: with the nearest known name.
    """
    names, word = list(known), plain(value)
    if isinstance(word, str) and word in names:
        return names[names.index(word)]
    listed = ", ".join(map(repr, names))
    raise UnknownNameError(f"unknown {kind} {shown(value)}.{nearest(word, names)} Known: {listed}.")


def refuse_option(name: str, known: Iterable[str]) -> NoReturn:
    """Refuses an option that has no place here, as Python refuses an argument.

    Raises:
        UnknownOptionError: with the nearest known name.
    """
    names = [each for each in known if each != name]
    raise UnknownOptionError(
        f"got an unexpected keyword argument {name!r}.{nearest(name, names)} "
        f"Known: {', '.join(names)}."
    )


def nearest(value: object, names: Sequence[str]) -> str:
    """Returns " Did you mean ...?" with the name that is most like a text, or nothing."""
    word = value[:LONGEST] if isinstance(value, str) else ""
    near = difflib.get_close_matches(word, names, n=1, cutoff=0.5)
    return f" Did you mean {near[0]!r}?" if near else ""


def finite(value: Any) -> float | None:
    """Returns a real, finite number as a float; None for anything else, truth values too."""
    if type(value) is float:  # The tests below take many times as long.
        return value if math.isfinite(value) else None
    number = plain(value)
    if isinstance(number, bool) or not isinstance(number, Real):
        return None
    try:
        converted = float(number)
    except (OverflowError, ValueError, TypeError):
        return None
    return converted if math.isfinite(converted) else None


def numbers(value: Any, count: int) -> tuple[float, ...] | None:
    """Returns a sequence or array of ``count`` finite numbers as floats; None for anything else."""
    items = plain(value)
    if not isinstance(items, Sequence) or isinstance(items, str | bytes) or len(items) != count:
        return None
    found = tuple(number for number in map(finite, items) if number is not None)
    return found if len(found) == count else None


@dataclass(frozen=True)
class Number:
    """A finite number in [low, high]."""

    low: float
    high: float

    def checked(self, name: str, value: Any) -> float:
        """Returns the value as a float; ValueError where it is none of these."""
        number = finite(value)
        if number is None or not self.low <= number <= self.high:
            raise ValueError(
                f"{name} = {shown(value)}: must be a finite number in [{self.low:g}, {self.high:g}]"
            )
        return number


@dataclass(frozen=True)
class Whole:
    """A whole number in [low, high]."""

    low: int
    high: float = math.inf

    def checked(self, name: str, value: Any) -> int:
        """Returns the value as an int; ValueError where it is none of these."""
        number = plain(value)
        whole = isinstance(number, Integral) and not isinstance(number, bool)
        if not whole or not self.low <= number <= self.high:
            bounded = self.high < math.inf
            allowed = f"from {self.low} to {self.high:g}" if bounded else f"of at least {self.low}"
            raise ValueError(f"{name} = {shown(value)}: must be a whole number {allowed}")
        return int(number)


@dataclass(frozen=True)
class Pair:
    """Two finite numbers in [low, high], of which an ``ordered`` pair has the smaller one first."""

    what: str
    low: float
    high: float
    ordered: bool = False

    def checked(self, name: str, value: Any) -> tuple[float, ...]:
        """Returns the value as a tuple of floats; ValueError where it is none of these."""
        pair = numbers(value, 2)
        if (
            pair is None
            or not self.low <= min(pair) <= max(pair) <= self.high
            or (self.ordered and pair[0] > pair[1])
        ):
            raise ValueError(
                f"{name} = {shown(value)}: must be {self.what}, two finite numbers in "
                f"[{self.low:g}, {self.high:g}]"
            )
        return pair


def interval(low: float, high: float) -> Pair:
    """Returns the check of (smallest, largest), both in [low, high]."""
    return Pair("(smallest, largest)", low, high, ordered=True)


@dataclass(frozen=True)
class Name:
    """One of some known names."""

    known: tuple[str, ...]

    def checked(self, name: str, value: Any) -> str:
        """Returns the known name; UnknownNameError where it is none."""
        return choice(name.rpartition(".")[2], value, self.known)


@dataclass(frozen=True)
class Truth:
    """True or False."""

    def checked(self, name: str, value: Any) -> bool:
        """Returns the value as a bool; ValueError where it is none."""
        truth = plain(value)
        if not isinstance(truth, bool):
            raise ValueError(f"{name} = {shown(value)}: must be True or False")
        return truth


Check = Number | Whole | Pair | Name | Truth


@cache
def fields_checked(kind: type) -> dict[str, tuple[Check, bool]]:
    """Returns the checks that the annotations of a class state, by field, and whether None is fine.

    Fields whose annotation states no check are left out.
    """
    found: dict[str, tuple[Check, bool]] = {}
    for name, hint in get_type_hints(kind, include_extras=True).items():
        parts = (hint, *get_args(hint))
        checks = [check for part in parts for check in getattr(part, "__metadata__", ())]
        if checks:
            found[name] = checks[0], type(None) in parts
    return found


def check_fields(owner: object) -> None:
    """Replaces the fields of a dataclass by values that its annotations allow.

    Raises:
        ValueError: a value that is not allowed, with the name of its field.
    """
    kind: Any = type(owner)
    for name, (check, optional) in fields_checked(kind).items():
        value = getattr(owner, name)
        if value is not None or not optional:
            _put(owner, name, check)


def check_numbers(owner: object, names: str, low: float, high: float = math.inf) -> None:
    """Makes floats of fields, named with spaces between, or refuses them; see ``Number``."""
    for name in names.split():
        _put(owner, name, Number(low, high))


def check_whole(owner: object, names: str, low: int, high: float = math.inf) -> None:
    """Makes ints of fields, named with spaces between, or refuses them; see ``Whole``."""
    for name in names.split():
        _put(owner, name, Whole(low, high))


def _put(owner: object, name: str, check: Check) -> None:
    value = check.checked(f"{type(owner).__name__}.{name}", getattr(owner, name))
    object.__setattr__(owner, name, value)


def check_num_boats(num_boats: Any) -> int:
    """Returns a team size; ValueError if it is not a whole number from 2 to ``LARGEST_TEAM``."""
    return Whole(2, LARGEST_TEAM).checked("num_boats", num_boats)
