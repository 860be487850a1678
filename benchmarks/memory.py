"""Memory of the environment over ten million world-steps: ``python benchmarks/memory.py``.

It exits with 1 if the resident set grows by more than ``LIMIT`` after the first quarter.
"""

import math
import resource
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import pandas as pd
import tyro
from subjects import SITUATIONS, vector_subject
from tqdm import trange

from asv_env.checks import check_whole
from baselines.rollout.commands import command

LIMIT = 4.0  #: growth of the resident set that still counts as none, MiB


@dataclass(frozen=True)
class Options:
    """Watches the resident set over many steps of both situations."""

    worlds: int = 1024  #: number of worlds
    threads: int = 2  #: number of threads
    steps: int = 10_000_000  #: number of world-steps in each situation

    def __post_init__(self) -> None:
        check_whole(self, "worlds", 1, 10**6)
        check_whole(self, "steps threads", 1)


def measure(name: str, options: Options) -> dict[str, Any]:
    """Returns the resident set at the start and after each quarter, MiB; and its growth."""
    subject = vector_subject(SITUATIONS[name], options.worlds, options.threads)
    quarter = math.ceil(options.steps / options.worlds / 4)
    resident = [resident_mib()]
    for step in trange(1, 4 * quarter + 1, desc=name, unit="step"):
        subject.step()
        if step % quarter == 0:
            resident.append(resident_mib())
    row = {"situation": name, "world-steps": 4 * quarter * options.worlds}
    row |= dict(zip(("start", "1/4", "1/2", "3/4", "end"), resident, strict=True))
    return row | {"growth": max(resident[2:]) - resident[1]}


def resident_mib() -> float:
    """Returns the resident set of this process, MiB; without /proc, the largest so far."""
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[1])
    except OSError:
        unit = 1 if sys.platform == "darwin" else 1024
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 2**20
    return pages * resource.getpagesize() / 2**20


def watch(options: Annotated[Options, tyro.conf.arg(name="")]) -> None:
    """Watch the resident set over many steps of both situations; fails if memory grows."""
    rows = pd.DataFrame([measure(name, options) for name in SITUATIONS])
    print(rows.to_string(index=False, float_format="{:.1f}".format))
    if (rows["growth"] > LIMIT).any():
        sys.exit(f"Memory grew by more than {LIMIT} MiB.")


main = command(watch, "python benchmarks/memory.py")

if __name__ == "__main__":
    main()
