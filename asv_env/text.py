"""Values and errors as one line of text that can stand in any message, table, file or terminal.

They may be foreign: their text can fail, be huge, or hold anything.
"""

from collections.abc import Callable

LONGEST = 200  #: largest number of characters of a line, by default
ROOM = 8  #: factor by which the text that is looked at may be longer: escapes and spaces go


def one_line(text: str, longest: int = LONGEST) -> str:
    r"""Returns a text in one line, cut to ``longest`` characters.

    White space becomes single spaces. What cannot be printed (control characters, escape sequences
    of terminals, surrogates, marks that turn the direction of writing) is written as Python does
    in a literal, such as ``\x1b``.
    """
    plain = str.__getitem__(text, slice(ROOM * longest))  # also of subclasses with methods of own
    words = " ".join(plain.split())
    shown = "".join(
        c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in words
    )
    whole = len(shown) <= longest and len(plain) == str.__len__(text)
    return shown if whole else f"{shown[: longest - 3]}..."


def shown(value: object) -> str:
    """Returns the text of a value, as Python writes it, in one line."""
    otherwise = _tried(lambda: f"<{type(value).__name__}>", "<?>")
    return one_line(_tried(lambda: repr(value), otherwise))  # fails for huge whole numbers too


def described(error: BaseException, longest: int = LONGEST) -> str:
    """Returns the kind of an error and what it says, in one line.

    Of a group of errors the first one is added.
    """
    kind = _tried(lambda: one_line(type(error).__name__, longest), "error")
    said = _tried(lambda: one_line(str(error), longest), "its text cannot be read")
    if isinstance(error, BaseExceptionGroup):
        said = f"{said}: {described(error.exceptions[0], longest)}"
    return one_line(f"{kind}: {said}" if said else kind, longest)


def _tried(text: Callable[[], str], otherwise: str) -> str:
    """Returns a text, or another one where it cannot be had."""
    try:
        return text()
    except KeyboardInterrupt:
        raise
    except BaseException:
        return otherwise
