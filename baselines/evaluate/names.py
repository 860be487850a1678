"""Names that a user gives: they stand in tables and files, and name folders."""

import re
import unicodedata
from collections.abc import Iterable
from typing import Any

LONGEST = 100  #: largest number of bytes of a name, in UTF-8
POLICY = re.compile(r"[^\W_][\w.+-]*")  #: names of policies, which can be typed in any shell
DEVICES = re.compile(r"(con|prn|aux|nul|com\d|lpt\d)(\..*)?", re.IGNORECASE)
"""Names that Windows keeps for devices."""


def check_name(kind: str, name: Any) -> None:
    """Refuses what cannot be the name of a folder everywhere.

    Raises:
        ValueError: no text, an empty or a very long one, with characters that cannot be printed or
            that separate folders, or with spaces or dots at its ends.
    """
    fine = (
        isinstance(name, str)
        and name.isprintable()
        and 0 < len(name.encode()) <= LONGEST
        and not set(name) & set("/\\")
        and name.strip(" ") == name
        and not name.startswith("..")
        and not name.endswith(".")
        and not DEVICES.fullmatch(name)
    )
    if not fine:
        shown = ascii(name) if len(ascii(name)) <= LONGEST else f"{ascii(name)[:LONGEST]}..."
        raise ValueError(
            f"{kind}: {shown} cannot be a name: it is also that of a folder; take 1 to {LONGEST} "
            "printable characters, no slashes, no spaces or dots at the ends, no device"
        )


def check_policy_name(name: Any) -> None:
    """Refuses what cannot be the name of a policy; raises ValueError."""
    check_name("policies", name)
    if not POLICY.fullmatch(name):
        raise ValueError(
            f"policies: {name!r} cannot be a name; begin with a letter or a digit and use these, "
            "dots, plus, minus and underscores (NAME=... on the command line)"
        )


def check_distinct(kind: str, names: Iterable[str]) -> None:
    """Refuses names that are one folder on some systems; raises ValueError."""
    found: dict[str, str] = {}
    for name in names:
        key = unicodedata.normalize("NFC", name).casefold()
        if key in found:
            raise ValueError(
                f"{kind}: {found[key]!r} and {name!r}: give each a name of its own, which differs "
                "by more than upper and lower case"
            )
        found[key] = name
