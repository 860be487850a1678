"""How exact contacts are: ``python benchmarks/convergence.py``.

Three situations are computed with several time steps and numbers of iterations of the contact
solver, and compared with the finest: an eighth of the nominal step, and 100 iterations. Each is
computed for 32 beginnings that differ by millimetres, so that no error is small by chance.

- *push*: two boats push obliquely with unequal motors for 5 s; the largest error of the vessel's
  position as a share of its path, and that of the mean contact forces as a share of the thrust.
- *ram*: a boat rams the middle of the vessel at 0.2 m/s, both free of drag; the largest spin
  that vessel or boat has 1 s later, which should have none.
- *slide*: a boat at full thrust slides along the side from 0.1 m/s; the largest error of its
  position after 1.5 s, mm.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any
from unittest import mock

import numpy as np
import tyro
from tqdm import tqdm

from asv_env import Simulation, make_params
from asv_env.params import EnvParams
from asv_env.physics import basin
from asv_env.tasks import starts
from asv_env.types import Float
from baselines.evaluate.publish import marks
from baselines.rollout.commands import FilePath, command, say

RATES = (50, 100, 200)  #: of the physics, Hz
FINEST = (400, 100)  #: rate and iterations of the reference
BEGINNINGS = 32  #: number of beginnings of each situation
DOWN = -np.pi / 2  #: heading of a boat that pushes the vessel from its +n side
TOUCH = 0.135  #: distance of the boat's middle from that of the vessel when its bow touches, m
FREE: dict[str, Any] = dict.fromkeys(("surge", "sway", "yaw"), (0.0, 0.0))
START, END = "<!-- convergence -->", "<!-- end of convergence -->"


@dataclass(frozen=True)
class Options:
    """Prints the errors of contacts by time step and iterations of the solver."""

    iterations: tuple[int, ...] = (5, 10, 20, 30, 40, 100)  #: of the contact solver in a step
    page: FilePath | None = None  #: page whose table is replaced, such as docs/physics.md


def params_at(rate: int, **options: Any) -> EnvParams:
    """Returns open water with two boats, their motors driven directly, at a rate, Hz."""
    clock = {"physics": rate, "sensing": 10, "control": 10}
    limits: dict[str, Any] = {"arena": 100.0, "goal": (90.0, 90.0, 0.0), "time_limit": 1e5}
    return make_params("push", 2, action_mode="thrusters", clock=clock, **limits, **options)


def run(
    params: EnvParams, motions: Float, action: Any, seconds: float
) -> Iterator[tuple[Float, Float]]:
    """Yields motions (N, B, 6) and contact forces (N, A) of worlds that begin with motions."""
    waiting = iter(motions)

    def begin(params: EnvParams, rng: np.random.Generator, goal: Float | None) -> Any:
        return replace(starts.in_slots(params, rng, goal), motion=next(waiting))

    simulation = Simulation(params, len(motions), initial_states=begin)
    simulation.reset(seeds=list(range(len(motions))))
    given = np.broadcast_to(np.asarray(action, dtype=np.float32), (len(motions), 2, 2))
    for _ in range(round(seconds * params.clock.control)):
        simulation.step(given)
        yield simulation.state.motion.copy(), simulation.state.contact_force.copy()


def beginnings(first: Any, second: Any, spread: Any) -> Float:
    """Returns motions (N, 3, 6) with the boats' (6,), varied by up to ``spread`` (6,)."""
    rng = np.random.default_rng(0)
    motions = np.zeros((BEGINNINGS, 3, 6))
    for row, boat in ((1, first), (2, second)):
        motions[:, row] = boat + rng.uniform(-1, 1, (BEGINNINGS, 6)) * spread
    return motions


def push(rate: int) -> Float:
    """Returns the vessel's path (N, T, 2), m, and the boats' mean contact forces (N, 2), N."""
    boats = (-0.08, TOUCH, DOWN, 0, 0, 0), (0.08, TOUCH, DOWN, 0, 0, 0)
    motions = beginnings(*boats, (0.005, 0, 0, 0, 0, 0))
    steps = list(run(params_at(rate), motions, ((0.9, 0.8), (0.6, 0.7)), 5.0))
    path = np.stack([motion[:, 0, :2] for motion, _ in steps], axis=1)
    force = np.mean([force for _, force in steps[10:]], axis=0)
    return np.concatenate([path.reshape(BEGINNINGS, -1), force], axis=1)


def ram(rate: int) -> Float:
    """Returns the spin (N, 2) of vessel and boat after a centred ram, rad/s."""
    params = params_at(rate, boat=FREE, vessel={**FREE, "fins": 0.0})
    boats = (0, 0.2, DOWN, 0, -0.2, 0), (-9, 0, 0, 0, 0, 0)
    motions = beginnings(*boats, (0, 0.01, 0, 0, 0, 0))
    *_, (motion, _) = run(params, motions, 0.0, 1.5)
    return motion[:, :2, 5]


def slide(rate: int) -> Float:
    """Returns where (N, 2) a boat is that slid along the side, m."""
    boats = (-0.12, TOUCH, DOWN, 0.1, 0, 0), (-9, 0, 0, 0, 0, 0)
    motions = beginnings(*boats, (0.005, 0, 0, 0.01, 0, 0))
    *_, (motion, _) = run(params_at(rate), motions, ((1, 1), (0, 0)), 1.5)
    return motion[:, 1, :2] - motion[:, 0, :2]


def errors(rate: int, iterations: int, reference: dict[str, Float]) -> tuple[float, ...]:
    """Returns the errors of a time step and number of iterations: a row of the table."""
    found = {name: result(case, rate, iterations) for name, case in CASES.items()}
    difference = np.abs(found["push"] - reference["push"])
    path = reference["push"][:, :-2].reshape(BEGINNINGS, -1, 2)
    way = np.hypot(*np.diff(path, axis=1).T).sum(axis=0)
    off = np.hypot(*difference[:, :-2].reshape(BEGINNINGS, -1, 2).T).max(axis=0)
    thrust = 2 * make_params().boat.thrust
    return (
        100 * float((off / way).max()),
        100 * float(difference[:, -2:].max() / thrust),
        float(np.abs(found["ram"]).max()),
        1e3 * float(np.hypot(*(found["slide"] - reference["slide"]).T).max()),
    )


CASES: dict[str, Callable[[int], Float]] = {"push": push, "ram": ram, "slide": slide}


def result(case: Callable[[int], Float], rate: int, iterations: int) -> Float:
    """Returns the outcome of a situation with a rate, Hz, and iterations of the solver."""
    with mock.patch.object(basin, "ITERATIONS", iterations):
        return case(rate)


def table(options: Options) -> str:
    """Returns the table of errors in Markdown."""
    reference = {name: result(case, *FINEST) for name, case in CASES.items()}
    lines = [
        "| physics (Hz) | iterations | push: path (%) | push: force (%) | ram: spin (rad/s) "
        "| slide (mm) |",
        "|---|---|---|---|---|---|",
    ]
    rows = [(rate, count) for rate in RATES for count in options.iterations]
    for rate, count in tqdm(rows, leave=False, unit="row"):
        numbers = " | ".join(f"{error:.2g}" for error in errors(rate, count, reference))
        lines.append(f"| {rate} | {count} | {numbers} |")
    return "\n".join(lines)


def study(options: Annotated[Options, tyro.conf.arg(name="")]) -> None:
    """Print how the errors of contacts fall with the time step and the solver's iterations."""
    page = options.page
    text = None if page is None else marks.read(page)
    if text is not None:
        marks.check(text, START, END)
    found = table(options)
    say(found)
    if page is not None and text is not None:
        Path(page).write_text(marks.replaced(text, START, END, found), encoding="utf-8")


main = command(study, "python benchmarks/convergence.py")

if __name__ == "__main__":
    main()
