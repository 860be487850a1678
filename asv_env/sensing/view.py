"""The world as the boats see it, from which features are computed."""

from functools import cached_property

import numpy as np

from asv_env.params import EnvParams
from asv_env.sensing.feature_table import hull, table
from asv_env.tasks.formation import Relations, relate
from asv_env.types import Complex, Float, Sensed, frozen


class View:
    """What features are computed from; see ``observation.observe``."""

    def __init__(self, sensed: Sensed, params: EnvParams) -> None:
        self.sensed = sensed  #: what the boats know
        self._params = params

    @cached_property
    def columns(self) -> Float:
        """Columns (W, A, n) of the built-in features, see ``feature_table``."""
        return table(self.sensed, self._params)

    @cached_property
    def relations(self) -> Relations:
        """Relations of the estimate."""
        seen = self.sensed
        return frozen(relate(seen.estimate, seen.goal, seen.slot, seen.side))

    @cached_property
    def to_boat(self) -> Complex:
        """Factors (W, A) that turn vectors of the world into the boats' frames."""
        return self.relations.heading[:, 1:].conj()

    @cached_property
    def to_vessel(self) -> Complex:
        """Factors (W, 1) that turn vectors of the world into the vessel's frame."""
        return self.relations.heading[:, :1].conj()

    @cached_property
    def slot(self) -> Complex:
        """Vector (W, A) from each boat to its slot, in the boat's frame, m."""
        return self.relations.slot_gap * (self.to_boat / self.to_vessel)

    @cached_property
    def slots_occupied(self) -> Float:
        """Fraction (W,) of the working boats that occupy their slots."""
        held = np.add.reduce(self.sensed.occupied & self.sensed.working, axis=1)
        return held * self.inverse_team

    @cached_property
    def inverse_team(self) -> Float:
        """One over the number of working boats (W,)."""
        inverse: Float = 1.0 / np.add.reduce(self.sensed.working, axis=1)
        return inverse

    @cached_property
    def inverse_length(self) -> Float:
        """One over the vessel's size (1, 1), 1/m."""
        return np.full((1, 1), hull(self._params).inverse_length)
