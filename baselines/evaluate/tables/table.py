"""A table of text, for the terminal, Markdown and HTML."""

import re
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any, Literal

from baselines.evaluate.tables import formats
from baselines.evaluate.tables.formats import NOTHING
from baselines.evaluate.tables.markdown import escaped

Kind = Literal["number", "words", "policy", "measure", "shared"]
OTHERS = ("words", "policy", "shared")  #: kinds of columns whose cells a user may have written
PIPE = re.compile(r"(?<!\\)\|")  #: a bar that is not escaped


@dataclass(frozen=True)
class Column:
    """A column of a table.

    Its kind is "number", flush right; "words", flush left; "policy" or "measure", a name; or
    "shared", a name that all lines of a condition have in common.
    """

    head: str  #: its heading
    cell: Callable[[Any], str]  #: returns the text of its cell from the subject of a line
    group: str = ""  #: heading above those of adjacent columns that belong together, if any
    kind: Kind = "number"


@dataclass(frozen=True)
class Table:
    """Cells of text under headings; its name is unique in a report."""

    name: str
    caption: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[str, ...], ...]

    @property
    def titles(self) -> list[str]:
        """Headings in a single line."""
        return [f"{c.group}: {c.head}" if c.group else c.head for c in self.columns]

    @property
    def groups(self) -> list[tuple[str, list[Column]]]:
        """Adjacent columns by the heading that they have in common, which may be empty."""
        return [(group, list(some)) for group, some in groupby(self.columns, lambda c: c.group)]

    @property
    def bodies(self) -> list[list[list[tuple[Column, str]]]]:
        """Lines by what they share, each line as pairs of column and cell."""
        lines = [list(zip(self.columns, row, strict=True)) for row in self.rows]
        shared = groupby(lines, key=lambda line: [t for c, t in line if c.kind == "shared"])
        return [list(some) for _, some in shared]

    @property
    def markdown(self) -> str:
        """The table in Markdown; names and words of others are escaped."""
        titles = [title.replace("<", "&lt;").replace("`", "\\`") for title in self.titles]
        pairs = list(zip(titles, self.columns, strict=True))
        cells = zip(self.columns, zip(*self.rows, strict=True), strict=True)
        shown = [map(escaped, column) if c.kind in OTHERS else column for c, column in cells]
        left = [title for title, column in pairs if column.kind != "number"]
        return grid(titles, list(zip(*shown, strict=True)), left)

    @property
    def text(self) -> str:
        """The table for a terminal, in ASCII."""
        lines = [self.titles, *self.rows]
        widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
        text = "\n".join(
            "  ".join(
                cell.rjust(width) if column.kind == "number" else cell.ljust(width)
                for column, cell, width in zip(self.columns, line, widths, strict=True)
            ).rstrip()
            for line in lines
        )
        return text.replace(formats.MINUS, formats.HYPHEN).replace(NOTHING, formats.HYPHEN)


def tabulated(name: str, caption: str, heads: Iterable[Column], subjects: Sequence[Any]) -> Table:
    """Returns the table with a line a subject; columns without any content are left out."""
    cells = {column: [column.cell(subject) for subject in subjects] for column in heads}
    kept = {c: texts for c, texts in cells.items() if any(text != NOTHING for text in texts)}
    return Table(name, caption, tuple(kept), tuple(zip(*kept.values(), strict=True)))


def grid(heads: Sequence[str], rows: Iterable[Sequence[str]], left: Collection[str] = ()) -> str:
    """Returns a table in Markdown; the columns with the heads ``left`` are flush left."""
    rules = [":--" if head in left else "--:" for head in heads]
    lines = [[" ".join(PIPE.sub(r"\\|", cell).split()) for cell in row] for row in (heads, *rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in (lines[0], rules, *lines[1:]))
