"""Built-in layouts of obstacles: pillars, a channel, a dock.

Their sizes are numbers of vessel lengths, so that they fit every vessel and team. A layout of one's
own is a function with the same arguments; see ``docs/extend.md``.
"""

import cmath
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from asv_env.checks import Number, Whole, check_fields, interval
from asv_env.memo import by_identity
from asv_env.params import EnvParams
from asv_env.params.obstacle_params import Circle, Polygon, Segment, Shape
from asv_env.tasks import formation
from asv_env.tasks.sampling import between

Pose = tuple[float, ...]  #: x m, y m, heading rad
Size = Annotated[float, Number(0.01, 100.0)]
SizeOrZero = Annotated[float, Number(0.0, 100.0)]
Sizes = Annotated[tuple[float, float], interval(0.01, 100.0)]
TRIES = 100  #: places that are tried for a pillar


@by_identity
def team_reach(params: EnvParams) -> tuple[float, float, float]:
    """Returns how far a team in its slots reaches from the vessel's centre, m.

    The numbers are those along the vessel, ahead (where it is pushed to), and behind.
    """
    vessel, boat = params.vessel, params.boat
    left, right, bottom, top = vessel.extents
    slots = np.array([formation.slots(params, params.num_boats, side) for side in (1.0, -1.0)])
    along = max(right, -left, abs(slots.real).max() + boat.width / 2)
    ahead = max(top, -bottom, boat.length / 2 - slots[0].imag.min())
    return float(along), float(ahead), float(abs(slots.imag).max() + boat.length / 2)


def _point(z: complex) -> tuple[float, float]:
    return z.real, z.imag


def _way(goal: Pose) -> tuple[complex, complex]:
    """Returns the place of a goal, m, and the direction of the way there from the origin."""
    end = complex(*goal[:2])
    return end, cmath.exp(1j * cmath.phase(end)) if end else 1.0


@dataclass(frozen=True)
class Pillars:
    """Round pillars scattered round the straight line from the start to the goal."""

    count: Annotated[int, Whole(1, 100)] = 6
    radius: Sizes = (0.1, 0.25)  #: (smallest, largest), vessel lengths
    gap: SizeOrZero = 0.5  #: smallest width of the water between two of them, vessel lengths
    #: smallest width of the water between them and a team in its slots at the start and at the
    #: goal, vessel lengths
    clear: SizeOrZero = 0.1
    spread: Size = 2.0  #: how far from the line they stand at most, vessel lengths

    def __post_init__(self) -> None:
        check_fields(self)

    def __call__(
        self, params: EnvParams, rng: np.random.Generator, goal: Pose, side: float
    ) -> Sequence[Shape]:
        """Returns the pillars."""
        length, (end, frame) = params.vessel.size, _way(goal)
        along, ahead, behind = team_reach(params)
        apart = math.hypot(along, max(ahead, behind)) + self.clear * length
        spread = self.spread * length
        ends = abs(end) / 2 + spread
        pillars: list[tuple[complex, float]] = []
        for _ in range(self.count):
            radius = length * between(rng, *self.radius)
            for _ in range(TRIES):
                x, y = between(rng, -ends, ends), between(rng, -spread, spread)
                centre = end / 2 + complex(x, y) * frame
                free = min(abs(centre), abs(centre - end)) > apart + radius
                if free and all(
                    abs(centre - c) > radius + r + self.gap * length for c, r in pillars
                ):
                    break
            pillars.append((centre, radius))
        return [Circle(_point(centre), radius) for centre, radius in pillars]


@dataclass(frozen=True)
class Channel:
    """Two banks along the way from the start to the goal, which winds between them."""

    width: Size = 3.5  #: width of the water between the banks, vessel lengths
    bend: SizeOrZero = 0.5  #: how far the middle of the channel moves aside, vessel lengths
    knots: Annotated[int, Whole(1, 50)] = 2  #: number of bends between start and goal
    ends: Size = 3.0  #: length of the channel before the start and after the goal, vessel lengths
    land: Size = 2.5  #: width of a bank, vessel lengths

    def __post_init__(self) -> None:
        check_fields(self)

    def __call__(
        self, params: EnvParams, rng: np.random.Generator, goal: Pose, side: float
    ) -> Sequence[Shape]:
        """Returns the two banks."""
        length, (end, frame) = params.vessel.size, _way(goal)
        before, after = -self.ends * length, abs(end) + self.ends * length
        along = np.concatenate([[before], np.linspace(0.0, abs(end), self.knots + 2), [after]])
        middle = np.zeros(len(along))
        middle[2:-2] = rng.uniform(-self.bend, self.bend, self.knots) * length
        banks = []
        for sign in (1.0, -1.0):
            inner = along + 1j * (middle + sign * self.width / 2 * length)
            across = 1j * sign * (self.width / 2 + self.bend + self.land) * length
            corners = np.array([*inner, after + across, before + across]) * frame
            banks.append(Polygon(tuple(map(_point, corners.tolist()))))
        return banks


@dataclass(frozen=True)
class Dock:
    """A quay and two piers between which the goal lies; the team pushes the vessel to the quay."""

    gap: SizeOrZero = 0.15  #: width of the water between the team and each pier, vessel lengths
    ahead: SizeOrZero = 0.1  #: width of the water between the team and the quay, vessel lengths
    length: Size = 1.0  #: length of the piers, vessel lengths
    thickness: Size = 0.2  #: of the piers and of the quay, vessel lengths

    def __post_init__(self) -> None:
        check_fields(self)

    def __call__(
        self, params: EnvParams, rng: np.random.Generator, goal: Pose, side: float
    ) -> Sequence[Shape]:
        """Returns the quay and the piers."""
        unit, half = params.vessel.size, self.thickness / 2 * params.vessel.size
        along, ahead, _ = team_reach(params)
        x, y = along + self.gap * unit + half, -ahead - self.ahead * unit - half
        x, y = float(x), float(y)
        frame, centre = cmath.exp(1j * goal[2]), complex(*goal[:2])

        def at(u: float, v: float) -> tuple[float, float]:
            return _point(centre + complex(u, side * v) * frame)

        piers = [Segment(at(u, y), at(u, y + self.length * unit), half) for u in (-x, x)]
        return [Segment(at(-x, y), at(x, y), half), *piers]
