"""The judge of a simulation: from the motion of a tick to state, ending, reward and metrics."""

import math
from typing import Any, NamedTuple

import numpy as np

from asv_env.compiled import Bound, allocating, bound, compiled
from asv_env.params import EnvParams
from asv_env.tasks import metrics, termination
from asv_env.tasks.formation import Relations, relate
from asv_env.tasks.judge import Standings, Team, stand, standings, team
from asv_env.tasks.laws import at_goal, rules
from asv_env.tasks.metrics import Block, Tick, count
from asv_env.tasks.payment import Happened, Payments, Worth, evaluate, pay, prices
from asv_env.tasks.reward import (
    Terms,
    Transition,
    blank_payments,
    blank_worth,
    checked_total,
    evaluate_some,
)
from asv_env.threads import spread
from asv_env.types import Bool, Complex, Ending, Float, Int, State, frozen, made, rows


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


@allocating
def judge(
    first: int,
    last: int,
    book: Bound,
    team: Team,
    anchored: Bool,
    before: Counts,
    water: Complex,
    found: Standings,
    counts: Counts,
    ends: Ends,
    worth: Worth,
) -> int:
    """Judges a tick of the worlds ``first`` to ``last - 1``.

    Args:
        first: first world.
        last: world after the last one.
        book: rules, limits and prices, and what ``settle`` takes.
        team: the true motion and situation.
        anchored: (W,) whether goals are final.
        before: counts before the tick.
        water: (W,) velocity of the water at the vessels, m/s.
        found: receives how the teams stand.
        counts: receives the counts after the tick.
        ends: receives whether and why episodes end.
        worth: receives what the states are worth.

    Returns:
        In how many of the worlds the episode ends.
    """
    rules, limits, prices, _, _, _ = book.content
    ended = 0
    for world in range(first, last):
        distance = stand(world, team, rules, found)
        motion, goal = team.motion[world], team.goal[world]
        there = anchored[world] and at_goal(motion, goal, water[world], rules)
        counts.tick[world] = before.tick[world] + 1
        counts.occupied[world] = before.occupied[world] + 1 if found.formed[world] else 0
        counts.delivered[world] = before.delivered[world] + 1 if there else 0
        end(world, motion, counts, limits, ends)
        evaluate(world, distance, goal, motion, team.side[world], prices, worth)
        ended += ends.terminated[world] or ends.truncated[world]
    return ended


@allocating
def settle(
    first: int,
    last: int,
    book: Bound,
    potential: Float,
    worth: Worth,
    happened: Happened,
    paid: Payments,
    now: Tick,
    pays: bool,
    counts: bool,
) -> bool:
    """Pays for a tick of the worlds ``first`` to ``last - 1``, and adds it to the metrics.

    Args:
        first: first world.
        last: world after the last one.
        book: rules, limits, prices, weights of the terms, full thrust, and the tally.
        potential: (W, P) before the tick.
        worth: what the states after it are worth.
        happened: what is paid for and counted.
        paid: receives the weighted terms and their sums.
        now: what is counted.
        pays: whether anything is paid.
        counts: whether the tick is added to the metrics.

    Returns:
        Whether all rewards are finite.
    """
    _, _, prices, weight, full, tally = book.content
    finite = True
    for world in range(first, last):
        if pays:
            pay(world, potential, worth, happened, prices, weight, paid)
        if counts:
            count(world, now, happened, worth.error, paid.reward, full, tally)
        for boat in range(paid.reward.shape[1]):
            finite = finite and math.isfinite(paid.reward[world, boat])
    return finite


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
        self._worth = blank_worth(num_worlds)
        self._others: Float = np.zeros((num_worlds, 0))  # (W, n) potentials that are not built in

    def begin(self, index: np.ndarray, state: State) -> None:
        """Begins episodes in the worlds ``index`` (n,) of a true state."""
        self.misassigned[index] = False
        self._renew(index, state)
        error = self._worth.error[index]
        metrics.restart(self._tally, index, state.closed[index], error)

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
        teams = team(before, moved["motion"])
        found, worth = standings(teams), blank_worth(worlds)
        counts = Counts(*(np.empty(worlds, np.int64) for _ in range(3)))
        ends = Ends(*(np.empty(worlds, np.bool_) for _ in range(5)))
        paid = blank_payments(worlds, boats)
        # What users' functions get is read-only, and what compiled code gets stays as it is.
        shown = _views if self._own else _same
        own_found, own_counts, own_ends = shown(found), shown(counts), shown(ends)
        values = {
            **vars(before),
            **moved,
            "occupied": own_found.occupied,
            "closed": own_found.closed,
            "tick": own_counts.tick,
            "occupied_ticks": own_counts.occupied,
            "delivered_ticks": own_counts.delivered,
        }
        state, ending = made(State, values), made(Ending, own_ends._asdict())
        motions = before.motion, state.motion
        ticked = Tick(*motions, before.touching, before.closed, found.closed, found.occupied)
        were = Counts(before.tick, before.occupied_ticks, before.delivered_ticks)
        judged = teams, before.anchored, were, water, found, counts, ends, worth
        happened = Happened(ends.reached, ends.strayed, counts.tick, state.thrust, state.touching)
        settled = self._worth.potential, worth, happened, paid, ticked

        ended, finite = [], []

        def run(first: int, last: int, thread: int) -> None:
            ended.append(judge(first, last, self._book, *judged))
            if not self._own:
                finite.append(settle(first, last, self._book, *settled, True, True))

        spread(run, worlds, self._num_threads)
        frozen(state)
        frozen(ending)
        terms: dict[str, Float] = {}
        others: Float = self._others
        if self._own:
            ending, terms, others = self._settle_own(before, state, ending, water, *settled)
        else:
            terms = self._terms.named(paid)
            if not all(finite):
                checked_total(terms, paid.reward)
        self.ended = any(ended) or not self._ends
        self._worth, self._others, self.misassigned = worth, others, found.misassigned
        return state, ending, terms, paid.reward

    def _settle_own(
        self,
        before: State,
        state: State,
        ending: Ending,
        water: Complex,
        potential: Float,
        worth: Worth,
        happened: Happened,
        paid: Payments,
        ticked: Tick,
    ) -> tuple[Ending, dict[str, Float], Float]:
        """Pays for a tick of a task that has functions of a user's; see ``tick``.

        Returns:
            The ending, the terms, and the potentials (W, n) that are not built in.
        """
        if not self._ends:
            ending = frozen(termination.ending(state, ending, water.copy(), self._params))
            happened.reached[...], happened.strayed[...] = ending.reached, ending.strayed
        settle(
            0, len(state.tick), self._book, potential, worth, happened, paid, ticked, True, False
        )
        terms, others = self._terms.named(paid), self._terms.potentials(state)
        now = Transition(before, state, ending, self._params)
        self._terms.add_others(now, self._others, others, terms, paid.reward)
        checked_total(terms, paid.reward)
        settle(
            0, len(state.tick), self._book, potential, worth, happened, paid, ticked, False, True
        )
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
        for total, remembered in zip(self._tally, totals, strict=True):
            total[...] = remembered


def _same(arrays: Any) -> Any:
    return arrays


def _views(arrays: Any) -> Any:
    return type(arrays)(*(array.view() for array in arrays))
