"""Speed of the whole environment step: ``python benchmarks/throughput.py``.

What is timed is a step as a learner sees it (physics, observation, reward, termination, infos
and autoreset) of worlds of 4 boats, physics at 50 Hz, control at 10 Hz, in two situations:

* unconstrained: Transport, random actions; few contacts.
* pushing: Push, the vessel grasped and under way at 10 cm/s; the boats at the side push at full
  speed, those at the ends keep pace and press on it: contacts everywhere.

Episodes end by a time limit (60 s and 20 s), staggered over the worlds, so that every stretch of
time has its share of resets.

*Bare* is the time of the same steps' calls of Chipmunk's ``cpSpaceStep`` alone, see ``bare.py``.
VMAS ``transport`` takes one physics substep a step where ours takes five, see ``vmas_process.py``.
``--against`` names a checkout of another version of this package, to be timed too. ``--torchrl``
times ``TorchRLEnv`` instead, see ``torchrl_process.py``, compared with TorchRL's wrapper of
``parallel_env`` on one world, and with that of VMAS where ``--vmas`` has TorchRL too.

All subjects have processes of their own and take turns, a short measurement each, in every round. A
ratio is taken within a round, between neighbours in time; the table shows medians over the rounds.
"""

import json
import math
import os
import platform
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import pandas as pd
import tyro
from subjects import CLOCK, NUM_BOATS
from tqdm import tqdm
from turns import READY

from asv_env import files
from asv_env.checks import TINY, check_numbers, check_whole
from baselines.rollout import provenance
from baselines.rollout.commands import FilePath, command

FOLDER = Path(__file__).resolve().parent
SUBSTEPS = CLOCK["physics"] // CLOCK["control"]
VMAS_SUBSTEPS = 1
ROW = ["worlds", "threads", "situation"]  #: columns that tell what was measured
FORMATS = {
    "env-steps/s": ",.0f",
    "substeps/s": ",.0f",
    "µs a step": ".2f",
    "over bare": ".2f",
    "over VMAS": ".2f",
    "substeps over VMAS": ".2f",
    "over the other version": ".2f",
    "over one thread": ".2f",
    "over PettingZooWrapper": ".0f",
}
"""Formats of the measured quantities."""
TORCHRL = "through TorchRL"  #: name of the situation of ``--torchrl``


@dataclass(frozen=True)
class Options:
    """Times the whole environment step, compared with bare ``cpSpaceStep`` and with VMAS."""

    worlds: tuple[int, ...] = (0, 64, 256, 1024)  #: numbers of worlds; 0 stands for ``gym.make``
    threads: int = 2  #: number of threads with which the largest number of worlds is timed again
    seconds: float = 0.5  #: length of a measurement, s
    rounds: int = 11  #: number of measurements of each subject
    clock: Literal["wall", "cpu"] = "wall"  #: "cpu" for one thread on a busy machine
    vmas: Path | None = None  #: interpreter that has VMAS, to compare with it
    against: Path | None = None  #: checkout of another version, to compare with it
    torchrl: tyro.conf.FlagCreatePairsOff[bool] = False  #: time ``TorchRLEnv``, on one thread
    out: FilePath | None = None  #: JSON file for all samples
    page: FilePath | None = None  #: page whose table is replaced by this one
    overwrite: tyro.conf.FlagCreatePairsOff[bool] = False  #: replace ``out``

    def __post_init__(self) -> None:
        if not self.worlds or not all(0 <= worlds <= 10**6 for worlds in self.worlds):
            raise ValueError(f"--worlds {self.worlds}: must be from 0 to 1,000,000")
        check_numbers(self, "seconds", TINY)
        check_whole(self, "rounds threads", 1, 10**6)
        if self.out is not None and self.out.exists() and not self.overwrite:
            raise ValueError(f"--out {self.out} exists: name another file, or use --overwrite")
        begin, _ = self.marks
        if self.page is not None and begin not in self.page.read_text(encoding="utf-8"):
            raise ValueError(f"--page {self.page}: has no line {begin}")
        if self.torchrl and (not any(self.worlds) or self.against is not None):
            raise ValueError("--torchrl: give --worlds above 0, and no --against")

    @property
    def marks(self) -> tuple[str, str]:
        """The lines round the page's table."""
        name = "throughput through TorchRL" if self.torchrl else "throughput"
        return f"<!-- {name} -->", f"<!-- end of {name} -->"


@dataclass
class Timed:
    """A subject in its process."""

    row: tuple[int, int, str]  #: values of ``ROW``
    subject: str  #: "ours", "VMAS", "other" or "wrapper"
    process: subprocess.Popen[str]

    def measure(self, seconds: float, word: str = "") -> dict[str, Any]:
        """Returns a measurement of at least so many seconds.

        Raises:
            RuntimeError: the process has ended; its message is on the screen.
        """
        assert self.process.stdin is not None
        with suppress(OSError):
            print(seconds, word, file=self.process.stdin, flush=True)
        return dict(json.loads(self._line()))

    def wait(self) -> None:
        """Waits until the subject is ready."""
        while self._line() != READY:
            pass

    def _line(self) -> str:
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        if not line:
            raise RuntimeError(f"{self.subject} {self.row}: its process has ended")
        return line.strip()


def rows(options: Options) -> list[tuple[int, int, str]]:
    """Returns what is measured: worlds, threads and situation of each row."""
    worlds = sorted(set(options.worlds))
    if options.torchrl:
        return [(each, 1, TORCHRL) for each in worlds if each]
    found = [(each, 1, situation) for each in worlds for situation in ("unconstrained", "pushing")]
    most = (worlds[-1], options.threads, "unconstrained")
    return found + [most] * (options.threads > 1 and worlds[-1] > 1)


@contextmanager
def started(options: Options) -> Iterator[list[Timed]]:
    """Starts the processes of all subjects, one after the other; ends them at last."""
    with ExitStack() as stack:

        def start(row: tuple[int, int, str], name: str, *words: object, **env: str) -> Timed:
            process = subprocess.Popen(
                list(map(str, words)),
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                text=True,
                env=os.environ | env,
            )
            stack.callback(process.wait)
            stack.callback(process.kill)
            timed = Timed(row, name, process)
            timed.wait()
            return timed

        found = []
        wanted = tqdm(rows(options), "starting", leave=False)
        if options.torchrl:
            process = FOLDER / "torchrl_process.py"
            found.append(start((1, 1, TORCHRL), "wrapper", sys.executable, process, "wrapper", 1))
            for row in wanted:
                found.append(start(row, "ours", sys.executable, process, "asv", row[0]))
                if options.vmas is not None:
                    words = process, "vmas", row[0]
                    found.append(start(row, "VMAS", options.vmas, *words, PYTHONPATH=""))
            yield found
            return
        for row in wanted:
            worlds, threads, situation = row
            words = FOLDER / "asv_process.py", situation, worlds, threads, options.clock
            found.append(start(row, "ours", sys.executable, *words))
            if options.against is not None and threads == 1:
                path = str(options.against.resolve())
                found.append(start(row, "other", sys.executable, *words, PYTHONPATH=path))
            if options.vmas is not None:
                words = FOLDER / "vmas_process.py", max(1, worlds), threads
                found.append(start(row, "VMAS", options.vmas, *words, PYTHONPATH=""))
        yield found


def throughput(options: Options) -> pd.DataFrame:
    """Runs all rounds; returns a row for each measurement."""
    found = []
    with started(options) as subjects:
        turns = [(number, subject) for number in range(options.rounds) for subject in subjects]
        for number, subject in tqdm(turns, unit="measurement"):
            sample = dict(zip(ROW, subject.row, strict=True)) | {"subject": subject.subject}
            sample |= {"round": number, **subject.measure(options.seconds)}
            bare = math.nan
            if subject.subject == "ours" and subject.row[1] == 1 and not options.torchrl:
                timed = subject.measure(options.seconds, "bare")
                bare = timed["bare"] / timed["steps"]
            found.append(sample | {"bare": bare})
    return pd.DataFrame(found)


def with_rates(samples: pd.DataFrame, clock: str) -> pd.DataFrame:
    """Returns rates and ratios of our rows; each ratio is of two samples of one round."""
    worlds = samples["worlds"].clip(lower=1)
    samples = samples.assign(rate=worlds * samples["steps"] / samples[clock])
    keys = [*ROW, "round"]
    ours, other, vmas = (
        samples[samples["subject"] == name].set_index(keys)["rate"]
        for name in ("ours", "other", "VMAS")
    )
    wrapper = samples[samples["subject"] == "wrapper"].set_index("round")["rate"]
    single = samples[(samples["subject"] == "ours") & (samples["threads"] == 1)]
    one = single.set_index(["worlds", "situation", "round"])["rate"]
    found = samples[samples["subject"] == "ours"].set_index(keys)
    index = found.index.droplevel("threads")
    step = found[clock] / found["steps"]
    rates = {
        "env-steps/s": ours,
        "substeps/s": SUBSTEPS * ours,
        "µs a step": 1e6 / ours,
        "over bare": step / found["bare"],
        "over VMAS": ours / vmas.reindex(ours.index),
        "substeps over VMAS": SUBSTEPS / VMAS_SUBSTEPS * ours / vmas.reindex(ours.index),
        "over the other version": ours / other.reindex(ours.index),
        "over one thread": (ours / one.reindex(index).to_numpy()).where(
            found.index.get_level_values("threads") > 1
        ),
        "over PettingZooWrapper": ours
        / wrapper.reindex(ours.index.get_level_values("round")).to_numpy(),
    }
    return pd.DataFrame(rates)


def medians(samples: pd.DataFrame, clock: str) -> pd.DataFrame:
    """Returns the table as texts: the median of each quantity over the rounds."""
    found = with_rates(samples, clock).groupby(level=ROW, sort=False).median()
    shown = {
        name: [format(value, form) if math.isfinite(value) else "" for value in found[name]]
        for name, form in FORMATS.items()
        if found[name].notna().any()
    }
    texts = pd.DataFrame(shown, index=found.index).reset_index()
    texts["worlds"] = [f"{worlds:,}" if worlds else "gym.make" for worlds in texts["worlds"]]
    return texts


def markdown(texts: pd.DataFrame) -> str:
    """Returns a table in Markdown."""
    lines = [list(texts.columns), ["---"] * texts.shape[1], *texts.astype(str).values.tolist()]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def circumstances(options: Options) -> dict[str, Any]:
    """Returns what a reader needs to know to judge the numbers."""
    names = ["asv-env", "numpy", "numba", "gymnasium", "pymunk"]
    names += ["torch", "torchrl"] * options.torchrl
    return {
        "python": platform.python_version(),
        "versions": provenance.versions(names),
        "machine": platform.machine(),
        "cores": os.cpu_count(),
        "load_average": os.getloadavg(),
        "clock": options.clock,
        "seconds": options.seconds,
        "rounds": options.rounds,
        "num_boats": NUM_BOATS,
        "rates": CLOCK,
    }


def write_page(page: Path, marks: tuple[str, str], table: str) -> None:
    """Replaces the table between two lines of a page."""
    begin, end = marks
    before, _, rest = page.read_text(encoding="utf-8").partition(begin)
    _, _, after = rest.partition(end)
    files.write_text(page, f"{before}{begin}\n{table}{end}{after}")


def time_steps(options: Annotated[Options, tyro.conf.arg(name="")]) -> None:
    """Time the whole environment step, compared with bare ``cpSpaceStep`` and with VMAS."""
    around = circumstances(options)
    samples = throughput(options)
    texts = medians(samples, options.clock)
    loads = f"{around['load_average'][0]:.1f} at the start, {os.getloadavg()[0]:.1f} at the end"
    versions = ", ".join(f"{name} {version}" for name, version in around["versions"].items())
    note = (
        f"Medians of {options.rounds} rounds, {options.clock} time, {around['cores']} cores "
        f"({around['machine']}), load average {loads}; Python {around['python']}, {versions}."
    )
    print(f"\n{texts.to_string(index=False)}\n\n{note}")
    if options.out is not None:
        kept = json.loads(samples.to_json(orient="records"))
        text = json.dumps({"circumstances": around, "samples": kept}, indent=2)
        files.write_text(options.out, text + "\n")
    if options.page is not None:
        write_page(options.page, options.marks, f"{markdown(texts)}\n{note}\n")


main = command(time_steps, "python benchmarks/throughput.py")

if __name__ == "__main__":
    main()
