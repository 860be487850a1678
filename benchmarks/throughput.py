"""Speed of the whole environment step: ``python benchmarks/throughput.py``.

What is timed is a step as a learner sees it (physics, observation, reward, termination, infos
and autoreset) of worlds of 4 boats, physics at 50 Hz under control at 10 Hz, in two situations:

* at large: Transport, random actions; few contacts.
* pushing: Push, the vessel in the grasp and under way at 10 cm/s; the pushers full ahead, the boats
  at the ends at its pace and leaning on it: contacts everywhere.

Episodes end by a time limit (60 s and 20 s), staggered over the worlds, so that every stretch of
time has its share of resets.

*Bare* is the time spent in ``pymunk.Space.step`` by these very steps: the method is wrapped in a
stopwatch while the environment runs, so the worlds, the contacts and the moment are the same by
construction. What the stopwatch itself costs is measured at the start and taken off both times.
Bare includes what Pymunk's own Python does in that method, and the caches are as the rest of the
step leaves them; a loop of nothing but ``Space.step`` would find them warmer.

VMAS ``transport`` (4 agents, random continuous actions, one torch thread, one physics substep a
step where ours takes five) is stepped through its public interface only. It is never reset, which
is in its favour. Actions are drawn beforehand on both sides.

All subjects take turns, a short measurement each, in every round; a ratio is taken within a round,
between neighbours in time, and the table shows medians and ranges over the rounds.
"""

from __future__ import annotations

import argparse
import contextlib
import functools
import io
import json
import math
import os
import platform
import resource
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from importlib import metadata
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
import pymunk
from gymnasium.vector import AutoresetMode
from tqdm import tqdm

from asv_env.envs.joint import JointEnv
from asv_env.envs.vector import AsvVectorEnv
from asv_env.simulation import Simulation

NUM_BOATS = 4
CLOCK = {"physics": 50, "sensing": 10, "control": 10}
SUBSTEPS = CLOCK["physics"] // CLOCK["control"]
VMAS_SUBSTEPS = 1
DRAWN = 32
"""Actions drawn beforehand, used over and over."""
MEMORY_STEPS = 1_000_000
MEMORY_LIMIT = 4.0
"""Growth of the resident set after the first quarter that is still called flat, MiB."""

Drive = Callable[[Simulation], list[np.ndarray]]


@dataclass(frozen=True)
class Situation:
    """What the boats are doing.

    Attributes:
        name: in the table.
        task: of the environment.
        time_limit: of an episode, s.
        drive: gives the actions (W, A, 2) to go through in turn.
    """

    name: str
    task: str
    time_limit: float
    drive: Drive

    @property
    def options(self) -> dict[str, Any]:
        """Arguments of the environment's faces."""
        return {
            "task": self.task,
            "num_boats": NUM_BOATS,
            "clock": CLOCK,
            "time_limit": self.time_limit,
        }


@dataclass
class Subject:
    """Something to be timed.

    Attributes:
        worlds: how many.
        situation: name of it.
        face: what is stepped.
        step: advances all worlds by one step.
        simulation: behind the face, if it is ours.
    """

    worlds: int
    situation: str
    face: str
    step: Callable[[], object]
    simulation: Simulation | None = None


@dataclass
class Sample:
    """One measurement.

    Attributes:
        steps: calls of ``Subject.step``.
        seconds: without the stopwatch's own time.
        bare: seconds of those in ``Space.step``.
        touching: share of the boats that touch something at its end.
    """

    steps: int
    seconds: float
    bare: float = 0.0
    touching: float = 0.0


class Stopwatch:
    """Adds up the time spent in a function.

    Attributes:
        seconds: so far, the part of the overhead that falls between the readings included.
        calls: so far.
    """

    def __init__(self) -> None:
        self.seconds, self.calls = 0.0, 0
        self._inside, self._whole = self._overhead()

    def around(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """The function, timed."""

        @functools.wraps(function)
        def timed(*arguments: Any) -> Any:
            start = time.perf_counter()
            result = function(*arguments)
            self.seconds += time.perf_counter() - start
            self.calls += 1
            return result

        return timed

    def restart(self) -> None:
        """Forgets what it has measured."""
        self.seconds, self.calls = 0.0, 0

    def sample(self, steps: int, seconds: float, touching: float) -> Sample:
        """What ``steps`` and ``seconds`` were without the stopwatch."""
        bare = self.seconds - self.calls * self._inside
        return Sample(steps, seconds - self.calls * self._whole, bare, touching)

    def _overhead(self, tries: int = 20, calls: int = 20_000) -> tuple[float, float]:
        """Seconds that a call costs more: between the two readings, and in all."""

        def nothing(space: object, dt: float) -> None:
            pass

        timed, inside, whole, plain = self.around(nothing), [], [], []
        for _ in range(tries):
            self.restart()
            plain.append(_duration(nothing, calls))
            whole.append(_duration(timed, calls))
            inside.append(self.seconds)
        self.restart()
        # The fastest try is the one that the rest of the machine disturbed least.
        return (min(inside) - min(plain)) / calls, (min(whole) - min(plain)) / calls


def _duration(function: Callable[[object, float], object], calls: int) -> float:
    start = time.perf_counter()
    for _ in range(calls):
        function(None, 0.0)
    return time.perf_counter() - start


@contextlib.contextmanager
def timed_space_steps() -> Iterator[Stopwatch]:
    """Wraps ``pymunk.Space.step``; environments made inside are timed."""
    original, watch = pymunk.Space.step, Stopwatch()
    pymunk.Space.step = watch.around(original)  # type: ignore[method-assign]
    try:
        yield watch
    finally:
        pymunk.Space.step = original  # type: ignore[method-assign]


# ---------------------------------------------------------------------- what is timed


def wander(simulation: Simulation) -> list[np.ndarray]:
    """Random actions."""
    rng = np.random.default_rng(0)
    shape = (simulation.num_worlds, NUM_BOATS, 2)
    return [rng.uniform(-1, 1, shape).astype(np.float32) for _ in range(DRAWN)]


def push(simulation: Simulation) -> list[np.ndarray]:
    """Pushers full ahead; the boats at the ends keep pace and lean on the vessel."""
    along = simulation.state.slot.real
    vessel, _ = simulation.params.hulls()
    at_end = np.abs(along) > vessel.length / 2
    action = np.zeros((*along.shape, 2), dtype=np.float32)
    action[..., 0] = np.where(at_end, 0.44, 1.0)
    action[..., 1] = np.where(at_end, -0.02 * np.sign(along), 0.0)
    return [action]


AT_LARGE = Situation("at large", "transport", 60.0, wander)
PUSHING = Situation("pushing", "push", 20.0, push)


def vector_subject(situation: Situation, worlds: int) -> Subject:
    """``AsvVectorEnv`` with SAME_STEP autoreset, its episodes staggered."""
    env = AsvVectorEnv(worlds, autoreset_mode=AutoresetMode.SAME_STEP, **situation.options)
    env.reset(seed=0)
    actions = situation.drive(env.simulation)
    step = _repeating(env.step, actions)
    length = round(situation.time_limit * CLOCK["control"])
    turn = np.arange(worlds) * length // worlds
    for tick in tqdm(range(length), f"{worlds} {situation.name}", leave=False, delay=1):
        step()
        if (turn == tick).any():
            env.reset(options={"reset_mask": turn == tick})
    return Subject(worlds, situation.name, "AsvVectorEnv", step, env.simulation)


def joint_subject(situation: Situation) -> Subject:
    """``JointEnv``, reset by its user."""
    env = JointEnv(**situation.options)
    env.reset(seed=0)
    advance = _repeating(env.step, [action[0] for action in situation.drive(env.simulation)])

    def step() -> None:
        _, _, terminated, truncated, _ = advance()
        if terminated or truncated:
            env.reset()

    for _ in range(100):
        step()
    return Subject(1, situation.name, "JointEnv", step, env.simulation)


def vmas_subject(vmas: VmasMaker, worlds: int) -> Subject:
    """VMAS ``transport`` under random actions."""
    step = vmas(worlds)
    for _ in range(20):
        step()
    return Subject(worlds, "", "VMAS", step)


def _repeating(function: Callable[[Any], Any], arguments: Sequence[Any]) -> Callable[[], Any]:
    """Calls the function with the arguments in turn, over and over."""
    count = 0

    def step() -> Any:
        nonlocal count
        count += 1
        return function(arguments[count % len(arguments)])

    return step


VmasMaker = Callable[[int], Callable[[], object]]


def load_vmas() -> VmasMaker | None:
    """A maker of VMAS's step for a number of worlds; None, with a message, without VMAS."""
    try:
        with contextlib.redirect_stderr(io.StringIO()):  # an old gym complains of its age
            import torch
            from vmas import make_env
    except ImportError as error:
        print(f"No comparison with VMAS ({error}). To have it: pip install vmas", file=sys.stderr)
        return None
    torch.set_num_threads(1)

    def make(worlds: int) -> Callable[[], object]:
        env = make_env(
            "transport",
            num_envs=worlds,
            device="cpu",
            continuous_actions=True,
            n_agents=NUM_BOATS,
            seed=0,
        )
        env.reset()
        drawn = [[2 * torch.rand(worlds, 2) - 1 for _ in range(NUM_BOATS)] for _ in range(DRAWN)]
        return _repeating(env.step, drawn)

    return make


# ---------------------------------------------------------------------- throughput


def measure(subject: Subject, seconds: float, watch: Stopwatch) -> Sample:
    """Steps the subject for at least so long.

    Raises:
        RuntimeError: the environment did its physics past ``Space.step``.
    """
    steps, elapsed = 0, 0.0
    watch.restart()
    start = time.perf_counter()
    while elapsed < seconds:
        subject.step()
        steps += 1
        elapsed = time.perf_counter() - start
    if subject.simulation is None:
        return Sample(steps, elapsed)
    if not watch.calls:
        raise RuntimeError("pymunk.Space.step was never called: the stopwatch has to go elsewhere")
    touching = float(subject.simulation.state.touching.any(axis=-1).mean())
    return watch.sample(steps, elapsed, touching)


def subjects(sizes: Sequence[int], vmas: VmasMaker | None) -> list[Subject]:
    """All that is timed, each size's together."""
    found = []
    for worlds in sizes:
        if vmas is not None:
            found.append(vmas_subject(vmas, worlds))
        for situation in (AT_LARGE, PUSHING):
            found.append(vector_subject(situation, worlds))
            if worlds == 1:
                found.append(joint_subject(situation))
    return found


def throughput(options: argparse.Namespace) -> list[dict[str, Any]]:
    """Runs all rounds; a row a subject."""
    with timed_space_steps() as watch:
        found = subjects(options.worlds, None if options.no_vmas else load_vmas())
        samples: list[list[Sample]] = [[] for _ in found]
        with tqdm(total=options.rounds * len(found), unit="measurement") as bar:
            for _ in range(options.rounds):
                for subject, own in zip(found, samples, strict=True):
                    own.append(measure(subject, options.seconds, watch))
                    bar.update()
    rivals = {
        subject.worlds: own
        for subject, own in zip(found, samples, strict=True)
        if subject.simulation is None
    }
    return [
        row(subject, own, rivals.get(subject.worlds))
        for subject, own in zip(found, samples, strict=True)
    ]


def row(subject: Subject, samples: list[Sample], rivals: list[Sample] | None) -> dict[str, Any]:
    """What a subject's samples come to; each ratio is of two samples of one round."""
    worlds = subject.worlds
    rates = [worlds * sample.steps / sample.seconds for sample in samples]
    result: dict[str, Any] = {
        "worlds": worlds,
        "face": subject.face,
        "situation": subject.situation,
        "env_steps_per_s": _spread(rates),
        "agent_steps_per_s": _spread([NUM_BOATS * rate for rate in rates]),
        "us_per_env_step": _spread([1e6 / rate for rate in rates]),
        "samples": [asdict(sample) for sample in samples],
    }
    if subject.simulation is None:
        return result
    bare = [1e6 * sample.bare / sample.steps / worlds for sample in samples]
    result["touching"] = median(sample.touching for sample in samples)
    result["bare_us_per_env_step"] = _spread(bare)
    result["over_bare"] = _spread([sample.seconds / sample.bare for sample in samples])
    if rivals is not None:
        theirs = [worlds * sample.steps / sample.seconds for sample in rivals]
        times = [ours / other for ours, other in zip(rates, theirs, strict=True)]
        result["env_steps_over_vmas"] = _spread(times)
        result["substeps_over_vmas"] = _spread([SUBSTEPS / VMAS_SUBSTEPS * x for x in times])
    return result


def _spread(values: Sequence[float]) -> dict[str, float]:
    return {"median": median(values), "min": min(values), "max": max(values)}


COLUMNS: dict[str, tuple[str, str]] = {
    "env_steps_per_s": ("env-steps/s", ",.0f"),
    "agent_steps_per_s": ("agent-steps/s", ",.0f"),
    "us_per_env_step": ("µs a step", ".1f"),
    "bare_us_per_env_step": ("bare µs", ".1f"),
    "over_bare": ("ours/bare", ".2f"),
    "env_steps_over_vmas": ("env-steps/VMAS", ".2f"),
    "substeps_over_vmas": ("substeps/VMAS", ".2f"),
}
RANGED = ("env_steps_per_s", "over_bare", "env_steps_over_vmas")


def table(rows: Sequence[dict[str, Any]]) -> str:
    """The rows as text: medians, and in brackets the range over the rounds."""
    shown = [key for key in COLUMNS if any(key in one for one in rows)]
    lines = [["worlds", "subject", "situation", "touching"] + [COLUMNS[key][0] for key in shown]]
    for one in rows:
        touching = f"{one['touching']:.0%}" if "touching" in one else ""
        lines.append([str(one["worlds"]), one["face"], one["situation"], touching])
        lines[-1] += [_cell(one[key], key) if key in one else "" for key in shown]
    return _aligned(lines, (1, 2))


def _cell(value: dict[str, float], key: str) -> str:
    form = COLUMNS[key][1]
    text = format(value["median"], form)
    if key in RANGED:
        text += f" ({value['min']:{form}}-{value['max']:{form}})"
    return text


def _aligned(lines: list[list[str]], names: Sequence[int]) -> str:
    """Columns side by side: those of names to the left, numbers to the right."""
    widths = [max(len(line[column]) for line in lines) for column in range(len(lines[0]))]
    texts = []
    for line in lines:
        cells = zip(line, widths, range(len(line)), strict=True)
        padded = [c.ljust(w) if i in names else c.rjust(w) for c, w, i in cells]
        texts.append("  ".join(padded).rstrip())
    texts.insert(1, "  ".join("-" * width for width in widths))
    return "\n".join(texts)


# ---------------------------------------------------------------------- memory


def memory(options: argparse.Namespace) -> list[dict[str, Any]]:
    """Resident set, MiB, over a million world-steps of each situation; a row each."""
    return [memory_row(situation, max(options.worlds)) for situation in (AT_LARGE, PUSHING)]


def memory_row(situation: Situation, worlds: int) -> dict[str, Any]:
    """Resident set at the start, after each quarter, and its growth after the first."""
    subject = vector_subject(situation, worlds)
    quarter = math.ceil(MEMORY_STEPS / worlds / 4)
    resident = [resident_mib()]
    with tqdm(total=4 * quarter, desc=f"{worlds} {situation.name}", unit="step") as bar:
        for _ in range(4):
            for _ in range(quarter):
                subject.step()
                bar.update()
            resident.append(resident_mib())
    return {
        "worlds": worlds,
        "situation": situation.name,
        "world_steps": 4 * quarter * worlds,
        "resident_mib": resident,
        "growth_mib": max(resident[2:]) - resident[1],
    }


def resident_mib() -> float:
    """Resident set of this process, MiB; where there is no /proc, the largest so far."""
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[1])
    except OSError:
        unit = 1 if sys.platform == "darwin" else 1024
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 2**20
    return pages * resource.getpagesize() / 2**20


def memory_table(rows: Sequence[dict[str, Any]]) -> str:
    """The rows as text."""
    head = ["worlds", "situation", "world-steps", "start", "1/4", "1/2", "3/4", "end", "growth"]
    lines = [head]
    for one in rows:
        sizes = [f"{size:.1f}" for size in (*one["resident_mib"], one["growth_mib"])]
        lines.append([str(one["worlds"]), one["situation"], f"{one['world_steps']:,}", *sizes])
    return _aligned(lines, (1,))


# ---------------------------------------------------------------------- command line


def parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    """The command line; exits with a message where it is wrong."""
    parser = argparse.ArgumentParser(
        description="Time the whole environment step beside bare Space.step and VMAS.",
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    parser.add_argument("--worlds", type=int, nargs="+", default=[1, 64, 256, 1024])
    parser.add_argument("--seconds", type=float, default=0.5, help="length of a measurement")
    parser.add_argument("--rounds", type=int, default=11, help="measurements of each subject")
    parser.add_argument("--no-vmas", action="store_true", help="leave VMAS out")
    parser.add_argument(
        "--memory",
        action="store_true",
        help="instead, watch the memory over a million world-steps of the most worlds",
    )
    parser.add_argument("--out", type=Path, help="JSON file for the results")
    parser.add_argument("--overwrite", action="store_true", help="replace that file")
    options = parser.parse_args(arguments)
    problem = _problem(options)
    if problem:
        parser.error(problem)
    return options


def _problem(options: argparse.Namespace) -> str:
    """What is wrong with the options; empty if nothing."""
    options.worlds = sorted(set(options.worlds))
    if options.worlds[0] < 1:
        return f"--worlds {options.worlds[0]}: must be at least 1"
    if not 0 < options.seconds < math.inf:
        return f"--seconds {options.seconds}: must be a positive number"
    if options.rounds < 1:
        return f"--rounds {options.rounds}: must be at least 1"
    if options.out is not None and options.out.is_dir():
        return f"--out {options.out} is a folder: name a file"
    if options.out is not None and options.out.exists() and not options.overwrite:
        return f"--out {options.out} exists: choose another name, or replace it with --overwrite"
    return ""


def circumstances(options: argparse.Namespace) -> dict[str, Any]:
    """What a reader needs to know to judge the numbers."""
    versions = {}
    for name in ("asv-env", "numpy", "gymnasium", "pymunk", "vmas", "torch"):
        with contextlib.suppress(metadata.PackageNotFoundError):
            versions[name] = metadata.version(name)
    return {
        "python": platform.python_version(),
        "versions": versions,
        "machine": platform.machine(),
        "cores": os.cpu_count(),
        "load_average": os.getloadavg(),
        "seconds": options.seconds,
        "rounds": options.rounds,
        "num_boats": NUM_BOATS,
        "clock": CLOCK,
    }


def main(arguments: Sequence[str] | None = None) -> int:
    """Measures, prints, writes; 1 if memory grew."""
    options = parse(arguments)
    around = circumstances(options)
    rows = memory(options) if options.memory else throughput(options)
    load = "{:.1f} at the start, {:.1f} at the end".format(
        around["load_average"][0], os.getloadavg()[0]
    )
    print(f"\n{memory_table(rows) if options.memory else table(rows)}\n")
    print(f"Load average {load}, {around['cores']} cores, Python {around['python']}, ", end="")
    print(", ".join(f"{name} {version}" for name, version in around["versions"].items()))
    if options.out is not None:
        options.out.parent.mkdir(parents=True, exist_ok=True)
        options.out.write_text(json.dumps({"circumstances": around, "rows": rows}, indent=2) + "\n")
    if options.memory and any(one["growth_mib"] > MEMORY_LIMIT for one in rows):
        print(f"Memory grew by more than {MEMORY_LIMIT} MiB.", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
