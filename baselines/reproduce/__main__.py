"""The command line: ``python -m baselines.reproduce``."""

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from asv_env.checks import check_whole, choice
from asv_env.files import write_text
from baselines.rollout import extras
from baselines.rollout.commands import FilePath, command

PROGRAM = "python -m baselines.reproduce"
with extras.needed(PROGRAM):
    from tqdm import tqdm

    from baselines.evaluate.publish import marks
    from baselines.reproduce import contents, paper_page
    from baselines.reproduce.artefact import Artefact, Job, OutputFolder
    from baselines.reproduce.contents import ARTEFACTS
    from baselines.rollout.lock import locked
CAPTIONS = "README.md"


@dataclass(frozen=True)
class Options:
    """What is made, and where."""

    only: tuple[str, ...] = tuple(ARTEFACTS)  #: names of the figures, tables and studies to make
    seed: int = 0  #: seed of the first episode
    trials: int = 12  #: number of trials of figures 6 to 10
    episodes: int = 96  #: number of episodes in each condition of the tables
    out: FilePath = Path("runs/reproduce")  #: folder to write to
    page: FilePath | None = None  #: page that receives tables as well, each between its marks
    overwrite: bool = False  #: replace what was made with other options or other code

    def __post_init__(self) -> None:
        if not self.only:
            raise ValueError(f"--only: name one at least of {', '.join(ARTEFACTS)}")
        for name in self.only:
            choice("figure or table", name, ARTEFACTS)
        check_whole(self, "seed", 0)
        check_whole(self, "trials episodes", 1)
        if self.out.exists() and not self.out.is_dir():
            raise FileExistsError(f"{self.out} is a file: choose another folder with --out")
        if self.page is not None:
            if not self.on_page:
                known = [name for name in paper_page.TABLES if name in ARTEFACTS]
                raise ValueError(f"--page takes tables: add one of {', '.join(known)} to --only")
            paper_page.check(marks.read(self.page), self.on_page)

    @property
    def on_page(self) -> list[str]:
        """Names of the tables for the page."""
        return [name for name in paper_page.TABLES if name in self.only]


def missing(options: Options, folder: OutputFolder) -> dict[str, Artefact]:
    """Returns the artefacts that are still to be made.

    Raises:
        FileExistsError: files are there that were made in another way, and are not to be replaced.
    """
    wanted = contents.selection(options.only)
    found = {name: one for name, one in wanted.items() if not folder.holds(name, one)}
    present = [file for name, one in found.items() for file in folder.in_the_way(name, one)]
    if (options.out / CAPTIONS).exists() and not folder.known:
        present.append(CAPTIONS)
    if present and not options.overwrite:
        raise FileExistsError(
            f"{options.out} holds {', '.join(present)} already, made with other options or other "
            "code: choose another folder with --out, or replace them with --overwrite"
        )
    return found


def make(artefacts: dict[str, Artefact], options: Options, folder: OutputFolder) -> None:
    """Makes artefacts and writes each as soon as it is made, then the page of captions."""
    with tqdm(artefacts, unit="artefact", file=sys.stderr) as bar:
        for name in bar:
            bar.set_description(name)
            folder.record(name, complete=False)
            artefacts[name].build(name, folder.job, options.out)
            folder.record(name, complete=True)
    write_text(options.out / CAPTIONS, contents.captions(folder.made(), options.out))
    if options.page is not None:
        text = paper_page.updated(marks.read(options.page), options.out, options.on_page)
        write_text(options.page, text)


def run(options: Annotated[Options, tyro.conf.arg(name="")]) -> None:
    """Reproduce the paper's figures and tables, side by side with its own numbers.

    What is there already, made with the same options by the same code, is kept: repeat the command
    to continue a run that was stopped. No other run can use the folder meanwhile.

    Raises:
        ValueError, OSError: see ``missing`` and ``OutputFolder``; or a file cannot be written.
    """
    job = Job(options.seed, options.trials, options.episodes)
    folder = OutputFolder(options.out, job, options.overwrite)
    missing(options, folder)  # before a lock is left there
    with locked(options.out):
        folder.read()
        artefacts = missing(options, folder)
        make(artefacts, options, folder)
    kept = len(contents.selection(options.only)) - len(artefacts)
    print(f"{options.out}: {len(artefacts)} made, {kept} kept. See {CAPTIONS} there.")


main = command(run, PROGRAM)

if __name__ == "__main__":
    main()
