"""What the re-attribution of targets is good for: fewer crossing paths, fewer collisions."""

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
from baselines.reproduce.artefact import Job
from baselines.reproduce.comparison_rows import Values
from baselines.reproduce.paper_environments import before_closure, experiment, run

THIN = 5
"""Only every so many poses of a log are searched for crossings."""


def kept(boat: Complex, slot: Complex, working: Bool, last: Complex) -> Complex:
    """Keeps the targets (W, A) of the first tick, which had the least total distance."""
    return np.where(np.isnan(last), nearest(boat, slot, working, last), last)


def numbered(points: Complex, boat: Complex, *_: Any) -> Complex:
    """Assigns target i of ``points`` (A,) to boat i, wherever it is."""
    return np.broadcast_to(points, boat.shape)


def by_number(params: EnvParams) -> PaperPolicy:
    """Returns the paper's policy whose boats go to the targets of their numbers."""
    points = formation.slots(params, params.num_boats)
    return PaperPolicy(params, assignment=partial(numbered, points))


ATTRIBUTIONS: dict[str, MakePolicy] = {
    "re-attributed at each tick": PaperPolicy,
    "kept, least total distance at the start": partial(PaperPolicy, assignment=kept),
    "kept, by the boats' numbers": by_number,
}


def compare(job: Job) -> Values:
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
