"""The reward: named, bounded, weighted terms of the true motion.

Terms of progress are differences of potentials, so that they cannot be farmed: what is gained on
the way there is lost on the way back (Ng, Harada and Russell, 1999). All built-in terms but effort
and collision are shared by the team. The sizes of the Gaussians grow with the vessel.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from asv_env.checks import REAL, FunctionError, choice, finite, values
from asv_env.params import EnvParams, RewardParams
from asv_env.tasks.formation import Relations, relate
from asv_env.tasks.judge import team
from asv_env.tasks.payment import (
    COLUMNS,
    LARGEST_STEP,
    OWN,
    POTENTIALS,
    SHARED,
    Happened,
    Payments,
    evaluate,
    pay,
    prices,
)
from asv_env.text import shown
from asv_env.threads import spread
from asv_env.types import Ending, Float, State, frozen, given

KIND = "reward term"  #: word for a term in messages


@dataclass(frozen=True)
class Transition:
    """One control tick of all worlds, from which the reward terms are computed.

    Attributes:
        previous: true state before the tick.
        state: true state after the tick.
        ending: whether and why episodes end with the tick.
        params: parameters of the environment.
    """

    previous: State
    state: State
    ending: Ending
    params: EnvParams

    @cached_property
    def relations(self) -> Relations:
        """True relations of vessel, boats, slots and goal after the tick, read-only."""
        state = self.state
        return frozen(relate(state.motion, state.goal, state.slot, state.side))

    @property
    def second(self) -> float:
        """Duration of the tick, s."""
        return 1.0 / self.params.clock.control


Potential = Callable[[Relations, State, EnvParams], Float]
"""Potential (W,), dimensionless, of a true state."""


Afterwards = Callable[[int, int, Float, Float], None]
"""What follows for the worlds from one to before another one, with errors and rewards."""


@dataclass(frozen=True)
class Worth:
    """What true states are worth, and how far the vessels are from their goals."""

    potential: Float  #: (W, P) built-in potentials
    error: Float  #: (W, 2) errors of position, m, and heading, rad
    others: Float  #: (W, n) potentials of other terms


@dataclass(frozen=True)
class BuiltInPotential:
    """A built-in potential, see ``payment.evaluate``."""

    column: str  #: among ``POTENTIALS``

    def __call__(self, relations: Relations, state: State, params: EnvParams) -> Float:
        """Returns the potential (W,) of a true state."""
        found: Float = evaluated(state, params)[0][:, POTENTIALS.index(self.column)]
        return found


@dataclass(frozen=True)
class BuiltIn:
    """A built-in term that is no rise of a potential, see ``payment.pay``."""

    column: str  #: among ``COLUMNS``

    def __call__(self, now: Transition) -> Float:
        """Returns the term, (W,) or for each boat (W, A)."""
        place, paid = COLUMNS.index(self.column), payments(*now.state.slot.shape)
        potential, error = evaluated(now.state, now.params)
        changes = potential, potential, error
        weight = given(np.ones(len(COLUMNS)))
        pay(0, len(error), *changes, happened(now), prices(now.params), weight, paid)
        return paid.shared[:, place] if place < SHARED else paid.own[..., place - SHARED]


@dataclass(frozen=True)
class Term:
    """One term of the reward: a function of the transition, or the rise of a potential.

    Attributes:
        name: of the term, whose key in infos is ``reward_<name>``.
        value: function from a ``Transition`` to values (W,), or (W, A) if not shared.
        potential: function from true relations, state and parameters to a potential (W,), in place
            of ``value``. The value is its rise in a tick, limited to +-``LARGEST_STEP``.
        weight: factor on the value, or the name of the field of ``RewardParams`` that holds it.
        shared: whether all boats of a world get the same value.

    Raises:
        ValueError: both a value and a potential, or neither.
    """

    name: str
    value: Callable[[Transition], Float] | None = None
    potential: Potential | None = None
    weight: float | str = 1.0
    shared: bool = True

    def __post_init__(self) -> None:
        if (self.value is None) == (self.potential is None):
            raise ValueError(f"{KIND} {self.name!r}: give either a value or a potential")
        if isinstance(self.weight, str):
            choice(f"weight of {KIND} {self.name!r}", self.weight, RewardParams.__annotations__)
        elif finite(self.weight) is None:
            raise ValueError(f"{KIND} {self.name!r}: weight = {shown(self.weight)}: must be finite")

    def factor(self, params: EnvParams) -> float:
        """Returns the weight of the term in an environment."""
        if isinstance(self.weight, str):
            return float(getattr(params.reward, self.weight))
        return self.weight

    @property
    def column(self) -> int | None:
        """Number of the built-in column that the term is, with its weight; None of any other."""
        law = self.value or self.potential
        if not isinstance(law, BuiltIn | BuiltInPotential):
            return None
        place = COLUMNS.index(law.column)
        return place if self.shared == (place < SHARED) else None


success = BuiltIn("success")
accurate_success = BuiltIn("accurate_success")
TERMS = (
    Term("closure", potential=BuiltInPotential("closure"), weight="closure"),
    Term("delivery", potential=BuiltInPotential("delivery"), weight="delivery"),
    Term("precision", potential=BuiltInPotential("precision"), weight="precision"),
    Term("success", accurate_success),
    Term("strayed", BuiltIn("strayed")),
    Term("time", BuiltIn("time")),
    Term("effort", BuiltIn("effort"), shared=False),
    Term("collision", BuiltIn("collision"), shared=False),
)  #: all terms, as Transport has them


def without(*names: str) -> tuple[Term, ...]:
    """Returns ``TERMS`` with some terms of weight zero; they are still reported."""
    return tuple(replace(term, weight=0.0) if term.name in names else term for term in TERMS)


def evaluated(state: State, params: EnvParams) -> tuple[Float, Float]:
    """Returns the built-in potentials (W, P) and the errors (W, 2) of a true state."""
    worlds = len(state.tick)
    potential, error = np.empty((worlds, len(POTENTIALS))), np.empty((worlds, 2))
    evaluate(0, worlds, team(state, state.motion), prices(params), potential, error)
    return potential, error


def happened(now: Transition) -> Happened:
    """Returns what is paid for in a tick."""
    state, ending = now.state, now.ending
    flags = given(ending.reached, np.bool_), given(ending.strayed, np.bool_)
    touching = given(state.touching, np.bool_)
    return Happened(*flags, given(state.tick, np.int64), given(state.thrust), touching)


def payments(worlds: int, boats: int) -> Payments:
    """Returns memory for the terms of so many worlds and boats."""
    shape = (worlds, boats)
    return Payments(np.empty((worlds, SHARED)), np.empty((*shape, OWN)), np.empty(shape))


def checked_total(terms: dict[str, Float], reward: Float) -> Float:
    """Returns rewards (W, A), which are the sum of terms.

    Raises:
        FunctionError: a term is not finite.
    """
    if not np.isfinite(reward).all():
        name = next((n for n, value in terms.items() if not np.isfinite(value).all()), "sum")
        raise FunctionError(f"{KIND} {name!r} is not finite")
    return reward


class Rewards:
    """Rewards of W worlds by the terms of a task, with the potentials after the last tick.

    Built-in terms are computed by compiled loops, each once; all others by their functions.
    """

    def __init__(self, terms: Sequence[Term], params: EnvParams) -> None:
        self._params, self._prices = params, prices(params)
        weight, taken = np.zeros(len(COLUMNS)), set()
        self._columns: list[tuple[str, int]] = []
        self._others: list[Term] = []
        for term in terms:
            place = term.column
            if place is None or place in taken:
                self._others.append(term)
            else:
                self._columns.append((term.name, place))
                weight[place] = term.factor(params)
                taken.add(place)
        self._names = [term.name for term in terms]
        self._weight = given(weight)
        self._rising = [term for term in self._others if term.potential is not None]
        self.only_built_in = not self._others  #: whether no term has a function of a user's

    def evaluate(self, state: State) -> Worth:
        """Returns what a true state is worth."""
        potential, error = evaluated(state, self._params)
        return Worth(potential, error, self._own_potentials(state))

    def pay(
        self, now: Transition, before: Worth, num_threads: int, afterwards: Afterwards
    ) -> tuple[Worth, dict[str, Float], Float]:
        """Pays for a tick, before which the state was worth so much.

        Args:
            now: the tick.
            before: what the state before it was worth.
            num_threads: number of threads over which the worlds are spread.
            afterwards: is called with a range of worlds, their errors (W, 2) and rewards (W, A).

        Returns:
            What the state after it is worth; the weighted terms by name, (W, 1) shared or (W, A)
            for each boat; and the rewards (W, A).

        Raises:
            FunctionError: a function of a term fails, or a term is not finite.
        """
        worlds, boats = now.state.slot.shape
        potential: Float = np.empty((worlds, len(POTENTIALS)))
        error: Float = np.empty((worlds, 2))
        teams, paid, what = (
            team(now.state, now.state.motion),
            payments(worlds, boats),
            happened(now),
        )

        def run(first: int, last: int, thread: int) -> None:
            evaluate(first, last, teams, self._prices, potential, error)
            changes = before.potential, potential, error
            pay(first, last, *changes, what, self._prices, self._weight, paid)
            if self.only_built_in:
                afterwards(first, last, error, paid.reward)

        spread(run, worlds, num_threads)
        terms, reward = self._terms(paid), paid.reward
        others: Float = np.zeros((worlds, 0))
        if not self.only_built_in:
            others = self._own_potentials(now.state)
            rises = np.clip(others - before.others, -LARGEST_STEP, LARGEST_STEP)
            reward += self._add_others(now, iter(rises.T), terms)
        checked_total(terms, reward)
        if not self.only_built_in:
            spread(lambda first, last, _: afterwards(first, last, error, reward), worlds, 1)
        return Worth(potential, error, others), terms, reward

    def _terms(self, paid: Payments) -> dict[str, Float]:
        """Returns the built-in terms by name, in their places among all terms."""
        terms: dict[str, Float] = dict.fromkeys(self._names, _NOTHING)
        for name, place in self._columns:
            if place < SHARED:
                terms[name] = paid.shared[:, place : place + 1]
            else:
                terms[name] = paid.own[..., place - SHARED]
        return terms

    def _own_potentials(self, state: State) -> Float:
        """Returns the potentials (W, n) that functions of users compute."""
        found, forms = np.empty((len(state.tick), len(self._rising))), {state.tick.shape: REAL}
        if self._rising:
            relations = frozen(relate(state.motion, state.goal, state.slot, state.side))
            for column, term in enumerate(self._rising):
                potential: Any = term.potential
                known = relations, state, self._params
                found[:, column] = values(forms, KIND, term.name, potential, *known)
        return found

    def _add_others(
        self, now: Transition, rises: Iterator[Float], terms: dict[str, Float]
    ) -> Float:
        """Adds the terms that functions of users compute; returns their sum (W, A)."""
        total = np.zeros(now.state.slot.shape)
        of_team, each = {now.state.tick.shape: REAL}, {now.state.slot.shape: REAL}
        for term in self._others:
            if term.value is None:
                value: Float = next(rises)
            else:
                forms = of_team if term.shared else each
                value = values(forms, KIND, term.name, term.value, now)
            if term.weight != 1.0:
                value = term.factor(self._params) * value
            terms[term.name] = value[:, None] if term.shared else value
            total += terms[term.name]
        return total


_NOTHING = np.zeros((0, 1))  # A place that a user's term will take.
