"""Measurement and estimate: the true motion with white noise, and a Kalman filter of it.

The team shares one measurement, as the paper's boats share one motion-capture system. The
filter is the steady-state Kalman filter of each axis, a pose and its rate, for a hull with random
acceleration of the expected size.

The measurement of a body can be lost; the filter then predicts. Its gain stays that of a filter
that loses none, so after a gap it trusts its prediction more than is best. What is measured and
estimated reaches the boats after the latency; nothing makes up for its age.
"""

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from asv_env.geometry import wrap
from asv_env.params import EnvParams
from asv_env.sensing.kalman import corrected, predicted, steady_gain
from asv_env.types import Bool, Float, copied, frozen, put_rows

BLOCK = 64  #: ticks of noise drawn from a world's Generator at a time
CHANGING = ("_readings", "_noises", "_losses", "_drawn", "_rngs")  #: names of what changes


@dataclass(frozen=True)
class Reading:
    """What a sensing tick yields; its arrays are read-only, as the next tick makes new ones."""

    measured: Float  #: (W, B, 6) the latest measurement that was not lost
    estimate: Float  #: (W, B, 6) the filtered motion
    received: Bool  #: (W, B) whether the measurement is of this tick


class Sensors:
    """Measurement and filter of ``num_worlds`` worlds, each with Generators of its own."""

    def __init__(self, params: EnvParams, num_worlds: int) -> None:
        p, clock = params.sensors, params.clock
        self._params, self._dt, self._exact = p, 1.0 / clock.sensing, p.exact
        #: sensing ticks in a control tick
        self._ticks = 1 if p.exact else clock.sensing // clock.control
        self._noise = np.array(
            [p.position_noise] * 2 + [p.heading_noise] + [p.speed_noise] * 2 + [p.yaw_rate_noise]
        )
        shape = (num_worlds, 1 + params.num_boats)
        self._all = np.ones(shape, dtype=np.bool_)
        blank = frozen(Reading(np.zeros((*shape, 6)), np.zeros((*shape, 6)), self._all))
        # Oldest first: those that a control tick delivers, then those under way.
        size = self._ticks * (1 + p.latency)
        self._readings = deque([blank] * size, maxlen=size)
        self._filters = not p.noiseless or p.dropout > 0.0
        if self._filters:
            vessel = self._axes_gain(p.vessel_acceleration, p.vessel_yaw_acceleration)
            boat = self._axes_gain(p.acceleration, p.yaw_acceleration)
            self._gain = np.stack([vessel] + [boat] * params.num_boats)
            self._noises = np.zeros((num_worlds, BLOCK, *shape[1:], 6))
            self._losses = np.zeros((num_worlds, BLOCK, *shape[1:]), dtype=np.bool_)
            self._drawn = np.full(num_worlds, BLOCK)
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

    def reset(
        self, index: np.ndarray, motion: Float, rngs: Mapping[int, np.random.Generator]
    ) -> None:
        """Begins episodes of the worlds ``index`` (n,) with the motion (W, B, 6) of all.

        The noise of an episode has a Generator of its own, spawned from the world's, so that
        the next episode does not depend on how long this one was; and so have the losses, so that
        the noise is the same with and without them. The first measurement is received at once.
        """
        if self._exact:
            self.sense(motion)
            return
        motion = motion[index]
        if self._filters:
            self._drawn[index] = BLOCK
            for world in map(int, index):
                noise = rngs[world].spawn(1)[0]
                self._rngs[world] = noise, noise.spawn(1)[0]
            motion, _ = self._drawn_at(index, motion)
        for age, reading in enumerate(self._readings):
            begun, received = copied(reading), np.full(motion.shape[:2], age == self._ticks - 1)
            put_rows(begun, index, Reading(motion, motion, received))
            self._readings[age] = frozen(begun)

    def sense(self, motion: Float) -> None:
        """Measures the motion (W, B, 6) and advances the estimate by one sensing tick."""
        if not self._filters:
            self._readings.append(Reading(motion, motion, self._all))
            return
        before = self._readings[-1]
        measured, lost = self._drawn_at(np.arange(len(motion)), motion)
        prediction = predicted(before.estimate, self._dt)
        estimate, _ = corrected(prediction, measured, self._gain)
        received = self._all
        if self._params.dropout:
            prediction[..., 2] = wrap(prediction[..., 2])
            np.copyto(measured, before.measured, where=lost[..., None])
            np.copyto(estimate, prediction, where=lost[..., None])
            received = ~lost
        self._readings.append(frozen(Reading(measured, estimate, received)))

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

    def _axes_gain(self, acceleration: float, yaw_acceleration: float) -> Float:
        """Returns the filter gain (2, 2, 3) of one hull's axes x, y and heading."""
        accelerations = (acceleration, acceleration, yaw_acceleration)
        axes = zip(accelerations, self._noise[:3], self._noise[3:], strict=True)
        return np.stack([steady_gain(*axis, self._dt) for axis in axes], axis=-1)

    def _drawn_at(self, index: np.ndarray, motion: Float) -> tuple[Float, Bool]:
        """Returns the motion (n, B, 6) of the worlds ``index`` (n,) with the noise of a tick.

        The other array, (n, B), tells which measurements of the tick are lost.
        """
        for world in index[self._drawn[index] == BLOCK]:
            noise, loss = self._rngs[int(world)]
            self._noises[world] = noise.standard_normal(self._noises.shape[1:])
            if self._params.dropout:
                self._losses[world] = loss.random(self._losses.shape[1:]) < self._params.dropout
            self._drawn[world] = 0
        tick = index, self._drawn[index]
        noisy, lost = motion + self._noise * self._noises[tick], self._losses[tick]
        self._drawn[index] += 1
        noisy[..., 2] = wrap(noisy[..., 2])
        return noisy, lost
