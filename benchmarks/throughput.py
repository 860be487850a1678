"""Speed of the whole environment step: ``python benchmarks/throughput.py``.

What is timed is a step as a learner sees it (physics, observation, reward, termination, infos
and autoreset) of worlds of 4 boats, physics at 50 Hz, control at 10 Hz, in two situations:

* unconstrained: Transport, random actions; few contacts.
* pushing: Push, the vessel grasped and under way at 10 cm/s; the boats at the side push at full
  speed, those at the ends keep pace and press on it: contacts everywhere.

Episodes end by a time limit (60 s and 20 s), staggered over the worlds, so that every stretch of
time has its share of resets.

*Bare* is the time spent in ``pymunk.Space.step`` by these very steps: the method is wrapped in a
stopwatch while the environment runs, so that worlds, contacts and moment are the same. What the
stopwatch itself costs is measured at the start and taken off both times. Bare includes what
Pymunk's own Python does in that method, and the caches are as the rest of the step leaves them; a
loop of nothing but ``Space.step`` would find them warmer.

VMAS ``transport`` (4 agents, random continuous actions, one torch thread, one physics substep a
step where ours takes five) is stepped through its public interface only. It is never reset, which
is in its favour. Actions are drawn beforehand on both sides.

All subjects take turns, a short measurement each, in every round; a ratio is taken within a round,
between neighbours in time, and the table shows medians and ranges over the rounds.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
import platform
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from importlib import metadata
from pathlib import Path
from statistics import median
from typing import Any

import pandas as pd
import tyro
from stopwatch import Sample, Stopwatch, timed_space_steps
from subjects import CLOCK, NUM_BOATS, Subject, all_subjects
from tqdm import tqdm

SUBSTEPS = CLOCK["physics"] // CLOCK["control"]
VMAS_SUBSTEPS = 1
COLUMNS: dict[str, tuple[str, str]] = {
    "env_steps_per_s": ("env-steps/s", ",.0f"),
    "agent_steps_per_s": ("agent-steps/s", ",.0f"),
    "us_per_env_step": ("µs a step", ".1f"),
    "bare_us_per_env_step": ("bare µs", ".1f"),
    "over_bare": ("ours/bare", ".2f"),
    "env_steps_over_vmas": ("env-steps/VMAS", ".2f"),
    "substeps_over_vmas": ("substeps/VMAS", ".2f"),
}
"""Measured quantities, with head and format of their columns."""
RANGED = ("env_steps_per_s", "over_bare", "env_steps_over_vmas")
"""Quantities whose range is shown."""


@dataclass(frozen=True)
class Options:
    """Times the whole environment step, compared with bare ``Space.step`` and with VMAS."""

    worlds: tuple[int, ...] = (1, 64, 256, 1024)
    """Numbers of worlds."""
    seconds: float = 0.5
    """Length of a measurement, s."""
    rounds: int = 11
    """Number of measurements of each subject."""
    vmas: bool = True
    """Compare with VMAS, if it is installed."""
    out: Path | None = None
    """JSON file for all samples."""
    overwrite: bool = False
    """Replace that file."""

    def __post_init__(self) -> None:
        if min(self.worlds, default=0) < 1:
            raise ValueError(f"--worlds {self.worlds}: must be at least 1")
        if not 0 < self.seconds < math.inf:
            raise ValueError(f"--seconds {self.seconds}: must be a positive number")
        if self.rounds < 1:
            raise ValueError(f"--rounds {self.rounds}: must be at least 1")
        if self.out is not None and self.out.exists() and not self.overwrite:
            raise ValueError(f"--out {self.out} exists: name another file, or use --overwrite")


def measure(subject: Subject, seconds: float, watch: Stopwatch) -> Sample:
    """Steps a subject for at least so long.

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
    if subject.simulation is None:
        return Sample(steps, elapsed)
    if not watch.calls:
        raise RuntimeError("pymunk.Space.step was never called: time something else")
    touching = float(subject.simulation.state.touching.any(axis=-1).mean())
    return watch.sample(steps, elapsed, touching)


def throughput(options: Options) -> list[dict[str, Any]]:
    """Runs all rounds; returns a row for each subject."""
    with timed_space_steps() as watch:
        subjects = all_subjects(sorted(set(options.worlds)), options.vmas)
        samples: list[list[Sample]] = [[] for _ in subjects]
        with tqdm(total=options.rounds * len(subjects), unit="measurement") as bar:
            for _ in range(options.rounds):
                for subject, own in zip(subjects, samples, strict=True):
                    own.append(measure(subject, options.seconds, watch))
                    bar.update()
    pairs = list(zip(subjects, samples, strict=True))
    vmas = {subject.worlds: own for subject, own in pairs if subject.simulation is None}
    return [row(subject, own, vmas.get(subject.worlds)) for subject, own in pairs]


def row(subject: Subject, samples: list[Sample], vmas: list[Sample] | None) -> dict[str, Any]:
    """Returns what a subject's samples amount to; each ratio is of two samples of one round."""
    worlds = subject.worlds
    rates = [worlds * sample.steps / sample.seconds for sample in samples]
    result: dict[str, Any] = {
        "worlds": worlds,
        "adapter": subject.adapter,
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
    if vmas is not None:
        theirs = [worlds * sample.steps / sample.seconds for sample in vmas]
        times = [ours / other for ours, other in zip(rates, theirs, strict=True)]
        result["env_steps_over_vmas"] = _spread(times)
        result["substeps_over_vmas"] = _spread([SUBSTEPS / VMAS_SUBSTEPS * x for x in times])
    return result


def _spread(values: Sequence[float]) -> dict[str, float]:
    return {"median": median(values), "min": min(values), "max": max(values)}


def table(rows: Sequence[dict[str, Any]]) -> str:
    """Returns the rows as text: medians, and in brackets the range over the rounds."""
    cells = []
    for one in rows:
        touching = f"{one['touching']:.0%}" if "touching" in one else ""
        line = {name: one[name] for name in ("worlds", "adapter", "situation")}
        line |= {"touching": touching}
        line |= {head: _cell(one[key], key) for key, (head, _) in COLUMNS.items() if key in one}
        cells.append(line)
    return pd.DataFrame(cells).to_string(index=False, na_rep="")


def _cell(value: dict[str, float], key: str) -> str:
    form = COLUMNS[key][1]
    text = format(value["median"], form)
    return text + f" ({value['min']:{form}}-{value['max']:{form}})" * (key in RANGED)


def circumstances(options: Options) -> dict[str, Any]:
    """Returns what a reader needs to know to judge the numbers."""
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


def main(options: Options) -> None:
    """Measures, prints and writes."""
    around = circumstances(options)
    rows = throughput(options)
    loads = f"{around['load_average'][0]:.1f} at the start, {os.getloadavg()[0]:.1f} at the end"
    versions = ", ".join(f"{name} {version}" for name, version in around["versions"].items())
    print(f"\n{table(rows)}\n")
    print(f"Load average {loads}, {around['cores']} cores, Python {around['python']}, {versions}")
    if options.out is not None:
        options.out.parent.mkdir(parents=True, exist_ok=True)
        options.out.write_text(json.dumps({"circumstances": around, "rows": rows}, indent=2) + "\n")


if __name__ == "__main__":
    main(tyro.cli(Options, config=(tyro.conf.FlagCreatePairsOff,)))
