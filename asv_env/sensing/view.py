"""The world as the boats see it, from which features are computed; the nearest boats among it."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Self

import numpy as np

from asv_env.params import EnvParams
from asv_env.tasks.formation import Relations
from asv_env.types import Bool, Complex, Float, Sensed

NEIGHBOURS = 4  #: number of boats that a boat observes


@dataclass
class View:
    """What features are computed from."""

    sensed: Sensed  #: what the boats measure
    relations: Relations  #: relations of the estimate
    to_boat: Complex  #: (W, A) factors that turn vectors of the world into the boats' frames
    to_vessel: Complex  #: (W, 1) factors that turn vectors of the world into the vessel's frame
    slot: Complex  #: (W, A) vector from each boat to its slot, in the boat's frame, m
    slots_occupied: Float  #: (W,) fraction of the working boats that occupy their slots
    inverse_team: Float  #: (W,) one over the number of working boats
    inverse_length: Float  #: (1, 1) one over the vessel's length, 1/m

    @classmethod
    def of(cls, sensed: Sensed, relations: Relations, occupied: Bool, params: EnvParams) -> Self:
        """Returns the view of all boats; see ``observation.observe``."""
        heading = relations.heading
        to_boat = heading[:, 1:].conj()
        working = np.add.reduce(sensed.working, axis=1)
        return cls(
            sensed,
            relations,
            to_boat,
            heading[:, :1].conj(),
            relations.slot_gap * (heading[:, :1] * to_boat),
            np.add.reduce(occupied & sensed.working, axis=1) / working,
            1.0 / working,
            np.full((1, 1), 1.0 / params.vessel.length),
        )


def nearest_boats(view: View) -> Float:
    """Returns the nearest boats, near to far, (W, A, 5 NEIGHBOURS).

    Each has x, y (m), vx, vy (m/s) in the frame of the boat that observes, and 1 for its presence;
    zeros where the team has no more boats.
    """
    position, velocity = view.relations.position[:, 1:], view.relations.velocity[:, 1:]
    worlds, team = position.shape
    count = min(NEIGHBOURS, team - 1)
    distance = np.abs(position[:, None, :] - position[:, :, None]) + _not_itself(team)
    nearest = _smallest(distance, count) + _first_boats(worlds, team)
    values = np.zeros((worlds, team, NEIGHBOURS, 5))
    seen = values[:, :, :count]
    vectors = seen[..., :4].view(np.complex128)
    to_boat = view.to_boat[..., None]
    np.multiply(position.ravel().take(nearest) - position[..., None], to_boat, out=vectors[..., 0])
    np.multiply(velocity.ravel().take(nearest) - velocity[..., None], to_boat, out=vectors[..., 1])
    seen[..., 4] = 1.0
    return values.reshape(worlds, team, 5 * NEIGHBOURS)


@lru_cache(maxsize=8)
def _not_itself(team: int) -> Float:
    """Returns (A, A) infinity on the diagonal, so that no boat is its own neighbour."""
    return np.where(np.eye(team, dtype=bool), np.inf, 0.0)


@lru_cache(maxsize=8)
def _first_boats(worlds: int, team: int) -> np.ndarray:
    """Returns (W, 1, 1) the row of each world's first boat among all boats."""
    return (team * np.arange(worlds))[:, None, None]


def _smallest(values: Float, count: int) -> np.ndarray:
    """Returns the indices of the ``count`` smallest along the last axis, in ascending order."""
    if values.shape[-1] > 4 * count:
        some = np.argpartition(values, count, axis=-1)[..., :count]
        order = np.argsort(np.take_along_axis(values, some, axis=-1), axis=-1, kind="stable")
        return np.take_along_axis(some, order, axis=-1)
    return values.argsort(axis=-1, kind="stable")[..., :count]
