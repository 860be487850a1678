"""The world as the boats see it: the quantities from which features are computed."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from asv_env.params import EnvParams
from asv_env.tasks.formation import Relations
from asv_env.types import Bool, Complex, Float, Sensed


@dataclass
class View:
    """What features are computed from.

    Attributes:
        sensed: What the boats measure.
        relations: Relations of the estimate.
        to_boat: (W, A) factors that turn vectors of the world into the boats' frames.
        to_vessel: (W, 1) factors that turn vectors of the world into the vessel's frame.
        slot: (W, A) vector from each boat to its slot, in the boat's frame, m.
        slots_occupied: (W,) fraction of the working boats that occupy their slots.
        inverse_team: (W,) one over the number of working boats.
        inverse_length: (1, 1) one over the vessel's length, 1/m.
    """

    sensed: Sensed
    relations: Relations
    to_boat: Complex
    to_vessel: Complex
    slot: Complex
    slots_occupied: Float
    inverse_team: Float
    inverse_length: Float

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
