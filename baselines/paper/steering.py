"""The approach: the memory of the team, its targets, and how boats steer there by Eq (3)."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from asv_env.geometry import xy
from asv_env.tasks.formation import Relations, assign
from asv_env.types import Bool, Complex, Float, Int, zeros
from baselines.paper import braitenberg
from baselines.paper.paper_numbers import PaperGains
from baselines.paper.spiral import angular_distance, approach_speed, arc_length, bearing_offset

FAR_AWAY = 1e6  #: distance of the circle's centre before any arc is planned, m
Assignment = Callable[[Complex, Complex, Bool, Complex], Complex]
"""Function from boats (W, A), slots (W, A), which boats work (W, A) and the last targets (W, A; NaN
before the first) to targets (W, A); positions in the vessel's frame, m."""


@dataclass
class Memory:
    """State of the controller; every array has the worlds as its first axis."""

    target: Complex  #: (W, A) slot assigned to each boat, vessel frame, m; NaN before the first
    turn_direction: Int  #: (W, A) D of each boat for that target
    pushing: Bool  #: (W,) whether the push has begun
    motors_off: Bool  #: (W,) whether the motors are off for good
    goal: Complex  #: (W,) position where the arcs end, m
    centre: Complex  #: (W, 2) centres of the two circles, m
    rho: Float  #: (W, 2) positions of the centres along the vessel's +x axis, m
    length: Float  #: (W, 2) lengths of the arcs, m
    arc: Int  #: (W,) index of the arc that the vessel is on, 0 or 1
    travelled: Float  #: (W,) path length round the first centre, m
    last_position: Complex  #: (W,) position of the vessel at the last tick, m
    lost_speed: Float  #: (W,) integral of the vessel's speed error, m/s
    wheels: Float  #: (W, A, 2) left and right wheel speed commanded at the last tick, m/s

    @classmethod
    def blank(cls, worlds: int, team: int) -> Self:
        """Returns the memory at the start of episodes: no targets, no arcs, the wheels at rest."""
        each, boats, arcs = (worlds,), (worlds, team), (worlds, 2)
        shapes = boats, boats, each, each, each, arcs, arcs, arcs, *4 * (each,), (*boats, 2)
        memory = zeros(cls, *shapes)
        memory.target[:], memory.centre[:], memory.rho[:] = np.nan, FAR_AWAY, FAR_AWAY
        return memory


def nearest(boat: Complex, slot: Complex, working: Bool, last: Complex) -> Complex:
    """Assigns the targets with the least total distance, whatever the last ones were.

    The paper re-attributes targets to the nearest boats at every tick. It does not say what
    happens where two targets have the same nearest boat. With the least total distance no two
    straight paths cross. A boat that does not work keeps its own slot.
    """
    target = slot.copy()
    for world, works in enumerate(working):
        points = slot[world, works]
        target[world, works] = points[assign(boat[world, works], points)]
    return target


class Steering(NamedTuple):
    """Arguments of Eq (3) for boats (W, A) that go round a point; angles in the vessel's frame."""

    alpha: Float  #: rad, direction in which the point sees the boat
    turn_direction: Int | Bool  #: D, 0 clockwise or 1 counter-clockwise
    phi: Float  #: rad, angle between the heading and the point
    speed: Float  #: m/s


def approach_steering(
    relations: Relations, memory: Memory, time_left: Float, stop_radius: float, gains: PaperGains
) -> Steering:
    """Steers along the spirals of Eq (2) at the speeds of Eq (7).

    Boats within the stop radius, m, of their targets wait and point at the hull. ``time_left``
    (W,) s is that to T_goal; the relations are those to the assigned targets.
    """
    alpha, distance = np.angle(-relations.slot_gap), relations.slot_error
    length = arc_length(distance, angular_distance(alpha, np.pi / 2), gains.sigma)
    speed = approach_speed(length, time_left[:, None], stop_radius, gains.max_speed)
    boat, target = xy(relations.boat), xy(memory.target)
    turn_direction = braitenberg.updated_turn_direction(boat, target, memory.turn_direction)
    arrived = distance < stop_radius
    alpha, speed = np.where(arrived, np.pi / 2, alpha), np.where(arrived, 0.0, speed)
    return Steering(alpha, turn_direction, bearing_offset(alpha, gains.sigma), speed)
