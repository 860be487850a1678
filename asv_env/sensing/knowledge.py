"""What the boats know: the sensors' motion, and the standing that follows from the estimate."""

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np

from asv_env.params import EnvParams
from asv_env.sensing.sensors import Sensors
from asv_env.tasks import standing
from asv_env.tasks.standing import Events
from asv_env.types import Float, Sensed, Situation, Standing, State, copied, frozen, made

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

    def __init__(self, params: EnvParams, state: State, num_threads: int) -> None:
        self._params, self._exact = params, params.sensors.exact
        self._num_threads = num_threads
        self._sensors = Sensors(params, len(state.tick))
        self._misassigned = np.zeros(len(state.tick), dtype=np.bool_)
        self._take(state)

    def reset(
        self,
        index: np.ndarray,
        state: State,
        rngs: Mapping[int, np.random.Generator],
    ) -> None:
        """Begins episodes in the worlds ``index`` (n,) of a true state."""
        self._sensors.reset(index, state.motion, rngs)
        if self._exact:
            self._take(state)
            return
        sensed = copied(Sensed(**{**vars(self.sensed), **self._sensors.delivered()}))
        for name in SITUATION:
            getattr(sensed, name)[index] = getattr(state, name)[index]
        standing.begun(sensed, sensed.estimate, index, self._params)
        self._misassigned[index] = False
        self.sensed = frozen(sensed)

    def sense(self, motion: Float) -> None:
        """Measures the true motion (W, B, 6) and advances the estimate by one sensing tick."""
        self._sensors.sense(motion)

    def advance(self, state: State) -> tuple[Situation, Float]:
        """Ends a control tick, in which the true state has become this.

        Returns:
            The situation as it is known, and the estimate (W, B, 6).
        """
        if self._exact:
            return state, state.motion
        before, delivered = self.sensed, self._sensors.delivered()
        now = standing.advanced(before, delivered["estimate"], self._params, self._num_threads)
        self._misassigned = now.misassigned
        judged = {"occupied": now.occupied, "closed": now.closed}
        exact = {name: getattr(state, name) for name in EXACT}
        self.sensed = frozen(Sensed(**{**vars(before), **exact, **judged, **delivered}))
        return self.sensed, self.sensed.estimate

    def change(self, events: Events | None, state: State) -> None:
        """Changes roles by events and by the estimate; the true state has changed its own."""
        if self._exact:
            self._take(state)
        else:
            now = self.sensed, self.sensed.estimate, self._misassigned
            self.sensed, _ = standing.changed(*now, events, self._params)

    def _take(self, state: State) -> None:
        """Takes the truth for what is known."""
        known = {name: getattr(state, name) for name in SITUATION}
        self.sensed = made(Sensed, {**known, **self._sensors.delivered()})

    def snapshot(self) -> tuple[Any, ...]:
        """Returns all that changes from tick to tick, for the simulation to copy."""
        return self.sensed, self._misassigned, self._sensors.snapshot()

    def restore(self, memory: tuple[Any, ...]) -> None:
        """Continues as the knowledge did whose ``snapshot`` this is."""
        self.sensed, self._misassigned, sensors = memory
        frozen(self.sensed)
        self._sensors.restore(sensors)
