"""What a boat observes: one table of features, egocentric and of a size free of the team's.

Everything comes from the estimate in ``Sensed``. Every feature is divided by a fixed scale and
clipped, so that no running statistics are needed. Lengths are in vessel lengths, so that one
policy serves every size; what has to be met to the centimetre appears a second time, magnified.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from asv_env.params import NOMINAL_LENGTH, EnvParams
from asv_env.physics.autopilot import FULL_SPEED, FULL_YAW_RATE
from asv_env.tasks.formation import Relations
from asv_env.types import Bool, Complex, Float, Observation, Sensed

FAR = 15.0
"""Largest distance that an observation tells, vessel lengths: more than the arena's diagonal."""
FAST = 4.0
"""Largest speed that an observation tells, full speeds and full yaw rates of a boat."""
FINE, FINE_ANGLE = 0.1, 0.1
"""Distance, m, and angle, rad, at which the magnified features saturate;
``FINE_SPEED``, m/s, and ``FINE_YAW_RATE``, rad/s, those of the vessel's motion."""
FINE_SPEED, FINE_YAW_RATE = 0.04, 0.15
NEIGHBOURS = 4
NEIGHBOUR_NAMES = ["x", "y", "vx", "vy", "present"]
NEIGHBOUR_BOUNDS = [FAR, FAR, FAST, FAST, 1.0]
VERSION = 2
"""Of what the columns mean: another one wherever a trained policy would be misled."""


@dataclass
class View:
    """The world as the boats see it: what the features are made from.

    Attributes:
        sensed: what was measured.
        relations: of the estimate.
        eyes: (W, A) conjugate directions of the boats; a vector times these is in their frame.
        hull: (W, 1) conjugate direction of the vessel.
        slot: (W, A) from each boat to its slot, in the boat's frame, m.
        ready: (W,) share of the working boats that hold their slots.
        inverse_team: (W,) one over the number of boats that work.
        inverse_length: (1, 1) one over the vessel's length, 1/m.
    """

    sensed: Sensed
    relations: Relations
    eyes: Complex
    hull: Complex
    slot: Complex
    ready: Float
    inverse_team: Float
    inverse_length: Float


@dataclass(frozen=True)
class Feature:
    """A row of the table.

    Attributes:
        name: what is observed.
        scale: by which it is divided; None is the vessel's length.
        bound: to which the scaled values are clipped, on both sides.
        of: from a view to (W, A) or (W, 1), complex for a vector x + iy; SI units.
    """

    name: str
    scale: float | None
    bound: float
    of: Callable[[View], np.ndarray]


VECTORS = (
    Feature("own velocity", FULL_SPEED, FAST, lambda v: v.relations.velocity[:, 1:] * v.eyes),
    Feature("own slot", None, FAR, lambda v: v.slot),
    Feature("own slot, magnified", FINE, 1.0, lambda v: v.slot),
    Feature("own direction against the slot's", 1.0, 1.0, lambda v: v.relations.alignment),
    Feature("own place beside the vessel", None, FAR, lambda v: v.relations.boat),
    Feature("own slot beside the vessel", None, FAR, lambda v: v.sensed.slot),
    Feature("vessel's velocity", FULL_SPEED, FAST, lambda v: v.relations.velocity[:, :1] * v.hull),
    Feature("vessel's goal", None, FAR, lambda v: v.relations.goal[:, None]),
    Feature("vessel's goal, magnified", FINE, 1.0, lambda v: v.relations.goal[:, None]),
    Feature("vessel's goal direction", 1.0, 1.0, lambda v: v.relations.goal_turn[:, None]),
    Feature(
        "vessel's velocity, magnified",
        FINE_SPEED,
        1.0,
        lambda v: v.relations.velocity[:, :1] * v.hull,
    ),
)
SCALARS = (
    Feature("own yaw rate", FULL_YAW_RATE, FAST, lambda v: v.relations.yaw_rate[:, 1:]),
    Feature("vessel's yaw rate", FULL_YAW_RATE, FAST, lambda v: v.relations.yaw_rate[:, :1]),
    Feature("own hull touches the vessel", 1.0, 1.0, lambda v: v.sensed.touching[..., 0]),
    Feature("own hull touches another", 1.0, 1.0, lambda v: v.sensed.touching[..., 1]),
    Feature("own thrusters work", 1.0, 1.0, lambda v: v.sensed.working),
    Feature("share of slots held", 1.0, 1.0, lambda v: v.ready[:, None]),
    Feature("closure formed", 1.0, 1.0, lambda v: v.sensed.closed[:, None]),
    Feature(
        "vessel's turn to go, magnified",
        FINE_ANGLE,
        1.0,
        lambda v: -v.relations.heading_error[:, None],
    ),
    Feature(
        "vessel's yaw rate, magnified",
        FINE_YAW_RATE,
        1.0,
        lambda v: v.relations.yaw_rate[:, :1],
    ),
    Feature("inverse of the team's size", 0.5, 2.0, lambda v: v.inverse_team[:, None]),
    Feature(
        "inverse of the vessel's length", 1.0 / NOMINAL_LENGTH, 4.0, lambda v: v.inverse_length
    ),
)
BOUND = np.array(
    [bound for feature in VECTORS for bound in [feature.bound] * 2]
    + [feature.bound for feature in SCALARS]
    + NEIGHBOUR_BOUNDS * NEIGHBOURS,
    dtype=np.float32,
)
"""(K,) every observation lies within +-BOUND: vectors, scalars, then the nearest boats."""
NAMES = (
    *(f"{feature.name}, {axis}" for feature in VECTORS for axis in "xy"),
    *(feature.name for feature in SCALARS),
    *(f"boat {k + 1} from here, {name}" for k in range(NEIGHBOURS) for name in NEIGHBOUR_NAMES),
)
"""(K,) what the columns of an observation are."""


def observe(sensed: Sensed, relations: Relations, holds: Bool, params: EnvParams) -> Observation:
    """Observations (W, A, K) of all boats, float32, within +-``BOUND``.

    Args:
        sensed: what the boats measure.
        relations: of ``sensed.estimate``.
        holds: (W, A) whether each boat holds its slot, by these relations.
        params: the environment's.
    """
    heading, length = relations.heading, params.vessel.length
    eyes = heading[:, 1:].conj()
    slot = relations.slot_gap * (heading[:, :1] * eyes)
    working = np.add.reduce(sensed.working, axis=1)
    ready = np.add.reduce(holds & sensed.working, axis=1) / working
    sizes = 1.0 / working, np.full((1, 1), 1.0 / length)
    view = View(sensed, relations, eyes, heading[:, :1].conj(), slot, ready, *sizes)

    values = np.zeros((*sensed.slot.shape, len(BOUND)))
    vectors = values[..., : 2 * len(VECTORS)].view(np.complex128)
    for column, feature in enumerate(VECTORS):
        vectors[..., column] = feature.of(view)
    for column, feature in enumerate(SCALARS, 2 * len(VECTORS)):
        values[..., column] = feature.of(view)
    _put_neighbours(view, values[..., -len(NEIGHBOUR_NAMES) * NEIGHBOURS :])
    values *= _per_scale(length)
    # Two passes of these take less time than one of clip.
    np.maximum(values, -BOUND, out=values)
    return np.minimum(values, BOUND, dtype=np.float32, casting="same_kind")


@lru_cache(maxsize=8)
def _per_scale(length: float) -> Float:
    """(K,) what the columns are multiplied by, for a vessel of this length, m."""
    features = [feature for feature in VECTORS for _ in "xy"] + list(SCALARS)
    scales = [feature.scale or length for feature in features]
    scales += [length, length, FULL_SPEED, FULL_SPEED, 1.0] * NEIGHBOURS
    return 1.0 / np.array(scales)


def _put_neighbours(view: View, values: Float) -> None:
    """The nearest boats, near to far: x, y, vx, vy in the boat's frame, presence; or zeros."""
    position, velocity = view.relations.position[:, 1:], view.relations.velocity[:, 1:]
    worlds, team = position.shape
    count = min(NEIGHBOURS, team - 1)
    distance = np.abs(position[:, None, :] - position[:, :, None]) + _itself(team)
    nearest = _smallest(distance, count) + _first_boats(worlds, team)
    seen = values.reshape(worlds, team, NEIGHBOURS, 5)[:, :, :count]
    vectors = seen[..., :4].view(np.complex128)
    eyes = view.eyes[..., None]
    np.multiply(position.ravel().take(nearest) - position[..., None], eyes, out=vectors[..., 0])
    np.multiply(velocity.ravel().take(nearest) - velocity[..., None], eyes, out=vectors[..., 1])
    seen[..., 4] = 1.0


@lru_cache(maxsize=8)
def _itself(team: int) -> Float:
    """(A, A) infinite on the diagonal: nobody is his own neighbour."""
    return np.where(np.eye(team, dtype=bool), np.inf, 0.0)


@lru_cache(maxsize=8)
def _first_boats(worlds: int, team: int) -> np.ndarray:
    """(W, 1, 1) row of each world's first boat among all boats."""
    return (team * np.arange(worlds))[:, None, None]


def _smallest(values: Float, count: int) -> np.ndarray:
    """Indices of the ``count`` smallest along the last axis, in ascending order of value."""
    if values.shape[-1] > 4 * count:
        some = np.argpartition(values, count, axis=-1)[..., :count]
        order = np.argsort(np.take_along_axis(values, some, axis=-1), axis=-1, kind="stable")
        return np.take_along_axis(some, order, axis=-1)
    return values.argsort(axis=-1, kind="stable")[..., :count]
