"""What a step costs with sensors of one's own: ``python benchmarks/sensing_cost.py``.

The whole environment step is timed with one noisy measurement that the team shares, and with one of
each boat, in turns and on one thread. Ratios of CPU times are taken within a round, so that what
else the machine does matters little; the table shows their medians.
"""

import os
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np
import tyro
from subjects import SITUATIONS, vector_subject
from tqdm import tqdm

from asv_env.checks import check_whole
from asv_env.presets import NOISE
from baselines.reproduce.artefact import markdown
from baselines.rollout.commands import command, say

SHARED = "shared"  #: name of the sensors with which the others are compared
SENSORS: dict[str, dict[str, Any]] = {
    SHARED: NOISE,
    "own": {**NOISE, "shared": False},
    "own, range 1 m, delay, dropout": {
        **NOISE, "shared": False, "range": 1.0, "delay": 0.2, "dropout": 0.1,
    },
    "exact": {},
}  # fmt: skip


@dataclass(frozen=True)
class Options:
    """Times a step with shared sensors and with those of each boat."""

    worlds: int = 64  #: number of worlds
    steps: int = 50  #: number of steps of a measurement
    rounds: int = 21  #: number of measurements of each subject

    def __post_init__(self) -> None:
        check_whole(self, "worlds steps rounds", 1, 10**6)


def seconds(step: Callable[[], object], steps: int) -> float:
    """Returns the CPU time of some steps, s."""
    begun = time.process_time()
    for _ in range(steps):
        step()
    return time.process_time() - begun


def study(options: Annotated[Options, tyro.conf.arg(name="")]) -> None:
    """Prints the CPU time of a step, µs, and its ratio to that with shared sensors."""
    load, rows = os.getloadavg()[0], []
    for situation, base in SITUATIONS.items():
        subjects = {
            name: vector_subject(replace(base, others={"sensors": own}), options.worlds, 1)
            for name, own in SENSORS.items()
        }
        taken: dict[str, list[float]] = {name: [] for name in SENSORS}
        for _ in tqdm(range(options.rounds), desc=situation):
            for name, subject in subjects.items():
                taken[name].append(seconds(subject.step, options.steps))
        for name, times in taken.items():
            ratio = np.median(np.divide(times, taken[SHARED]))
            step = 1e6 * np.median(times) / options.steps
            row = {"situation": situation, "sensors": name}
            rows.append({**row, "µs a step": f"{step:.0f}", "over shared": f"{ratio:.2f}"})
    loads = f"load average {load:.1f} at the start, {os.getloadavg()[0]:.1f} at the end"
    say(markdown({"rows": rows, "notes": [f"{options.worlds} worlds, one thread, {loads}."]}))


main = command(study, "python benchmarks/sensing_cost.py")

if __name__ == "__main__":
    main()
