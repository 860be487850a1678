"""What options cost: ``python benchmarks/option_cost.py --study obstacles``.

The whole environment step is timed with the options of a study in turns, on one thread: sensors
that the team shares or of each boat, or water with obstacles. Ratios of CPU times to the first one
are taken within a round, so that what else the machine does matters little; the table has medians.
"""

import os
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal

import numpy as np
import tyro
from subjects import SITUATIONS, vector_subject
from tqdm import tqdm

from asv_env.checks import check_whole
from asv_env.presets import NOISE
from baselines.reproduce.artefact import markdown
from baselines.rollout.commands import command, say

OWN = {**NOISE, "shared": False}
STUDIES: dict[str, dict[str, dict[str, Any]]] = {
    "sensors": {
        "shared": {"sensors": NOISE},
        "own": {"sensors": OWN},
        "own, range 1 m, delay, dropout": {
            "sensors": {**OWN, "range": 1.0, "delay": 0.2, "dropout": 0.1}
        },
        "exact": {},
    },
    "obstacles": {
        "open water": {},
        "16 pillars": {"obstacles": {"name": "pillars", "count": 16, "spread": 3.0, "gap": 0.2}},
        "dock": {"obstacles": "dock"},
        "channel": {"obstacles": "channel"},
    },
}
"""Options by name, in studies; others are compared with the first ones."""


@dataclass(frozen=True)
class Options:
    """Times a step with each of some options."""

    study: Literal["sensors", "obstacles"] = "sensors"  #: which options
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
    """Prints the CPU time of a step, µs, and its ratio to that with the first options."""
    load, rows, choices = os.getloadavg()[0], [], STUDIES[options.study]
    first = next(iter(choices))
    for situation, base in SITUATIONS.items():
        subjects = {
            name: vector_subject(replace(base, others=others), options.worlds, 1)
            for name, others in choices.items()
        }
        taken: dict[str, list[float]] = {name: [] for name in choices}
        for _ in tqdm(range(options.rounds), desc=situation):
            for name, subject in subjects.items():
                taken[name].append(seconds(subject.step, options.steps))
        for name, times in taken.items():
            ratio = np.median(np.divide(times, taken[first]))
            step = 1e6 * np.median(times) / options.steps
            row = {"situation": situation, options.study: name}
            rows.append({**row, "µs a step": f"{step:.0f}", f"over {first}": f"{ratio:.2f}"})
    loads = f"load average {load:.1f} at the start, {os.getloadavg()[0]:.1f} at the end"
    say(markdown({"rows": rows, "notes": [f"{options.worlds} worlds, one thread, {loads}."]}))


main = command(study, "python benchmarks/option_cost.py")

if __name__ == "__main__":
    main()
