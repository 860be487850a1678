"""What a task is: how episodes begin, what is rewarded, when they succeed, what is reported.

A task of one's own is made from a built-in one with ``dataclasses.replace``::

    from dataclasses import replace
    from asv_env.tasks import TRANSPORT, Term

    def turning(now):
        return -abs(now.relations.yaw_rate[:, 0])

    STEADY = replace(TRANSPORT, name="steady", reward=(*TRANSPORT.reward, Term("turning", turning)))

Its functions are sent to worker processes, also those of a notebook.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from asv_env.params import EnvParams
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
    """A number that is reported at the end of an episode, beside those of ``metrics.summary``."""

    name: str  #: key in ``info``
    value: Callable[[State, Relations, EnvParams], Float | Bool]  #: to values (W,)


@dataclass(frozen=True)
class Task:
    """A task: data and pure functions, no state."""

    name: str  #: in tables, and in the registry ``asv_env.tasks.TASKS``
    initial_states: InitialStates
    reward: tuple[Term, ...]  #: table of reward terms
    success: Success
    cause: Cause  #: why an episode failed, as tables name it
    metrics: tuple[Metric, ...] = ()  #: metrics of the task's own
    not_applicable: tuple[str, ...] = ()  #: columns of an episode's row that mean nothing here
    time_limit: float = 180.0  #: for a vessel of nominal length, s
    starts_grasped: bool = False  #: whether episodes begin in closure, the boats in their slots
    has_goal: bool = True  #: whether the vessel is to be brought to a goal pose

    def __post_init__(self) -> None:
        names = [term.name for term in self.reward]
        if not names or len(set(names)) < len(names):
            raise ValueError(f"reward terms {names} of {self.name!r}: give one at least, each once")
