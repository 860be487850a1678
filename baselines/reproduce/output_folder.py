"""The output folder: what it holds, by which options it was made, and what may be replaced.

Results follow from the options and the code alone. So what was made with the same ones is kept,
which is also how a run that was stopped continues; what was made with others is replaced only when
that is asked for.
"""

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

from baselines.reproduce.artefact import Artefact, Job
from baselines.rollout import provenance
from baselines.rollout.files import write_text

NAME = "record.json"
LIBRARIES = ("numpy", "scipy", "pymunk", "matplotlib")


class OutputFolder:
    """A folder of artefacts, which need not exist yet, with their options in its ``record.json``.

    Raises:
        ValueError: the record in the folder cannot be read.
    """

    def __init__(self, path: Path, job: Job) -> None:
        self._path, self._record = path, path / NAME
        self._options: dict[str, Any] = {
            **asdict(job),
            "code": provenance.code("baselines.reproduce"),
            "versions": provenance.versions(LIBRARIES),
        }
        try:
            text = self._record.read_text() if self._record.exists() else "{}"
            self._entries: dict[str, Any] = json.loads(text)
        except json.JSONDecodeError as error:
            raise ValueError(
                f"{self._record} is not a record: remove it, or choose another --out"
            ) from error

    @property
    def known(self) -> bool:
        """Whether runs of this command have left anything in the folder."""
        return bool(self._entries)

    def made(self) -> list[str]:
        """Returns the names of the artefacts that are there, made with whatever options."""
        return [name for name, entry in self._entries.items() if entry["complete"]]

    def holds(self, name: str, artefact: Artefact) -> bool:
        """Returns whether an artefact is there, made with these options by this code."""
        there = all((self._path / file).exists() for file in artefact.files(name))
        return there and self._ours(name) and self._entries[name]["complete"]

    def in_the_way(self, name: str, artefact: Artefact) -> list[str]:
        """Returns files that an artefact would replace and that no run like this one has left."""
        if self._ours(name):
            return []
        return [file for file in artefact.files(name) if (self._path / file).exists()]

    def record(self, name: str, complete: bool) -> None:
        """Records that the files of an artefact are about to be written, or are complete."""
        self._entries[name] = {"complete": complete, "options": self._options}
        write_text(self._record, json.dumps(self._entries, indent=2) + "\n")

    def _ours(self, name: str) -> bool:
        return name in self._entries and self._entries[name]["options"] == self._options
