"""The judge of a simulation: from the motion of a tick to state, ending, reward and metrics."""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from asv_env.compiled import Bound, allocating, bound, compiled
from asv_env.params import EnvParams
from asv_env.tasks import metrics, termination
from asv_env.tasks.formation import Relations, relate
from asv_env.tasks.judge import Standings, Team, stand
from asv_env.tasks.laws import Rules, at_goal, rules
from asv_env.tasks.metrics import Block, Tick, count
from asv_env.tasks.payment import Happened, Payments, Prices, Worth, evaluate, pay, prices
from asv_env.tasks.reward import (
    Terms,
    Transition,
    blank_payments,
    blank_worth,
    checked_total,
    evaluate_some,
)
from asv_env.threads import spread
from asv_env.types import Bool, Complex, Ending, Float, Int, State, frozen, given, made, rows


class Counts(NamedTuple):
    """Numbers of control ticks, each (W,)."""

    tick: Int  #: since the episode began
    occupied: Int  #: for which every slot was occupied without a break
    delivered: Int  #: for which the vessel was at its goal without a break


class Limits(NamedTuple):
    """When episodes end."""

    arena: float  #: half the side of the square that no body may leave, m
    time: int  #: ticks
    hold: int  #: ticks for which all slots must be occupied, if this is success; else 0
    delivery: int  #: ticks for which the vessel must be at its goal, if this is success; else 0


class Ends(NamedTuple):
    """Whether and why episodes end, each (W,); as ``Ending``."""

    reached: Bool
    strayed: Bool
    timed_out: Bool
    terminated: Bool
    truncated: Bool


def limits(params: EnvParams) -> Limits:
    """Returns when the episodes of an environment end."""
    success = params.definition.success
    hold = termination.hold_ticks(params) if success is termination.slots_occupied else 0
    delivered = success is termination.vessel_delivered
    delivery = termination.delivery_ticks(params) if delivered else 0
    return Limits(params.task.arena, params.time_limit_ticks, hold, delivery)


@compiled
def end(world: int, motion: Float, counts: Counts, limits: Limits, ends: Ends) -> None:
    """Decides whether the episode of a world ends; success that is not built in is not seen."""
    farthest = 0.0
    for body in range(motion.shape[0]):
        farthest = max(farthest, abs(motion[body, 0]), abs(motion[body, 1]))
    strayed = farthest > limits.arena
    held = limits.hold > 0 and counts.occupied[world] >= limits.hold
    delivered = limits.delivery > 0 and counts.delivered[world] >= limits.delivery
    ends.reached[world] = (held or delivered) and not strayed
    ends.strayed[world] = strayed
    ends.timed_out[world] = counts.tick[world] >= limits.time
    ends.terminated[world] = ends.reached[world] or strayed
    ends.truncated[world] = ends.timed_out[world] and not ends.terminated[world]


class Before(NamedTuple):
    """The true states before a tick, read-only; fields of ``State``."""

    motion: Float
    goal: Float
    slot: Complex
    side: Float
    working: Bool
    closed: Bool
    anchored: Bool
    touching: Bool
    aground: Bool
    tick: Int
    occupied_ticks: Int
    delivered_ticks: Int


class Page(NamedTuple):
    """Memory for what is decided in a tick."""

    occupied: Bool  #: (W, A) as ``Standings``
    flags: Bool  #: (8, W) the other fields of ``Standings``, then those of ``Ends``
    counts: Int  #: (3, W) fields of ``Counts``
    worth: Worth
    paid: Payments


def blank_page(worlds: int, boats: int) -> Page:
    """Returns memory for so many worlds and boats."""
    flags = len(Standings._fields) - 1 + len(Ends._fields)
    return Page(
        np.empty((worlds, boats), np.bool_),
        np.empty((flags, worlds), np.bool_),
        np.empty((len(Counts._fields), worlds), np.int64),
        blank_worth(worlds),
        blank_payments(worlds, boats),
    )


@compiled
def judge(
    world: int,
    team: Team,
    before: Before,
    water: Complex,
    rules: Rules,
    limits: Limits,
    prices: Prices,
    found: Standings,
    counts: Counts,
    ends: Ends,
    worth: Worth,
) -> None:
    """Judges a tick of a world; see ``officiate``."""
    distance = stand(world, team, rules, found)
    motion, goal = team.motion[world], team.goal[world]
    there = before.anchored[world] and at_goal(motion, goal, water[world], rules)
    counts.tick[world] = before.tick[world] + 1
    counts.occupied[world] = before.occupied_ticks[world] + 1 if found.formed[world] else 0
    counts.delivered[world] = before.delivered_ticks[world] + 1 if there else 0
    end(world, motion, counts, limits, ends)
    evaluate(world, distance, goal, motion, team.side[world], prices, worth)


@allocating
def officiate(
    first: int,
    last: int,
    book: Bound,
    before: Before,
    motion: Float,
    thrust: Float,
    touching: Bool,
    aground: Bool,
    water: Complex,
    potential: Float,
    page: Page,
    judges: bool,
    pays: bool,
    counts: bool,
) -> tuple[int, int, bool]:
    """Judges a tick of the worlds ``first`` to ``last - 1``, pays for it, and counts it.

    Args:
        first: first world.
        last: world after the last one.
        book: rules, limits, prices, weights of the terms, full thrust, and the tally.
        before: the states before it.
        motion: (W, B, 6) after it.
        thrust: (W, A, 2) after it.
        touching: (W, A, 2) after it.
        aground: (W,) after it.
        water: (W,) velocity of the water at the vessels, m/s.
        potential: (W, P) before it.
        page: receives what is decided.
        judges: whether it is judged.
        pays: whether it is paid for.
        counts: whether it is added to the metrics.

    Returns:
        In how many of the worlds the episode ends, in how many the team is misassigned, and
        whether all rewards are finite.
    """
    rules, limits, prices, weight, full, tally = book.content
    flags, numbers = page.flags, page.counts
    team = Team(motion, before.goal, before.slot, before.side, before.working, before.closed)
    found = Standings(page.occupied, flags[0], flags[1], flags[2])
    ends = Ends(flags[3], flags[4], flags[5], flags[6], flags[7])
    count_of = Counts(numbers[0], numbers[1], numbers[2])
    happened = Happened(ends.reached, ends.strayed, count_of.tick, thrust, touching, aground)
    touched = before.touching, before.aground
    now = Tick(before.motion, motion, *touched, before.closed, found.closed, found.occupied)
    worth, paid = page.worth, page.paid
    ended, misassigned, finite = 0, 0, True
    for world in range(first, last):
        if judges:
            given = team, before, water, rules, limits, prices
            judge(world, *given, found, count_of, ends, worth)
        if pays:
            pay(world, potential, worth, happened, prices, weight, paid)
        if counts:
            count(world, now, happened, worth.error, paid.reward, full, tally)
        ended += ends.terminated[world] or ends.truncated[world]
        misassigned += found.misassigned[world]
        for boat in range(paid.reward.shape[1]):
            finite = finite and math.isfinite(paid.reward[world, boat])
    return ended, misassigned, finite


class Referee:
    """Judges the true state of ``num_worlds`` worlds, on so many threads."""

    def __init__(self, params: EnvParams, num_worlds: int, num_threads: int) -> None:
        self._params, self._num_threads = params, num_threads
        self._terms = Terms(params.definition.reward, params)
        self._tally = metrics.tally(num_worlds, params.num_boats)
        ends = limits(params)
        full = 2 * params.num_boats * params.boat.thrust * params.clock.control
        numbers = rules(params), ends, prices(params), self._terms.weight, full
        self._book = bound((*numbers, self._tally))
        self._ends = ends.hold + ends.delivery > 0  # whether the task's success is built in
        self._own = bool(self._terms.others) or not self._ends
        #: (W,) where all boats rest on the hull without closure, after the last tick
        self.misassigned = np.zeros(num_worlds, dtype=np.bool_)
        self.ended = False  #: whether any episode ended at the last tick
        self.some_misassigned = False  #: whether ``misassigned`` holds anywhere
        self._worth = blank_worth(num_worlds)
        self._others: Float = np.zeros((num_worlds, 0))  # (W, n) potentials that are not built in

    def begin(self, index: np.ndarray, state: State) -> None:
        """Begins episodes in the worlds ``index`` (n,) of a true state."""
        self.misassigned[index] = False
        self.some_misassigned = bool(self.misassigned.any())
        self._renew(index, state)
        known = given(index, np.int64), given(state.closed, np.bool_), self._worth.error
        metrics.restart(self._tally, *known)

    def tick(
        self, before: State, moved: dict[str, Any], water: Complex
    ) -> tuple[State, Ending, dict[str, Float], Float]:
        """Judges a tick and pays for it.

        Args:
            before: the true state before the tick.
            moved: fields of the state after it that the physics decides, read-only.
            water: (W,) velocity of the water at the vessels, m/s.

        Returns:
            The state after it, and whether and why episodes end, read-only; the weighted reward
            terms by name, (W, 1) shared or (W, A) for each boat; and the rewards (W, A).

        Raises:
            FunctionError: a function of the task fails, or a term is not finite.
        """
        worlds, boats = before.slot.shape
        page = blank_page(worlds, boats)
        closed, _, misassigned, *ends = page.flags
        tick, occupied_ticks, delivered_ticks = page.counts
        values = {
            **vars(before),
            **moved,
            # What users' functions get is read-only, and what compiled code gets stays as it is.
            "occupied": page.occupied.view(),
            "closed": closed,
            "tick": tick,
            "occupied_ticks": occupied_ticks,
            "delivered_ticks": delivered_ticks,
        }
        state = frozen(made(State, values))
        ending = frozen(made(Ending, dict(zip(Ends._fields, ends, strict=True))))
        were = Before(*[getattr(before, name) for name in Before._fields])
        after = state.motion, state.thrust, state.touching, state.aground, water
        ticked = self._book, were, *after, self._worth.potential, page
        done = []

        def run(first: int, last: int, thread: int) -> None:
            done.append(officiate(first, last, *ticked, True, not self._own, not self._own))

        spread(run, worlds, self._num_threads)
        terms: dict[str, Float] = {}
        others: Float = self._others
        if self._own:
            known = before, state, ending, water, page
            ending, terms, others = self._settle_own(
                *known, lambda *flags: officiate(0, worlds, *ticked, *flags)
            )
        else:
            terms = self._terms.named(page.paid)
            if not all(finite for _, _, finite in done):
                checked_total(terms, page.paid.reward)
        self.ended = not self._ends or any(ended for ended, _, _ in done)
        self.some_misassigned = any(some for _, some, _ in done)
        self._worth, self._others, self.misassigned = page.worth, others, misassigned
        return state, ending, terms, page.paid.reward

    def _settle_own(
        self,
        before: State,
        state: State,
        ending: Ending,
        water: Complex,
        page: Page,
        again: Callable[[bool, bool, bool], object],
    ) -> tuple[Ending, dict[str, Float], Float]:
        """Pays for a tick of a task that has functions of a user's; see ``tick``.

        ``again`` calls ``officiate`` for all worlds, given whether it judges, pays and counts.

        Returns:
            The ending, the terms, and the potentials (W, n) that are not built in.
        """
        if not self._ends:
            ending = frozen(termination.ending(state, ending, water.copy(), self._params))
            page.flags[3:] = list(vars(ending).values())
        again(False, True, False)
        terms, others = self._terms.named(page.paid), self._terms.potentials(state)
        now = Transition(before, state, ending, self._params)
        self._terms.add_others(now, self._others, others, terms, page.paid.reward)
        checked_total(terms, page.paid.reward)
        again(False, False, True)
        return ending, terms, others

    def change(self, index: np.ndarray, anchored: np.ndarray, state: State) -> None:
        """Takes note of slots and goals that change in some worlds (n,), which earns no reward.

        In the worlds ``anchored`` (m,) the goal became final.
        """
        self._renew(index, state)
        metrics.restart_errors(self._tally, anchored, self._worth.error[anchored])

    def _renew(self, index: np.ndarray, state: State) -> None:
        """Evaluates the states of some worlds (n,) again."""
        evaluate_some(index, state, self._params, self._worth)
        if not self._terms.rising:
            return
        others = self._terms.potentials(frozen(rows(state, index)))
        if self._others.shape[1] < others.shape[1]:
            self._others = np.zeros((len(state.tick), others.shape[1]))
        self._others[index] = others

    def summary(self, state: State, ending: Ending) -> list[Block]:
        """Returns the metrics of the episodes so far; see ``metrics.summary``."""

        def relations() -> Relations:
            return frozen(relate(state.motion, state.goal, state.slot, state.side))

        known = state, relations, self._worth.error, ending, self._params
        return metrics.summary(self._tally, *known)

    def snapshot(self) -> tuple[Any, ...]:
        """Returns all that changes from tick to tick, for the simulation to copy."""
        return tuple(self._worth), self._others, tuple(self._tally), self.misassigned

    def restore(self, memory: tuple[Any, ...]) -> None:
        """Continues as the referee did whose ``snapshot`` this is."""
        worth, self._others, totals, self.misassigned = memory
        self._worth = Worth(*worth)
        self.some_misassigned = bool(self.misassigned.any())
        for total, remembered in zip(self._tally, totals, strict=True):
            total[...] = remembered
