"""What a run makes: studies (numbers), figures and tables, and the folder that holds their files.

Results follow from the options and the code alone. So what was made with the same ones is kept,
which is also how a run that was stopped continues; what was made with others is replaced only when
that is asked for.
"""

import ast
import inspect
import json
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from textwrap import dedent
from typing import Any, ClassVar

from asv_env.files import write_text
from baselines.evaluate.tables.formats import NOTHING
from baselines.evaluate.tables.table import grid
from baselines.reproduce import style
from baselines.rollout import provenance

NAME = "record.json"
LIBRARIES = ("numpy", "numba", "scipy", "pymunk", "matplotlib")


@dataclass(frozen=True)
class Job:
    """Options on which the numbers depend."""

    seed: int  #: of the first episode; episode k has the seed plus k
    trials: int  #: number of episodes of Figs. 6 to 10; the paper has 12
    episodes: int  #: number of episodes in each condition of the tables

    def seeds(self, number: int) -> range:
        """Returns the seeds of the first ``number`` episodes."""
        return range(self.seed, self.seed + number)


@dataclass(frozen=True)
class Artefact(ABC):
    """One thing to make."""

    suffixes: ClassVar[tuple[str, ...]]

    make: Callable[..., Any]  #: from the job and the studies needed to what ``save`` saves
    source: str  #: where its numbers come from
    needs: tuple[str, ...] = ()  #: studies whose results it takes
    #: from the studies that it needs to sentences with their numbers, for the caption
    facts: Callable[..., str] | None = None

    def files(self, name: str) -> list[str]:
        """Returns the names of its files."""
        return [name + suffix for suffix in self.suffixes]

    def shown(self, name: str) -> str:
        """Returns its files in Markdown: links, or the picture."""
        return ", ".join(f"[{file}]({file})" for file in self.files(name))

    @property
    def caption(self) -> str:
        """What it shows: the docstring of the function that makes it, from its source.

        ``python -OO`` keeps no docstrings.
        """
        (function,) = ast.parse(dedent(inspect.getsource(self.make))).body
        assert isinstance(function, ast.FunctionDef)
        return ast.get_docstring(function) or ""

    def full_caption(self, folder: Path) -> str:
        """Returns the caption, and the facts that follow from the studies in a folder."""
        if self.facts is None:
            return self.caption
        return f"{self.caption}\n\n{self.facts(*self.studies(folder))}"

    def studies(self, folder: Path) -> list[Any]:
        """Returns the results of the studies that it needs, from their folder."""
        return [read_json(folder / f"{need}.json") for need in self.needs]

    def build(self, name: str, job: Job, folder: Path) -> None:
        """Makes it from the studies in the folder, and writes its files there."""
        with style.applied():
            self.save(self.make(job, *self.studies(folder)), folder / name)

    @abstractmethod
    def save(self, product: Any, stem: Path) -> None:
        """Writes what was made to files that differ in their suffixes."""


class Study(Artefact):
    """Numbers that figures and tables are made of: a document of plain values."""

    suffixes = (".json",)

    def save(self, product: Any, stem: Path) -> None:
        """See ``Artefact.save``."""
        write_text(stem.with_suffix(".json"), json.dumps(product) + "\n")


class Figure(Artefact):
    """A matplotlib figure, saved as a picture and as a drawing."""

    suffixes = style.SUFFIXES

    def shown(self, name: str) -> str:
        """See ``Artefact.shown``."""
        return f"![{name}]({name}.png)"

    def save(self, product: Any, stem: Path) -> None:
        """See ``Artefact.save``."""
        style.save(product, stem)


class Table(Artefact):
    """Rows of cells by column, and notes, saved for readers and for programs."""

    suffixes = (".md", ".json")

    def save(self, product: Any, stem: Path) -> None:
        """See ``Artefact.save``."""
        write_text(stem.with_suffix(".json"), json.dumps(product, indent=2) + "\n")
        write_text(stem.with_suffix(".md"), markdown(product))


class OutputFolder:
    """A folder of artefacts, which need not exist yet, with their options in its ``record.json``.

    Args:
        path: of the folder.
        job: options on which the numbers depend.
        replace: whether a damaged record counts as none.

    Raises:
        ValueError: the record in the folder is damaged.
    """

    def __init__(self, path: Path, job: Job, replace: bool = False) -> None:
        self._path, self.job, self._record = path, job, path / NAME
        self._options: dict[str, Any] = {
            **asdict(job),
            "code": provenance.code("baselines.reproduce"),
            "versions": provenance.versions(LIBRARIES),
        }
        self._replace = replace
        self.read()

    def read(self) -> None:
        """Reads the record again; another run may have written to it."""
        self._entries: dict[str, Any] = {}
        try:
            self._entries = _entries(self._record) if self._record.exists() else {}
        except ValueError:
            if not self._replace:
                raise

    @property
    def known(self) -> bool:
        """Whether runs of this command have left anything in the folder."""
        return bool(self._entries)

    def made(self) -> list[str]:
        """Returns the names of the artefacts that are there, made with whatever options."""
        return [name for name, entry in self._entries.items() if entry["complete"]]

    def holds(self, name: str, artefact: Artefact) -> bool:
        """Returns whether an artefact is there, whole, made with these options by this code."""
        there = all(_is_whole(self._path / file) for file in artefact.files(name))
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


def read_json(path: Path) -> Any:
    """Returns the content of a file; ValueError, which names it and a remedy, where it is none."""
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (ValueError, RecursionError) as error:
        raise ValueError(
            f"{path} is damaged ({error}): remove it, or begin again with --overwrite"
        ) from error


def _is_whole(path: Path) -> bool:
    """Returns whether a file is there, and not damaged as far as that can be seen."""
    try:
        return path.stat().st_size > 0 and (path.suffix != ".json" or read_json(path) is not None)
    except (OSError, ValueError):
        return False


def _entries(record: Path) -> dict[str, Any]:
    """Returns the entries of a record; ValueError where it is damaged, or of something else."""
    found = read_json(record)
    known = {"complete", "options"}
    if not isinstance(found, dict) or not all(
        isinstance(entry, dict) and known <= entry.keys() for entry in found.values()
    ):
        raise ValueError(
            f"{record} is not a record: remove it, or begin again with --overwrite, or choose "
            "another --out"
        )
    return found


def markdown(product: dict[str, Any]) -> str:
    """Returns a table as Markdown: ``rows`` map the same columns to text, numbers or None."""
    rows = product["rows"]
    heads = list(rows[0])
    words = [head for head in heads if any(isinstance(row[head], str) for row in rows)]
    text = grid(heads, [[cell(value) for value in row.values()] for row in rows], words)
    return "\n\n".join([text, *product["notes"]]) + "\n"


def cell(value: Any) -> str:
    """Returns the text of a table's cell: numbers to three digits, a dash for None."""
    if value is None:
        return NOTHING
    return f"{value:.3g}" if isinstance(value, float) else str(value)
