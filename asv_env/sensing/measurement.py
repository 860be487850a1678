"""Laws of sensing: what becomes of a measurement, and what an observer knows after a tick."""

from typing import NamedTuple

import numpy as np

from asv_env.compiled import allocating, compiled
from asv_env.geometry import wrapped
from asv_env.sensing.kalman import correct, predict
from asv_env.types import Bool, Float, Int

RECEIVED, LOST, UNSEEN = range(3)
"""What becomes of a measurement."""


class Chance(NamedTuple):
    """Random numbers of the measurements, T of each body at a time; read-only."""

    noise: Float  #: (W, T, observers, B, 6) standard normal
    lost: Bool  #: (W, T, observers, B) whether a measurement is lost
    tick: Int  #: (W,) number of the next one, below T


class Filter(NamedTuple):
    """How a measurement corrects an estimate."""

    gain: Float  #: (B, 2, 2, 3) of each body, see ``kalman.correct``
    dt: float  #: duration of a sensing tick, s
    keep: float  #: factor on the rates of an unseen body at each tick


@compiled
def sees(motion: Float, observer: int, body: int, reach: float) -> bool:
    """Returns whether a body of a motion (B, 6) is within reach, m, of another one."""
    x, y = motion[body, 0] - motion[observer, 0], motion[body, 1] - motion[observer, 1]
    return x * x + y * y <= reach * reach


@compiled
def measure(
    first: int,
    last: int,
    worlds: Int,
    motion: Float,
    deviation: Float,
    reach: float,
    chance: Chance,
    measured: Float,
    outcome: Int,
) -> None:
    """Writes the measurements of some worlds, and what becomes of them.

    Args:
        first: place of the first world in ``worlds``.
        last: place after that of the last one.
        worlds: (n,) numbers of the worlds.
        motion: (W, B, 6) true motion.
        deviation: (6,) standard deviations of the noise.
        reach: distance within which an observer sees, m.
        chance: random numbers.
        measured: (n observers, B, 6) measurements.
        outcome: (n observers, B) ``RECEIVED``, ``LOST`` or ``UNSEEN``.
    """
    observers, bodies = chance.lost.shape[2:]
    for place in range(first, last):
        world = worlds[place]
        now, tick = motion[world], chance.tick[world]
        for observer in range(observers):
            row = place * observers + observer
            for body in range(bodies):
                own = observers > 1 and body == observer + 1
                for k in range(6):
                    noise = chance.noise[world, tick, observer, body, k]
                    measured[row, body, k] = now[body, k] + deviation[k] * noise
                measured[row, body, 2] = wrapped(measured[row, body, 2])
                outcome[row, body] = RECEIVED
                if chance.lost[world, tick, observer, body] and not own:
                    outcome[row, body] = LOST
                elif observers > 1 and not sees(now, observer + 1, body, reach):
                    outcome[row, body] = UNSEEN


class Past(NamedTuple):
    """Fields of the ``Reading`` before a tick, read-only."""

    measured: Float
    estimate: Float
    seen: Bool


@allocating
def advance(
    first: int,
    last: int,
    before: Past,
    measured: Float,
    outcome: Int,
    rules: Filter,
    after: Float,
    received: Bool,
    seen: Bool,
) -> None:
    """Writes what some observers know after a tick, from what they knew and have measured.

    A body that comes into sight is known by its measurement alone; the believed rates of one that
    is unseen fade. A lost measurement does not tell whether its body is in sight.

    Args:
        first: number of the first observer.
        last: number after that of the last one.
        before: what they knew.
        measured: (V, B, 6) measurements; where none was received, the one before takes its place.
        outcome: (V, B) what has become of them.
        rules: how they correct the estimate.
        after: (V, B, 6) estimate.
        received: (V, B) as in ``Reading``.
        seen: (V, B) as in ``Reading``.
    """
    innovation = np.empty(6)
    for row in range(first, last):
        for body in range(measured.shape[1]):
            motion, now = after[row, body], measured[row, body]
            came, sighted = outcome[row, body] == RECEIVED, before.seen[row, body]
            predict(before.estimate[row, body], rules.dt, motion)
            if came and sighted:
                correct(motion, now, rules.gain[body], motion, innovation)
            elif came:
                motion[:] = now
            else:
                motion[2] = wrapped(motion[2])
                now[:] = before.measured[row, body]
            in_sight = came or (sighted and outcome[row, body] == LOST)
            received[row, body], seen[row, body] = came, in_sight
            if not in_sight:
                motion[3:] *= rules.keep
