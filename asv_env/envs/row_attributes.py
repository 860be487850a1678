"""Attributes of a vector environment as other libraries ask for them: one value for each row."""

import operator
from collections.abc import Sequence
from typing import Any


class RowAttributes:
    """Attributes by row: those of the environment, which all rows share, or the rows' own.

    A name that the environment does not have is the user's: every row has a value of its own.
    """

    def __init__(self, env: Any, rows: int) -> None:
        self._env, self._rows = env, rows
        self._own: dict[str, dict[int, Any]] = {}  #: values by name and row

    def get(self, name: str, rows: Sequence[int]) -> list[Any]:
        """Returns the values of an attribute; AttributeError where a row has none."""
        own = self._own.get(name)
        if own is None:
            return [getattr(self._env, name)] * len(rows)
        missing = [row for row in rows if row not in own]
        if missing:
            raise AttributeError(f"rows {missing} have no attribute {name!r}")
        return [own[row] for row in rows]

    def set(self, name: str, values: Sequence[Any], rows: Sequence[int]) -> None:
        """Sets an attribute of rows to a value each.

        Raises:
            ValueError: the environment has this attribute, which all rows share, and the values
                differ or are for some rows only.
        """
        if not hasattr(self._env, name):
            self._own.setdefault(name, {}).update(zip(rows, values, strict=True))
            return
        if set(rows) != set(range(self._rows)) or any(one is not values[0] for one in values):
            raise ValueError(f"{name}: all rows share it; give one value for all of them")
        setattr(self._env, name, values[0])

    def checked(self, indices: Any) -> list[int]:
        """Returns the rows of indices: None for all, a number, or several; negative from the end.

        Raises:
            IndexError: there is no such row.
            TypeError: not whole numbers.
        """
        if indices is None:
            return list(range(self._rows))
        try:
            several = [operator.index(indices)]
        except TypeError:
            several = [operator.index(one) for one in indices]
        for one in several:
            if not -self._rows <= one < self._rows:
                raise IndexError(f"row {one}: there are {self._rows}, from 0 to {self._rows - 1}")
        return [one % self._rows for one in several]
