"""The world as the boats see it, from which features are computed; the nearest boats among it."""

from functools import lru_cache

import numpy as np

from asv_env.params import EnvParams
from asv_env.tasks.formation import Relations
from asv_env.types import Float, Sensed

NEIGHBOURS = 4  #: number of boats that a boat observes


class View:
    """What features are computed from; see ``observation.observe``."""

    def __init__(self, sensed: Sensed, relations: Relations, params: EnvParams) -> None:
        heading, working = relations.heading, np.add.reduce(sensed.working, axis=1)
        self.sensed = sensed  #: what the boats know
        self.relations = relations  #: relations of the estimate
        #: (W, A) and (W, 1) factors that turn vectors of the world into the hulls' frames
        self.to_boat, self.to_vessel = heading[:, 1:].conj(), heading[:, :1].conj()
        #: (W, A) vector from each boat to its slot, in the boat's frame, m
        self.slot = relations.slot_gap * (heading[:, :1] * self.to_boat)
        #: (W,) fraction of the working boats that occupy their slots
        self.slots_occupied: Float = (
            np.add.reduce(sensed.occupied & sensed.working, axis=1) / working
        )
        self.inverse_team: Float = 1.0 / working  #: (W,) one over the number of working boats
        self.inverse_length = np.full((1, 1), 1.0 / params.vessel.length)  #: 1/m


def nearest_boats(view: View) -> Float:
    """Returns the nearest boats, near to far, (W, A, 5 NEIGHBOURS).

    Each has x, y (m), vx, vy (m/s) in the frame of the boat that observes, and 1 for its presence;
    zeros where the team has no more boats.
    """
    position, velocity = view.relations.position[:, 1:], view.relations.velocity[:, 1:]
    worlds, team = position.shape
    count = min(NEIGHBOURS, team - 1)
    distance = np.abs(position[:, None, :] - position[:, :, None]) + _not_itself(team)
    nearest = _smallest(distance, count) + (team * np.arange(worlds))[:, None, None]
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
    distance = np.where(np.eye(team, dtype=bool), np.inf, 0.0)
    distance.setflags(write=False)
    return distance


def _smallest(values: Float, count: int) -> np.ndarray:
    """Returns the indices of the ``count`` smallest along the last axis, in ascending order."""
    if values.shape[-1] > 4 * count:
        some = np.argpartition(values, count, axis=-1)[..., :count]
        order = np.argsort(np.take_along_axis(values, some, axis=-1), axis=-1, kind="stable")
        return np.take_along_axis(some, order, axis=-1)
    return values.argsort(axis=-1, kind="stable")[..., :count]
