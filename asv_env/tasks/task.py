"""What a task is: how episodes begin, what is rewarded, when they succeed, what is reported.

A custom task is made from a built-in one with ``dataclasses.replace``::

    from dataclasses import replace
    from asv_env.tasks import TRANSPORT, Term

    def turning(now):
        return -abs(now.relations.yaw_rate[:, 0])

    STEADY = replace(TRANSPORT, name="steady", reward=(*TRANSPORT.reward, Term("turning", turning)))

Its functions are sent to worker processes, also those that a notebook defines.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from asv_env.params import EnvParams
from asv_env.tasks import starts
from asv_env.tasks.formation import Relations
from asv_env.tasks.reward import Term
from asv_env.types import Bool, Complex, Float, InitialState, State

InitialStates = Callable[[EnvParams, np.random.Generator, Float | None], InitialState]
"""Distribution of initial states: from parameters, the world's Generator and a given goal."""
Success = Callable[[Relations, State, Complex, EnvParams], Bool]
"""(W,) whether the task is done, from the true relations and state and the water's velocity."""
Cause = Callable[[Mapping[str, Any], EnvParams], str]
"""Cause of the failure of an episode, from its ``metrics.summary`` and the parameters."""


@dataclass(frozen=True)
class Metric:
    """A number that is reported at the end of an episode, besides those of ``metrics.summary``.

    Attributes:
        name: key in ``info``.
        value: function from state, relations and parameters to values (W,).
    """

    name: str
    value: Callable[[State, Relations, EnvParams], Float | Bool]


@dataclass(frozen=True)
class Task:
    """A task: how episodes begin, what is rewarded, when they succeed. Has no state.

    Attributes:
        name: name in tables and in the registry ``asv_env.tasks.TASKS``.
        initial_states: function from parameters, the world's Generator and the goal that was
            given to ``reset`` (or None) to an ``asv_env.types.InitialState``.
        reward: terms whose sum is the reward.
        success: function from the true relations and state, the velocity (W,) of the water at the
            vessel and the parameters to (W,) bool, whether the task is done.
        cause: function from the metrics of a failed episode and the parameters to the cause of
            the failure, a few words for tables.
        metrics: metrics that are reported besides those of ``metrics.summary``.
        not_applicable: columns of ``episodes.csv`` that are left empty for this task.
        time_limit: time limit for a vessel of 0.40 m, s; it grows with the vessel's length.
        starts_grasped: whether episodes begin in closure, with the boats in their slots.
        has_goal: whether the vessel has to be brought to a goal pose.
    """

    name: str
    initial_states: InitialStates
    reward: tuple[Term, ...]
    success: Success
    cause: Cause
    metrics: tuple[Metric, ...] = ()
    not_applicable: tuple[str, ...] = ()
    time_limit: float = 180.0
    starts_grasped: bool = False
    has_goal: bool = True

    def __post_init__(self) -> None:
        for name in ("reward", "metrics", "not_applicable"):
            object.__setattr__(self, name, tuple(getattr(self, name)))
        names = [term.name for term in self.reward]
        if not names or len(set(names)) < len(names):
            raise ValueError(f"reward terms {names} of {self.name!r}: give one at least, each once")

    def check(self, params: EnvParams) -> None:
        """Refuses parameters with which no episode can begin, by trying.

        Initial states that are not built in are not tried: what they do is their own affair.

        Raises:
            ValueError: boats or goals have no place.
        """
        if self.initial_states in (starts.scattered, starts.in_slots):
            self.initial_states(params, np.random.default_rng(0), None)
