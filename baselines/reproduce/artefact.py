"""What a run makes: studies (numbers), figures and tables, and the files they become."""

from __future__ import annotations

import inspect
import json
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from baselines.reproduce import style
from baselines.reproduce.job import Job

GEOMETRY = "equations alone, nothing is simulated"
MODEL = "the kinematic model of Eq. (8), without hulls and water"
SIMULATION = "simulation of hulls, water and contact"
BOTH = f"{SIMULATION}; beside it the paper's own numbers from its tank experiment"


@dataclass(frozen=True)
class Artefact(ABC):
    """One thing to make.

    Attributes:
        make: from the job and the studies needed to what ``save`` saves.
        source: where its numbers come from.
        needs: studies whose results it takes, by name.
    """

    suffixes: ClassVar[tuple[str, ...]]

    make: Callable[..., Any]
    source: str
    needs: tuple[str, ...] = ()

    def files(self, name: str) -> list[str]:
        """Names of its files."""
        return [name + suffix for suffix in self.suffixes]

    def shown(self, name: str) -> str:
        """Its files in Markdown."""
        return ", ".join(f"[{file}]({file})" for file in self.files(name))

    @property
    def caption(self) -> str:
        """What it shows: the docstring of the function that makes it."""
        return inspect.getdoc(self.make) or ""

    def build(self, name: str, job: Job, folder: Path) -> None:
        """Makes it and writes its files."""
        studies = [json.loads((folder / f"{need}.json").read_text()) for need in self.needs]
        with style.applied():
            self.save(self.make(job, *studies), folder / name)

    @abstractmethod
    def save(self, product: Any, stem: Path) -> None:
        """Writes what was made to files that differ in their suffixes."""


class Study(Artefact):
    """Numbers that figures and tables are made of."""

    suffixes = (".json",)

    def save(self, product: Any, stem: Path) -> None:
        """Writes a document of plain values."""
        stem.with_suffix(".json").write_text(json.dumps(product) + "\n")


class Figure(Artefact):
    """A matplotlib figure."""

    suffixes = style.SUFFIXES

    def shown(self, name: str) -> str:
        """The picture."""
        return f"![{name}]({name}.png)"

    def save(self, product: Any, stem: Path) -> None:
        """Writes a picture and a drawing."""
        style.save(product, stem)


class Table(Artefact):
    """Rows of cells by column, and remarks."""

    suffixes = (".md", ".json")

    def save(self, product: Any, stem: Path) -> None:
        """Writes the same table for readers and for programs."""
        stem.with_suffix(".json").write_text(json.dumps(product, indent=2) + "\n")
        stem.with_suffix(".md").write_text(markdown(product))


def markdown(product: dict[str, Any]) -> str:
    """A table as Markdown.

    Args:
        product: ``rows``, mappings from the same columns to text, numbers or None; ``notes``.
    """
    rows = product["rows"]
    heads = list(rows[0])
    lines = [heads, ["---"] * len(heads), *([cell(row[head]) for head in heads] for row in rows)]
    text = "\n".join("| " + " | ".join(line) + " |" for line in lines)
    return "\n\n".join([text, *product["notes"]]) + "\n"


def cell(value: Any) -> str:
    """A cell of a table for readers: numbers to three digits."""
    if value is None:
        return "–"
    return f"{value:.3g}" if isinstance(value, float) else str(value)
