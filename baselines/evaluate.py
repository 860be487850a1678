"""Runs policies on the same seeded episodes: ``python -m baselines.evaluate``.

Prints a table and writes ``episodes.csv``, ``summary.json`` and ``trajectories.png``.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Sequence
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import binomtest
from tqdm import tqdm

from asv_env import video
from asv_env.checks import choice
from asv_env.params import TASKS, EnvParams
from asv_env.presets import PRESETS, SCENARIOS, make_params
from baselines import episodes, film, trajectories
from baselines.episodes import Episode, Track
from baselines.paper import PaperPolicy
from baselines.policy import Idle, Policy, Random
from baselines.scripted import ScriptedPolicy

PAPER_GOAL = (0.55, -0.95, 0.1)
POLICIES: dict[str, Callable[[EnvParams], Policy]] = {
    "scripted": ScriptedPolicy,
    "paper": PaperPolicy,
    "idle": Idle,
    "random": Random,
}
FILES = ("episodes.csv", "summary.json", "trajectories.png")
MEDIANS = {
    "position_error": ("position", "cm", 100.0),
    "heading_error": ("|heading|", "rad", 1.0),
    "time_to_closure": ("closure", "s", 1.0),
    "time_to_goal": ("delivery", "s", 1.0),
}


def parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    """The command line; exits with a message where it is wrong."""
    parser = argparse.ArgumentParser(
        prog="python -m baselines.evaluate",
        description="Run policies on the same seeded episodes and compare them.",
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    parser.add_argument("--policies", nargs="+", default=["scripted"], help=", ".join(POLICIES))
    parser.add_argument("--task", default="transport", help=", ".join(TASKS))
    parser.add_argument("--episodes", type=int, default=100, help="episodes for each policy")
    parser.add_argument("--seed", type=int, default=0, help="seed of the first episode")
    parser.add_argument(
        "--goal",
        type=float,
        nargs=3,
        metavar=("X", "Y", "H"),
        default=PAPER_GOAL,
        help="goal pose: m, m, rad",
    )
    parser.add_argument(
        "--random-goals", action="store_true", help="a goal for each episode, drawn by its seed"
    )
    parser.add_argument("--num-boats", type=int, help="2 to 100; by default the preset's own")
    parser.add_argument("--scenario", default="nominal", help=", ".join(SCENARIOS))
    parser.add_argument("--preset", default="nominal", help=", ".join(PRESETS))
    parser.add_argument("--num-envs", type=int, default=50, help="worlds side by side")
    parser.add_argument("--out", type=Path, help="folder for the results (default: runs/...)")
    parser.add_argument(
        "--video", type=Path, help="film the first policy's first episode: a .gif or .mp4 file"
    )
    parser.add_argument("--overwrite", action="store_true", help="replace results that are there")
    options = parser.parse_args(arguments)
    try:
        _check(options)
    except (ValueError, TypeError, FileExistsError) as error:
        parser.error(str(error))
    return options


def _check(options: argparse.Namespace) -> None:
    """Completes the options.

    Raises:
        ValueError: an unknown name or a number out of range.
        FileExistsError: there are results in the folder already.
    """
    for policy in options.policies:
        choice("policy", policy, POLICIES)
    if len(set(options.policies)) < len(options.policies):
        raise ValueError(f"--policies {' '.join(options.policies)}: name each policy once")
    for name, least in (("episodes", 1), ("num_envs", 1), ("seed", 0)):
        if getattr(options, name) < least:
            flag = name.replace("_", "-")
            raise ValueError(f"--{flag} {getattr(options, name)}: must be at least {least}")
    goal: dict[str, Any] = {} if options.random_goals else {"goal": tuple(options.goal)}
    options.params = make_params(
        options.task, options.num_boats, options.scenario, options.preset, **goal
    )
    if options.out is None:
        names = "-".join([options.task, options.scenario, *options.policies])
        options.out = Path("runs") / names
    present = [name for name in FILES if (options.out / name).exists()]
    if present and not options.overwrite:
        raise FileExistsError(
            f"{options.out} holds {', '.join(present)} already: "
            "choose another folder with --out, or replace them with --overwrite"
        )
    if options.video is not None:
        choice("kind of video", options.video.suffix, video.SUFFIXES)
        if options.video.exists() and not options.overwrite:
            raise FileExistsError(f"{options.video} exists: name another file, or use --overwrite")
    if options.out.exists() and not options.out.is_dir():
        raise FileExistsError(f"{options.out} is a file: choose another folder with --out")


def evaluate(options: argparse.Namespace) -> list[Track]:
    """Runs all policies, with a progress bar; tracks in order of policy and seed."""
    seeds = range(options.seed, options.seed + options.episodes)
    tracks: list[Track] = []
    with tqdm(total=len(seeds) * len(options.policies), unit="episode", file=sys.stderr) as bar:
        for name in options.policies:
            bar.set_description(name)
            own = []
            for track in episodes.run(
                POLICIES[name], name, options.scenario, options.params, seeds, options.num_envs
            ):
                own.append(track)
                bar.update()
            tracks += sorted(own, key=lambda track: track.episode.seed)
    return tracks


def summarise(rows: Sequence[Episode]) -> dict[str, Any]:
    """Summary of one policy's episodes.

    Returns:
        Success with its 95 % Wilson interval; median, mean and standard deviation of each
        number that applies, over the episodes where it does; heading errors by magnitude.
    """
    success = sum(row.success for row in rows)
    interval = binomtest(success, len(rows)).proportion_ci(0.95, method="wilson")
    summary: dict[str, Any] = {
        "episodes": len(rows),
        "success": success / len(rows),
        "success_interval": [interval.low, interval.high],
    }
    for column in episodes.COLUMNS[episodes.COLUMNS.index("position_error") :]:
        values = [getattr(row, column) for row in rows if getattr(row, column) is not None]
        if not values:
            continue
        array = np.array(values, dtype=np.float64)
        if column.startswith("heading"):
            array = np.abs(array)
        summary[column] = {
            "median": float(np.median(array)),
            "mean": float(array.mean()),
            "sd": float(array.std(ddof=1)) if len(array) > 1 else None,
            "n": len(array),
        }
    return summary


def table(summaries: dict[str, dict[str, Any]]) -> str:
    """A table of the summaries, one line a policy; errors and times are medians."""
    heads = ["policy", "success", "95 % interval"]
    heads += [f"{name} [{unit}]" for name, unit, _ in MEDIANS.values()]
    lines = [heads]
    for name, summary in summaries.items():
        low, high = summary["success_interval"]
        cells = [name, f"{summary['success']:.1%}", f"{low:.1%} to {high:.1%}"]
        for column, (_, _, scale) in MEDIANS.items():
            cells.append(f"{summary[column]['median'] * scale:.2f}" if column in summary else "-")
        lines.append(cells)
    widths = [max(len(line[column]) for line in lines) for column in range(len(heads))]
    return "\n".join(
        "  ".join(
            cell.ljust(width) if column == 0 else cell.rjust(width)
            for column, (cell, width) in enumerate(zip(line, widths, strict=True))
        )
        for line in lines
    )


def save(options: argparse.Namespace, tracks: Sequence[Track]) -> dict[str, dict[str, Any]]:
    """Writes the results into the output folder; returns the summaries by policy."""
    rows = [track.episode for track in tracks]
    summaries = {
        name: summarise([row for row in rows if row.policy == name]) for name in options.policies
    }
    options.out.mkdir(parents=True, exist_ok=True)
    episodes.write_csv(options.out / FILES[0], rows)
    document = {
        "versions": {name: metadata.version(name) for name in ("asv-env", "numpy", "pymunk")},
        "options": {
            "task": options.task,
            "scenario": options.scenario,
            "preset": options.preset,
            "num_boats": options.params.num_boats,
            "goal": options.params.task.goal,
            "seeds": [options.seed, options.seed + options.episodes - 1],
        },
        "policies": summaries,
    }
    (options.out / FILES[1]).write_text(json.dumps(document, indent=2) + "\n")
    trajectories.save_picture(options.out / FILES[2], tracks, options.params)
    return summaries


def main(arguments: Sequence[str] | None = None) -> None:
    """Entry point of ``asv-evaluate`` and ``python -m baselines.evaluate``."""
    options = parse(arguments)
    summaries = save(options, evaluate(options))
    print(table(summaries))
    print("Errors and times are medians; errors of all episodes, times of those that got there.")
    print("Results: " + ", ".join(str(options.out / name) for name in FILES))
    if options.video is not None:
        film.save(options.video, POLICIES[options.policies[0]], options.params, options.seed)
        print(f"Video: {options.video}")


if __name__ == "__main__":
    main()
