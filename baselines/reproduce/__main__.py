"""The command line: ``python -m baselines.reproduce``."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path

from tqdm import tqdm

from asv_env.checks import choice
from baselines.reproduce import contents, readme_table
from baselines.reproduce.artefact import Artefact
from baselines.reproduce.contents import ARTEFACTS
from baselines.reproduce.job import Job
from baselines.reproduce.output_folder import Record

CAPTIONS = "README.md"
TABLE = "table"


def parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    """The command line; exits with a message where it is wrong."""
    parser = argparse.ArgumentParser(
        prog="python -m baselines.reproduce",
        description="Make the paper's figures and table anew, beside its own numbers. What is "
        "there already, made with the same options by the same code, is kept: start a run that "
        "was stopped again, and it goes on.",
    )
    add = parser.add_argument
    add("--only", nargs="+", metavar="NAME", default=list(ARTEFACTS),
        help=f"of {', '.join(ARTEFACTS)}; by default all")  # fmt: skip
    add("--seed", type=int, default=0, help="seed of the first episode (%(default)s)")
    add("--trials", type=int, default=12, help="trials of figures 6 to 10 (%(default)s)")
    add("--episodes", type=int, default=96, help="episodes a condition of tables (%(default)s)")
    add("--out", type=Path, default=Path("runs/reproduce"), help="folder (%(default)s)")
    add("--page", type=Path, help="a page to put the table into as well, between its marks")
    add("--overwrite", action="store_true", help="replace what was made with other options")
    options = parser.parse_args(arguments)
    try:
        _check(options)
    except (ValueError, TypeError, FileExistsError, FileNotFoundError) as error:
        parser.error(str(error))
    return options


def _check(options: argparse.Namespace) -> None:
    """Completes the options with ``record`` and ``missing``, what is still to be made.

    Raises:
        ValueError: an unknown name, a number out of range, or a page that cannot take the table.
        FileExistsError: there is something in the way.
        FileNotFoundError: there is no such page.
    """
    for name in options.only:
        choice("figure or table", name, ARTEFACTS)
    for name, least in (("seed", 0), ("trials", 1), ("episodes", 1)):
        if getattr(options, name) < least:
            raise ValueError(f"--{name} {getattr(options, name)}: must be at least {least}")
    if options.out.exists() and not options.out.is_dir():
        raise FileExistsError(f"{options.out} is a file: choose another folder with --out")
    if options.page is not None:
        if TABLE not in options.only:
            raise ValueError(f"--page takes the table: add {TABLE} to --only")
        readme_table.check(options.page.read_text())
    options.job = Job(options.seed, options.trials, options.episodes)
    options.record = Record(options.out, options.job)
    options.missing = {
        name: artefact
        for name, artefact in contents.selection(options.only).items()
        if not options.record.complete(name, artefact.files(name))
    }
    present = [
        file
        for name, artefact in options.missing.items()
        for file in options.record.in_the_way(name, artefact.files(name))
    ]
    if (options.out / CAPTIONS).exists() and not options.record.known:
        present.append(CAPTIONS)
    if present and not options.overwrite:
        raise FileExistsError(
            f"{options.out} holds {', '.join(present)} already, made with other options or other "
            "code: choose another folder with --out, or replace them with --overwrite"
        )


def reproduce(options: argparse.Namespace) -> None:
    """Makes what is missing, and writes each artefact as soon as it is made."""
    options.out.mkdir(parents=True, exist_ok=True)
    bar: tqdm[tuple[str, Artefact]]
    with tqdm(options.missing.items(), unit="artefact", file=sys.stderr) as bar:
        for name, artefact in bar:
            bar.set_description(name)
            options.record.begin(name)
            artefact.build(name, options.job, options.out)
            options.record.finish(name)
    (options.out / CAPTIONS).write_text(contents.captions(options.record.made()))
    if options.page is not None:
        table = json.loads((options.out / f"{TABLE}.json").read_text())
        options.page.write_text(readme_table.updated(options.page.read_text(), table))


def main(arguments: Sequence[str] | None = None) -> None:
    """Entry point of ``python -m baselines.reproduce``."""
    options = parse(arguments)
    kept = len(contents.selection(options.only)) - len(options.missing)
    try:
        reproduce(options)
    except KeyboardInterrupt:
        sys.exit("\nStopped. What was made is kept: give the same command to go on.")
    print(f"{options.out}: {len(options.missing)} made, {kept} kept. See {CAPTIONS} there.")


if __name__ == "__main__":
    main()
