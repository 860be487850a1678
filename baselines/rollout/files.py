"""Files that are written all at once."""

import os
from collections.abc import Callable
from pathlib import Path


def write(path: Path, save: Callable[[Path], object]) -> None:
    """Writes a file all at once: whoever reads it, or is killed, leaves the old or the new one.

    Args:
        path: file that is written or replaced.
        save: writes the file under the name that it is given, which has the same suffix.
    """
    part = path.with_name(f"{path.stem}.{os.getpid()}.part{path.suffix}")
    try:
        save(part)
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Writes a text file in UTF-8 all at once, line ends as they are."""
    write(path, lambda part: part.write_bytes(text.encode()))


def remove_parts(folder: Path) -> None:
    """Removes what killed runs have left half written."""
    for part in folder.glob("*.part*"):
        part.unlink()
