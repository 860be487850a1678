"""Text of others in Markdown: names, errors and descriptions cannot become markup."""

import re

MARKUP = re.compile(r"[\\`*\[\]|~$#]|(?<!\w)_|_(?!\w)")
"""Characters that could begin markup; underscores within words are none."""
CODE = re.compile(r"(`[^`]+`)")


def escaped(text: str) -> str:
    """Returns any text as a piece of a line of Markdown that shows just this text."""
    line = " ".join(text.split()).replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    return MARKUP.sub(r"\\\g<0>", line)


def prose(text: str) -> str:
    """Returns a description in Markdown, what stands between backquotes as code."""
    parts = CODE.split(text)
    return "".join(code(p[1:-1]) if CODE.fullmatch(p) else _spaced(p) for p in parts)


def _spaced(text: str) -> str:
    """Returns escaped text with the spaces at its ends."""
    before, after = (" " if text[:1].isspace() else ""), (" " if text[-1:].isspace() else "")
    return f"{before}{escaped(text)}{after}" if text.strip() else before


def code(text: str) -> str:
    """Returns any text as a code span, within a fence that is longer than those it holds."""
    line = " ".join(text.split()) or " "
    fence = "`" * (1 + max(map(len, re.findall("`+", line)), default=0))
    pad = " " if "`" in (line[0], line[-1]) else ""
    return f"{fence}{pad}{line}{pad}{fence}"
