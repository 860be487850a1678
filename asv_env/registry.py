"""Registries: things of one kind by name, built in or registered by a user.

Wherever an option takes a name, it also takes ``"module:ATTRIBUTE"``, which is imported, or the
thing itself.
"""

import importlib
import importlib.machinery
import importlib.util
import os
import sys
from collections.abc import Callable, Iterator, Mapping
from types import ModuleType
from typing import Any, Generic, NoReturn, TypeVar

from asv_env.checks import choice, plain
from asv_env.text import described, one_line, shown

T = TypeVar("T")


class LoadError(ImportError, ValueError):
    """What ``"module:ATTRIBUTE"`` names cannot be had; the message gives the reason."""


class WrongKindError(TypeError, ValueError):
    """A thing that is not of the kind that an option takes."""


class ReadOnlyDict(dict[str, Any]):
    """A dictionary that cannot be changed; it can be pickled, and ``dict(it)`` can be changed."""

    def _refuse(self, *args: Any, **kwargs: Any) -> NoReturn:
        raise TypeError("this table is read-only: change a copy, dict(it), or register another")

    __setitem__ = __delitem__ = __ior__ = _refuse
    clear = pop = popitem = setdefault = update = _refuse

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (dict(self),)


def read_only(value: Any) -> Any:
    """Returns a mapping, and what it holds, as values that cannot be changed; others as they are.

    Mappings become ``ReadOnlyDict``, lists and arrays tuples.
    """
    if isinstance(value, Mapping):
        return ReadOnlyDict({name: read_only(item) for name, item in value.items()})
    items = plain(value)
    return tuple(map(read_only, items)) if isinstance(items, list | tuple) else value


class Registry(Mapping[str, T], Generic[T]):
    """Mapping from names to objects of one kind, in the order in which they were registered.

    Args:
        kind: singular noun for messages, such as "scenario".
        entries: built-in things; a text ``"module:ATTRIBUTE"`` is imported when it is asked for.
        fits: whether an object is of the kind; by default any is. Mappings are kept as copies
            that cannot be changed.
    """

    def __init__(
        self,
        kind: str,
        entries: Mapping[str, T | str] | None = None,
        fits: Callable[[object], bool] | None = None,
    ) -> None:
        self._kind, self._fits = kind, fits
        self._entries: dict[str, T | str] = {}
        for name, value in (entries or {}).items():
            self.register(name, value)

    def register(self, name: str, value: T | str) -> None:
        """Adds a thing under a name of its own.

        Raises:
            ValueError: the name is taken, or it cannot be a name.
            WrongKindError: the thing is not of the kind.
        """
        if not isinstance(name, str) or not name or ":" in name:
            raise ValueError(f"{self._kind} name {shown(name)}: must be a text without a colon")
        kept: Any = read_only(value) if isinstance(value, Mapping) else value
        if self._entries.get(name, kept) != kept:
            raise ValueError(f"there is a {self._kind} {name!r} already: choose another name")
        self._entries[name] = kept if isinstance(kept, str) else self._checked(kept)

    def find(self, word: str | T, option: str | None = None) -> T:
        """Returns what a name, or ``"module:ATTRIBUTE"``, stands for; anything else as it is.

        Args:
            word: a name, ``"module:ATTRIBUTE"``, or a thing.
            option: for messages, the option that takes the word; by default the kind.

        Raises:
            UnknownNameError: the name is not registered.
            LoadError: see ``load``.
            WrongKindError: the thing is not of the kind.
        """
        given = plain(word)
        if not isinstance(given, str):
            return self._checked(word, option)
        if given in self._entries or ":" not in given:
            kind = self._kind if option in (None, self._kind) else f"{self._kind} for {option}"
            return self._entry(choice(kind, given, self))
        return self._checked(load(given, option or self._kind), option)

    def _checked(self, thing: Any, option: str | None = None) -> Any:
        if self._fits is not None and not self._fits(thing):
            raise WrongKindError(
                f"{option or self._kind} = {shown(thing)}: give the name of a {self._kind}, "
                f"'module:NAME', or a {self._kind} itself"
            )
        return thing

    def _entry(self, name: str) -> T:
        entry: Any = self._entries[name]
        return self._checked(load(entry)) if isinstance(entry, str) else entry

    def __getitem__(self, name: str) -> T:
        return self._entry(choice(self._kind, name, self))

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and name in self._entries

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)


def load(word: str, option: str = "") -> Any:
    """Returns the attribute that ``"module:ATTRIBUTE"`` names.

    A module that is found nowhere else is looked for in the current folder, which then stays the
    last place where Python looks for modules. So no file there takes the place of a library.

    Args:
        word: the names of a module and of a thing in it.
        option: for messages, the option that takes the word.

    Raises:
        LoadError: a word of another form, no such module or attribute, or an import that fails.
    """
    given = f"{option} = {shown(word)}" if option else one_line(word)
    module, _, name = word.partition(":")
    if not name.isidentifier() or not all(part.isidentifier() for part in module.split(".")):
        raise LoadError(f"{given}: give 'module:NAME', the names of a module and of a thing in it")
    try:
        found = _imported(module)
    except ModuleNotFoundError as error:
        if error.name is None or not f"{module}.".startswith(f"{error.name}."):
            raise _failed(given, module, error) from error
        raise LoadError(
            f"{given}: No module named {error.name!r}, installed or in the current folder"
        ) from error
    except (Exception, SystemExit) as error:  # whatever the user's own code raises
        raise _failed(given, module, error) from error
    try:
        return getattr(found, name)
    except AttributeError as error:
        raise LoadError(
            f"{given}: the module {module} has no attribute {name!r}{_place(found)}"
        ) from error


def _imported(module: str) -> ModuleType:
    """Imports a module, also one of the current folder if there is no other of its name."""
    _look_here(module.partition(".")[0])
    return importlib.import_module(module)


def _failed(given: str, module: str, error: BaseException) -> LoadError:
    return LoadError(f"{given}: importing the module {module} failed with {described(error)}")


def _look_here(top: str) -> None:
    """Makes the current folder the last place to look in, if only there is a module ``top``."""
    spec = None if top in sys.modules else importlib.util.find_spec(top)
    # A folder somewhere that merely has the module's name counts as a module without origin.
    if top in sys.modules or (spec and spec.origin):
        return
    here = os.path.abspath(os.curdir)
    importlib.invalidate_caches()
    if here not in sys.path and importlib.machinery.PathFinder.find_spec(top, [here]):
        sys.path.append(here)


def _place(module: ModuleType) -> str:
    """Returns where a module was found, and a hint where a file of its name was passed over."""
    file = getattr(module, "__file__", None)
    here = os.path.join(os.getcwd(), f"{module.__name__}.py")
    if not os.path.exists(here) or (file and os.path.samefile(file, here)):
        return f" ({file})" if file else ""
    return (
        f"; it is {file or 'a part of Python'}, not the file in the current folder: "
        "give that file another name"
    )
