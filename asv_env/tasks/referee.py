"""The judge of a simulation: from the motion of a tick to state, ending, reward and metrics."""

from typing import Any

import numpy as np

from asv_env.params import EnvParams
from asv_env.tasks import metrics, termination
from asv_env.tasks.formation import relate
from asv_env.tasks.judge import Counts, judge, standings, team
from asv_env.tasks.laws import rules
from asv_env.tasks.reward import Rewards, Transition, Worth
from asv_env.threads import spread
from asv_env.types import Complex, Ending, Float, State, frozen, given, made, rows


class Referee:
    """Judges the true state of ``num_worlds`` worlds, on so many threads."""

    def __init__(self, params: EnvParams, num_worlds: int, num_threads: int) -> None:
        self._params, self._rules, self._num_threads = params, rules(params), num_threads
        self._rewards = Rewards(params.definition.reward, params)
        self._tally = metrics.tally(num_worlds, params.num_boats)
        boat, clock = params.boat, params.clock
        self._full = 2 * params.num_boats * boat.thrust * clock.control
        #: (W,) where all boats rest on the hull without closure, after the last tick
        self.misassigned = np.zeros(num_worlds, dtype=np.bool_)
        self._worth: Worth

    def begin(self, index: np.ndarray, state: State) -> None:
        """Begins episodes in the worlds ``index`` (n,) of a true state."""
        self.misassigned[index] = False
        if len(index) == len(state.tick):
            self._worth = self._rewards.evaluate(state)
        else:
            self._renew(index, state)
        error = self._worth.error[index]
        metrics.restart(self._tally, index, state.closed[index], error)

    def judge(self, before: State, moved: dict[str, Any], water: Complex) -> tuple[State, Ending]:
        """Judges a tick.

        Args:
            before: the true state before the tick.
            moved: fields of the state after it that the physics decides.
            water: (W,) velocity of the water at the vessels, m/s.

        Returns:
            The state after it, and whether and why episodes end; read-only.
        """
        worlds = len(before.tick)
        teams = team(before, moved["motion"])
        found = standings(teams)
        were = Counts(before.occupied_ticks, before.delivered_ticks)
        counts = Counts(np.empty(worlds, np.int64), np.empty(worlds, np.int64))
        strayed = np.empty(worlds, np.bool_)
        judged = given(water, np.complex128), self._params.task.arena, self._rules
        results = found, counts, strayed

        def run(first: int, last: int, thread: int) -> None:
            judge(first, last, teams, before.anchored, were, *judged, *results)

        spread(run, worlds, self._num_threads)
        self.misassigned = found.misassigned
        values = {
            **vars(before),
            **moved,
            "tick": before.tick + 1,
            "occupied": found.occupied,
            "closed": found.closed,
            "occupied_ticks": counts.occupied,
            "delivered_ticks": counts.delivered,
        }
        state = frozen(made(State, values))
        return state, frozen(termination.ending(state, strayed, water, self._params))

    def reward(
        self, previous: State, state: State, ending: Ending
    ) -> tuple[dict[str, Float], Float]:
        """Returns the weighted reward terms of a tick by name, and the rewards (W, A).

        The tick is added to the metrics of the episodes.
        """
        ticked = metrics.ticked(previous, state)

        def count(first: int, last: int, error: Float, reward: Float) -> None:
            metrics.count(first, last, ticked, error, reward, self._full, self._tally)

        now = Transition(previous, state, ending, self._params)
        paid = self._rewards.pay(now, self._worth, self._num_threads, count)
        self._worth, terms, reward = paid
        return terms, reward

    def change(self, index: np.ndarray, anchored: np.ndarray, state: State) -> None:
        """Takes note of slots and goals that change in some worlds (n,), which earns no reward.

        In the worlds ``anchored`` (m,) the goal became final.
        """
        self._renew(index, state)
        metrics.restart_errors(self._tally, anchored, self._worth.error[anchored])

    def _renew(self, index: np.ndarray, state: State) -> None:
        new = self._rewards.evaluate(rows(state, index))
        for name, values in vars(self._worth).items():
            values[index] = getattr(new, name)

    def summary(self, state: State, ending: Ending) -> dict[str, Any]:
        """Returns the metrics of the episodes so far, each (W,); see ``metrics.summary``."""

        def relations() -> Any:
            return frozen(relate(state.motion, state.goal, state.slot, state.side))

        known = state, relations, self._worth.error, ending, self._params
        return metrics.summary(self._tally, *known)

    def snapshot(self) -> tuple[Any, ...]:
        """Returns all that changes from tick to tick, for the simulation to copy."""
        return self._worth, tuple(self._tally), self.misassigned

    def restore(self, memory: tuple[Any, ...]) -> None:
        """Continues as the referee did whose ``snapshot`` this is."""
        self._worth, totals, self.misassigned = memory
        self._tally = metrics.Tally(*totals)
