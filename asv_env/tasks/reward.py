"""The reward: named, bounded, weighted terms of the true motion.

Terms of progress are differences of potentials, so that they cannot be farmed: what is gained on
the way there is lost on the way back (Ng, Harada and Russell, 1999). All built-in terms but effort
and collision are shared by the team. The sizes of the Gaussians grow with the vessel.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from asv_env.checks import REAL, FunctionError, choice, finite, values
from asv_env.compiled import compiled
from asv_env.params import EnvParams, RewardParams
from asv_env.tasks.formation import Relations, relate
from asv_env.tasks.judge import Standings, Team, stand, standings, team
from asv_env.tasks.laws import Rules, rules
from asv_env.tasks.payment import (
    COLUMNS,
    LARGEST_STEP,
    OWN,
    POTENTIALS,
    SHARED,
    Happened,
    Payments,
    Prices,
    Worth,
    evaluate,
    pay,
    prices,
)
from asv_env.text import shown
from asv_env.types import Ending, Float, Int, State, frozen, given

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


@dataclass(frozen=True)
class BuiltInPotential:
    """A built-in potential, see ``payment.evaluate``."""

    column: str  #: among ``POTENTIALS``

    def __call__(self, relations: Relations, state: State, params: EnvParams) -> Float:
        """Returns the potential (W,) of a true state."""
        found: Float = evaluated(state, params).potential[:, POTENTIALS.index(self.column)]
        return found


@dataclass(frozen=True)
class BuiltIn:
    """A built-in term that is no rise of a potential, see ``payment.pay``."""

    column: str  #: among ``COLUMNS``

    def __call__(self, now: Transition) -> Float:
        """Returns the term, (W,) or for each boat (W, A)."""
        place, paid = COLUMNS.index(self.column), _paid(now)
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


@compiled
def _evaluate_some(
    worlds: Int, team: Team, rules: Rules, prices: Prices, found: Standings, worth: Worth
) -> None:
    for number in range(len(worlds)):
        w = worlds[number]
        distance = stand(w, team, rules, found)
        evaluate(w, distance, team.goal[w], team.motion[w], team.side[w], prices, worth)


@compiled
def _pay_all(
    before: Float, worth: Worth, happened: Happened, prices: Prices, weight: Float, paid: Payments
) -> None:
    for w in range(len(before)):
        pay(w, before, worth, happened, prices, weight, paid)


def evaluated(state: State, params: EnvParams) -> Worth:
    """Returns what a true state is worth."""
    worth = blank_worth(len(state.tick))
    evaluate_some(np.arange(len(state.tick)), state, params, worth)
    return worth


def evaluate_some(worlds: Int, state: State, params: EnvParams, worth: Worth) -> None:
    """Writes what some worlds (n,) of a true state are worth."""
    teams, numbers = team(state, state.motion), (rules(params), prices(params))
    _evaluate_some(given(worlds, np.int64), teams, *numbers, standings(teams), worth)


def blank_worth(worlds: int) -> Worth:
    """Returns memory for what the states of so many worlds are worth."""
    return Worth(np.empty((worlds, len(POTENTIALS))), np.empty((worlds, 2)))


def blank_payments(worlds: int, boats: int) -> Payments:
    """Returns memory for the terms of so many worlds and boats."""
    shape = (worlds, boats)
    return Payments(np.empty((worlds, SHARED)), np.empty((*shape, OWN)), np.empty(shape))


def _paid(now: Transition) -> Payments:
    """Returns the built-in terms of a tick without weights, and without rises of potentials."""
    state, ending = now.state, now.ending
    flags = given(ending.reached, np.bool_), given(ending.strayed, np.bool_)
    seen = given(state.tick, np.int64), given(state.thrust), given(state.touching, np.bool_)
    aground = given(state.aground, np.bool_)
    worth, paid = evaluated(state, now.params), blank_payments(*state.slot.shape)
    numbers = prices(now.params), np.ones(len(COLUMNS))
    _pay_all(worth.potential, worth, Happened(*flags, *seen, aground), *numbers, paid)
    return paid


def checked_total(terms: dict[str, Float], reward: Float) -> Float:
    """Returns rewards (W, A), which are the sum of terms.

    Raises:
        FunctionError: a term is not finite.
    """
    if not np.isfinite(reward).all():
        name = next((n for n, value in terms.items() if not np.isfinite(value).all()), "sum")
        raise FunctionError(f"{KIND} {name!r} is not finite")
    return reward


class Terms:
    """The reward terms of a task: built-in ones are columns, all others have functions."""

    def __init__(self, terms: Sequence[Term], params: EnvParams) -> None:
        self._params = params
        weight, taken = np.zeros(len(COLUMNS)), set()
        self._columns: list[tuple[str, int]] = []
        #: terms with functions of a user's
        self.others: list[Term] = []
        for term in terms:
            place = term.column
            if place is None or place in taken:
                self.others.append(term)
            else:
                self._columns.append((term.name, place))
                weight[place] = term.factor(params)
                taken.add(place)
        self._names = [term.name for term in terms]
        self.weight = weight  #: (9,) factors on the columns
        #: those of them that are rises of potentials
        self.rising = [term for term in self.others if term.potential is not None]

    def named(self, paid: Payments) -> dict[str, Float]:
        """Returns the built-in terms by name, in their places among all terms."""
        terms: dict[str, Float] = dict.fromkeys(self._names, _NOTHING)
        for name, place in self._columns:
            if place < SHARED:
                terms[name] = paid.shared[:, place : place + 1]
            else:
                terms[name] = paid.own[..., place - SHARED]
        return terms

    def potentials(self, state: State) -> Float:
        """Returns the potentials (W, n) that functions of users compute."""
        found, forms = np.empty((len(state.tick), len(self.rising))), {state.tick.shape: REAL}
        if self.rising:
            relations = frozen(relate(state.motion, state.goal, state.slot, state.side))
            for column, term in enumerate(self.rising):
                potential: Any = term.potential
                known = relations, state, self._params
                found[:, column] = values(forms, KIND, term.name, potential, *known)
        return found

    def add_others(
        self, now: Transition, before: Float, after: Float, terms: dict[str, Float], reward: Float
    ) -> None:
        """Adds the terms that functions of users compute to ``terms`` and to ``reward`` (W, A).

        ``potentials`` before and after the tick are (W, n).
        """
        rises = iter(np.clip(after - before, -LARGEST_STEP, LARGEST_STEP).T)
        of_team, each = {now.state.tick.shape: REAL}, {now.state.slot.shape: REAL}
        for term in self.others:
            if term.value is None:
                value: Float = next(rises)
            else:
                forms = of_team if term.shared else each
                value = values(forms, KIND, term.name, term.value, now)
            if term.weight != 1.0:
                value = term.factor(self._params) * value
            terms[term.name] = value[:, None] if term.shared else value
            reward += terms[term.name]


_NOTHING = np.zeros((0, 1))  # A place that a user's term will take.
