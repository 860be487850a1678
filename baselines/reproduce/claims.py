"""Claims of the paper that a simulation can test."""

from __future__ import annotations

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
from baselines.reproduce.comparison_rows import row, rows_of
from baselines.reproduce.job import Job
from baselines.reproduce.paper_environments import before_closure, experiment, run, simulation
from baselines.reproduce.single_runs import noisy_paper
from baselines.rollout.episodes import PoseLog

ARC, WATCHED = np.pi / 2, 1.0
"""Turn of the arcs of the pivot, and the part of it on which the boat there is watched, rad."""
WIDER = 3.0
"""Radius of the wide arc, in radii of the narrow one."""
FAILS_AT = (0.1, 0.1)
"""Time at which the boat of a role dies, s: the first control tick."""
STATEMENTS = {
    "equal mass": "The sum of the boats' weights equals the vessel's weight, which prevents early "
    "boats from turning the vessel (Sec. III-C). Ten boats with the noise of Fig. 6.",
    "re-attribution": "Targets are re-attributed to the nearest boats at each iteration to "
    "minimise path crossings and collisions (Sec. IV-A). Up to closure or the time limit.",
    "pivot": "In a turn of minimal radius the vessel moves the boat that serves as its pivot, and "
    "wider turns place it more precisely (Sec. III-B.2). A quarter turn, scenario mismatch; the "
    "pivot is the boat beyond the inner end, watched over the first radian.",
    "roles": "Redundancy in the boats performing each role brings robustness (Sec. I). From a "
    "formed closure to the paper's goal, scenario mismatch; the environment gives the slots of a "
    "smaller team to the boats that are left.",
}
"""What the paper says, and how it was tested."""


def study(job: Job) -> dict[str, list[dict[str, Any]]]:
    """Rows of the table by claim."""
    return {
        "equal mass": equal_mass(job),
        "re-attribution": reattribution.compare(job),
        "pivot": pivot(job),
        "roles": missing_roles(job),
    }


def table(job: Job, claims: dict[str, list[dict[str, Any]]]) -> dict[str, Any]:
    """Claims of the paper put to the test in simulation: with what each names, and without."""
    notes = [
        "All rows are simulation, policy `paper` unless said otherwise. Difference: to the first "
        "row of the same measure, over the same seeds, mean with its 95 % bootstrap interval.",
        *(f"*{claim}*: {statement}" for claim, statement in STATEMENTS.items()),
    ]
    rows = [{"claim": claim, **row} for claim, rows in claims.items() for row in rows]
    return {"rows": rows, "notes": notes}


# ---------------------------------------------------------------- equal total mass


def equal_mass(job: Job) -> list[dict[str, Any]]:
    """Turn of the vessel before closure, as heavy as all boats together and as one of them."""
    equal = simulation("approach")
    light = simulation("approach", vessel={"mass": equal.boat.mass})
    values = {}
    for condition, params in (("vessel = ten boats", equal), ("vessel = one boat", light)):
        logs = run(noisy_paper(job.seed), params, job.seeds(job.trials), condition)
        turns = [np.degrees(largest_turn(before_closure(log, params))) for log in logs]
        values[condition] = {"largest turn before closure (deg)": turns}
    return rows_of(values)


def largest_turn(poses: Float) -> float:
    """Largest angle, rad, by which the vessel of a log (T, B, 3) is turned from its start."""
    return float(np.abs(wrap(poses[:, 0, 2] - poses[0, 0, 2])).max())


# ---------------------------------------------------------------- the pivot of a turn


def pivot(job: Job) -> list[dict[str, Any]]:
    """Where the inner end boat goes in a turn about its own slot, and in a wider one."""
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
            "smallest distance (cm)": [nearest(t) for t in logs],
        }
    return rows_of(values)


def off_circle(log: PoseLog, radius: float, end: float) -> float:
    """Largest distance, m, of the boat beyond the end from the circle that its slot describes.

    Args:
        log: from the origin, on an arc about (radius, 0); until it has turned by ``WATCHED``.
        radius: of the arc, m.
        end: position of the slot along the vessel, m.
    """
    turned = np.unwrap(log.poses[:, 0, 2]) >= WATCHED
    until = int(turned.argmax()) + 1 if turned.any() else len(turned)
    boats = log.poses[:until, 1:, :2]
    boat = int(np.argmax(boats[0, :, 0]))
    distance = np.hypot(*(boats[:, boat] - (radius, 0.0)).T)
    return float(np.abs(distance - abs(radius - end)).max())


def nearest(log: PoseLog) -> float:
    """Smallest distance of the vessel to its goal, cm."""
    assert log.episode.min_position_error is not None
    return 100 * log.episode.min_position_error


# ---------------------------------------------------------------- a boat of each role missing


def missing_roles(job: Job) -> list[dict[str, Any]]:
    """Pushes with all boats at work, or one of each role dead from the start."""
    whole = experiment("push", scenario="mismatch")
    broken = broken_world()
    seeds = job.seeds(job.episodes)
    dead = [role_of_dead(broken, seed) for seed in seeds]
    rows = []
    for policy in ("paper", "scripted"):
        with_all = run(POLICIES[policy], whole, seeds, f"{policy}, all boats")
        with_less = run(POLICIES[policy], broken, seeds, f"{policy}, one boat dead")
        for measure, value in (
            ("delivered", lambda log: float(log.episode.success)),
            ("smallest distance (cm)", nearest),
        ):
            rows.append(row(f"{policy}, all boats", measure, [value(t) for t in with_all], None))
            for role in ("inner", "end"):
                index = [k for k, found in enumerate(dead) if found == role]
                values = [value(with_less[k]) for k in index]
                first = [value(with_all[k]) for k in index]
                rows.append(row(f"{policy}, one {role} boat dead", measure, values, first))
    return rows


def broken_world() -> EnvParams:
    """Pushes in which one boat, drawn by the seed, is dead from the start."""
    return experiment(
        "push", scenario="mismatch", variation={"failures": 1, "failure_time": FAILS_AT}
    )


def role_of_dead(params: EnvParams, seed: int) -> str:
    """Role of the boat that dies in an episode of Push: "end" or "inner"."""
    start = starts.sample(params, np.random.default_rng(seed))
    boat = int(np.argmax(start.failure_tick))
    return "end" if abs(start.motion[1 + boat, 0]) > params.vessel.length / 2 else "inner"
