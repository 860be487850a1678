"""Measurement and estimate: the true motion with white noise, and a Kalman filter of it.

By default the team shares one measurement, as the paper's boats share one motion-capture system.
With ``SensorParams.shared=False`` every boat is an observer of its own: its measurement of each
body has its own noise and its own losses, and bodies farther away than the range are unseen. The
axis of the observers is part of that of the worlds: row w A + a is what boat a of world w knows.

The filter is the steady-state Kalman filter of each axis, a pose and its rate, for a hull with
random acceleration of the expected size.

The measurement of a body can be lost; the filter then predicts. Its gain stays that of a filter
that loses none, so after a gap it trusts its prediction more than is best. What is measured and
estimated reaches the boats after the delay; nothing makes up for its age.
"""

import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from asv_env.params import EnvParams
from asv_env.sensing.kalman import steady_gain
from asv_env.sensing.measurement import Chance, Filter, Past, advance, measure
from asv_env.threads import spread
from asv_env.types import Bool, Float, Int, copied, frozen, given, put_rows

BLOCK = 64  #: measurements of a body for which noise is drawn from a world's Generator at a time
FADING = 2.0  #: time constant by which the believed rates of an unseen body fade, s at nominal size
CHANGING = ("_readings", "_noises", "_losses", "_drawn", "_rngs")  #: names of what changes


@dataclass(frozen=True)
class Reading:
    """What a sensing tick yields; its arrays are read-only, as the next tick makes new ones.

    V is the number of observers: that of the worlds, or of all boats of all worlds.
    """

    measured: Float  #: (V, B, 6) the latest measurement that was received
    estimate: Float  #: (V, B, 6) the filtered motion
    received: Bool  #: (V, B) whether the measurement is of this tick
    seen: Bool  #: (V, B) whether the body is in sight, as far as is known


class Sensors:
    """Measurement and filter of ``num_worlds`` worlds, each with Generators of its own.

    V observers: one for each world, or each boat.
    """

    def __init__(self, params: EnvParams, num_worlds: int, num_threads: int) -> None:
        p, clock = params.sensors, params.clock
        self._params, self._exact, self._num_threads = p, p.exact, num_threads
        #: sensing ticks in a control tick
        self._ticks = 1 if p.exact else clock.sensing // clock.control
        self._noise = np.array(
            [p.position_noise] * 2 + [p.heading_noise] + [p.speed_noise] * 2 + [p.yaw_rate_noise]
        )
        bodies = 1 + params.num_boats
        self.observers = 1 if p.shared else params.num_boats  #: of each world
        shape = (num_worlds * self.observers, bodies)
        self._all = np.ones(shape, dtype=np.bool_)
        self._all.setflags(write=False)
        still = np.zeros((*shape, 6))
        blank = frozen(Reading(still, still, self._all, self._all))
        # Oldest first: those that a control tick delivers, then those under way.
        size = self._ticks * (1 + clock.ticks(p.delay))
        self._readings = deque([blank] * size, maxlen=size)
        self._filters = not p.noiseless or p.dropout > 0.0 or p.range is not None
        if self._filters:
            dt = 1.0 / clock.sensing
            vessel = self._axes_gain(p.vessel_acceleration, p.vessel_yaw_acceleration, dt)
            boat = self._axes_gain(p.acceleration, p.yaw_acceleration, dt)
            keep = math.exp(-dt / (FADING * math.sqrt(params.scale)))
            gain = np.stack([vessel] + [boat] * params.num_boats)
            self._rules = Filter(given(gain), dt, keep)
            block = max(1, BLOCK // self.observers)
            drawn = (num_worlds, block, self.observers, bodies)
            self._noises = np.zeros((*drawn, 6))
            self._losses = np.zeros(drawn, dtype=np.bool_)
            self._drawn = np.full(num_worlds, block)
            #: Generators of noise and of losses, by world
            self._rngs: dict[int, tuple[np.random.Generator, np.random.Generator]] = {}

    def snapshot(self) -> dict[str, Any]:
        """Returns all that changes from tick to tick by name, for the simulation to copy."""
        return {name: vars(self)[name] for name in CHANGING if name in vars(self)}

    def restore(self, memory: dict[str, Any]) -> None:
        """Continues as the sensors did whose ``snapshot`` this is."""
        vars(self).update(memory)
        for reading in self._readings:
            frozen(reading)

    def of_each(self, values: Any) -> Any:
        """Returns values (n, ...) of worlds as those (n observers, ...) of their observers."""
        return values if self.observers == 1 else np.repeat(values, self.observers, axis=0)

    def rows(self, index: np.ndarray) -> np.ndarray:
        """Returns the numbers (n observers,) of the observers of some worlds (n,)."""
        first = self.observers * np.asarray(index)[:, None]
        return (first + np.arange(self.observers)).reshape(-1)

    def reset(
        self, index: np.ndarray, motion: Float, rngs: Mapping[int, np.random.Generator]
    ) -> None:
        """Begins episodes of the worlds ``index`` (n,) with the motion (W, B, 6) of all.

        The noise of an episode has a Generator of its own, spawned from the world's, so that
        the next episode does not depend on how long this one was; and so have the losses, so that
        the noise is the same with and without them. The first measurement is received at once: it
        is one of all bodies, which every observer hears.
        """
        if self._exact:
            self.sense(motion)
            return
        first = motion[index]
        if self._filters:
            self._drawn[index] = self._noises.shape[1]
            for world in map(int, index):
                noise = rngs[world].spawn(1)[0]
                self._rngs[world] = noise, noise.spawn(1)[0]
            first = self._measured(index, motion)[0][:: self.observers]
        first, rows = self.of_each(first), self.rows(index)
        seen = np.ones(first.shape[:2], dtype=np.bool_)
        for age, reading in enumerate(self._readings):
            begun, received = copied(reading), seen & (age == self._ticks - 1)
            put_rows(begun, rows, Reading(first, first, received, seen))
            self._readings[age] = frozen(begun)

    def sense(self, motion: Float) -> None:
        """Measures the motion (W, B, 6) and advances the estimate by one sensing tick."""
        if not self._filters:
            known = self.of_each(motion)
            known.setflags(write=False)
            self._readings.append(Reading(known, known, self._all, self._all))
            return
        last = self._readings[-1]
        before = Past(last.measured, last.estimate, last.seen)
        measured, outcome = self._measured(np.arange(len(motion)), motion)
        after = np.empty_like(measured)
        received, seen = np.empty_like(self._all), np.empty_like(self._all)
        found = after, received, seen

        def run(first: int, last: int, thread: int) -> None:
            advance(first, last, before, measured, outcome, self._rules, *found)

        spread(run, len(measured), self._num_threads)
        self._readings.append(frozen(Reading(measured, *found)))

    def delivered(self) -> dict[str, Any]:
        """Returns the fields of ``Reading``, as they reach the boats with a control tick.

        A measurement is received if one of those since the previous control tick was.
        """
        if self._ticks == 1:
            return vars(self._readings[0])
        since = [self._readings[age] for age in range(self._ticks)]
        received = np.logical_or.reduce([reading.received for reading in since])
        received.setflags(write=False)
        return {**vars(since[-1]), "received": received}

    def _axes_gain(self, acceleration: float, yaw_acceleration: float, dt: float) -> Float:
        """Returns the filter gain (2, 2, 3) of one hull's axes x, y and heading."""
        accelerations = (acceleration, acceleration, yaw_acceleration)
        axes = zip(accelerations, self._noise[:3], self._noise[3:], strict=True)
        return np.stack([steady_gain(*axis, dt) for axis in axes], axis=-1)

    def _measured(self, index: np.ndarray, motion: Float) -> tuple[Float, Int]:
        """Returns the measurements (n observers, B, 6) of a tick in the worlds ``index`` (n,).

        The motion (W, B, 6) is that of all worlds. The other array, (n observers, B), tells what
        becomes of the measurements.
        """
        self._draw(index[self._drawn[index] == self._noises.shape[1]])
        shape = (len(index) * self.observers, self._noises.shape[3])
        measured, outcome = np.empty((*shape, 6)), np.empty(shape, dtype=np.int64)
        reach = math.inf if self._params.range is None else self._params.range
        chance = Chance(given(self._noises), given(self._losses, np.bool_), self._drawn)
        known = given(index, np.int64), given(motion), given(self._noise), reach, chance

        def run(first: int, last: int, thread: int) -> None:
            measure(first, last, *known, measured, outcome)

        spread(run, len(index), self._num_threads)
        self._drawn[index] += 1
        return measured, outcome

    def _draw(self, index: np.ndarray) -> None:
        """Draws the random numbers of the next measurements in the worlds ``index`` (n,)."""
        for world in map(int, index):
            noise, loss = self._rngs[world]
            if not self._params.noiseless:
                noise.standard_normal(out=self._noises[world])
            if self._params.dropout:
                self._losses[world] = loss.random(self._losses.shape[1:]) < self._params.dropout
        self._drawn[index] = 0
