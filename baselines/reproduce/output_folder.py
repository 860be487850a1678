"""The output folder: what it holds, by which options it was made, and what may be replaced.

Results follow from the options and the code alone. So what was made with the same ones is kept,
which is also how a run that was stopped goes on; what was made with others is replaced only when
that is asked for.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from baselines.reproduce.job import Job
from baselines.rollout import provenance
from baselines.rollout.files import write_text

NAME = "record.json"
LIBRARIES = ("numpy", "scipy", "pymunk", "matplotlib")


class Record:
    """What an output folder holds, kept in its ``record.json``.

    Args:
        folder: need not exist.
        job: what is asked for.

    Raises:
        ValueError: the record in the folder cannot be read.
    """

    def __init__(self, folder: Path, job: Job) -> None:
        made_by = {
            "code": provenance.code("baselines.reproduce"),
            "versions": provenance.versions(LIBRARIES),
        }
        self._options: dict[str, Any] = {**asdict(job), **made_by}
        self._folder = folder
        self._entries: dict[str, Any] = {}
        path = folder / NAME
        if path.exists():
            try:
                self._entries = json.loads(path.read_text())
            except json.JSONDecodeError as error:
                raise ValueError(
                    f"{path} is not a record: remove it, or choose another --out"
                ) from error

    @property
    def known(self) -> bool:
        """Whether runs of this command have left anything in the folder."""
        return bool(self._entries)

    def made(self) -> list[str]:
        """Names of the artefacts that are there, by whichever options they were made."""
        return [name for name, entry in self._entries.items() if entry["complete"]]

    def complete(self, name: str, files: Sequence[str]) -> bool:
        """Whether an artefact is there, made with these options by this code."""
        there = all((self._folder / file).exists() for file in files)
        return there and self._ours(name) and self._entries[name]["complete"]

    def in_the_way(self, name: str, files: Sequence[str]) -> list[str]:
        """Files that an artefact would replace, unless an interrupted run like this left them."""
        if self._ours(name):
            return []
        return [file for file in files if (self._folder / file).exists()]

    def begin(self, name: str) -> None:
        """Notes that the files of an artefact are about to be written."""
        self._write(name, complete=False)

    def finish(self, name: str) -> None:
        """Notes that they are."""
        self._write(name, complete=True)

    def _ours(self, name: str) -> bool:
        return name in self._entries and self._entries[name]["options"] == self._options

    def _write(self, name: str, complete: bool) -> None:
        self._entries[name] = {"complete": complete, "options": self._options}
        write_text(self._folder / NAME, json.dumps(self._entries, indent=2) + "\n")
