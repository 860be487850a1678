"""Registries: things of one kind by name, built in or registered by a user.

Wherever an option takes a name, it also takes ``"module:ATTRIBUTE"``, which is imported, or the
thing itself.
"""

import importlib
import sys
from collections.abc import Iterator, Mapping
from typing import Any, Generic, TypeVar

from asv_env.checks import choice

T = TypeVar("T")


class Registry(Mapping[str, T], Generic[T]):
    """Mapping from names to objects of one kind, in the order in which they were registered.

    Args:
        kind: singular noun for messages, such as "scenario".
        entries: built-in things; a text ``"module:ATTRIBUTE"`` is imported when it is asked for.
    """

    def __init__(self, kind: str, entries: Mapping[str, T | str] | None = None) -> None:
        self._kind = kind
        self._entries: dict[str, T | str] = dict(entries or {})

    def register(self, name: str, value: T | str) -> None:
        """Adds a thing under a name of its own.

        Raises:
            ValueError: the name is taken, or it cannot be a name.
        """
        if not isinstance(name, str) or not name or ":" in name:
            raise ValueError(f"{self._kind} name {name!r}: must be a text without a colon")
        if self._entries.get(name, value) != value:
            raise ValueError(f"there is a {self._kind} {name!r} already: choose another name")
        self._entries[name] = value

    def find(self, word: str | T) -> T:
        """Returns what a name, or ``"module:ATTRIBUTE"``, stands for; anything else as it is.

        Raises:
            UnknownNameError: the name is not registered.
            ValueError, ImportError: see ``load``.
        """
        if not isinstance(word, str):
            return word
        return self[word] if word in self or ":" not in word else load(word)

    def __getitem__(self, name: str) -> T:
        entry: Any = self._entries[choice(self._kind, name, self)]
        return load(entry) if isinstance(entry, str) else entry

    def __contains__(self, name: object) -> bool:
        return name in self._entries

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)


def load(word: str) -> Any:
    """Returns the attribute that ``"module:ATTRIBUTE"`` names.

    Modules of the current folder are found too.

    Raises:
        ValueError: the module has no such attribute.
        ImportError: there is no such module.
    """
    module, _, name = word.partition(":")
    if "" not in sys.path:
        sys.path.insert(0, "")
    found = importlib.import_module(module)
    if not hasattr(found, name):
        raise ValueError(f"{word}: the module {module} has no attribute {name!r}")
    return getattr(found, name)
