"""The part of a page that a command writes, between two marks."""

from __future__ import annotations


def check(text: str, start: str, end: str) -> None:
    """Whether a page can take it.

    Raises:
        ValueError: it has not just one mark of each kind, in their order.
    """
    if text.count(start) != 1 or text.count(end) != 1 or text.index(start) > text.index(end):
        raise ValueError(f"the page needs a line {start!r} and below it a line {end!r}, once each")


def replaced(text: str, start: str, end: str, content: str) -> str:
    """The text of a page with something else between its marks.

    Raises:
        ValueError: see ``check``.
    """
    check(text, start, end)
    before, _, rest = text.partition(start)
    _, _, after = rest.partition(end)
    return f"{before}{start}\n\n{content.strip()}\n\n{end}{after}"
