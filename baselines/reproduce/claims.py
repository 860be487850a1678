"""Claims of the paper that a simulation can test."""

from collections.abc import Callable
from typing import Any

import numpy as np

from asv_env.geometry import wrap
from asv_env.params import EnvParams
from asv_env.tasks import formation, starts
from asv_env.types import Float
from baselines.paper import pushing
from baselines.paper.arcs import advance
from baselines.policy import POLICIES
from baselines.reproduce import reattribution
from baselines.reproduce.artefact import Job
from baselines.reproduce.comparison_rows import Values, rows_of
from baselines.reproduce.paper_environments import before_closure, experiment, run, simulation
from baselines.reproduce.single_runs import noisy_paper
from baselines.rollout.episodes import PoseLog

ARC = np.pi / 2
"""Turn of the arcs about the pivot, rad."""
OBSERVED_TURN = 1.0
"""First part of that turn, over which the boat at the pivot is observed, rad."""
WIDER = 3.0
"""Radius of the wide arc, in radii of the narrow one."""
FAILURE_TIME = (0.1, 0.1)
"""Interval of the time at which a boat dies, s: the first control tick."""
STATEMENTS = {
    "equal mass": "The sum of the boats' weights equals the vessel's weight, which prevents early "
    "boats from turning the vessel (Sec. III-C). Ten boats with the noise of Fig. 6.",
    "re-attribution": "Targets are re-attributed to the nearest boats at each iteration to "
    "minimise path crossings and collisions (Sec. IV-A). Up to closure or the time limit.",
    "pivot": "In a turn of minimal radius the vessel moves the boat that serves as its pivot, and "
    "wider turns place it more precisely (Sec. III-B.2). A quarter turn, scenario mismatch; the "
    "pivot is the boat beyond the inner end, observed over the first radian.",
    "roles": "Redundancy in the boats performing each role brings robustness (Sec. I). From a "
    "formed closure to the paper's goal, scenario mismatch; the environment gives the slots of a "
    "smaller team to the boats that are left.",
}
"""Claims of the paper, and how each was tested."""


def study(job: Job) -> dict[str, list[Values]]:
    """Returns the values of each claim: one comparison or several."""
    return {
        "equal mass": [equal_mass(job)],
        "re-attribution": [reattribution.compare(job)],
        "pivot": [pivot(job)],
        "roles": [missing_roles(job, policy) for policy in ("paper", "scripted")],
    }


def table(job: Job, claims: dict[str, list[Values]]) -> dict[str, Any]:
    """Claims of the paper put to the test in simulation: with what each names, and without."""
    rows = [
        {"claim": claim, **row}
        for claim, comparisons in claims.items()
        for values in comparisons
        for row in rows_of(values)
    ]
    notes = [
        "All rows are simulation, policy `paper` unless another is named. Difference: to the first "
        "row of the same measure, over the same seeds, mean with its 95 % interval.",
        *(f"*{claim}*: {statement}" for claim, statement in STATEMENTS.items()),
    ]
    return {"rows": rows, "notes": notes}


def equal_mass(job: Job) -> Values:
    """Returns the turn before closure of a vessel as heavy as all boats together, or as one."""
    equal = simulation("approach")
    light = simulation("approach", vessel={"mass": equal.boat.mass})
    values = {}
    for condition, params in (("vessel = ten boats", equal), ("vessel = one boat", light)):
        logs = run(noisy_paper(job.seed), params, job.seeds(job.trials), condition)
        turns = [float(np.degrees(largest_turn(before_closure(log, params)))) for log in logs]
        values[condition] = {"largest turn before closure (deg)": turns}
    return values


def largest_turn(poses: Float) -> float:
    """Returns the largest turn, rad, of the vessel of a log (T, B, 3) from its first pose."""
    return float(np.abs(wrap(poses[:, 0, 2] - poses[0, 0, 2])).max())


def pivot(job: Job) -> Values:
    """Returns how far the boat at the pivot leaves its circle, in a narrow and in a wider turn."""
    narrow = float(formation.slots(experiment("push"), experiment("push").num_boats)[-1].real)
    values = {}
    for radius in (narrow, WIDER * narrow):
        goal = tuple(advance(np.zeros(3), 1 / radius, radius * ARC))
        params = experiment("push", scenario="mismatch", goal=goal)
        asked = float(pushing.normal_speeds(narrow, 1 / radius, 1.0))
        condition = f"radius {radius:.2f} m: Eq. (16) asks {asked:.2f} S of the boat"
        logs = run(POLICIES["paper"], params, job.seeds(job.episodes), condition)
        values[condition] = {
            "off its circle, largest (cm)": [100 * off_circle(t, radius, narrow) for t in logs],
            "smallest distance (cm)": [smallest_distance(t) for t in logs],
        }
    return values


def off_circle(log: PoseLog, radius: float, end: float) -> float:
    """Returns the largest distance, m, of the boat beyond the end from the circle of its slot.

    Args:
        log: of a vessel that starts at the origin, on an arc about (radius, 0).
        radius: of the arc, m.
        end: position of the slot along the vessel, m.
    """
    turned = np.unwrap(log.poses[:, 0, 2]) >= OBSERVED_TURN
    until = int(turned.argmax()) + 1 if turned.any() else len(turned)
    boats = log.poses[:until, 1:, :2]
    boat = int(np.argmax(boats[0, :, 0]))
    distance = np.hypot(*(boats[:, boat] - (radius, 0.0)).T)
    return float(np.abs(distance - abs(radius - end)).max())


def smallest_distance(log: PoseLog) -> float:
    """Returns the smallest distance of the vessel to its goal, cm."""
    assert log.episode.min_position_error is not None
    return 100 * log.episode.min_position_error


MEASURES: dict[str, Callable[[PoseLog], float]] = {
    "delivered": lambda log: float(log.episode.success),
    "smallest distance (cm)": smallest_distance,
}


def missing_roles(job: Job, policy: str) -> Values:
    """Returns pushes with all boats at work, and with one of each role dead from the start."""
    whole, broken = experiment("push", scenario="mismatch"), one_boat_dead()
    seeds = job.seeds(job.episodes)
    all_boats = run(POLICIES[policy], whole, seeds, f"{policy}, all boats")
    without = run(POLICIES[policy], broken, seeds, f"{policy}, one boat dead")
    values: dict[str, dict[str, list[float | None]]] = {
        f"{policy}, all boats": {
            name: [value(log) for log in all_boats] for name, value in MEASURES.items()
        }
    }
    dead = [role_of_dead(broken, seed) for seed in seeds]
    for role in ("inner", "end"):
        values[f"{policy}, one {role} boat dead"] = {
            name: [
                value(log) if role == found else None
                for log, found in zip(without, dead, strict=True)
            ]
            for name, value in MEASURES.items()
        }
    return values


def one_boat_dead() -> EnvParams:
    """Returns pushes in which one boat, drawn by the seed, is dead from the start."""
    variation = {"failures": 1, "failure_time": FAILURE_TIME}
    return experiment("push", scenario="mismatch", variation=variation)


def role_of_dead(params: EnvParams, seed: int) -> str:
    """Returns the role of the boat that dies in an episode of Push: "end" or "inner"."""
    initial = starts.sample(params, np.random.default_rng(seed))
    boat = int(np.argmax(initial.failure_tick))
    return "end" if abs(initial.motion[1 + boat, 0]) > params.vessel.length / 2 else "inner"
