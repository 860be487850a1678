"""Pieces of HTML: text, tables, lists."""

from __future__ import annotations

import html
import json
import re
from collections.abc import Iterable, Sequence
from itertools import groupby
from typing import Any
from urllib.parse import quote

from baselines.evaluate.report.figures import Colours
from baselines.evaluate.tables.columns import Column
from baselines.evaluate.tables.formats import NOTHING
from baselines.evaluate.tables.table import Table

SPANNING = ("condition", "control")
"""Heads of columns whose cells hold for all lines of a condition."""


def text(words: str) -> str:
    """Words as they are."""
    return html.escape(words)


def prose(words: str) -> str:
    """Words in which names may stand between backquotes."""
    return re.sub(r"`([^`]*)`", r"<code>\1</code>", text(words))


def address(words: str) -> str:
    """Words as part of an address."""
    return html.escape(quote(words, safe=""))


def swatch(policy: str, colours: Colours) -> str:
    """A policy's name, with its colour before it."""
    return f'<span class="swatch" style="--colour: {colours[policy]}"></span>{text(policy)}'


def data(values: Any) -> str:
    """Plain values as JSON that can stand in a ``script`` element."""
    dumped = json.dumps(values, separators=(",", ":"), ensure_ascii=False)
    return dumped.replace("<", "\\u003c")


def facts(pairs: Iterable[tuple[str, str]]) -> str:
    """Terms and what is said of them, the latter as HTML."""
    lines = [f"<div><dt>{text(term)}</dt><dd>{said}</dd></div>" for term, said in pairs]
    return f'<dl class="facts">{"".join(lines)}</dl>'


def table(shown: Table, colours: Colours, caption: str, name: str) -> str:
    """A table; lines of the same condition have its name in common.

    Args:
        shown: its cells.
        colours: of the policies.
        caption: what it shows.
        name: unique in the page.
    """
    bodies = [
        _body(shown.columns, list(rows), colours)
        for _, rows in groupby(shown.rows, key=lambda row: _common(shown.columns, row))
    ]
    named = f'aria-labelledby="{name}"'
    return (
        f'<p class="caption" id="{name}">{text(caption)}</p>'
        f'<div class="scroll" tabindex="0" role="group" {named}><table {named}>'
        f"<thead>{_heads(shown.columns, colours)}</thead>{''.join(bodies)}</table></div>"
    )


def _common(columns: Sequence[Column], row: Sequence[str]) -> tuple[str, ...]:
    pairs = zip(columns, row, strict=True)
    return tuple(cell for column, cell in pairs if column.head in SPANNING)


def _heads(columns: Sequence[Column], colours: Colours) -> str:
    """One line of heads, or two where columns have groups."""
    grouped = any(column.group for column in columns)
    upper, lower = [], []
    for group, some in groupby(columns, key=lambda column: column.group):
        members = list(some)
        if group:
            head = swatch(group, colours) if group in colours else _head(group)
            upper.append(f'<th scope="colgroup" colspan="{len(members)}">{head}</th>')
            lower += [f'<th scope="col">{_head(column.head)}</th>' for column in members]
        else:
            rows = ' rowspan="2"' if grouped else ""
            upper += [
                f'<th scope="col"{rows}{_kind(column)}>{_head(column.head)}</th>'
                for column in members
            ]
    lines = [upper, lower] if grouped else [upper]
    return "".join(f"<tr>{''.join(line)}</tr>" for line in lines)


def _head(words: str) -> str:
    """A head, its unit set apart."""
    return re.sub(r" \[([^\]]*)\]$", r' <span class="unit">[\1]</span>', text(words))


def _body(columns: Sequence[Column], rows: Sequence[Sequence[str]], colours: Colours) -> str:
    lines = []
    for number, row in enumerate(rows):
        cells = []
        for column, cell in zip(columns, row, strict=True):
            if column.head in SPANNING:
                if number == 0:
                    scope = f'scope="rowgroup" rowspan="{len(rows)}"'
                    cells.append(f"<th {scope}>{text(cell)}</th>")
            elif column.head == "policy":
                cells.append(f'<th scope="row">{swatch(cell, colours)}</th>')
            elif column.head == "measure":
                cells.append(f'<th scope="row">{_head(cell)}</th>')
            else:
                cells.append(f"<td{_kind(column)}>{_cell(cell)}</td>")
        lines.append(f"<tr>{''.join(cells)}</tr>")
    return f"<tbody>{''.join(lines)}</tbody>"


def _kind(column: Column) -> str:
    return ' class="words"' if column.words else ""


def _cell(words: str) -> str:
    """A cell; an interval stands below its number."""
    if words == NOTHING:
        return f'<span class="nothing">{NOTHING}</span>'
    return re.sub(r" (\[[^\]]*\])$", r' <span class="interval">\1</span>', text(words))


def figure(title: str, drawing: str, caption: str, wide: bool, level: int = 4) -> str:
    """A figure with its title, a heading of a level, and its caption."""
    kind, heading = "card wide" if wide else "card", f"h{level}"
    return (
        f'<figure class="{kind}"><{heading}>{text(title)}</{heading}>'
        f'<div class="scroll">{drawing}</div>'
        f"<figcaption>{text(caption)}</figcaption></figure>"
    )
