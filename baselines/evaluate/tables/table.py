"""A table of text, for the terminal, Markdown and HTML."""

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any

from baselines.evaluate.tables import formats
from baselines.evaluate.tables.columns import Column
from baselines.evaluate.tables.formats import NOTHING


@dataclass(frozen=True)
class Table:
    """Cells of text under headings.

    Attributes:
        name: unique among the tables of a report.
        caption: what the table shows, in a sentence.
        columns: its columns; the first ones name the subject of a line.
        rows: its lines, each with a cell for every column.
    """

    name: str
    caption: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[str, ...], ...]

    @property
    def titles(self) -> list[str]:
        """Headings in a single line."""
        return [column.title for column in self.columns]

    @property
    def groups(self) -> list[tuple[str, list[Column]]]:
        """Adjacent columns by the heading that they have in common, which may be empty."""
        pairs = groupby(self.columns, key=lambda column: column.group)
        return [(group, list(some)) for group, some in pairs]

    @property
    def bodies(self) -> list[list[list[tuple[Column, str]]]]:
        """Lines by what they share, each line as pairs of column and cell."""
        lines = [list(zip(self.columns, row, strict=True)) for row in self.rows]
        shared = groupby(lines, key=lambda line: [t for c, t in line if c.kind == "shared"])
        return [list(some) for _, some in shared]

    @property
    def markdown(self) -> str:
        """The table in Markdown."""
        left = [column.title for column in self.columns if column.kind != "number"]
        return grid(self.titles, self.rows, left)

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
    """Returns cells as a table in Markdown.

    Args:
        heads: headings of the columns.
        rows: lines with a cell for every column.
        left: headings of the columns that are flush left, not right.
    """
    rules = [":--" if head in left else "--:" for head in heads]
    lines = [[" ".join(cell.replace("|", "\\|").split()) for cell in row] for row in (heads, *rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in (lines[0], rules, *lines[1:]))
