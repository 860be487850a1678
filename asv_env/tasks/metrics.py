"""Metrics of episodes, accumulated tick by tick from the true state."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from asv_env.checks import REAL, FunctionError, values
from asv_env.compiled import compiled
from asv_env.params import EnvParams
from asv_env.tasks.formation import Relations
from asv_env.types import Bool, Ending, Float, Int, State, given

KIND = "metric"  #: word for a metric of a task's own in messages
NEVER = -1  #: tick of an event that has not come


class Tally(NamedTuple):
    """Running totals of the episodes, by world."""

    closure_tick: Int  #: (W,) tick at which closure was first formed, or NEVER
    arrival_tick: Int  #: (W, A) tick at which each boat first occupied its slot, or NEVER
    closure_lost: Int  #: (W,) times that closure was lost
    #: (W,) smallest distance of the vessel to its goal, m, and signed heading error there, rad
    min_position_error: Float
    heading_error_at_min: Float
    path_length: Float  #: (W,) length of the path of the vessel's centre, m
    effort: Float  #: (W,) time at full thrust, averaged over all motors, s
    collisions: Int  #: (W,) number of times that a boat began to touch a boat or a wall
    episode_return: Float  #: (W,) sum over the ticks of the boats' mean reward


def tally(worlds: int, team: int) -> Tally:
    """Returns totals for so many worlds and boats; ``restart`` begins them."""
    whole, real = (lambda: np.zeros(worlds, dtype=np.int64)), (lambda: np.zeros(worlds))
    arrival = np.zeros((worlds, team), dtype=np.int64)
    errors = real(), real()
    return Tally(whole(), arrival, whole(), *errors, real(), real(), whole(), real())


def restart(tally: Tally, index: np.ndarray, closed: Bool, error: Float) -> None:
    """Begins the totals in the worlds ``index`` (n,), with closure (n,) and errors (n, 2)."""
    for total in tally:
        total[index] = 0
    tally.closure_tick[index] = np.where(closed, 0, NEVER)
    tally.arrival_tick[index] = NEVER
    restart_errors(tally, index, error)


def restart_errors(tally: Tally, index: np.ndarray, error: Float) -> None:
    """Takes the present errors (n, 2) in the worlds ``index`` (n,) for the smallest."""
    tally.min_position_error[index] = error[:, 0]
    tally.heading_error_at_min[index] = error[:, 1]


class Tick(NamedTuple):
    """What is counted in a tick: fields of the true states before and after it, read-only."""

    motion_before: Float
    motion: Float
    touching_before: Bool
    touching: Bool
    closed_before: Bool
    closed: Bool
    occupied: Bool
    tick: Int
    thrust: Float


def ticked(previous: State, state: State) -> Tick:
    """Returns what is counted in a tick."""
    return Tick(
        given(previous.motion),
        given(state.motion),
        given(previous.touching, np.bool_),
        given(state.touching, np.bool_),
        given(previous.closed, np.bool_),
        given(state.closed, np.bool_),
        given(state.occupied, np.bool_),
        given(state.tick, np.int64),
        given(state.thrust),
    )


@compiled
def count(
    first: int, last: int, now: Tick, error: Float, reward: Float, full: float, tally: Tally
) -> None:
    """Adds a tick of the worlds ``first`` to ``last - 1`` to the totals.

    Args:
        first: first world.
        last: world after the last one.
        now: the tick.
        error: (W, 2) errors of position, m, and heading, rad.
        reward: (W, A) of the boats.
        full: sum of the thrusts of a team at full thrust for a second, in N ticks.
        tally: the totals.
    """
    team = reward.shape[1]
    for w in range(first, last):
        tick, thrust, total = now.tick[w], 0.0, 0.0
        if now.closed[w] and tally.closure_tick[w] < 0:
            tally.closure_tick[w] = tick
        if now.closed_before[w] and not now.closed[w]:
            tally.closure_lost[w] += 1
        for a in range(team):
            if now.occupied[w, a] and tally.arrival_tick[w, a] < 0:
                tally.arrival_tick[w, a] = tick
            if now.touching[w, a, 1] and not now.touching_before[w, a, 1]:
                tally.collisions[w] += 1
            thrust += abs(now.thrust[w, a, 0]) + abs(now.thrust[w, a, 1])
            total += reward[w, a]
        if error[w, 0] < tally.min_position_error[w]:
            tally.min_position_error[w] = error[w, 0]
            tally.heading_error_at_min[w] = error[w, 1]
        dx = now.motion[w, 0, 0] - now.motion_before[w, 0, 0]
        dy = now.motion[w, 0, 1] - now.motion_before[w, 0, 1]
        tally.path_length[w] += math.hypot(dx, dy)
        tally.effort[w] += thrust / full
        tally.episode_return[w] += total / team


@compiled
def _events(
    tally: Tally,
    reached: Bool,
    tick: Int,
    second: float,
    time_to_closure: Float,
    closure_spread: Float,
    time_to_goal: Float,
) -> None:
    """Writes the times of events, s, infinite where they have not come; ``second`` is in ticks."""
    for w in range(len(tick)):
        arrival = tally.arrival_tick[w]
        spread = (arrival.max() - arrival.min()) / second
        closed = tally.closure_tick[w] / second
        time_to_closure[w] = closed if tally.closure_tick[w] >= 0 else np.inf
        closure_spread[w] = spread if arrival.min() >= 0 else np.inf
        time_to_goal[w] = tick[w] / second if reached[w] else np.inf


def summary(
    tally: Tally,
    state: State,
    relations: Callable[[], Relations],
    error: Float,
    ending: Ending,
    params: EnvParams,
) -> dict[str, Float | Bool]:
    """Returns the metrics of the episodes, each (W,), as ``info`` has them at the end.

    They are ``is_success``, ``strayed``, errors (m, rad), times (s, infinite where the event has
    not come), the running totals, and the metrics of the task's own.
    """
    times = np.empty((3, len(state.tick)))
    reached, tick = given(ending.reached, np.bool_), given(state.tick, np.int64)
    _events(tally, reached, tick, float(params.clock.control), *times)
    totals = tally._asdict()
    del totals["closure_tick"], totals["arrival_tick"]
    found = {
        "is_success": ending.reached.copy(),
        "strayed": ending.strayed.copy(),
        "position_error": error[:, 0].copy(),
        "heading_error": error[:, 1].copy(),
        **dict(zip(("time_to_closure", "closure_spread", "time_to_goal"), times, strict=True)),
        **{name: total.copy() for name, total in totals.items()},
    }
    for one in params.definition.metrics:
        if one.name in found:
            raise FunctionError(f"{KIND} {one.name!r}: there is one already: choose another name")
        forms, known = {state.tick.shape: REAL}, (state, relations(), params)
        value = values(forms, KIND, one.name, one.value, *known)
        if np.isnan(value).any():
            raise FunctionError(f"{KIND} {one.name!r} is not a number; infinite is allowed")
        found[one.name] = np.array(value)
    return found
