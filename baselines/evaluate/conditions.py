"""What episodes are run: conditions, and suites of them.

A condition is one condition, and a suite a table of conditions with a range of seeds. Conditions with the same team
and vessel have the same starts and goals at the same seed: what a disturbance costs is seen beside
its control condition, pair by pair.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np

from asv_env.params import EnvParams
from asv_env.presets import make_params
from asv_env.tasks import starts

EPISODES = 2000
"""Episodes of a condition that carries a comparison."""
DRAWN = 3
"""Episodes of a condition whose beginnings go into the digest."""


@dataclass(frozen=True)
class Condition:
    """One condition.

    Attributes:
        name: unique in its suite.
        about: what it is, in a few words.
        control: name of the condition without the disturbance; None for one that is such a condition.
        task: "approach", "push" or "transport".
        scenario, preset, num_boats, options: as of ``make_params``.
    """

    name: str
    about: str = ""
    control: str | None = None
    task: str = "transport"
    scenario: str = "nominal"
    preset: str = "nominal"
    num_boats: int | None = None
    options: Mapping[str, Any] = field(default_factory=dict)

    @cached_property
    def params(self) -> EnvParams:
        """The environment's parameters.

        Raises:
            ValueError: an unknown name or a value out of range.
        """
        return make_params(self.task, self.num_boats, self.scenario, self.preset, **self.options)


@dataclass(frozen=True)
class Suite:
    """A set of episodes.

    Attributes:
        name: with its version, such as "plane-v1".
        about: what it is for, in a sentence.
        conditions: its conditions.
        seed: of the first episode of every condition.
        episodes: of every condition.
    """

    name: str
    about: str
    conditions: tuple[Condition, ...]
    seed: int = 0
    episodes: int = EPISODES

    def of(self, task: str) -> Suite:
        """The same starts and goals with another task."""
        return replace(
            self, conditions=tuple(replace(condition, task=task) for condition in self.conditions)
        )

    def first(self, episodes: int) -> Suite:
        """The first episodes of every condition."""
        return replace(self, episodes=episodes)

    @property
    def seeds(self) -> range:
        """Of the episodes of every condition."""
        return range(self.seed, self.seed + self.episodes)

    @property
    def task(self) -> str:
        """Of the conditions, joined where they differ."""
        return "+".join(dict.fromkeys(condition.task for condition in self.conditions))

    def digest(self) -> str:
        """A fingerprint of what the episodes are, not of how many are taken.

        It covers the parameters of all conditions (but for the weights of the reward) and how their
        first episodes begin.
        """
        conditions = [
            [condition.name, _described(condition.params), *_begun(condition, self.seed)]
            for condition in self.conditions
        ]
        text = json.dumps(_rounded(conditions), sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:16]


def _described(params: EnvParams) -> dict[str, Any]:
    """Returns the parameters that decide what the episodes are, as plain values."""
    values = asdict(params)
    for name in ("definition", "observation", "reward"):
        del values[name]
    return values


def _begun(condition: Condition, seed: int) -> list[dict[str, Any]]:
    seeds = range(seed, seed + DRAWN)
    return [vars(starts.sample(condition.params, np.random.default_rng(seed))) for seed in seeds]


def _rounded(value: Any) -> Any:
    """Plain values with nine digits of every number: the last ones are the processor's own."""
    if isinstance(value, Mapping):
        return {name: _rounded(item) for name, item in value.items()}
    if isinstance(value, np.ndarray):
        return _rounded(value.tolist())
    if isinstance(value, list | tuple):
        return [_rounded(item) for item in value]
    return f"{value:.9g}" if isinstance(value, float) else value


def custom(
    tasks: Sequence[str],
    disturbances: Sequence[str],
    teams: Sequence[int | None],
    preset: str,
    goal: tuple[float, ...] | None,
    seed: int,
    episodes: int,
) -> Suite:
    """A sweep over tasks, scenarios and team sizes; ``goal`` None draws one for each episode.

    Raises:
        ValueError: an unknown name, a value out of range, or one that is named twice.
    """
    given = {"--task": tasks, "--scenario": disturbances, "--num-boats": teams}
    for flag, values in given.items():
        if len(set(values)) < len(values):
            raise ValueError(f"{flag} {' '.join(map(str, values))}: name each once")
    options: dict[str, Any] = {} if goal is None else {"goal": goal}
    conditions = []
    for task, scenario, team in product(tasks, disturbances, teams):
        condition = Condition("", "", None, task, scenario, preset, team, options)
        boats = condition.params.num_boats
        conditions.append(
            replace(
                condition, name=_condition_name(tasks, disturbances, teams, task, scenario, boats)
            )
        )
    about = f"{_listed(tasks)}; {_listed(disturbances)}"
    return Suite("custom", about, tuple(conditions), seed, episodes)


def _condition_name(
    tasks: Sequence[str],
    disturbances: Sequence[str],
    teams: Sequence[int | None],
    task: str,
    scenario: str,
    boats: int,
) -> str:
    """What sets a condition apart in its sweep."""
    parts = [task] * (len(tasks) > 1)
    parts += [f"{boats} boats"] * (len(teams) > 1)
    parts += [scenario] * (len(disturbances) > 1 or not parts)
    return ", ".join(parts)


def _listed(names: Iterable[str]) -> str:
    return ", ".join(names)
