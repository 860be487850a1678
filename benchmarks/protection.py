"""Cost of handing out read-only records and copies: ``python benchmarks/protection.py``.

A policy that does nothing runs in the loop of all rollouts, with the protection and without it, by
turns, a short measurement each. A ratio is taken within a turn, between neighbours in time.
"""

import time
from contextlib import ExitStack
from dataclasses import dataclass
from unittest import mock

import numpy as np
import tyro
from tqdm import tqdm

from asv_env import Simulation, make_params
from asv_env.checks import check_whole
from baselines.policy import Idle
from baselines.rollout.loop import rollout

WITHOUT = {
    "asv_env.simulation.frozen": lambda record: record,
    "asv_env.simulation.Simulation.sensed": property(Simulation._sensed),
    "baselines.rollout.loop.own": lambda array: array,
}  #: what stands in place of the protection


@dataclass(frozen=True)
class Options:
    """Times a step of a rollout with and without the protection of what is handed out."""

    worlds: tuple[int, ...] = (1, 64)  #: numbers of worlds
    steps: int = 200  #: steps of a measurement
    rounds: int = 41  #: number of measurements of each

    def __post_init__(self) -> None:
        check_whole(self, "steps rounds", 1)


def measure(worlds: int, steps: int) -> float:
    """Returns the CPU time of a step of a rollout, s, episodes of noisy Push worlds."""
    params = make_params("push", scenario="noisy")
    simulation, policy = Simulation(params, worlds), Idle(params)
    ticks = rollout(simulation, policy.act, range(worlds), steps + 1)
    next(ticks)
    start = time.process_time()
    for _ in ticks:
        pass
    return (time.process_time() - start) / steps


def main(options: Options) -> None:
    """Prints the median cost of the protection and its quartiles."""
    for worlds in options.worlds:
        ratios, times = [], []
        for _ in tqdm(range(options.rounds), unit="round", leave=False):
            times.append(measure(worlds, options.steps))
            with ExitStack() as unprotected:
                for name, stand_in in WITHOUT.items():
                    unprotected.enter_context(mock.patch(name, stand_in))
                ratios.append(times[-1] / measure(worlds, options.steps) - 1.0)
        low, middle, high = np.quantile(ratios, [0.25, 0.5, 0.75])
        spent = 1e6 * np.median(times)
        print(
            f"{worlds} worlds: {middle:+.1%} ({low:+.1%} to {high:+.1%}) of {spent:.0f} us a step"
        )


if __name__ == "__main__":
    main(tyro.cli(Options))
