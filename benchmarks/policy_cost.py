"""What a scripted policy costs beside the worlds it acts in: ``python benchmarks/policy_cost.py``.

Policies run whole episodes, in which worlds that have ended begin again. The CPU time of their
decisions is compared with that of stepping and resetting the worlds, on one thread.
"""

import os
import time
from dataclasses import dataclass
from typing import Annotated, Any

import tyro
from tqdm import tqdm

from asv_env import make_params
from asv_env.checks import check_whole
from asv_env.simulation import Simulation
from baselines.distributed import distributed
from baselines.policy import POLICIES
from baselines.reproduce.artefact import markdown
from baselines.rollout import seeds
from baselines.rollout.commands import command, say
from baselines.rollout.loop import rollout

WATERS: dict[str, dict[str, Any]] = {
    "open water": {},
    "noisy": {"scenario": "noisy"},
    "current of 2 cm/s": {"water": {"current": "uniform", "current_speed": 0.02}},
    "pillars": {"obstacles": "pillars"},
    "channel": {"obstacles": "channel"},
    "dock": {"obstacles": "dock"},
}
"""Options of Transport by name."""


@dataclass(frozen=True)
class Options:
    """Prints the CPU time of decisions over that of stepping the worlds."""

    policies: tuple[str, ...] = ("scripted", "allocation")  #: registered names
    worlds: int = 256  #: number of worlds
    ticks: int = 1200  #: control ticks that are timed

    def __post_init__(self) -> None:
        check_whole(self, "worlds ticks", 1, 10**6)
        for name in self.policies:
            POLICIES.find(name)


def cost(name: str, options: Options, water: dict[str, Any]) -> tuple[float, float]:
    """Returns the CPU time of a tick's decisions and of the rest of a tick, µs a world."""
    params = make_params("transport", **water)
    policy = distributed(POLICIES.find(name)(params), params)
    spent = 0.0

    def act(*given: Any) -> Any:
        nonlocal spent
        begun = time.process_time()
        try:
            return policy.act(*given)
        finally:
            spent += time.process_time() - begun

    simulation = Simulation(params, options.worlds, num_threads=1)
    first = range(seeds.DEVELOPMENT.start, seeds.DEVELOPMENT.start + options.worlds)
    ticks = rollout(simulation, act, first, options.ticks + 1)
    next(ticks)  # compiles what has to be
    spent, begun = 0.0, time.process_time()
    for _ in ticks:
        pass
    whole = time.process_time() - begun
    share = 1e6 / (options.ticks * options.worlds)
    return spent * share, (whole - spent) * share


def study(options: Annotated[Options, tyro.conf.arg(name="")]) -> None:
    """Prints the table of costs."""
    load, rows = os.getloadavg()[0], []
    pairs = [(name, water) for name in options.policies for water in WATERS]
    for name, water in tqdm(pairs):
        decisions, rest = cost(name, options, WATERS[water])
        timed = {"decisions, µs": f"{decisions:.0f}", "stepping, µs": f"{rest:.0f}"}
        rows.append({"policy": name, "water": water, **timed, "ratio": f"{decisions / rest:.2f}"})
    loads = f"load average {load:.1f} at the start, {os.getloadavg()[0]:.1f} at the end"
    notes = [f"A world and a tick; {options.worlds} worlds, {options.ticks} ticks, {loads}."]
    say(markdown({"rows": rows, "notes": notes}))


main = command(study, "python benchmarks/policy_cost.py")

if __name__ == "__main__":
    main()
