"""The reward: named, bounded terms, weighted, of the true motion alone.

Progress terms are differences of potentials, so that they cannot be farmed: what is gained by
going is lost by coming back. All terms but effort and collision are shared by the team.

==========  ====================================================================
closure     towards the slots: fall of the boats' mean distance, vessel lengths
delivery    towards the goal: fall of the way to it, see ``way``, vessel lengths
precision   rise of a bell round the goal, 8 cm (nominal size) and 0.2 rad wide
success     1 at the tick at which the task is done; of a delivery, a share is paid by a narrow
            bell round the goal, 2 cm (nominal size) and 0.05 rad wide
strayed     -1 at the tick at which a body leaves the arena, plus the time that was left
time        -1 each second
effort      minus the boat's mean squared share of full thrust, each second
collision   -1 each second in which the boat touches another hull than the vessel
==========  ====================================================================
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from asv_env.geometry import wrap
from asv_env.params import NOMINAL_LENGTH, EnvParams, RewardParams
from asv_env.tasks.formation import Relations
from asv_env.types import Ending, Float, State

SHARED = ("closure", "delivery", "precision", "success", "strayed", "time")
HEADING_WEIGHT = 0.25
"""Way that counts for a turn of the vessel, m/rad at the nominal size."""
SIDEWAYS = 4.0
"""Way that counts for a metre in any direction."""
BELL = (0.08, 0.2)
"""Width of the bell of precision, m at the nominal size and rad."""
NARROW_BELL = (0.02, 0.05)
"""The same of a delivery's accuracy."""
LARGEST_STEP = 1.0
"""Bound on the rise of a potential in one tick."""


def potentials(relations: Relations, state: State, params: EnvParams) -> Float:
    """Potentials (W, 4) of closure, delivery and precision, whose rise is rewarded; accuracy.

    Dimensionless; 0, 0, 1 and 1 where all is done.
    """
    length = params.vessel.length
    size = length / NOMINAL_LENGTH
    off = np.add.reduce(relations.slot_error * state.working, axis=1)
    distance, turn = relations.goal_error, np.abs(relations.heading_error)
    values = np.empty((len(distance), 4))
    values[:, 0] = off / (-length * np.add.reduce(state.working, axis=1))
    values[:, 1] = way(relations, state.side, size) / -length
    for column, (width, angle) in ((2, BELL), (3, NARROW_BELL)):
        bell = np.square(distance / (width * size)) + np.square(turn / angle)
        np.exp(-bell, out=values[:, column])
    return values


def way(relations: Relations, side: Float, size: float) -> Float:
    """Way (W,) in m of the vessel to its goal, where a turn counts as a way too.

    It turns until the goal lies where the team pushes, goes there, and turns to the goal's
    heading. Or, when the goal is near, it moves there as it is, which costs several times the
    distance, and turns. The shorter one counts: a plain distance would call the first turn a step
    back.

    Args:
        relations: of the true motion.
        side: (W,) of the vessel from which the team pushes.
        size: of the vessel, in nominal lengths.
    """
    distance, turn = relations.goal_error, -relations.heading_error
    ahead = relations.goal * (1j * side)
    bearing = np.arctan2(ahead.imag, ahead.real)
    turns = np.abs(bearing) + np.abs(wrap(turn - bearing))
    straight = SIDEWAYS * distance + size * HEADING_WEIGHT * np.abs(turn)
    shortest: Float = np.minimum(distance + size * HEADING_WEIGHT * turns, straight)
    return shortest


def terms(
    before: Float, after: Float, state: State, ending: Ending, params: EnvParams
) -> dict[str, Float]:
    """Weighted terms of one control tick by name, (W, 1) shared or (W, A) of a boat's own.

    Args:
        before: (W, 4) potentials before the tick.
        after: (W, 4) potentials after it.
        state: after the tick.
        ending: after the tick.
        params: the environment's.
    """
    weight, second = params.reward, 1.0 / params.clock.control
    shared = np.empty((len(after), len(SHARED)))
    rise = after[:, :3] - before[:, :3]
    np.minimum(np.maximum(rise, -LARGEST_STEP, out=rise), LARGEST_STEP, out=rise)
    np.multiply(_progress_weights(weight, params.task.name), rise, out=shared[:, :3])
    exact = 0.0 if params.task.name == "approach" else weight.accuracy * (1.0 - after[:, 3])
    shared[:, 3] = weight.success * ending.reached * (1.0 - exact)
    time_lost = weight.time * second * (params.time_limit_ticks - state.tick)
    shared[:, 4] = ending.strayed * (-weight.strayed - time_lost)
    shared[:, 5] = -weight.time * second
    squares = np.add.reduce(np.square(state.thrust), axis=-1)
    named: dict[str, Float] = {name: shared[:, i : i + 1] for i, name in enumerate(SHARED)}
    named["effort"] = squares * (-0.5 * weight.effort * second / params.boat.thrust**2)
    named["collision"] = -weight.collision * second * state.touching[..., 1]
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
