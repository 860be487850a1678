"""What the boats know: the sensors' motion, and the standing that follows from the estimate."""

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np

from asv_env.params import EnvParams
from asv_env.sensing.sensors import Sensors
from asv_env.tasks import standing
from asv_env.tasks.formation import Relations
from asv_env.tasks.standing import Events
from asv_env.types import Float, Sensed, Situation, Standing, State, copied, frozen

SITUATION = tuple(f.name for f in fields(Situation))  #: names of all that is known but motion
STANDING = {f.name for f in fields(Standing)}  #: names of what follows from the estimate
EXACT = tuple(name for name in SITUATION if name not in STANDING)  #: names of the rest


class Knowledge:
    """What the teams of ``num_worlds`` worlds know.

    The standing in ``sensed`` follows from the estimate alone, from the beginning of an episode
    on, by the rules by which the judge decides on the truth. Where the estimate is the truth, both
    are one.
    """

    sensed: Sensed  #: what is known now, read-only
    relations: Relations  #: relations of the estimate, read-only

    def __init__(self, params: EnvParams, state: State, relations: Relations) -> None:
        self._params, self._exact = params, params.sensors.exact
        self._sensors = Sensors(params, len(state.tick))
        self._take(state, relations)

    def reset(
        self,
        index: np.ndarray,
        state: State,
        relations: Relations,
        rngs: Mapping[int, np.random.Generator],
    ) -> None:
        """Begins episodes in the worlds ``index`` (n,) with a true state and its relations."""
        self._sensors.reset(index, state.motion[index], rngs)
        if self._exact:
            self._take(state, relations)
            return
        sensed = copied(Sensed(**{**vars(self.sensed), **self._sensors.delivered()}))
        for name in SITUATION:
            getattr(sensed, name)[index] = getattr(state, name)[index]
        estimate, params = sensed.estimate, self._params
        self.relations = standing.begun(sensed, self.relations, estimate, index, params)
        self.sensed = frozen(sensed)

    def sense(self, motion: Float) -> None:
        """Measures the true motion (W, B, 6) and advances the estimate by one sensing tick."""
        self._sensors.sense(motion)

    def advance(self, state: State) -> Situation:
        """Ends a control tick, in which the true state has become this; returns the situation."""
        if self._exact:
            return state
        before, delivered = self.sensed, self._sensors.delivered()
        self.relations, _, judged = standing.advanced(
            before, delivered["estimate"], self._params.task
        )
        exact = {name: getattr(state, name) for name in EXACT}
        self.sensed = frozen(Sensed(**{**vars(before), **exact, **judged, **delivered}))
        return self.sensed

    def change(self, events: Events | None, state: State, relations: Relations) -> None:
        """Changes roles by events and by the estimate; the true state has changed its own."""
        if self._exact:
            self._take(state, relations)
        else:
            self.sensed, self.relations, _ = standing.changed(
                self.sensed, self.relations, self.sensed.estimate, events, self._params
            )

    def _take(self, state: State, relations: Relations) -> None:
        """Takes the truth for what is known."""
        known = {name: getattr(state, name) for name in SITUATION}
        self.sensed, self.relations = Sensed(**known, **self._sensors.delivered()), relations

    def snapshot(self) -> tuple[Sensed, Relations, dict[str, Any]]:
        """Returns all that changes from tick to tick, for the simulation to copy."""
        return self.sensed, self.relations, self._sensors.snapshot()

    def restore(self, memory: tuple[Sensed, Relations, dict[str, Any]]) -> None:
        """Continues as the knowledge did whose ``snapshot`` this is."""
        self.sensed, self.relations, sensors = memory
        for record in (self.sensed, self.relations):
            frozen(record)
        self._sensors.restore(sensors)
