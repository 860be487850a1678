"""What episodes are run: conditions, and suites of them.

A suite is a table of conditions with a range of seeds. Conditions with the same team and vessel
have the same initial states and goals at the same seed, so that the cost of a disturbance is
measured pair by pair, against its control condition.
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from typing import Any, Self

import numpy as np

from asv_env.params import EnvParams
from asv_env.presets import make_params
from asv_env.tasks import starts
from baselines.evaluate.names import check_distinct, check_name

EPISODES = 2000  #: episodes of a condition that carries a comparison
IN_DIGEST = 3  #: number of episodes of a condition whose initial states go into the digest
NOT_IN_DIGEST = ("reward", "definition", "observation")  #: only how episodes are judged or seen
NAMED = {"task", "num_boats", "scenario", "preset"}  #: arguments of ``make_params`` as fields
CUSTOM = "custom"  #: name of a suite that is not published, and of a scenario given as an object


@dataclass(frozen=True)
class Condition:
    """One environment in which policies are compared.

    Raises ValueError for an option that is a field.
    """

    name: str  #: unique in its suite
    about: str = ""  #: description in a few words
    control: str | None = None  #: name of the condition without the disturbance, if any
    task: Any = "transport"  #: name of a task, "module:NAME", or a Task
    scenario: Any = "nominal"  #: name of a scenario, "module:NAME", or its overrides as a mapping
    preset: str = "nominal"  #: this, num_boats and options are as in make_params
    num_boats: int | None = None
    options: Mapping[str, Any] = field(default_factory=dict)
    #: whether no training may contain it, so that it shows how policies generalise
    out_of_distribution: bool = False
    environment: EnvParams | None = None  #: complete parameters, in place of task to options

    def __post_init__(self) -> None:
        if doubled := sorted(NAMED & set(self.options)):
            raise ValueError(
                f"condition {self.name!r}: options cannot hold {doubled[0]!r}: give the field "
                f"{doubled[0]}=... of Condition instead"
            )

    @cached_property
    def params(self) -> EnvParams:
        """The environment's parameters; ValueError where a name or a value is wrong."""
        if self.environment is not None:
            return self.environment
        return make_params(self.task, self.num_boats, self.scenario, self.preset, **self.options)

    @property
    def task_name(self) -> str:
        """Name of the task, as in the rows of episodes."""
        return self.params.task.name

    @property
    def scenario_name(self) -> str:
        """Name of the scenario, as in the rows of episodes."""
        named = isinstance(self.scenario, str) and self.environment is None
        return self.scenario.rpartition(":")[2] if named else CUSTOM


@dataclass(frozen=True)
class Suite:
    """A set of episodes.

    Raises ValueError for names that cannot be names of folders, or that are not distinct.
    """

    name: str  #: with its version, such as "plane-v2"
    about: str  #: purpose, in a sentence
    conditions: tuple[Condition, ...]  #: one or more, their names unique
    seed: int = 0  #: first seed of every condition
    episodes: int = EPISODES  #: number of episodes of every condition

    def __post_init__(self) -> None:
        for kind, name in (("suite", self.name), *(("condition", c.name) for c in self.conditions)):
            check_name(kind, name)
        check_distinct("conditions", [condition.name for condition in self.conditions])

    def with_task(self, task: Any) -> Self:
        """Returns the suite with another task, unless a condition has complete parameters."""
        for each in self.conditions:
            if each.environment is not None:
                raise ValueError(f"task={task}: the condition {each.name!r} has its own task")
        return replace(self, conditions=tuple(replace(c, task=task) for c in self.conditions))

    def first(self, episodes: int) -> Self:
        """Returns the suite with the first episodes of every condition."""
        return replace(self, episodes=episodes)

    @property
    def seeds(self) -> range:
        """Seeds of the episodes, the same in every condition."""
        return range(self.seed, self.seed + self.episodes)

    @property
    def task(self) -> str:
        """Names of the conditions' tasks, joined where they differ."""
        return "+".join(dict.fromkeys(condition.task_name for condition in self.conditions))

    def digest(self) -> str:
        """Returns a fingerprint of what the episodes are, not of how many are taken.

        It covers all parameters but ``NOT_IN_DIGEST``, and the first initial states.
        """
        conditions = []
        for condition in self.conditions:
            fields = asdict(condition.params).items()
            kept = {name: value for name, value in fields if name not in NOT_IN_DIGEST}
            rngs = map(np.random.default_rng, range(self.seed, self.seed + IN_DIGEST))
            states = [vars(starts.sample(condition.params, rng)) for rng in rngs]
            conditions.append([condition.name, kept, *states])
        text = json.dumps(_rounded(conditions), sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:16]


def _rounded(value: Any) -> Any:
    """Returns plain values, numbers with nine digits: the others differ between processors."""
    if isinstance(value, Mapping):
        return {name: _rounded(item) for name, item in value.items()}
    if isinstance(value, np.ndarray):
        return _rounded(value.tolist())
    if isinstance(value, list | tuple):
        return [_rounded(item) for item in value]
    if callable(value):  # a layout of obstacles, whose code ``provenance`` covers
        return str(getattr(value, "__qualname__", type(value).__qualname__))
    return f"{value:.9g}" if isinstance(value, float) else value
