"""Cost of handing out read-only records and copies: ``python benchmarks/protection.py``.

A policy that does nothing runs in the loop of all rollouts, with the protection and without it, by
turns, a short measurement each. A ratio is taken within a turn, between neighbours in time.
"""

import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Annotated
from unittest import mock

import numpy as np
import tyro
from tqdm import tqdm

import asv_env.simulation
from asv_env import Sensed, Simulation, make_params
from asv_env.checks import check_whole
from baselines.policy import Idle
from baselines.rollout.commands import command
from baselines.rollout.loop import rollout


@dataclass(frozen=True)
class Options:
    """Times a step of a rollout with and without the protection of what is handed out."""

    worlds: tuple[int, ...] = (1, 64)  #: numbers of worlds
    steps: int = 200  #: steps of a measurement
    rounds: int = 41  #: number of measurements of each

    def __post_init__(self) -> None:
        check_whole(self, "steps rounds", 1, 10**6)


def measure(simulation: Simulation, steps: int) -> float:
    """Returns the CPU time of a step in the loop of all rollouts, s."""
    ticks = rollout(simulation, Idle(simulation.params).act, range(simulation.num_worlds), steps)
    next(ticks)
    start = time.process_time()
    for _ in ticks:
        pass
    return (time.process_time() - start) / (steps - 1)


@contextmanager
def unprotected() -> Iterator[None]:
    """Hands out the simulation's own arrays, and lets everybody write to them."""
    with ExitStack() as patches:
        for target, name, stand_in in (
            (asv_env.simulation, "frozen", lambda record: record),
            (Simulation, "sensed", property(lambda worlds: Sensed(**worlds._known()))),
            (np, "copy", lambda array: array),
        ):
            patches.enter_context(mock.patch.object(target, name, stand_in))
        yield


def compare(options: Annotated[Options, tyro.conf.arg(name="")]) -> None:
    """Print the median cost of the protection and its quartiles."""
    params = make_params("push", scenario="noisy", goal=(0.0, -2.5, 0.0))
    for worlds in options.worlds:
        ratios, times = [], []
        for _ in tqdm(range(options.rounds), unit="round", leave=False):
            times.append(measure(Simulation(params, worlds), options.steps))
            with unprotected():
                plain = measure(Simulation(params, worlds), options.steps)
            ratios.append(times[-1] / plain - 1.0)
        low, middle, high = np.quantile(ratios, [0.25, 0.5, 0.75])
        spent = 1e6 * np.median(times)
        print(
            f"{worlds} worlds: {middle:+.1%} ({low:+.1%} to {high:+.1%}) of {spent:.0f} us a step"
        )


main = command(compare, "python benchmarks/protection.py")

if __name__ == "__main__":
    main()
