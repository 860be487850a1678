"""The command line: ``python -m baselines.evaluate``."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

import tyro

from baselines.evaluate.api import InputError, StoppedError, compare
from baselines.evaluate.comparison import Comparison
from baselines.evaluate.options import Options, as_flags, folder_name
from baselines.evaluate.request import FILES

PROGRAM = "python -m baselines.evaluate"


def main(arguments: Sequence[str] | None = None) -> None:
    """Compares policies as a command line says; exits with a message where something is wrong."""
    options = tyro.cli(
        Options, args=arguments, prog=PROGRAM, config=(tyro.conf.FlagCreatePairsOff,)
    )
    try:
        suite, policies = options.chosen_suite(), options.named_policies()
        options.check_video()
    except (ValueError, TypeError, OSError, ImportError) as error:
        _refuse(error)
    out = options.out or Path("runs") / folder_name(suite)
    try:
        comparison = compare(
            policies,
            suite,
            options.episodes,
            out,
            workers=options.workers,
            num_envs=options.num_envs,
            replays=options.replays,
            record=options.record,
            overwrite=options.overwrite,
            trust_pickles=options.trust_pickles,
        )
    except InputError as error:
        _refuse(error)
    except (KeyboardInterrupt, StoppedError) as error:
        reason = "stopped" if isinstance(error, KeyboardInterrupt) else str(error)
        sys.exit(f"\n{reason}\nFinished episodes are kept: give the same command to continue.")
    print(comparison)
    _print_errors(comparison)
    print(f"Results: {', '.join(str(out / name) for name in FILES)}")
    if options.video is not None:
        _film(comparison, options.video)


def _refuse(error: Exception) -> NoReturn:
    print(f"{PROGRAM}: error: {as_flags(str(error))}", file=sys.stderr)
    sys.exit(2)


def _print_errors(comparison: Comparison) -> None:
    """Names the episodes in which a policy raised or gave no usable action, the first few."""
    broken = [row for row in comparison.results if row.error]
    for row in broken[:10]:
        print(f"policy error: {row.policy}, {row.condition}, seed {row.seed}: {row.error}")
    if len(broken) > 10:
        print(f"... and {len(broken) - 10} more; see the column error of episodes.csv")


def _film(comparison: Comparison, path: Path) -> None:
    try:
        comparison.film(path)
    except Exception as error:  # of a policy or a codec: everything else is saved by now
        sys.exit(f"{path}: no film, {type(error).__name__}: {error}")
    print(f"Video: {path}")
