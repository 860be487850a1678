"""The part of a page that a command writes, between a line that starts it and one that ends it."""

from pathlib import Path


def read(page: Path) -> str:
    """Returns the text of a page; ValueError, which names it, where it is no text in UTF-8."""
    try:
        return page.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise ValueError(f"{page} is not a text in UTF-8: {error}") from error


def check(text: str, start: str, end: str) -> None:
    """Raises ValueError unless a page has both lines, once each and in their order."""
    if text.count(start) != 1 or text.count(end) != 1 or text.index(start) > text.index(end):
        raise ValueError(f"the page needs a line {start!r} and below it a line {end!r}, once each")


def replaced(text: str, start: str, end: str, content: str) -> str:
    """Returns the text of a page with other content between the two lines; see ``check``."""
    check(text, start, end)
    before, _, rest = text.partition(start)
    _, _, after = rest.partition(end)
    return f"{before}{start}\n\n{content.strip()}\n\n{end}{after}"
