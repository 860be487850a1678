"""Runs the episodes of a comparison that are not there yet, and collects all of them."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

from tqdm import tqdm

from baselines.evaluate import workers
from baselines.evaluate.conditions import Condition
from baselines.evaluate.named_policies import NamedPolicy
from baselines.evaluate.request import Request
from baselines.evaluate.results import Results
from baselines.evaluate.store import RunKey, Store
from baselines.evaluate.workers import Job
from baselines.rollout import files, trajectories
from baselines.rollout.episodes import Label


def run(request: Request, store: Store, progress: bool) -> None:
    """Runs the missing episodes and stores each as it ends.

    Args:
        request: what is compared.
        store: where episodes are and go.
        progress: whether a bar is shown.
    """
    jobs = [job for job in _jobs(request, store) if job.seeds]
    trainings = sum(len(policy.trainings) for policy in request.policies)
    total = len(request.suite.conditions) * request.suite.episodes * trainings
    done = total - sum(len(job.seeds) for job in jobs)
    with tqdm(
        total=total, initial=done, unit="episode", file=sys.stderr, disable=not progress
    ) as bar:
        for key, log in workers.run(jobs, request.workers):
            store.add(key, log)
            bar.set_description(f"{key.policy}, {key.condition}", refresh=False)
            bar.update()


def collect(request: Request, store: Store) -> Results:
    """Returns the rows of all episodes of a comparison."""
    rows = {
        (condition.name, policy.name): [
            list(store.rows(RunKey(condition.name, policy.name, number), request.suite.seeds))
            for number in range(len(policy.trainings))
        ]
        for condition in request.suite.conditions
        for policy in request.policies
    }
    return Results(request.suite, tuple(policy.name for policy in request.policies), rows)


def _jobs(request: Request, store: Store) -> Iterator[Job]:
    for condition in request.suite.conditions:
        for policy in request.policies:
            for number in range(len(policy.trainings)):
                yield _job(request, store, condition, policy, number)


def _job(
    request: Request, store: Store, condition: Condition, policy: NamedPolicy, number: int
) -> Job:
    """Returns the job of the missing episodes of one training in one condition."""
    seed = policy.training_seed(number)
    label = Label(policy.name, seed, condition.name, condition.scenario_name)
    record = None
    if request.record:
        record = trajectories.folder(request.out, condition.name, policy.name, seed)
    key = RunKey(condition.name, policy.name, number)
    done = _done(request, store, key, record)
    missing = [seed for seed in request.suite.seeds if seed not in done]
    return Job(
        key,
        condition.params,
        policy.trainings[number],
        request.fingerprints[policy.name][number],
        label,
        missing,
        request.num_envs,
        record,
    )


def _done(request: Request, store: Store, key: RunKey, record: Path | None) -> set[int]:
    """Returns the seeds of episodes that are stored, and recorded where that was asked for."""
    if record is None:
        return store.seeds(key)
    files.remove_parts(record)
    return {
        row.seed
        for row in store.rows(key, request.suite.seeds)
        if row.error or trajectories.holds(record, row)
    }
