"""The reward: named, bounded terms, weighted, of the true motion alone.

Progress terms are differences of potentials, so that they cannot be farmed: what is gained by
going is lost by coming back. All terms but effort and collision are shared by the team.

==========  ====================================================================
closure     towards the slots: fall of the boats' mean distance, vessel lengths
delivery    towards the goal: fall of distance + a quarter per rad, vessel lengths
precision   rise of a bell round the goal, 8 cm and 0.2 rad wide
success     1 at the tick at which the task is done
strayed     -1 at the tick at which a body leaves the arena, plus the time that was left
time        -1 each tick
effort      minus the boat's mean squared share of full thrust
collision   -1 each tick at which the boat touches another hull than the vessel
==========  ====================================================================
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from asv_env.formation import Relations
from asv_env.params import NOMINAL_LENGTH, EnvParams
from asv_env.types import Ending, Float, State

HEADING_WEIGHT = 0.25
BELL_DISTANCE = 0.08
BELL_ANGLE = 0.2
LARGEST_STEP = 1.0
"""Bound on the progress of one tick, vessel lengths."""


@dataclass
class Potentials:
    """Potentials (W,) whose rise is rewarded; 0 where all is done."""

    closure: Float
    delivery: Float
    precision: Float


def potentials(relations: Relations, state: State, params: EnvParams) -> Potentials:
    """Potentials of the true relations, dimensionless."""
    length = params.vessel.length
    size = length / NOMINAL_LENGTH
    off = np.add.reduce(relations.slot_error * state.working, axis=1)
    distance, turn = relations.goal_error, np.abs(relations.heading_error)
    return Potentials(
        closure=-off / (length * np.add.reduce(state.working, axis=1)),
        delivery=-(distance + size * HEADING_WEIGHT * turn) / length,
        precision=np.exp(
            -np.square(distance / (BELL_DISTANCE * size)) - np.square(turn / BELL_ANGLE)
        ),
    )


def terms(
    before: Potentials, after: Potentials, state: State, ending: Ending, params: EnvParams
) -> dict[str, Float]:
    """Weighted terms of one control tick by name, (W, 1) shared or (W, A) of a boat's own.

    The lengths are in nominal vessels' metres in effect: a delivery from one length away is
    worth the same for every vessel.
    """
    weight, task = params.reward, params.task.name
    shared: dict[str, Any] = {}
    if task != "push":
        shared["closure"] = weight.closure * _rise(before.closure, after.closure)
    if task != "approach":
        shared["delivery"] = weight.delivery * _rise(before.delivery, after.delivery)
        shared["precision"] = weight.precision * _rise(before.precision, after.precision)
    left = np.maximum(params.time_limit_ticks - state.tick, 0)
    shared["success"] = weight.success * ending.reached
    shared["strayed"] = -(weight.strayed + weight.time * left) * ending.strayed
    shared["time"] = np.full(len(left), -weight.time)
    own: dict[str, Float] = {name: value[:, None] for name, value in shared.items()}
    squares = np.add.reduce(np.square(state.thrust), axis=-1)
    own["effort"] = squares * (-0.5 * weight.effort / params.boat.thrust**2)
    own["collision"] = -weight.collision * state.touching[..., 1]
    return own


def total(terms: dict[str, Float], team: int) -> Float:
    """Reward (W, A): the sum of the terms."""
    reward = np.zeros((len(terms["time"]), team))
    for term in terms.values():
        reward += term
    return reward


def _rise(before: Float, after: Float) -> Float:
    return np.minimum(np.maximum(after - before, -LARGEST_STEP), LARGEST_STEP)
