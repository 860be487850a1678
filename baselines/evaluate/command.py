"""The command line: what is asked for, the run, and the files that it leaves."""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tqdm import tqdm

from asv_env import video
from asv_env.checks import choice
from asv_env.params import TASKS
from asv_env.presets import PRESETS, SCENARIOS
from baselines import film, provenance
from baselines.episodes import Label
from baselines.evaluate import recording, report, workers
from baselines.evaluate.entrants import POLICIES, Entrant, entrants
from baselines.evaluate.results import Results, write_csv
from baselines.evaluate.store import NAME as STORE
from baselines.evaluate.store import Series, Store
from baselines.evaluate.suites import PAPER_GOAL, SUITES, Suite, custom
from baselines.evaluate.summary import summarise
from baselines.evaluate.table import text_table
from baselines.evaluate.workers import Job

FILES = ("episodes.csv", "summary.json", *report.FILES)
LIBRARIES = ("numpy", "scipy", "pymunk")
JOB = 500
"""Largest number of episodes that a worker takes at a time."""
ONLY_CUSTOM = ("scenario", "num_boats", "preset", "seed", "goal", "random_goals")
"""Options that a suite has settled."""


def parser() -> argparse.ArgumentParser:
    """Of the command line."""
    made = argparse.ArgumentParser(
        prog="python -m baselines.evaluate",
        description="Run policies on the same seeded episodes and compare them. What is in the "
        "output folder already, made by the same code, is kept: give the command of a run that "
        "was stopped again, and it goes on; add policies or episodes, and only they are run.",
    )
    who = made.add_argument_group("who takes part")
    who.add_argument(
        "--policies", nargs="+", default=["scripted"], metavar="WORD",
        help=f"{', '.join(POLICIES)}; a policy file (.npz), a stable-baselines3 model (.zip), or "
        "module:Class. NAME=WORD gives it another name, NAME=WORD,WORD,... is one policy that "
        "was trained several times. The others are compared with the first (%(default)s)",
    )  # fmt: skip
    who.add_argument(
        "--trust-pickles", action="store_true",
        help="read stable-baselines3 models; doing so runs whatever code is in them",
    )  # fmt: skip
    what = made.add_argument_group("what is run: a suite")
    what.add_argument("--suite", metavar="NAME", help=", ".join(SUITES))
    what.add_argument("--task", nargs="+", metavar="NAME", help=f"{', '.join(TASKS)} (transport)")
    what.add_argument("--episodes", type=int, metavar="N", help="of each arm (the suite's, or 100)")
    own = made.add_argument_group("or a sweep: several tasks, scenarios, team sizes")
    own.add_argument("--scenario", nargs="+", metavar="NAME", help=f"{', '.join(SCENARIOS)}")
    own.add_argument("--num-boats", nargs="+", type=int, metavar="N", help="2 to 100 (4)")
    own.add_argument("--preset", help=", ".join(PRESETS))
    own.add_argument("--seed", type=int, help="of the first episode (0)")
    own.add_argument(
        "--goal", type=float, nargs=3, metavar=("X", "Y", "H"),
        help="pose of the vessel, m, m, rad (the paper's, {} {} {})".format(*PAPER_GOAL),
    )  # fmt: skip
    own.add_argument(
        "--random-goals", action="store_true", help="a goal for each episode, drawn by its seed"
    )
    how = made.add_argument_group("how it is run, which changes no number")
    how.add_argument(
        "--workers", type=int, metavar="N", default=len(os.sched_getaffinity(0)),
        help="processes (%(default)s); 0 runs all in this one, for debugging",
    )  # fmt: skip
    how.add_argument(
        "--num-envs", type=int, metavar="N", default=32,
        help="worlds side by side in a process (%(default)s)",
    )  # fmt: skip
    out = made.add_argument_group("what is left")
    out.add_argument("--out", type=Path, metavar="DIR", help="folder (below runs)")
    out.add_argument(
        "--replays", type=int, metavar="N", default=60,
        help="first episodes of each arm that can be watched in the report; where policies fail, "
        "up to as many again (%(default)s)",
    )  # fmt: skip
    out.add_argument(
        "--record", action="store_true", help="save trajectories too, for imitation learning"
    )
    out.add_argument(
        "--video", type=Path, metavar="FILE", help="film the first episode: .gif or .mp4"
    )
    out.add_argument("--overwrite", action="store_true", help="replace what is in the way")
    return made


def parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Options, completed with ``suite`` and ``entrants``; exits with a message if wrong."""
    made = parser()
    options = made.parse_args(arguments)
    try:
        _check_numbers(options)
        options.suite = _suite(options)
        options.entrants = entrants(options.policies, options.suite, options.trust_pickles)
        _check_files(options)
    except (ValueError, TypeError, OSError, ImportError) as error:
        made.error(str(error))
    return options


_LEAST = (("episodes", 1), ("num_envs", 1), ("seed", 0), ("workers", 0), ("replays", 0))


def _check_numbers(options: argparse.Namespace) -> None:
    for name, least in _LEAST:
        value = getattr(options, name)
        if value is not None and value < least:
            flag = name.replace("_", "-")
            raise ValueError(f"--{flag} {value}: must be at least {least}")


def _suite(options: argparse.Namespace) -> Suite:
    """What is to be run."""
    tasks = options.task or ["transport"]
    if options.suite is None:
        goal = None if options.random_goals else tuple(options.goal or PAPER_GOAL)
        return custom(
            tasks,
            options.scenario or ["nominal"],
            options.num_boats or [None],
            options.preset or "nominal",
            goal,
            options.seed or 0,
            options.episodes or 100,
        )
    suite = SUITES[choice("suite", options.suite, SUITES)]
    settled = [
        name
        for name in ONLY_CUSTOM
        if (value := getattr(options, name)) is not None and value is not False
    ]
    if settled or len(tasks) > 1:
        flag = (settled or ["task"])[0].replace("_", "-")
        raise ValueError(f"--{flag} cannot go with --suite, which settles it: leave one out")
    episodes = options.episodes or suite.episodes
    if episodes > suite.episodes:
        raise ValueError(f"--episodes {episodes}: {suite.name} has {suite.episodes} of each arm")
    return suite.of(choice("task", tasks[0], TASKS)).first(episodes)


def _check_files(options: argparse.Namespace) -> None:
    """Completes ``out``, and refuses to replace what the folder does not hold by itself."""
    suite = options.suite
    if options.out is None:
        names = [suite.name] * (suite.name in SUITES)
        names += [] if suite.name in SUITES and suite.task == "transport" else [suite.task]
        if suite.name not in SUITES:
            names += [*(options.scenario or ["nominal"]), *(one.name for one in options.entrants)]
        options.out = Path("runs") / "-".join(names)
    if options.out.exists() and not options.out.is_dir():
        raise FileExistsError(f"{options.out} is a file: choose another folder with --out")
    present = [name for name in FILES if (options.out / name).exists()]
    if present and not (options.out / STORE).exists() and not options.overwrite:
        raise FileExistsError(
            f"{options.out} holds {', '.join(present)} of another origin: choose another folder "
            "with --out, or replace them with --overwrite"
        )
    if options.video is not None:
        choice("kind of video", options.video.suffix, video.SUFFIXES)
        if options.video.exists() and not options.overwrite:
            raise FileExistsError(f"{options.video} exists: name another file, or use --overwrite")


def origin(suite: Suite) -> dict[str, Any]:
    """By what episodes are made, beside the policies."""
    return {
        "suite": suite.name,
        "task": suite.task,
        "set of episodes": suite.digest(),
        "state of the code": provenance.code(provenance.TOP),
        "set of libraries": provenance.versions(LIBRARIES),
    }


def run(options: argparse.Namespace, store: Store) -> None:
    """Runs the episodes that are not there yet, with a progress bar."""
    jobs = [
        job
        for arm in options.suite.arms
        for one in options.entrants
        for number in range(len(one.sources))
        for job in _jobs(options, store, arm, one, number)
    ]
    total = len(options.suite.arms) * options.suite.episodes
    total *= sum(len(one.sources) for one in options.entrants)
    missing = sum(len(job.seeds) for job in jobs)
    with tqdm(total=total, initial=total - missing, unit="episode", file=sys.stderr) as bar:
        for series, track in workers.run(jobs, options.workers):
            store.add(series, track)
            bar.set_description(f"{series.policy}, {series.arm}", refresh=False)
            bar.update()


def _jobs(
    options: argparse.Namespace, store: Store, arm: Any, one: Entrant, number: int
) -> list[Job]:
    """The episodes of one series that are missing, shared out."""
    suite, series = options.suite, Series(arm.name, one.name, number)
    record = None
    there = store.seeds(series)
    if options.record:
        record = recording.folder(options.out, arm.name, one.name, one.training_seed(number))
        there = {seed for seed in there if recording.path(record, seed).exists()}
    missing = [seed for seed in suite.seeds if seed not in there]
    size = max(1, min(JOB, -(-len(missing) // max(1, options.workers))))
    label = Label(one.name, one.training_seed(number), arm.name, arm.scenario)
    return [
        Job(series, arm, one.sources[number], label, tuple(missing[k : k + size]),
            options.num_envs, record)
        for k in range(0, len(missing), size)
    ]  # fmt: skip


def collect(options: argparse.Namespace, store: Store) -> Results:
    """The rows of all episodes that were asked for."""
    suite = options.suite
    rows = {
        (arm.name, one.name): [
            list(store.rows(Series(arm.name, one.name, number), suite.seeds))
            for number in range(len(one.sources))
        ]
        for arm in suite.arms
        for one in options.entrants
    }
    return Results(suite, tuple(one.name for one in options.entrants), rows)


def save(options: argparse.Namespace, store: Store, results: Results) -> dict[str, Any]:
    """Writes the files of the output folder; returns the summary."""
    suite = options.suite
    write_csv(options.out / "episodes.csv", results)
    summary = {
        "suite": suite.name,
        "about": suite.about,
        "episodes": suite.episodes,
        "seeds": [suite.seeds[0], suite.seeds[-1]],
        "origin": origin(suite),
        "policies": {
            one.name: [source.fingerprint() for source in one.sources] for one in options.entrants
        },
        **summarise(results),
    }
    (options.out / "summary.json").write_text(json.dumps(summary, indent=2) + "\n")
    report.write(options.out, results, summary, store, options.replays)
    return summary


def main(arguments: Sequence[str] | None = None) -> None:
    """See ``baselines.evaluate.main``."""
    options = parse(arguments)
    made_by = {one.name: [s.fingerprint() for s in one.sources] for one in options.entrants}
    try:
        store = Store(options.out, origin(options.suite), made_by, options.overwrite)
    except FileExistsError as error:
        parser().error(str(error))
    try:
        run(options, store)
        results = collect(options, store)
        summary = save(options, store, results)
    except (KeyboardInterrupt, RuntimeError) as error:
        reason = "Stopped" if isinstance(error, KeyboardInterrupt) else str(error)
        sys.exit(f"\n{reason}. Finished episodes are kept: give the same command to go on.")
    finally:
        store.close()
    print(text_table(summary))
    _name_broken(results)
    print(f"Results: {', '.join(str(options.out / name) for name in FILES)}")
    if options.video is not None:
        source, arm = options.entrants[0].sources[0], options.suite.arms[0]
        film.save(options.video, source.make, arm.params, options.suite.seed)
        print(f"Video: {options.video}")


def _name_broken(results: Results) -> None:
    """Names the episodes that a policy has broken, the first few of them."""
    broken = [row for row in results if row.error]
    for row in broken[:10]:
        print(f"policy error: {row.policy}, {row.arm}, seed {row.seed}: {row.error}")
    if len(broken) > 10:
        print(f"... and {len(broken) - 10} more; see the column error of episodes.csv")
