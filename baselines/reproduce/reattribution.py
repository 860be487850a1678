"""What the re-attribution of targets is good for: ways that cross, and collisions."""

from __future__ import annotations

from functools import partial
from itertools import combinations
from typing import Any

import numpy as np

from asv_env.params import EnvParams
from asv_env.tasks import formation
from asv_env.types import Bool, Complex, Float
from baselines.paper.paper_policy import PaperPolicy
from baselines.paper.target_assignment import nearest
from baselines.policy import MakePolicy
from baselines.reproduce.comparison_rows import rows_of
from baselines.reproduce.job import Job
from baselines.reproduce.paper_environments import before_closure, experiment, run

THIN = 5
"""Of a log's poses, one in so many is kept to look for crossings."""


def kept(boat: Complex, slot: Complex, working: Bool, before: Complex) -> Complex:
    """Boats keep the targets (W, A) of the first tick, which had the least total distance."""
    return np.where(np.isnan(before), nearest(boat, slot, working, before), before)


def numbered(points: Complex, boat: Complex, *_: Any) -> Complex:
    """Boat i gets target i of ``points`` (A,), wherever it is."""
    return np.broadcast_to(points, boat.shape)


def by_number(params: EnvParams) -> PaperPolicy:
    """The paper's policy whose boats go to the targets of their numbers."""
    points = formation.slots(params, params.num_boats)
    return PaperPolicy(params, assignment=partial(numbered, points))


ATTRIBUTIONS: dict[str, MakePolicy] = {
    "re-attributed at each tick": PaperPolicy,
    "kept, least total distance at the start": partial(PaperPolicy, assignment=kept),
    "kept, by the boats' numbers": by_number,
}


def compare(job: Job) -> list[dict[str, Any]]:
    """Crossings of ways and collisions on the approach, by how targets are attributed."""
    params, values = experiment("approach"), {}
    for condition, make_policy in ATTRIBUTIONS.items():
        logs = run(make_policy, params, job.seeds(job.episodes), condition)
        values[condition] = {
            "closure reached": [float(t.episode.time_to_closure is not None) for t in logs],
            "crossings of ways": [crossings(before_closure(t, params)[::THIN]) for t in logs],
            "collisions": [float(t.episode.collisions) for t in logs],
        }
    return rows_of(values)


def crossings(poses: Float) -> float:
    """How often the ways of two boats of a log (T, B, 3) cross one another."""
    ways = poses[:, 1:, 0] + 1j * poses[:, 1:, 1]
    return sum(
        float(meet(ways[:, one], ways[:, other]).sum())
        for one, other in combinations(range(ways.shape[1]), 2)
    )


def meet(one: Complex, other: Complex) -> Bool:
    """Which segments (n - 1, m - 1) of two polylines (n,) and (m,) cross."""

    def sides(line: Complex, points: Complex) -> Bool:
        start, along = line[:-1, None], np.diff(line)[:, None]
        left = ((points - start) * along.conj()).imag > 0
        return left[:, :-1] != left[:, 1:]

    return sides(one, other) & sides(other, one).T
