"""What is to be compared, and how: everything checked before anything is run or replaced."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from baselines.evaluate.code_identity import fingerprint, identify, own_functions
from baselines.evaluate.conditions import Suite
from baselines.evaluate.named_policies import NamedPolicy, check_fit
from baselines.evaluate.report import document
from baselines.evaluate.store import NAME as STORE
from baselines.rollout import provenance

FILES = ("episodes.csv", "summary.json", *document.FILES)
"""Files that a comparison leaves in its folder."""
LIBRARIES = ("numpy", "scipy", "pymunk")
REPLAYS = 180
"""Replayed episodes of a report, without those that are added where policies fail."""
LEAST = {"workers": 0, "num_envs": 1, "replays": 0}


@dataclass(frozen=True)
class Request:
    """A comparison that can be run.

    Attributes:
        suite: conditions and seeds.
        policies: policies; the others are compared with the first.
        out: folder of the run.
        workers: number of processes; 0 runs everything in this one.
        num_envs: number of worlds side by side in a process.
        replays: number of first episodes of each condition that the report replays.
        record: whether trajectories are saved too.
        overwrite: whether what is in the way may be replaced.

    Raises:
        ValueError, TypeError: a number out of range, or a policy that does not fit the suite.
        FileExistsError: the folder holds files of something else.
    """

    suite: Suite
    policies: tuple[NamedPolicy, ...]
    out: Path
    workers: int
    num_envs: int
    replays: int
    record: bool = False
    overwrite: bool = False

    def __post_init__(self) -> None:
        for name, least in LEAST.items():
            check_least(name, getattr(self, name), least)
        check_fit(self.policies, self.suite)
        if self.out.exists() and not self.out.is_dir():
            raise FileExistsError(f"{self.out} is a file: choose another folder (out=...)")
        present = [name for name in FILES if (self.out / name).exists()]
        if present and not (self.out / STORE).exists() and not self.overwrite:
            raise FileExistsError(
                f"{self.out} holds {', '.join(present)} but no {STORE}: choose another "
                "folder (out=...), or replace them (overwrite=True)"
            )

    @cached_property
    def fingerprints(self) -> Mapping[str, list[str]]:
        """Fingerprints of the trainings of each policy, by name."""
        return {
            policy.name: [source.fingerprint() for source in policy.trainings]
            for policy in self.policies
        }

    @cached_property
    def provenance(self) -> Mapping[str, Any]:
        """Suite, code and libraries that made the episodes, by name."""
        records = [(c.params.definition, c.params.observation) for c in self.suite.conditions]
        own = {fingerprint(*identify(function)) for function in own_functions(records)}
        return {
            "suite": self.suite.name,
            "task": self.suite.task,
            "set of episodes": self.suite.digest(),
            "state of the code": provenance.code(),
            "set of libraries": provenance.versions(LIBRARIES),
            **({"definition of the task or the observation": sorted(own)} if own else {}),
        }


def check_least(name: str, value: int, least: int) -> None:
    """Refuses a number that is not whole or below the least that it may be."""
    if isinstance(value, bool) or not isinstance(value, int) or value < least:
        raise ValueError(f"{name}={value}: must be a whole number of at least {least}")


def cores() -> int:
    """Returns the number of processor cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
