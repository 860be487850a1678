"""What the boats know: the sensors' motion, and the standing that follows from the estimate."""

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np

from asv_env.params import EnvParams
from asv_env.sensing.sensors import Sensors
from asv_env.tasks import standing
from asv_env.tasks.standing import Events
from asv_env.types import (
    Bool,
    Float,
    Sensed,
    Situation,
    Standing,
    State,
    copied,
    frozen,
    made,
)

SITUATION = tuple(f.name for f in fields(Situation))  #: names of all that is known but motion
STANDING = {f.name for f in fields(Standing)}  #: names of what follows from the estimate
CONSTANT = {"side", "obstacle"}  #: names of what stays as it is through an episode
EXACT = tuple(name for name in SITUATION if name not in STANDING | CONSTANT)
"""Names of the rest, which is known exactly."""


class Knowledge:
    """What the teams of ``num_worlds`` worlds know.

    The standing in ``sensed`` follows from the estimate alone, from the beginning of an episode
    on, by the rules by which the judge decides on the truth. Where the estimate is the truth, both
    are one.

    Boats with sensors of their own each judge for themselves. Each tells the others by radio
    whether its thrusters work and what it touches, and is heard as far as it is seen: the last
    report counts, and what an unseen boat touches is unknown, so nothing.
    """

    sensed: Sensed  #: what is known now, read-only

    def __init__(self, params: EnvParams, state: State, num_threads: int) -> None:
        self._params, self._exact = params, params.sensors.exact
        self._num_threads = num_threads
        self._sensors = Sensors(params, len(state.tick), num_threads)
        self._shared = params.sensors.shared
        team = np.arange(params.num_boats)
        #: (V, A) whether a boat is the observer itself, who needs no report
        self._own = np.tile(np.equal.outer(team, team), (len(state.tick), 1))
        self._misassigned = np.zeros(len(self._sensors.of_each(state.tick)), dtype=np.bool_)
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
        rows = self._sensors.rows(index)
        for name in SITUATION:
            getattr(sensed, name)[rows] = self._sensors.of_each(getattr(state, name)[index])
        standing.begun(sensed, sensed.estimate, rows, self._params)
        self._misassigned[rows] = False
        self.sensed = frozen(sensed)

    def sense(self, motion: Float) -> None:
        """Measures the true motion (W, B, 6) and advances the estimate by one sensing tick."""
        self._sensors.sense(motion)

    def advance(self, state: State) -> tuple[Bool, Float]:
        """Ends a control tick, in which the true state has become this.

        Returns:
            Which teams believe to be in closure (W,), and the motion that they believe the vessel
            to have (W, 6). Of boats with sensors of their own the first one that works decides.
        """
        if self._exact:
            return state.closed, state.motion[:, 0]
        before, delivered = self.sensed, self._sensors.delivered()
        now = standing.advanced(before, delivered["estimate"], self._params, self._num_threads)
        self._misassigned = now.misassigned
        judged = {"occupied": now.occupied, "closed": now.closed}
        exact = {name: self._sensors.of_each(getattr(state, name)) for name in EXACT}
        if not self._shared:
            exact |= self._reports(exact, delivered)
        self.sensed = frozen(Sensed(**{**vars(before), **exact, **judged, **delivered}))
        leader = slice(None)
        if not self._shared:
            team = self._params.num_boats
            leader = np.arange(len(state.tick)) * team + state.working.argmax(axis=1)
        return self.sensed.closed[leader], self.sensed.estimate[leader, 0]

    def _heard(self, received: Bool) -> Bool:
        """Returns whose reports (V, A) are heard where measurements (V, B) are received."""
        return received[:, 1:] | self._own

    def _reports(self, exact: Mapping[str, Any], delivered: Mapping[str, Any]) -> dict[str, Any]:
        """Returns what boats know of thrusters (V, A) and contacts (V, A, 2).

        Thrusters fail at the end of a tick, of which ``change`` tells.
        """
        heard, seen = self._heard(delivered["received"]), delivered["seen"][:, 1:]
        last = self.sensed.touching & (seen | self._own)[..., None]
        touching = np.where(heard[..., None], exact["touching"], last)
        return {"working": self.sensed.working, "touching": touching}

    def change(self, events: Events | None, state: State) -> None:
        """Changes roles by events and by the estimate; the true state has changed its own."""
        if self._exact:
            self._take(state)
            return
        if events is not None and not self._shared:
            events = self._as_known(events)
        now = self.sensed, self.sensed.estimate, self._misassigned
        self.sensed, _ = standing.changed(*now, events, self._params)

    def _as_known(self, events: Events) -> Events:
        """Returns the events of the worlds as their boats learn of them."""
        each = {name: self._sensors.of_each(value) for name, value in vars(events).items()}
        known, heard = self.sensed.working, self._heard(self.sensed.received)
        working = np.where(heard, each["working"], known)
        return Events(**{**each, "working": working, "assigns": (working != known).any(axis=1)})

    def _take(self, state: State) -> None:
        """Takes the truth for what is known."""
        known = {name: self._sensors.of_each(getattr(state, name)) for name in SITUATION}
        self.sensed = made(Sensed, {**known, **self._sensors.delivered()})
        if not self._shared:
            frozen(self.sensed)

    def snapshot(self) -> tuple[Any, ...]:
        """Returns all that changes from tick to tick, for the simulation to copy."""
        return self.sensed, self._misassigned, self._sensors.snapshot()

    def restore(self, memory: tuple[Any, ...]) -> None:
        """Continues as the knowledge did whose ``snapshot`` this is."""
        self.sensed, self._misassigned, sensors = memory
        frozen(self.sensed)
        self._sensors.restore(sensors)
