"""Metrics of episodes, accumulated tick by tick from the true state."""

import math
from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np

from asv_env.checks import REAL, FunctionError, values
from asv_env.compiled import compiled
from asv_env.params import EnvParams
from asv_env.tasks.formation import Relations
from asv_env.tasks.payment import Happened
from asv_env.types import Bool, Ending, Float, Int, State

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
    #: (W,) number of times that a boat began to touch a boat, or any hull an obstacle
    collisions: Int
    episode_return: Float  #: (W,) sum over the ticks of the boats' mean reward


def tally(worlds: int, team: int) -> Tally:
    """Returns totals for so many worlds and boats; ``restart`` begins them."""
    whole, real = (lambda: np.zeros(worlds, dtype=np.int64)), (lambda: np.zeros(worlds))
    arrival = np.zeros((worlds, team), dtype=np.int64)
    errors = real(), real()
    return Tally(whole(), arrival, whole(), *errors, real(), real(), whole(), real())


@compiled
def restart(tally: Tally, worlds: Int, closed: Bool, error: Float) -> None:
    """Begins the totals in some worlds (n,), given closure (W,) and errors (W, 2) of all."""
    for number in range(len(worlds)):
        w = worlds[number]
        tally.closure_tick[w] = 0 if closed[w] else NEVER
        for boat in range(tally.arrival_tick.shape[1]):
            tally.arrival_tick[w, boat] = NEVER
        tally.closure_lost[w] = tally.collisions[w] = 0
        tally.path_length[w] = tally.effort[w] = tally.episode_return[w] = 0.0
        tally.min_position_error[w], tally.heading_error_at_min[w] = error[w, 0], error[w, 1]


def restart_errors(tally: Tally, index: np.ndarray, error: Float) -> None:
    """Takes the present errors (n, 2) in the worlds ``index`` (n,) for the smallest."""
    tally.min_position_error[index] = error[:, 0]
    tally.heading_error_at_min[index] = error[:, 1]


class Tick(NamedTuple):
    """What is counted in a tick: fields of the true states before and after it, read-only."""

    motion_before: Float
    motion: Float
    touching_before: Bool
    aground_before: Bool
    closed_before: Bool
    closed: Bool
    occupied: Bool


@compiled
def count(
    world: int,
    now: Tick,
    happened: Happened,
    error: Float,
    reward: Float,
    full: float,
    tally: Tally,
) -> None:
    """Adds a tick of a world to its totals.

    Args:
        world: row of the world in all arrays.
        now: the tick.
        happened: what else has happened in it.
        error: (W, 2) errors of position, m, and heading, rad.
        reward: (W, A) of the boats.
        full: sum of the thrusts of a team at full thrust for a second, in N ticks.
        tally: the totals.
    """
    team = reward.shape[1]
    tick, thrust, total = happened.tick[world], 0.0, 0.0
    if now.closed[world] and tally.closure_tick[world] < 0:
        tally.closure_tick[world] = tick
    if now.closed_before[world] and not now.closed[world]:
        tally.closure_lost[world] += 1
    for boat in range(team):
        if now.occupied[world, boat] and tally.arrival_tick[world, boat] < 0:
            tally.arrival_tick[world, boat] = tick
        touched = now.touching_before[world, boat, 1]
        if happened.touching[world, boat, 1] and not touched:
            tally.collisions[world] += 1
        left, right = happened.thrust[world, boat, 0], happened.thrust[world, boat, 1]
        thrust += abs(left) + abs(right)
        total += reward[world, boat]
    if happened.aground[world] and not now.aground_before[world]:
        tally.collisions[world] += 1
    if error[world, 0] < tally.min_position_error[world]:
        tally.min_position_error[world] = error[world, 0]
        tally.heading_error_at_min[world] = error[world, 1]
    dx = now.motion[world, 0, 0] - now.motion_before[world, 0, 0]
    dy = now.motion[world, 0, 1] - now.motion_before[world, 0, 1]
    tally.path_length[world] += math.sqrt(dx * dx + dy * dy)
    tally.effort[world] += thrust / full
    tally.episode_return[world] += total / team


FLAGS = ("is_success", "strayed")
NUMBERS = (
    *("position_error", "heading_error", "time_to_closure", "closure_spread", "time_to_goal"),
    *("min_position_error", "heading_error_at_min", "path_length", "effort", "episode_return"),
)
WHOLES = ("closure_lost", "collisions")
"""Names of the metrics that every task has: truth values, real and whole numbers."""


@compiled
def _report(
    tally: Tally,
    error: Float,
    reached: Bool,
    strayed: Bool,
    tick: Int,
    second: float,
    flags: Bool,
    numbers: Float,
    wholes: Int,
) -> None:
    """Writes the metrics ``FLAGS``, ``NUMBERS`` and ``WHOLES``, (n, W); a second is in ticks."""
    for w in range(len(tick)):
        flags[0, w], flags[1, w] = reached[w], strayed[w]
        closed = tally.closure_tick[w]
        first = last = tally.arrival_tick[w, 0]
        for boat in range(1, tally.arrival_tick.shape[1]):
            arrival = tally.arrival_tick[w, boat]
            first, last = min(first, arrival), max(last, arrival)
        numbers[0, w], numbers[1, w] = error[w, 0], error[w, 1]
        numbers[2, w] = closed / second if closed >= 0 else np.inf
        numbers[3, w] = (last - first) / second if first >= 0 else np.inf
        numbers[4, w] = tick[w] / second if reached[w] else np.inf
        numbers[5, w] = tally.min_position_error[w]
        numbers[6, w] = tally.heading_error_at_min[w]
        numbers[7, w] = tally.path_length[w]
        numbers[8, w] = tally.effort[w]
        numbers[9, w] = tally.episode_return[w]
        wholes[0, w], wholes[1, w] = tally.closure_lost[w], tally.collisions[w]


Block = tuple[tuple[str, ...], np.ndarray]
"""Names (n,) of metrics of one type, and their values (n, W)."""


def summary(
    tally: Tally,
    state: State,
    relations: Callable[[], Relations],
    error: Float,
    ending: Ending,
    params: EnvParams,
) -> list[Block]:
    """Returns the metrics of the episodes, as ``info`` has them at the end.

    They are ``is_success``, ``strayed``, errors (m, rad), times (s, infinite where the event has
    not come), the running totals, and the metrics of the task's own.
    """
    worlds = len(state.tick)
    flags = np.empty((len(FLAGS), worlds), dtype=np.bool_)
    numbers = np.empty((len(NUMBERS), worlds))
    wholes = np.empty((len(WHOLES), worlds), dtype=np.int64)
    happened = ending.reached, ending.strayed, state.tick, float(params.clock.control)
    _report(tally, error, *happened, flags, numbers, wholes)
    found: list[Block] = [(FLAGS, flags), (NUMBERS, numbers), (WHOLES, wholes)]
    for one in params.definition.metrics:
        if any(one.name in names for names, _ in found):
            raise FunctionError(f"{KIND} {one.name!r}: there is one already: choose another name")
        forms, known = {state.tick.shape: REAL}, (state, relations(), params)
        value = values(forms, KIND, one.name, one.value, *known)
        if np.isnan(value).any():
            raise FunctionError(f"{KIND} {one.name!r} is not a number; infinite is allowed")
        found.append(((one.name,), np.array(value)[None]))
    return found


def by_name(blocks: Iterable[Block]) -> dict[str, np.ndarray]:
    """Returns the values (W,) by name."""
    return {name: row for names, rows in blocks for name, row in zip(names, rows, strict=True)}
