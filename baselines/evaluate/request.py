"""What is to be compared: checked before anything is replaced, then run episode by episode."""

import os
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from numbers import Integral
from pathlib import Path
from typing import Any

from tqdm import tqdm

from asv_env import files
from asv_env.text import shown
from baselines.evaluate import workers
from baselines.evaluate.conditions import Condition, Suite
from baselines.evaluate.fingerprints import fingerprint, identify, own_functions
from baselines.evaluate.policy_sources import PolicySource
from baselines.evaluate.report import document
from baselines.evaluate.results import Results
from baselines.evaluate.store import NAME as STORE
from baselines.evaluate.store import RunKey, Store
from baselines.evaluate.workers import Job
from baselines.rollout import provenance, trajectories
from baselines.rollout.episodes import Label

FILES = ("episodes.csv", "summary.json", *document.FILES)  #: what a comparison leaves in its folder
LIBRARIES = ("numpy", "scipy", "pymunk")
REPLAYS = 180  #: replayed episodes of a report, without those that are added where policies fail
MOST_EPISODES = 1_000_000  #: largest number of episodes of a condition
LIMITS = {"workers": (0, 1024), "num_envs": (1, MOST_EPISODES), "replays": (0, MOST_EPISODES)}
"""Least and largest values of arguments."""


@dataclass(frozen=True)
class Request:
    """A comparison that can be run; the attributes are those arguments of ``compare``.

    Raises:
        ValueError, TypeError: a number out of range, or a policy that does not fit the suite.
        FileExistsError: the folder holds files of something else.
    """

    suite: Suite
    policies: Mapping[str, tuple[PolicySource, ...]]
    out: Path
    workers: int
    num_envs: int
    replays: int
    record: bool = False
    overwrite: bool = False

    def __post_init__(self) -> None:
        for name, limits in LIMITS.items():
            check_whole(name, getattr(self, name), *limits)
        check_whole("episodes", self.suite.episodes, 1, MOST_EPISODES)
        if os.path.lexists(self.out) and not os.path.isdir(self.out):
            raise FileExistsError(f"{self.out} is no folder: choose another one (out=...)")
        workers.check_fit(self.policies, self.suite, self.workers)
        present = [name for name in FILES if os.path.exists(self.out / name)]
        if present and not os.path.exists(self.out / STORE) and not self.overwrite:
            raise FileExistsError(
                f"{self.out} holds {', '.join(present)} but no {STORE}: choose another "
                "folder (out=...), or replace them (overwrite=True)"
            )

    @cached_property
    def fingerprints(self) -> Mapping[str, list[str]]:
        """Fingerprints of the trainings of each policy, by name."""
        return {name: [each.fingerprint() for each in of] for name, of in self.policies.items()}

    @cached_property
    def provenance(self) -> Mapping[str, Any]:
        """Suite, code and libraries that made the episodes, by name."""
        every = [condition.params for condition in self.suite.conditions]
        records = [(each.definition, each.observation, each.obstacles) for each in every]
        own = {fingerprint(*identify(function)) for function in own_functions(records)}
        return {
            "suite": self.suite.name,
            "task": self.suite.task,
            "set of episodes": self.suite.digest(),
            "state of the code": provenance.code(),
            "set of libraries": provenance.versions(LIBRARIES),
            **(
                {"definition of the task, the observation or the obstacles": sorted(own)}
                if own
                else {}
            ),
        }

    def runs(self) -> Iterator[tuple[RunKey, Condition]]:
        """Yields every training of every policy in every condition."""
        for condition in self.suite.conditions:
            for policy, trainings in self.policies.items():
                for number in range(len(trainings)):
                    yield RunKey(condition.name, policy, number), condition


def check_whole(name: str, value: Any, least: int, most: int) -> None:
    """Refuses what is not a whole number between two others."""
    whole = isinstance(value, Integral) and not isinstance(value, bool)
    if not whole or not least <= value <= most:
        reach = f"at least {least}" if whole and value < least else f"{least} to {most}"
        raise ValueError(f"{name}={shown(value)}: must be a whole number, {reach}")


def run(request: Request, store: Store, progress: bool) -> None:
    """Runs the missing episodes, stores each as it ends, and shows a bar if ``progress``."""
    jobs = [_job(request, store, *each) for each in request.runs()]
    total = len(jobs) * request.suite.episodes
    done = total - sum(len(job.seeds) for job in jobs)
    shown: dict[str, Any] = {"unit": "episode", "disable": not progress or sys.stderr is None}
    with tqdm(total=total, initial=done, **shown) as bar:
        for key, log in workers.run([job for job in jobs if job.seeds], request.workers):
            store.add(key, log)
            bar.set_description(f"{key.policy}, {key.condition}", refresh=False)
            bar.update()


def collect(request: Request, store: Store) -> Results:
    """Returns the rows of all episodes of a comparison."""
    rows: dict[tuple[str, str], list[Any]] = {}
    for key, _ in request.runs():
        training = list(store.rows(key, request.suite.seeds))
        rows.setdefault((key.condition, key.policy), []).append(training)
    return Results(request.suite, tuple(request.policies), rows)


def _job(request: Request, store: Store, key: RunKey, condition: Condition) -> Job:
    """Returns the job of the episodes of a run that are not stored, or not recorded as asked."""
    trainings = request.policies[key.policy]
    seed = key.training if len(trainings) > 1 else None
    folder = trajectories.folder(request.out, key.condition, key.policy, seed)
    record = folder if request.record else None
    seeds = request.suite.seeds
    if record is None:
        done = store.seeds(key)
    else:
        files.remove_parts(record)
        rows = store.rows(key, seeds)
        done = {row.seed for row in rows if row.error or trajectories.holds(record, row)}
    return Job(
        key,
        condition.params,
        trainings[key.training],
        request.fingerprints[key.policy][key.training],
        Label(key.policy, seed, key.condition, condition.scenario_name),
        [each for each in seeds if each not in done],
        request.num_envs,
        record,
    )
