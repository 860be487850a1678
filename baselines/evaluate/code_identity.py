"""Fingerprints of user-defined classes and functions, in modules and in notebooks."""

import hashlib
import inspect
import linecache
import pickle
import sys
import uuid
from collections.abc import Callable, Iterator, Sequence
from dataclasses import fields, is_dataclass
from functools import partial
from pathlib import Path
from typing import Any

PACKAGES = ("asv_env", "baselines")  #: packages whose code ``provenance.code`` covers


def digest(data: bytes) -> str:
    """Returns a short digest of bytes."""
    return hashlib.sha256(data).hexdigest()[:16]


def fingerprint(file: Path | None, identity: str) -> str:
    """Returns a fingerprint of the present contents of a file, if any, and of an identity."""
    contents = "" if file is None else digest(file.read_bytes())
    return " with ".join(filter(None, (contents, identity)))


def identify(function: Any) -> tuple[Path | None, str]:
    """Returns the file of a class or function, and its identity within that file.

    In a notebook the file is None, and the identity covers the cell. It also covers values that
    are bound to the function, such as the arguments of a ``partial``, but nothing that it imports.
    Where these cannot be compared, the identity is random: no two are taken for the same.
    """
    bound = [cell.cell_contents for cell in getattr(function, "__closure__", None) or ()]
    if isinstance(function, partial):
        bound = [function.args, function.keywords]
        function = function.func
    file = getattr(sys.modules.get(function.__module__), "__file__", None)
    cell = "" if file else _notebook_cell(function)
    if not file and not cell:
        return None, uuid.uuid4().hex
    name = getattr(function, "__qualname__", type(function).__qualname__)
    try:
        more = digest(cell.encode() + pickle.dumps(bound)) if cell or bound else ""
    except (pickle.PickleError, TypeError, AttributeError):
        more = uuid.uuid4().hex
    return Path(file) if file else None, f"{name} {more}".strip()


def is_own(function: Any) -> bool:
    """Returns whether a class or function is user-defined, not of this package."""
    while isinstance(function, partial):
        function = function.func
    return str(function.__module__).partition(".")[0] not in PACKAGES


def own_functions(record: Any) -> Iterator[Callable[..., Any]]:
    """Yields the user-defined functions in a record, such as a Task or a list of Features."""
    if is_dataclass(record) and not isinstance(record, type):
        parts: Sequence[Any] = [getattr(record, f.name) for f in fields(record)]
    elif isinstance(record, list | tuple):
        parts = record
    else:
        if callable(record) and is_own(record):
            yield record
        return
    for part in parts:
        yield from own_functions(part)


def _notebook_cell(function: Any) -> str:
    """Returns the text of the cell in which a class or function is written, "" if unknown."""
    parts = vars(function).values() if inspect.isclass(function) else [function]
    names = [part.__code__.co_filename for part in parts if inspect.isfunction(part)]
    return "".join(linecache.getlines(names[0])) if names else ""
