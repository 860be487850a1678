"""Claims of the paper that a simulation can test."""

from collections.abc import Callable, Sequence
from functools import partial
from itertools import combinations
from typing import Any

import numpy as np

from asv_env.geometry import wrap
from asv_env.params import EnvParams
from asv_env.tasks import formation, starts
from asv_env.types import Bool, Complex, Float
from baselines.paper import pushing
from baselines.paper.arcs import advance
from baselines.paper.paper_policy import PaperPolicy
from baselines.paper.steering import nearest
from baselines.policy import POLICIES, MakePolicy
from baselines.reproduce.artefact import Job
from baselines.reproduce.comparison_rows import Column, Values, rows_of
from baselines.reproduce.paper_environments import before_closure, experiment, run, simulation
from baselines.reproduce.single_runs import noisy_paper
from baselines.rollout.episodes import PoseLog

ARC = np.pi / 2  #: turn of the arcs about the pivot, rad
OBSERVED_TURN = 1.0  #: first part of that turn, over which the boat at the pivot is observed, rad
WIDER = 3.0  #: radius of the wide arc, in radii of the narrow one
FAILURE_TIME = (0.1, 0.1)  #: interval of the time at which a boat dies, s: the first control tick
THIN = 5  #: only every so many poses of a log are searched for crossings
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
        "re-attribution": [reattribution(job)],
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
        headings = [before_closure(log, params)[:, 0, 2] for log in logs]
        turns = [float(np.degrees(np.abs(wrap(h - h[0])).max())) for h in headings]
        values[condition] = {"largest turn before closure (deg)": turns}
    return values


def kept(boat: Complex, slot: Complex, working: Bool, last: Complex) -> Complex:
    """Keeps the targets (W, A) of the first tick, which had the least total distance."""
    return np.where(np.isnan(last), nearest(boat, slot, working, last), last)


def by_number(boat: Complex, slot: Complex, working: Bool, last: Complex) -> Complex:
    """Assigns the i-th target along the hull to boat i, wherever it is."""
    return np.sort(slot, axis=-1)


ATTRIBUTIONS: dict[str, MakePolicy] = {
    "re-attributed at each tick": PaperPolicy,
    "kept, least total distance at the start": partial(PaperPolicy, assignment=kept),
    "kept, by the boats' numbers": partial(PaperPolicy, assignment=by_number),
}


def reattribution(job: Job) -> Values:
    """Returns crossings of paths and collisions on the approach, by how targets are attributed."""
    params, values = experiment("approach"), {}
    for condition, make_policy in ATTRIBUTIONS.items():
        logs = run(make_policy, params, job.seeds(job.episodes), condition)
        values[condition] = {
            "closure reached": [float(t.episode.time_to_closure is not None) for t in logs],
            "crossings of paths": [crossings(before_closure(t, params)[::THIN]) for t in logs],
            "collisions": [float(t.episode.collisions) for t in logs],
        }
    return values


def crossings(poses: Float) -> float:
    """Counts how often the paths of two boats of a log (T, B, 3) cross one another."""
    paths = poses[:, 1:, 0] + 1j * poses[:, 1:, 1]
    pairs = combinations(paths.T, 2)
    return float(sum(crossing_segments(first, second).sum() for first, second in pairs))


def crossing_segments(first: Complex, second: Complex) -> Bool:
    """Returns which segments (n - 1, m - 1) of two polylines (n,) and (m,) cross."""

    def separated(line: Complex, points: Complex) -> Bool:
        start, along = line[:-1, None], np.diff(line)[:, None]
        left = ((points - start) * along.conj()).imag > 0
        return left[:, :-1] != left[:, 1:]

    return separated(first, second) & separated(second, first).T


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

    The vessel of the log starts at the origin, on an arc about (radius, 0); the slot of the boat is
    at ``end`` along the vessel.
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
    roles = [role_of_dead(broken, seed) for seed in seeds]

    def measured(logs: Sequence[PoseLog], applies: Sequence[bool]) -> dict[str, Column]:
        pairs = list(zip(logs, applies, strict=True))
        return {n: [value(log) if a else None for log, a in pairs] for n, value in MEASURES.items()}

    return {
        f"{policy}, all boats": measured(all_boats, [True] * len(seeds)),
        f"{policy}, one inner boat dead": measured(without, [role == "inner" for role in roles]),
        f"{policy}, one end boat dead": measured(without, [role == "end" for role in roles]),
    }


def one_boat_dead() -> EnvParams:
    """Returns pushes in which one boat, drawn by the seed, is dead from the start."""
    variation = {"failures": 1, "failure_time": FAILURE_TIME}
    return experiment("push", scenario="mismatch", variation=variation)


def role_of_dead(params: EnvParams, seed: int) -> str:
    """Returns the role of the boat that dies in an episode of Push: "end" or "inner"."""
    initial = starts.sample(params, np.random.default_rng(seed))
    boat = int(np.argmax(initial.failure_tick))
    return "end" if abs(initial.motion[1 + boat, 0]) > params.vessel.length / 2 else "inner"
