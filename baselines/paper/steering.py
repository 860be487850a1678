"""The arguments of the steering law, Eq (3), and their values on the approach to a target."""

from dataclasses import dataclass, fields

import numpy as np

from asv_env.geometry import xy
from asv_env.tasks.formation import Relations
from asv_env.types import Bool, Float, Int
from baselines.paper import braitenberg
from baselines.paper.paper_gains import PaperGains
from baselines.paper.paper_memory import Memory
from baselines.paper.spiral import angular_distance, approach_speed, arc_length, bearing_offset


@dataclass(frozen=True)
class Steering:
    """Arguments of Eq (3) for boats (W, A) that go round a point; angles in the vessel's frame.

    Attributes:
        alpha: (W, A) rad, direction in which the point sees the boat.
        turn_direction: (W, A) D, 0 clockwise or 1 counter-clockwise.
        phi: (W, A) rad, angle between the heading and the point.
        speed: (W, A) m/s.
    """

    alpha: Float
    turn_direction: Int | Bool
    phi: Float
    speed: Float


def choose(condition: Bool, one: Steering, other: Steering) -> Steering:
    """Returns the one steering where the condition (W, 1) holds, the other elsewhere."""
    names = [field.name for field in fields(Steering)]
    return Steering(*(np.where(condition, getattr(one, n), getattr(other, n)) for n in names))


def approach_steering(
    relations: Relations, memory: Memory, time_left: Float, stop_radius: float, gains: PaperGains
) -> Steering:
    """Steers along the spirals of Eq (2) at the speeds of Eq (7).

    Boats within the stop radius of their targets wait and point at the hull.

    Args:
        relations: of the boats to the targets that are assigned to them.
        memory: of the controller.
        time_left: (W,) until T_goal, s.
        stop_radius: distance to the target at which a boat has arrived, m.
        gains: of the controller.
    """
    alpha, distance = np.angle(-relations.slot_gap), relations.slot_error
    speed = approach_speed(
        arc_length(distance, angular_distance(alpha, np.pi / 2), gains.sigma),
        time_left[:, None],
        stop_radius=stop_radius,
        max_speed=gains.max_speed,
    )
    turn_direction = braitenberg.updated_turn_direction(
        xy(relations.boat), xy(memory.target), memory.turn_direction
    )
    arrived = distance < stop_radius
    alpha, speed = np.where(arrived, np.pi / 2, alpha), np.where(arrived, 0.0, speed)
    return Steering(alpha, turn_direction, bearing_offset(alpha, gains.sigma), speed)
