"""What the command line may ask for, and what is refused before anything is run."""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from pathlib import Path

from asv_env.checks import choice
from asv_env.presets import PRESETS, SCENARIOS
from asv_env.render import video
from asv_env.tasks import TASKS
from baselines.evaluate.conditions import Suite, custom
from baselines.evaluate.policy_sources import entrants
from baselines.evaluate.report import document
from baselines.evaluate.store import NAME as STORE
from baselines.evaluate.suites import SUITES
from baselines.paper.experiment import PAPER_GOAL
from baselines.policy import POLICIES
from baselines.rollout import seeds

FILES = ("episodes.csv", "summary.json", *document.FILES)
ONLY_CUSTOM = ("scenario", "num_boats", "preset", "seed", "goal", "random_goals")
"""Options that a suite has settled."""
REPLAYS = 180
"""Of a page, without those that are added where policies fail."""
LEAST = {"episodes": 1, "num_envs": 1, "seed": 0, "workers": 0, "replays": 0}


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
        "was trained several times. The others are compared with the first (scripted)",
    )  # fmt: skip
    who.add_argument(
        "--trust-pickles", action="store_true",
        help="read stable-baselines3 models; doing so runs whatever code is in them",
    )  # fmt: skip
    what = made.add_argument_group("what is run: a suite")
    what.add_argument("--suite", metavar="NAME", help=", ".join(SUITES))
    what.add_argument("--task", nargs="+", metavar="NAME", help=f"{', '.join(TASKS)} (transport)")
    what.add_argument(
        "--episodes", type=int, metavar="N", help="of each condition (the suite's, or 100)"
    )
    own = made.add_argument_group("or a sweep: several tasks, scenarios, team sizes")
    own.add_argument("--scenario", nargs="+", metavar="NAME", help=f"{', '.join(SCENARIOS)}")
    own.add_argument("--num-boats", nargs="+", type=int, metavar="N", help="2 to 100 (4)")
    own.add_argument("--preset", help=", ".join(PRESETS))
    own.add_argument("--seed", type=int, help="of the first episode (0)")
    goals = own.add_mutually_exclusive_group()
    goals.add_argument(
        "--goal", type=float, nargs=3, metavar=("X", "Y", "H"),
        help="pose of the vessel, m, m, rad (the paper's, {} {} {})".format(*PAPER_GOAL),
    )  # fmt: skip
    goals.add_argument(
        "--random-goals", action="store_true", help="a goal for each episode, drawn by its seed"
    )
    how = made.add_argument_group("how it is run, which changes no number")
    how.add_argument(
        "--workers", type=int, metavar="N", default=_cores(),
        help="processes (%(default)s); 0 runs all in this one, for a debugger",
    )  # fmt: skip
    how.add_argument(
        "--num-envs", type=int, metavar="N", default=32,
        help="worlds side by side in a process (%(default)s)",
    )  # fmt: skip
    out = made.add_argument_group("what is left")
    out.add_argument("--out", type=Path, metavar="DIR", help="folder (below runs)")
    out.add_argument(
        "--replays", type=int, metavar="N",
        help="first episodes of each condition that can be watched in the report; where policies fail, "
        f"up to as many again ({REPLAYS} shared out over the conditions)",
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
    """Options, completed with ``suite``, ``entrants`` and their ``fingerprints``.

    Exits with a message where something is wrong.
    """
    made = parser()
    options = made.parse_args(arguments)
    try:
        _check_numbers(options)
        options.suite = _suite(options)
        if options.replays is None:
            options.replays = REPLAYS // len(options.suite.conditions)
        options.entrants = entrants(options.policies, options.suite, options.trust_pickles)
        options.fingerprints = {
            one.name: [source.fingerprint() for source in one.sources] for one in options.entrants
        }
        _check_files(options)
    except (ValueError, TypeError, OSError, ImportError) as error:
        made.error(str(error))
    return options


def _check_numbers(options: argparse.Namespace) -> None:
    for name, least in LEAST.items():
        value = getattr(options, name)
        if value is not None and value < least:
            flag = name.replace("_", "-")
            raise ValueError(f"--{flag} {value}: must be at least {least}")
    if (options.seed or 0) + (options.episodes or 0) >= seeds.TRAINING.stop:
        raise ValueError(f"--seed {options.seed}: must lie below {seeds.TRAINING.stop}")


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
        raise ValueError(
            f"--episodes {episodes}: {suite.name} has {suite.episodes} of each condition"
        )
    return suite.of(choice("task", tasks[0], TASKS)).first(episodes)


def _check_files(options: argparse.Namespace) -> None:
    """Completes ``out``, and refuses to replace what the folder does not hold by itself."""
    suite = options.suite
    if options.out is None:
        options.out = Path("runs") / _folder_name(suite)
    if options.out.exists() and not options.out.is_dir():
        raise FileExistsError(f"{options.out} is a file: choose another folder with --out")
    present = [name for name in FILES if (options.out / name).exists()]
    if present and not (options.out / STORE).exists() and not options.overwrite:
        raise FileExistsError(
            f"{options.out} holds {', '.join(present)} of another origin: choose another folder "
            "with --out, or replace them with --overwrite"
        )
    if options.video is not None:
        choice("kind of video", options.video.suffix.lower(), video.SUFFIXES)
        if options.video.exists() and not options.overwrite:
            raise FileExistsError(f"{options.video} exists: name another file, or use --overwrite")


def _folder_name(suite: Suite) -> str:
    """What a folder is called after: the same for the same set of episodes."""
    if suite.name in SUITES:
        return suite.name if suite.task == "transport" else f"{suite.name}-{suite.task}"
    parts = [suite.task, *dict.fromkeys(condition.scenario for condition in suite.conditions)]
    return "-".join([*parts, suite.digest()[:6]])


def _cores() -> int:
    """That this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
