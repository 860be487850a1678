"""The numbers that a boat sees: those of itself and its task, and those of an item of each set.

Vectors are in the frame of the boat's contact point, whose x-axis is the direction in which the
boat is to point there, unless they say otherwise. So nothing depends on the world's frame, on which
end of the hull is its bow, or on where the boat points now, which is seen once. Lengths are those
of the nominal world. Each number is divided by a unit and clipped; what must be met to the
centimetre appears a second time, magnified.
"""

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

from asv_env.params import NOMINAL_LENGTH
from asv_env.types import Float

FINE, FINE_SPEED = 0.05, 0.02  #: where magnified lengths, m, and speeds, m/s, saturate
FINE_ANGLE, FINE_YAW_RATE = 0.1, 0.1  #: the same of angles, rad, and yaw rates, rad/s
SPEED, YAW_RATE = 0.1, 0.5  #: units of speeds, m/s, and yaw rates, rad/s
FAR, FAST = 10.0, 5.0  #: bounds of lengths and of rates in their units


class Seen(NamedTuple):
    """What boats see; leading axes are free."""

    own: Float  #: (..., K) itself and its task
    boats: Float  #: (..., A - 1, F) the other boats
    outline: Float  #: (..., P, F) points of the vessel's outline
    obstacles: Float  #: (..., M, F) the nearest points of obstacles, none or six


class Column(NamedTuple):
    """A number that is seen, or a vector's two."""

    name: str
    unit: float = 1.0  #: divisor
    bound: float = 1.0  #: magnitude to which it is clipped after that
    signs: tuple[int, ...] = (1,)  #: of its numbers in a mirrored world


def _odd(name: str, unit: float, bound: float = 1.0) -> Column:
    return Column(name, unit, bound, (-1,))


def _vector(name: str, unit: float = 1.0, bound: float = 1.0) -> Column:
    return Column(name, unit, bound, (1, -1))


def _length(name: str) -> Column:
    return _vector(name, NOMINAL_LENGTH, FAR)


CONTACT = (
    _length("lever_arm"),  #: of the contact point, from the vessel's centre; along the drive
    _vector("push"),  #: direction in which a boat pushes there; along the drive
    _odd("moment", NOMINAL_LENGTH / 2, FAR),  #: of its force there, per newton
)
"""A boat's contact point on the vessel, relative to the direction in which that is to be driven."""
ENVIRONMENT = {
    "own_velocity": (1, -1),
    "hull": (1, -1),
    "hull_fine": (1, -1),
    "own_yaw_rate": (-1,),
    "touches_vessel": (1,),
    "touches_other": (1,),
    "thrusters_work": (1,),
    "vessel_seen": (1,),
}
"""Features of the environment's observation that come first, in the boat's frame, with their signs
when mirrored."""
OWN = (
    _vector("slip", SPEED, FAST),  #: velocity of the hull where the boat is, relative to the boat
    _vector("slip_fine", FINE_SPEED),
    _length("gap"),  #: to its contact point
    _vector("gap_fine", FINE),
    _vector("heading"),
    _odd("heading_angle", 2 * FINE_ANGLE),
    _vector("drive"),  #: direction in which the vessel is to be driven
    _length("vessel"),  #: of its centre
    _vector("drift", FINE_SPEED, FAST),  #: velocity of the water
    Column("in_place"),  #: whether it is at its contact point
    # In the frame of the drive.
    _length("goal"),
    _vector("goal_fine", FINE),
    _vector("goal_turn"),
    _odd("goal_angle", FINE_ANGLE),
    _vector("vessel_velocity", SPEED, FAST),
    _vector("vessel_velocity_fine", FINE_SPEED),
    _odd("vessel_yaw_rate", YAW_RATE, FAST),
    _odd("vessel_yaw_rate_fine", FINE_YAW_RATE),
    *CONTACT,
    # Of the team.
    Column("allocated"),  #: whether it has the contact points of a formation, and not slots
    Column("closed"),
    Column("grasped"),  #: whether all boats have been in place since it got them
    Column("arrived"),  #: whether the vessel has been at the goal since, and is still near it
    Column("share_in_place"),
    Column("inverse_team", 0.5, 2.0),
)
"""The boat and its task."""
BOAT = (
    Column("present"),
    _length("position"),
    _vector("heading"),
    _vector("velocity", SPEED, FAST),  #: relative to the observer
    # In the frame of its contact point.
    _length("gap"),
    _vector("gap_fine", FINE),
    _vector("alignment"),
    *CONTACT,
    *(Column("in_place"), Column("touches"), Column("works"), Column("seen")),
)
"""Another boat."""
POINT = (_length("point"), _vector("normal"))
"""A point of the vessel's outline, and the outward normal there."""
OBSTACLE = (
    Column("present"),
    _length("from_boat"),
    _length("from_vessel"),
    Column("nearest_to_vessel"),
)
"""The nearest point of an obstacle, to the boat or to the vessel."""


def _signs(columns: Iterable[Column]) -> list[int]:
    return [sign for column in columns for sign in column.signs]


MIRROR = Seen(
    *(
        np.array(signs, dtype=np.float32)
        for signs in (
            [*sum(ENVIRONMENT.values(), ()), *_signs(OWN)],
            *map(_signs, (BOAT, POINT, OBSTACLE)),
        )
    )
)
"""Signs of the numbers in a mirrored world."""
WIDTHS = tuple(map(len, MIRROR))  #: how many numbers there are of the boat, and of an item each


def put(out: Float, columns: Iterable[Column], values: Mapping[str, Any]) -> None:
    """Writes values by their names, real or complex x + iy, into the columns of ``out`` (..., n).

    The magnified name of a value, which ends in ``_fine``, is written too.
    """
    place = 0
    for name, unit, bound, signs in columns:
        value = values[name.removesuffix("_fine")]
        for part in (value.real, value.imag) if len(signs) == 2 else (value,):
            out[..., place] = np.minimum(np.maximum(part * (1.0 / unit), -bound), bound)
            place += 1
