"""Metrics of episodes, accumulated tick by tick from the true state."""

import numpy as np

from asv_env.checks import REAL, FunctionError, values
from asv_env.geometry import plane
from asv_env.params import EnvParams
from asv_env.tasks.formation import Relations
from asv_env.tasks.reward import Transition
from asv_env.types import Bool, Ending, Float, Int, State

KIND = "metric"  #: word for a metric of a task's own in messages
NEVER = -1  #: tick of an event that has not come


class Tallies:
    """Running totals of the episodes, by world, as they are at the beginning."""

    def __init__(self, relations: Relations, state: State) -> None:
        worlds, team = relations.boat.shape
        #: (W,) tick at which closure was first formed, or NEVER
        self.closure_tick: Int = np.where(state.closed, state.tick, NEVER)
        #: (W, A) tick at which each boat first occupied its slot, or NEVER
        self.arrival_tick: Int = np.full((worlds, team), NEVER)
        self.closure_lost = np.zeros(worlds, dtype=np.int64)  #: (W,) times that closure was lost
        #: (W,) smallest distance of the vessel to its goal, m, and signed heading error there, rad
        self.min_position_error = relations.goal_error.copy()
        self.heading_error_at_min = relations.heading_error.copy()
        self.path_length = np.zeros(worlds)  #: (W,) length of the path of the vessel's centre, m
        self.effort = np.zeros(worlds)  #: (W,) time at full thrust, averaged over all motors, s
        #: (W,) number of times that a boat began to touch a boat or a wall
        self.collisions = np.zeros(worlds, dtype=np.int64)
        self.episode_return = np.zeros(worlds)  #: (W,) sum over the ticks of the boats' mean reward


def restart_errors(tally: Tallies, relations: Relations, index: np.ndarray) -> None:
    """Takes the present errors in worlds ``index`` (n,), or a mask (W,), for the smallest."""
    tally.min_position_error[index] = relations.goal_error[index]
    tally.heading_error_at_min[index] = relations.heading_error[index]


def update(tally: Tallies, now: Transition, reward: Float) -> None:
    """Adds a tick and the reward (W, A) of the boats, in place."""
    previous, state, relations, params = now.previous, now.state, now.relations, now.params
    occupied = state.occupied
    if occupied.any() or previous.closed.any():
        first = (tally.closure_tick < 0) & state.closed
        tally.closure_tick = np.where(first, state.tick, tally.closure_tick)
        first = (tally.arrival_tick < 0) & occupied
        tally.arrival_tick = np.where(first, state.tick[:, None], tally.arrival_tick)
        tally.closure_lost += previous.closed > state.closed
    nearer = relations.goal_error < tally.min_position_error
    restart_errors(tally, relations, nearer)
    tally.path_length += np.abs(plane(state.motion[:, 0]) - plane(previous.motion[:, 0]))
    full = params.boat.thrust * params.clock.control * state.thrust[0].size
    tally.effort += np.add.reduce(np.abs(state.thrust), axis=(1, 2)) / full
    bumps = state.touching[..., 1] > previous.touching[..., 1]
    tally.collisions += np.add.reduce(bumps, axis=1)
    tally.episode_return += np.add.reduce(reward, axis=1) / reward.shape[1]


def summary(
    tally: Tallies, state: State, relations: Relations, ending: Ending, params: EnvParams
) -> dict[str, Float | Bool]:
    """Returns the metrics of the episodes, each (W,), as ``info`` has them at the end.

    They are ``is_success``, ``strayed``, errors (m, rad), times (s, infinite where the event has
    not come), the running totals, and the metrics of the task's own.
    """
    hz = params.clock.control
    arrived = (tally.arrival_tick >= 0).all(axis=1)
    spread = tally.arrival_tick.max(axis=1) - tally.arrival_tick.min(axis=1)
    closed = tally.closure_tick >= 0
    tallied = {name: total for name, total in vars(tally).items() if not name.endswith("_tick")}
    found = {
        "is_success": ending.reached,
        "strayed": ending.strayed,
        "position_error": relations.goal_error,
        "heading_error": relations.heading_error,
        "time_to_closure": np.where(closed, tally.closure_tick / hz, np.inf),
        "closure_spread": np.where(arrived, spread / hz, np.inf),
        "time_to_goal": np.where(ending.reached, state.tick / hz, np.inf),
        **tallied,
    }
    for one in params.definition.metrics:
        if one.name in found:
            raise FunctionError(f"{KIND} {one.name!r}: there is one already: choose another name")
        forms = {state.tick.shape: REAL}
        found[one.name] = values(forms, KIND, one.name, one.value, state, relations, params)
        if np.isnan(found[one.name]).any():
            raise FunctionError(f"{KIND} {one.name!r} is not a number; infinite is allowed")
    return {name: np.array(value) for name, value in found.items()}
