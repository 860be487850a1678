"""Compilation of the laws: scalar functions that Numba turns into machine code, cached on disk.

A law is written once, in scalars, as its equation stands in the books. Compiled loops over worlds
call it, and tests call it from Python.
"""

import hashlib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba.core import types
from numba.experimental import structref

LAWS = (
    "compiled.py",
    "capsules.py",
    "geometry.py",
    "polygons.py",
    *(f"{room}/*.py" for room in ("params", "physics", "sensing", "tasks")),
)  #: files with laws and constants
Law = TypeVar("Law", bound=Callable[..., Any])


def compiled(law: Law) -> Law:
    """Compiles a function at its first call; it runs without the interpreter's lock.

    It must not make arrays: then Numba need not count who holds which, which takes longer than most
    laws. Where it is called by compiled code, it becomes part of the caller.

    The machine code is kept beside the source, or in the user's cache where that folder cannot be
    written to. Where neither can, each process compiles for itself. Numba takes code from its cache
    as long as the function's own file is the same; here any change of a file with laws, or with
    their constants, or of the function's own folder counts, because laws call each other across
    files.
    """
    return _compiled(law, forceinline=True, _nrt=False)


def allocating(law: Law) -> Law:
    """Compiles a function as ``compiled`` does, which may make arrays or take a ``Bound``."""
    return _compiled(law)


def _compiled(law: Law, **options: Any) -> Law:
    """Compiles a function with more options of Numba."""
    options = {"nogil": True, "error_model": "numpy", **options}
    try:
        dispatcher = numba.njit(cache=True, **options)(law)
    except RuntimeError:  # Numba finds no folder for its cache.
        return cast(Law, numba.njit(**options)(law))
    index = cast(Any, dispatcher)._cache._cache_file
    index._source_stamp = index._source_stamp, _stamp(Path(law.__code__.co_filename).parent)
    return cast(Law, dispatcher)


@cache
def _stamp(folder: Path) -> str:
    """Returns a hash of the sources of all laws and of a folder, and of what compiles them."""
    here = Path(__file__).parent
    sources = [path for name in LAWS for path in sorted(here.glob(name))]
    if here not in (folder, *folder.parents):
        sources += sorted(folder.glob("*.py"))
    return hashlib.sha256(b"".join(path.read_bytes() for path in sources)).hexdigest()


@structref.register
class _BoundType(types.StructRef):
    """Type of ``Bound`` in compiled code."""

    def preprocess_fields(self, fields: Any) -> Any:
        return tuple((name, types.unliteral(kind)) for name, kind in fields)


class Bound(structref.StructRefProxy):
    """Arguments of compiled code that are handed over once and not at every call.

    Attributes:
        content: tuple of records of arrays and numbers. The arrays are shared, not copied.
    """

    content: Any


structref.define_proxy(Bound, _BoundType, ["content"])


@allocating
def bound(content: tuple[Any, ...]) -> Any:
    """Returns a ``Bound`` of this content."""
    return Bound(content)
