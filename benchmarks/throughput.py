"""Speed of the whole environment step: ``python benchmarks/throughput.py``.

What is timed is a step as a learner sees it (physics, observation, reward, termination, infos
and autoreset) of worlds of 4 boats, physics at 50 Hz, control at 10 Hz, in two situations:

* unconstrained: Transport, random actions; few contacts.
* pushing: Push, the vessel grasped and under way at 10 cm/s; the boats at the side push at full
  speed, those at the ends keep pace and press on it: contacts everywhere.

Episodes end by a time limit (60 s and 20 s), staggered over the worlds, so that every stretch of
time has its share of resets.

*Bare* is the time spent in ``pymunk.Space.step`` by these very steps, under a stopwatch whose own
cost is measured at the start and taken off. It includes what Pymunk's own Python does, with the
caches as the rest of the step leaves them; a loop of nothing but ``Space.step`` would be faster.

VMAS ``transport`` (4 agents, random continuous actions, one torch thread, one physics substep a
step where ours takes five) is stepped through its public interface only. It is never reset, which
is in its favour. Actions are drawn beforehand on both sides.

All subjects take turns, a short measurement each, in every round; a ratio is taken within a round,
between neighbours in time, and the table shows medians and ranges over the rounds.
"""

import json
import math
import os
import platform
import time
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Annotated, Any
from unittest import mock

import pandas as pd
import pymunk
import tyro
from stopwatch import Stopwatch
from subjects import CLOCK, NUM_BOATS, Subject, all_subjects
from tqdm import tqdm

from asv_env import files
from asv_env.checks import TINY, check_numbers, check_whole
from baselines.rollout import provenance
from baselines.rollout.commands import FilePath, command

SUBSTEPS = CLOCK["physics"] // CLOCK["control"]
VMAS_SUBSTEPS = 1
SUBJECT = ["worlds", "adapter", "situation"]  #: columns that tell what was measured
FORMATS = {
    "touching": ".0%",
    "env-steps/s": ",.0f",
    "agent-steps/s": ",.0f",
    "µs a step": ".1f",
    "bare µs": ".1f",
    "ours/bare": ".2f",
    "env-steps/VMAS": ".2f",
    "substeps/VMAS": ".2f",
}
"""Formats of the measured quantities."""
RANGED = ("env-steps/s", "ours/bare", "env-steps/VMAS")  #: quantities whose range is shown


@dataclass(frozen=True)
class Options:
    """Times the whole environment step, compared with bare ``Space.step`` and with VMAS."""

    worlds: tuple[int, ...] = (1, 64, 256, 1024)  #: numbers of worlds
    seconds: float = 0.5  #: length of a measurement, s
    rounds: int = 11  #: number of measurements of each subject
    vmas: tyro.conf.FlagCreatePairsOff[bool] = True  #: compare with VMAS, if it is installed
    out: FilePath | None = None  #: JSON file for all samples
    overwrite: tyro.conf.FlagCreatePairsOff[bool] = False  #: replace that file

    def __post_init__(self) -> None:
        if not self.worlds or not all(1 <= worlds <= 10**6 for worlds in self.worlds):
            raise ValueError(f"--worlds {self.worlds}: must be from 1 to 1,000,000")
        check_numbers(self, "seconds", TINY)
        check_whole(self, "rounds", 1, 10**6)
        if self.out is not None and self.out.exists() and not self.overwrite:
            raise ValueError(f"--out {self.out} exists: name another file, or use --overwrite")


def throughput(options: Options) -> pd.DataFrame:
    """Runs all rounds; returns a row for each measurement."""
    watch = Stopwatch()
    overhead = watch.overhead()
    with mock.patch.object(pymunk.Space, "step", watch.timed("bare", pymunk.Space.step)):
        subjects = all_subjects(sorted(set(options.worlds)), options.vmas)
        turns = [(number, subject) for number in range(options.rounds) for subject in subjects]
        return pd.DataFrame(
            {"round": number, **measure(subject, options.seconds, watch, *overhead)}
            for number, subject in tqdm(turns, unit="measurement")
        )


def measure(
    subject: Subject, seconds: float, watch: Stopwatch, inside: float, whole: float
) -> dict[str, Any]:
    """Steps a subject for at least so long; returns the columns of one measurement.

    They are ``SUBJECT``; "steps" of all worlds; "seconds"; the part of them that is "bare"; and
    "touching", the fraction of the boats that touch something at the end. What the stopwatch
    costs, ``inside`` and as a ``whole``, is taken off the times.

    Raises:
        RuntimeError: the environment did its physics without ``Space.step``.
    """
    steps, elapsed = 0, 0.0
    watch.restart()
    start = time.perf_counter()
    while elapsed < seconds:
        subject.step()
        steps += 1
        elapsed = time.perf_counter() - start
    found = {name: getattr(subject, name) for name in SUBJECT} | {"steps": steps}
    if subject.simulation is None:
        return found | {"seconds": elapsed, "bare": math.nan, "touching": math.nan}
    calls = watch.calls["bare"]
    if not calls:
        raise RuntimeError("pymunk.Space.step was never called: time something else")
    touching = float(subject.simulation.state.touching.any(axis=-1).mean())
    bare = watch.seconds["bare"] - calls * inside
    return found | {"seconds": elapsed - calls * whole, "bare": bare, "touching": touching}


def with_rates(samples: pd.DataFrame) -> pd.DataFrame:
    """Returns measurements with rates and ratios; each ratio is of two samples of one round."""
    worlds, steps, seconds, bare = (samples[n] for n in ("worlds", "steps", "seconds", "bare"))
    rate = worlds * steps / seconds
    vmas = rate.where(samples["adapter"] == "VMAS")
    vmas = vmas.groupby([samples["round"], worlds]).transform("max").where(bare.notna())
    rates = {
        "env-steps/s": rate,
        "agent-steps/s": NUM_BOATS * rate,
        "µs a step": 1e6 / rate,
        "bare µs": 1e6 * bare / steps / worlds,
        "ours/bare": seconds / bare,
        "env-steps/VMAS": rate / vmas,
        "substeps/VMAS": SUBSTEPS / VMAS_SUBSTEPS * rate / vmas,
    }
    return samples.assign(**rates)


def table(samples: pd.DataFrame) -> str:
    """Returns the measurements as text: medians, and in brackets the range over the rounds."""
    groups = with_rates(samples).groupby(SUBJECT, sort=False)
    columns = {name: groups[name].apply(_cell, name) for name in FORMATS}
    shown = {name: cells for name, cells in columns.items() if cells.any()}
    return pd.DataFrame(shown).reset_index().to_string(index=False)


def _cell(values: pd.Series, name: str) -> str:
    form = FORMATS[name]
    if values.isna().all():
        return ""
    text = format(values.median(), form)
    return text + f" ({values.min():{form}}-{values.max():{form}})" * (name in RANGED)


def circumstances(options: Options) -> dict[str, Any]:
    """Returns what a reader needs to know to judge the numbers."""
    names = ("asv-env", "numpy", "gymnasium", "pymunk", "vmas", "torch")
    versions = provenance.versions(name for name in names if find_spec(name.replace("-", "_")))
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


def time_steps(options: Annotated[Options, tyro.conf.arg(name="")]) -> None:
    """Time the whole environment step, compared with bare ``Space.step`` and with VMAS."""
    around = circumstances(options)
    samples = throughput(options)
    loads = f"{around['load_average'][0]:.1f} at the start, {os.getloadavg()[0]:.1f} at the end"
    versions = ", ".join(f"{name} {version}" for name, version in around["versions"].items())
    print(f"\n{table(samples)}\n")
    print(f"Load average {loads}, {around['cores']} cores, Python {around['python']}, {versions}")
    if options.out is not None:
        rows = json.loads(samples.to_json(orient="records"))
        text = json.dumps({"circumstances": around, "samples": rows}, indent=2)
        files.write_text(options.out, text + "\n")


main = command(time_steps, "python benchmarks/throughput.py")

if __name__ == "__main__":
    main()
