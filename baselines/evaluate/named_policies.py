"""The policies of a comparison: their names, their trainings, and whether they fit the suite."""

from __future__ import annotations

import inspect
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import numpy as np

from asv_env.params import EnvParams
from asv_env.simulation import Simulation
from baselines.evaluate import policy_sources
from baselines.evaluate.conditions import Suite
from baselines.evaluate.policy_sources import PolicySource
from baselines.policy import POLICIES, MakePolicy, checked_action

NAME = re.compile(r"[A-Za-z0-9][\w.+-]*")
"""Pattern of the names of policies, which also name folders."""
PolicyLike = str | Path | MakePolicy | Sequence[str | Path | MakePolicy]
"""A policy as ``policy_sources.find`` takes it, or several trainings of one."""


@dataclass(frozen=True)
class NamedPolicy:
    """A policy that is compared.

    Attributes:
        name: in tables; it also names a folder.
        trainings: one source for each of its trainings, one alone for a scripted policy.
    """

    name: str
    trainings: tuple[PolicySource, ...]

    def training_seed(self, number: int) -> int | None:
        """Returns the number of a training, as in rows; None where there is only one."""
        return number if len(self.trainings) > 1 else None


def named(policies: Mapping[str, PolicyLike], trust_pickles: bool) -> tuple[NamedPolicy, ...]:
    """Returns the policies of a comparison, found but not yet made.

    Raises:
        ValueError, FileNotFoundError, ImportError, TypeError: as ``policy_sources.find``; or a
            name that cannot be one, or trainings that are no trainings.
    """
    if not isinstance(policies, Mapping) or not policies:
        raise TypeError(f"policies={policies!r}: give at least one, by name: {{'mine': MyPolicy}}")
    found = []
    for name, given in policies.items():
        several = isinstance(given, Sequence) and not isinstance(given, str)
        trainings: list[Any] = list(cast(Any, given)) if several else [given]
        if not isinstance(name, str) or not NAME.fullmatch(name):
            raise ValueError(
                f"policies: {name!r} cannot be a name; begin with a letter or a digit and use "
                "these, dots, plus, minus and underscores"
            )
        if not trainings or (
            len(trainings) > 1 and any(isinstance(t, str) and t in POLICIES for t in trainings)
        ):
            raise ValueError(
                f"policies: {name}={','.join(map(str, trainings))}: several trainings of one "
                "policy are files or classes of their own; different policies need a name each"
            )
        sources = [policy_sources.find(training, trust_pickles) for training in trainings]
        found.append(NamedPolicy(name, tuple(sources)))
    return tuple(found)


def check_fit(policies: Sequence[NamedPolicy], suite: Suite) -> None:
    """Makes every policy for every condition and lets it decide once.

    Raises:
        ValueError, TypeError: it cannot be made, or does not act as ``Policy`` says.
    """
    for policy in policies:
        for source in policy.trainings:
            for condition in suite.conditions:
                try:
                    _check_decision(source, condition.params, suite.seed)
                except ValueError as error:
                    raise ValueError(
                        f"{policy.name} in condition {condition.name!r}: {error}"
                    ) from error


def _check_decision(source: PolicySource, params: EnvParams, seed: int) -> None:
    policy: Any = source.make(params)
    if not hasattr(policy, "act"):
        raise ValueError(f"{source.word} is not a policy: it has no method act")
    simulation = Simulation(params)
    observation = simulation.reset(seeds=[seed])
    arguments = (simulation.sensed, observation, None, np.ones(1, dtype=np.bool_))
    try:
        inspect.signature(policy.act).bind(*arguments)
    except TypeError as error:
        raise ValueError(
            f"{source.word}: act must take (sensed, observation, memory, fresh): {error}"
        ) from error
    try:
        decided = policy.act(*arguments)
    except Exception:
        return  # It fails its episodes, one by one, and each is named.
    if not (isinstance(decided, tuple) and len(decided) == 2):
        raise ValueError(
            f"{source.word}: act returned {type(decided).__name__}: return (action, memory)"
        )
    checked_action(decided[0], (1, params.num_boats, 2))
