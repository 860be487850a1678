"""The command line: ``python -m baselines.evaluate``.

What takes long to import is imported when it is needed, so that ``--help`` comes at once.
"""

import os
import re
import sys
from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

import tyro

from asv_env.text import described, one_line
from baselines.rollout import extras
from baselines.rollout.commands import LONGEST, FilePath, say, steady
from baselines.rollout.process_state import Terminated

if TYPE_CHECKING:
    from baselines.evaluate.conditions import Suite

PROGRAM = "python -m baselines.evaluate"
SWEEP = ("scenario", "num_boats", "preset", "difficulty", "seed", "goal", "random_goals")
"""Options that a suite settles."""
LONG = 80  #: number of characters at which the name of the default folder is cut
PASSED = ("workers", "num_envs", "replays", "record", "overwrite", "trust_pickles")
"""Options that are arguments of ``compare`` as they are."""


@dataclass(frozen=True)
class Options:
    """Run policies on the same seeded episodes and compare them.

    What is in the output folder already, made by the same code, is kept: give the command of a
    run that was stopped again, and it continues; add policies or episodes, and only they are run.
    """

    policies: tuple[str, ...] = ("scripted",)
    """scripted, allocation, paper, paper-tuned, learned, idle, random; a policy file (.npz), a
    stable-baselines3 model (.zip), or module:Class. NAME=WORD gives it another name,
    NAME=WORD,WORD,... is one policy that was trained several times. The others are compared with
    the first"""
    trust_pickles: bool = False
    """read stable-baselines3 models; doing so runs whatever code is in them"""
    suite: str | None = None
    """suite to run: quick-v2, paper-v2, plane-v2, robust-v2, team-v2, shape-v2, easy-v1,
    harbour-v1, sensing-v1, hard-v1. Without one, a sweep over the tasks, scenarios and team sizes
    below is run"""
    task: tuple[str, ...] = ("transport",)
    """approach, push, transport, or module:NAME; a suite takes one, a sweep several"""
    episodes: int | None = None
    """number of episodes of each condition; by default the suite's, or 100"""
    scenario: tuple[str, ...] = ()
    """scenarios of a sweep: nominal, noisy, delay, dropout, shelter, current, gyre, gusts,
    mismatch, unlike, load, failure, failure-in-push, harsh, or module:NAME; by default nominal"""
    num_boats: tuple[int, ...] = ()  # team sizes of a sweep, 2 to 100; by default 4
    preset: str | None = None
    """preset of a sweep: nominal, experiment, paper_simulation, tank, tank-calibrated, otter,
    heron, cybership2"""
    difficulty: str | None = None
    """difficulty of a sweep: easy, standard, hard; with one, each episode draws a goal"""
    seed: int | None = None  # seed of the first episode of a sweep; by default 0
    goal: tuple[float, float, float] | None = None
    """goal of a sweep, the pose x y heading of the vessel in m, m, rad; by default the paper's"""
    random_goals: bool = False  # draw a goal for each episode of a sweep by its seed
    workers: int | None = None
    """number of processes, by default one a core; 0 runs everything in this one, for a debugger.
    It changes no number"""
    num_envs: int = 64  # number of worlds side by side in a process. It changes no number
    out: str | None = None  # folder of the run; by default below runs
    replays: int | None = None
    """number of first episodes of each condition that can be watched in the report; where policies
    fail, up to as many again. By default 180, shared by the conditions"""
    record: bool = False  # save trajectories too, for imitation learning
    video: FilePath | None = None  # film the first episode: .gif or .mp4
    overwrite: bool = False  # replace what is in the way

    def chosen_suite(self) -> "Suite":
        """Returns the suite or the sweep that is asked for, by options that go together."""
        from baselines.evaluate.suites import SUITES, sweep
        from baselines.paper.paper_numbers import PAPER_GOAL

        if self.suite is not None:
            settled = [name for name in SWEEP if getattr(self, name) != getattr(Options, name)]
            if settled or len(self.task) > 1:
                flag = "--" + (settled or ["task"])[0].replace("_", "-")
                raise ValueError(f"{flag} cannot go with --suite, which settles it: leave one out")
            suite = SUITES.find(self.suite)
            return suite if self.task == Options.task else suite.with_task(self.task[0])
        if self.random_goals and self.goal:
            raise ValueError("--random-goals is not allowed with --goal: leave one out")
        return sweep(
            self.task,
            self.scenario or ("nominal",),
            self.num_boats or (None,),
            self.preset or "nominal",
            None if self.random_goals or self.difficulty else self.goal or PAPER_GOAL,
            self.seed or 0,
            100 if self.episodes is None else self.episodes,
            self.difficulty or "standard",
        )

    def named_policies(self) -> dict[str, list[str]]:
        """Returns the words of ``policies`` by the names of the policies."""
        from baselines.evaluate.policy_sources import is_file

        found: dict[str, list[str]] = {}
        for word in self.policies:
            name, equals, rest = word.partition("=")
            if not equals or os.path.exists(word):
                name, rest = "", word
            words = rest.split(",")
            if len(words) > 1 and not name:
                raise ValueError(
                    f"{word}: several trainings of one policy need a name, NAME=A.zip,B.zip; "
                    "separate different policies with spaces"
                )
            name = name or (Path(word).stem if is_file(word) else word.rpartition(":")[2])
            if name in found:
                given = " ".join(self.policies)
                raise ValueError(f"--policies {given}: name each policy once (NAME=...)")
            found[name] = words
        return found

    def check_video(self) -> None:
        """Refuses a film of an unknown kind, or one that would replace a file."""
        from asv_env.checks import choice
        from asv_env.render import video

        if self.video is None:
            return
        choice("kind of video", self.video.suffix.lower(), video.SUFFIXES)
        if self.video.exists() and not self.overwrite:
            raise FileExistsError(f"{self.video} exists: name another file, or use --overwrite")
        if self.video.is_dir() or not self.video.parent.is_dir():
            raise ValueError(f"--video {self.video}: name a file in a folder that exists")


def main(arguments: Sequence[str] | None = None) -> None:
    """Compares policies as a command line says; exits with a message where something is wrong."""
    try:
        with steady(), extras.needed(PROGRAM):
            _main(arguments)
    except KeyboardInterrupt as error:
        stopped(f"stopped by {error}" if isinstance(error, Terminated) else "stopped")


def _main(arguments: Sequence[str] | None) -> None:
    options = tyro.cli(
        Options, args=arguments, prog=PROGRAM, config=(tyro.conf.FlagCreatePairsOff,)
    )
    from baselines.evaluate.api import InputError, StoppedError, compare, refusing
    from baselines.evaluate.report import rendering
    from baselines.evaluate.request import FILES

    try:
        with refusing():
            suite, policies = options.chosen_suite(), options.named_policies()
            options.check_video()
        out = str(Path("runs") / folder_name(suite)) if options.out is None else options.out
        passed = {name: getattr(options, name) for name in PASSED}
        comparison = compare(policies, suite, options.episodes, out, **passed)
    except InputError as error:
        if sys.stderr is not None:
            message = one_line(as_flags(str(error)), LONGEST)
            print(f"{PROGRAM}: error: {message}", file=sys.stderr)
        sys.exit(2)
    except StoppedError as error:
        stopped(str(error))
    say(comparison)
    for line in rendering.broken(comparison.results):
        say(f"policy error: {line}")
    say(f"Results: {', '.join(str(Path(out) / name) for name in FILES)}")
    if options.video is not None:
        try:
            comparison.film(options.video)
        except Exception as error:  # of a codec: everything else is saved by now
            sys.exit(f"{options.video}: no film, {described(error)}")
        say(f"Video: {options.video}")


def stopped(reason: str) -> NoReturn:
    """Exits where an evaluation could not be finished."""
    sys.exit(f"\n{reason}\nFinished episodes are kept: give the same command to continue.")


def folder_name(suite: "Suite") -> str:
    """Returns the name of the default folder, the same for the same set of episodes."""
    from baselines.evaluate.suites import SUITES

    if suite.name in SUITES:
        name = suite.name if suite.task == "transport" else f"{suite.name}-{suite.task}"
    else:
        scenarios = dict.fromkeys(condition.scenario_name for condition in suite.conditions)
        name = "-".join([suite.task, *scenarios, suite.digest()[:6]])
    return re.sub(
        r"[^\w.+-]", "_", name if len(name) <= LONG else f"{name[:LONG]}-{suite.digest()}"
    )


def as_flags(message: str) -> str:
    """Returns a message about arguments of ``compare`` as one about options."""
    names = "|".join(f.name for f in fields(Options))
    found = rf"\b({names})=(True\b|\.\.\.)?"
    return re.sub(found, lambda m: f"--{m[1].replace('_', '-')}{'' if m[2] else ' '}", message)
