"""Fingerprints of policies and tasks that users write: what must not change between two runs."""

import hashlib
import inspect
import linecache
import os
import pickle
import sys
import uuid
from collections.abc import Callable, Iterator
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

    In a notebook the file is None, and the identity covers the cell. It also covers the values that
    are ``bound`` to it, but nothing that it imports. Where these cannot be compared, the identity
    is random: no two are taken for the same.
    """
    whole = function
    while isinstance(function, partial):
        function = function.func
    file = getattr(sys.modules.get(function.__module__), "__file__", None)
    if file and not os.path.isfile(file):  # as of a program that is read from standard input
        file = None
    cell = "" if file else _notebook_cell(function)
    if not file and not cell:
        return None, uuid.uuid4().hex
    name = getattr(function, "__qualname__", type(function).__qualname__)
    try:
        values = bound(whole)
        more = digest(cell.encode() + pickle.dumps(values)) if cell or values else ""
    except Exception:  # of whatever is bound
        more = uuid.uuid4().hex
    return Path(file) if file else None, f"{name} {more}".strip()


def bound(thing: Any, owner: type | None = None) -> list[Any]:
    """Returns the values that are bound to a class or function, which its file does not tell.

    They are the arguments of a ``partial``, the object of a method or one that can be called, and
    what a class or function that another function has made knows of it. The class ``owner``, to
    which a function belongs, is left out.
    """
    if isinstance(thing, partial):
        return [thing.args, thing.keywords, *bound(thing.func)]
    if inspect.ismethod(thing):
        return [thing.__self__]
    if not _is_code(thing):
        return [] if inspect.isbuiltin(thing) else [thing]
    if getattr(sys.modules.get(thing.__module__), thing.__name__, None) is thing:
        return []
    values: list[Any]
    if inspect.isclass(thing):
        parts = {name: getattr(part, "__func__", part) for name, part in vars(thing).items()}
        kept = (n for n in parts if _is_code(parts[n]) or not n.startswith(("__", "_abc_")))
        owner, values = thing, [*thing.__bases__, *map(parts.__getitem__, kept)]
    else:
        cells = [cell.cell_contents for cell in thing.__closure__ or ()]
        values = [*cells, *(thing.__defaults__ or ()), *(thing.__kwdefaults__ or {}).values()]
    values = [value for value in values if value is not owner]
    return [one for v in values for one in (bound(v, owner) if _is_code(v) else [v])]


def _is_code(thing: Any) -> bool:
    return inspect.isfunction(thing) or inspect.isclass(thing)


def is_own(function: Any) -> bool:
    """Returns whether a class or function is user-defined, not of this package."""
    while isinstance(function, partial):
        function = function.func
    return str(function.__module__).partition(".")[0] not in PACKAGES


def own_functions(record: Any) -> Iterator[Callable[..., Any]]:
    """Yields the user-defined functions in a record, such as a Task or a list of Features."""
    if is_dataclass(record) and not isinstance(record, type):
        record = [getattr(record, f.name) for f in fields(record)]
    if isinstance(record, list | tuple):
        for part in record:
            yield from own_functions(part)
    elif callable(record) and is_own(record):
        yield record


def _notebook_cell(function: Any) -> str:
    """Returns the text of the cell in which a class or function is written, "" if unknown."""
    parts = vars(function).values() if inspect.isclass(function) else [function]
    names = [part.__code__.co_filename for part in parts if inspect.isfunction(part)]
    return "".join(linecache.getlines(names[0])) if names else ""
