"""The reward: named, bounded terms, weighted, of the true motion alone.

Progress terms are differences of potentials, so that they cannot be farmed: what is gained by
going is lost by coming back. All terms but effort and collision are shared by the team.

==========  ====================================================================
closure     towards the slots: fall of the boats' mean distance, vessel lengths
delivery    towards the goal: fall of the distance, a quarter of a metre counting for a radian
            of heading at the nominal size, vessel lengths
precision   rise of a bell round the goal, 8 cm (nominal size) and 0.2 rad wide
success     1 at the tick at which the task is done
strayed     -1 at the tick at which a body leaves the arena, plus the time that was left
time        -1 each tick
effort      minus the boat's mean squared share of full thrust
collision   -1 each tick at which the boat touches another hull than the vessel
==========  ====================================================================
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from asv_env.formation import Relations
from asv_env.params import NOMINAL_LENGTH, EnvParams, RewardParams
from asv_env.types import Ending, Float, State

SHARED = ("closure", "delivery", "precision", "success", "strayed", "time")
HEADING_WEIGHT = 0.25
BELL_DISTANCE = 0.08
BELL_ANGLE = 0.2
LARGEST_STEP = 1.0
"""Bound on the rise of a potential in one tick."""


def potentials(relations: Relations, state: State, params: EnvParams) -> Float:
    """Potentials (W, 3) of closure, delivery and precision, whose rise is rewarded.

    Dimensionless; 0, 0 and 1 where all is done.
    """
    length = params.vessel.length
    size = length / NOMINAL_LENGTH
    off = np.add.reduce(relations.slot_error * state.working, axis=1)
    distance, turn = relations.goal_error, np.abs(relations.heading_error)
    values = np.empty((len(distance), 3))
    values[:, 0] = off / (-length * np.add.reduce(state.working, axis=1))
    values[:, 1] = (distance + size * HEADING_WEIGHT * turn) / -length
    bell = np.square(distance / (BELL_DISTANCE * size)) + np.square(turn / BELL_ANGLE)
    np.exp(-bell, out=values[:, 2])
    return values


def terms(
    before: Float, after: Float, state: State, ending: Ending, params: EnvParams
) -> dict[str, Float]:
    """Weighted terms of one control tick by name, (W, 1) shared or (W, A) of a boat's own.

    Args:
        before: (W, 3) potentials before the tick.
        after: (W, 3) potentials after it.
        state: after the tick.
        ending: after the tick.
        params: the environment's.
    """
    weight = params.reward
    shared = np.empty((len(after), len(SHARED)))
    rise = np.minimum(np.maximum(after - before, -LARGEST_STEP), LARGEST_STEP)
    np.multiply(_progress_weights(weight, params.task.name), rise, out=shared[:, :3])
    shared[:, 3] = weight.success * ending.reached
    time_lost = weight.time * (params.time_limit_ticks - state.tick)
    shared[:, 4] = ending.strayed * (-weight.strayed - time_lost)
    shared[:, 5] = -weight.time
    squares = np.add.reduce(np.square(state.thrust), axis=-1)
    named: dict[str, Float] = {name: shared[:, i : i + 1] for i, name in enumerate(SHARED)}
    named["effort"] = squares * (-0.5 * weight.effort / params.boat.thrust**2)
    named["collision"] = -weight.collision * state.touching[..., 1]
    return named


@lru_cache(maxsize=8)
def _progress_weights(weight: RewardParams, task: str) -> Float:
    """Weights (3,) of the potentials; what is not of the task has none."""
    to_slots, to_goal = task != "push", task != "approach"
    return np.array(
        [weight.closure * to_slots, weight.delivery * to_goal, weight.precision * to_goal]
    )


def total(terms: dict[str, Float]) -> Float:
    """Reward (W, A): the sum of the terms."""
    reward = terms["effort"] + terms["collision"]
    for name in SHARED:
        reward += terms[name]
    return reward
