"""What a run makes: studies (numbers), figures and tables, and the files they become."""

import inspect
import json
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from baselines.evaluate.tables.formats import NOTHING
from baselines.evaluate.tables.table import grid
from baselines.reproduce import style

GEOMETRY = "equations alone, nothing is simulated"
MODEL = "the kinematic model of Eq. (8), without hulls and water"
SIMULATION = "simulation of hulls, water and contact"
BOTH = f"{SIMULATION}; next to it the paper's own numbers from its tank experiment"


@dataclass(frozen=True)
class Job:
    """Options on which the numbers depend."""

    seed: int  # of the first episode; episode k has the seed plus k
    trials: int  # number of episodes of Figs. 6 to 10; the paper has 12
    episodes: int  # number of episodes in each condition of the tables

    def seeds(self, number: int) -> range:
        """Returns the seeds of the first ``number`` episodes."""
        return range(self.seed, self.seed + number)


@dataclass(frozen=True)
class Artefact(ABC):
    """One thing to make."""

    suffixes: ClassVar[tuple[str, ...]]

    make: Callable[..., Any]  # from the job and the studies needed to what ``save`` saves
    source: str  # where its numbers come from
    needs: tuple[str, ...] = ()  # studies whose results it takes

    def files(self, name: str) -> list[str]:
        """Returns the names of its files."""
        return [name + suffix for suffix in self.suffixes]

    def shown(self, name: str) -> str:
        """Returns its files in Markdown: links, or the picture."""
        return ", ".join(f"[{file}]({file})" for file in self.files(name))

    @property
    def caption(self) -> str:
        """What it shows: the docstring of the function that makes it."""
        return inspect.getdoc(self.make) or ""

    def build(self, name: str, job: Job, folder: Path) -> None:
        """Makes it from the studies in the folder, and writes its files there."""
        studies = [json.loads((folder / f"{need}.json").read_text()) for need in self.needs]
        with style.applied():
            self.save(self.make(job, *studies), folder / name)

    @abstractmethod
    def save(self, product: Any, stem: Path) -> None:
        """Writes what was made to files that differ in their suffixes."""


class Study(Artefact):
    """Numbers that figures and tables are made of: a document of plain values."""

    suffixes = (".json",)

    def save(self, product: Any, stem: Path) -> None:
        """See ``Artefact.save``."""
        stem.with_suffix(".json").write_text(json.dumps(product) + "\n")


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
        stem.with_suffix(".json").write_text(json.dumps(product, indent=2) + "\n")
        stem.with_suffix(".md").write_text(markdown(product))


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
