"""Writes the published results onto pages: ``python -m baselines.evaluate.publish``.

Every number follows from the ``episodes.csv`` of the suites. With ``--check`` nothing is written,
and stale pages are an error.
"""

import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import tyro

from baselines.evaluate.publish import marks, model_cards, suite_tables
from baselines.evaluate.publish.suite_tables import FOLDER, PROGRAM
from baselines.evaluate.report import rendering
from baselines.evaluate.results import Results, of_rows, read_csv
from baselines.evaluate.suites import SUITES
from baselines.learned import shipped
from baselines.rollout import files

START = f"<!-- results: what follows is written by {PROGRAM} -->"
END = "<!-- results: up to here -->"


@dataclass(frozen=True)
class Options:
    """Writes the published results onto the pages of the repository."""

    results: Path = Path(FOLDER)
    """Folder of the results, with one folder a suite."""
    page: Path = Path("README.md")
    """Page with the marks between which the overview stands."""
    check: bool = False
    """Whether to write nothing, and to fail where a page is stale."""


def read(folder: Path) -> list[Results]:
    """Returns the results of all suites in a folder, in the order of ``SUITES``.

    Raises:
        FileNotFoundError: there are none.
        ValueError: rows are not those of the suite.
    """
    paths = {name: folder / name / "episodes.csv" for name in SUITES}
    found = [of_rows(SUITES[name], read_csv(path)) for name, path in paths.items() if path.exists()]
    if not found:
        raise FileNotFoundError(f"{folder} holds no results of suites: run some with --out there")
    return found


def pages(published: Sequence[Results], options: Options) -> dict[Path, str]:
    """Returns the text of every page, by path.

    Raises:
        ValueError: the page of the overview has no marks.
    """
    readme = options.page.read_text(encoding="utf-8")
    texts = {
        options.page: marks.replaced(readme, START, END, suite_tables.overview(published)),
        options.results / "README.md": suite_tables.page(published),
        shipped.FOLDER / "README.md": model_cards.page(shipped.FOLDER),
    }
    for results in published:
        folder = options.results / results.suite.name
        if (folder / "summary.json").exists():
            summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
            texts[folder / "report.md"] = rendering.markdown(results, summary)
    return texts


def main(arguments: Sequence[str] | None = None) -> None:
    """Writes the pages, or checks them; exits with a message where that fails."""
    options = tyro.cli(Options, args=arguments, prog=PROGRAM)
    try:
        texts = pages(read(options.results), options)
    except (ValueError, OSError) as error:
        sys.exit(f"{PROGRAM}: {error}")
    stale = {
        path: text
        for path, text in texts.items()
        if not path.exists() or path.read_text(encoding="utf-8") != text
    }
    if options.check and stale:
        sys.exit(f"stale: {', '.join(map(str, stale))}: run {PROGRAM}")
    for path, text in stale.items():
        files.write_text(path, text)
        print(f"{path}: written")
