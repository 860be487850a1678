"""Laws of the tasks, in scalars: relations of one boat or goal, slots, closure, delivery, cost.

Vectors are complex numbers; ``to_vessel`` is the factor that turns one of the world into the
vessel's frame. Compiled loops over the worlds call these.
"""

import math
from typing import NamedTuple

from asv_env.compiled import compiled
from asv_env.geometry import wrapped
from asv_env.memo import by_identity
from asv_env.params import EnvParams
from asv_env.types import Float

CLOSURE_LOST = 2.0  #: distance of a boat from its slot at which closure is lost, slot tolerances
HEADING_WEIGHT = 0.25  #: cost of a turn of the vessel by 1 rad, m at the nominal size
SIDEWAYS = 4.0  #: cost of a metre that the vessel moves without turning first, m


class Rules(NamedTuple):
    """Numbers by which slots, closure and delivery are decided; see ``TaskParams``."""

    slot_distance: float  #: m
    slot_alignment: float  #: cosine of the largest heading error in a slot
    slot_speed: float  #: m/s
    closure_lost: float  #: m
    position_tolerance: float  #: m
    heading_tolerance: float  #: rad
    holding: bool  #: whether a vessel is delivered by holding, else by passing
    speed_tolerance: float  #: m/s
    yaw_rate_tolerance: float  #: rad/s
    water_growth: float  #: relative growth of both with the speed of the water, s/m
    passing_speed: float  #: m/s
    passing_yaw_rate: float  #: rad/s
    nearing_tolerance: float  #: m/s


@by_identity
def rules(params: EnvParams) -> Rules:
    """Returns the rules of an environment."""
    task = params.task
    return Rules(
        slot_distance=task.slot_distance,
        slot_alignment=math.cos(task.slot_angle),
        slot_speed=task.slot_speed,
        closure_lost=CLOSURE_LOST * task.slot_distance,
        position_tolerance=task.position_tolerance,
        heading_tolerance=task.heading_tolerance,
        holding=task.delivery == "holding",
        speed_tolerance=task.speed_tolerance,
        yaw_rate_tolerance=task.yaw_rate_tolerance,
        water_growth=task.water_tolerance / task.speed_tolerance,
        passing_speed=task.passing_speed,
        passing_yaw_rate=task.passing_yaw_rate,
        nearing_tolerance=task.nearing_tolerance,
    )


@compiled
def direction_of(heading: float) -> complex:
    """Returns the unit vector of a heading, rad."""
    return complex(math.cos(heading), math.sin(heading))


@compiled
def size_of(vector: complex) -> float:
    """Returns the length of a vector that is neither tiny nor huge."""
    return math.sqrt(vector.real * vector.real + vector.imag * vector.imag)


@compiled
def around(
    motion: Float, body: int, heading: complex, to_vessel: complex, slot: complex, side: float
) -> tuple[complex, complex, complex, complex]:
    """Returns how a boat stands to the vessel and to its slot.

    Args:
        motion: (B, 6) of a world.
        body: row of the boat.
        heading: direction of the boat, world frame.
        to_vessel: turns vectors of the world into the vessel's frame.
        slot: position of the boat's slot, vessel frame, m.
        side: from which the team pushes, +1 or -1.

    Returns:
        Position of the boat, and vector from it to its slot, vessel frame, m; its direction
        relative to that of its slot, which points across the vessel; its velocity relative to the
        hull, world frame, m/s.
    """
    offset = complex(motion[body, 0] - motion[0, 0], motion[body, 1] - motion[0, 1])
    velocity = complex(motion[body, 3] - motion[0, 3], motion[body, 4] - motion[0, 4])
    boat = offset * to_vessel
    alignment = heading * to_vessel * complex(0.0, side)
    return boat, slot - boat, alignment, velocity - complex(0.0, motion[0, 5]) * offset


@compiled
def aim(motion: Float, goal: Float, to_vessel: complex) -> tuple[complex, complex]:
    """Returns position, m, and direction of a goal (3,) in the frame of the vessel."""
    offset = complex(goal[0] - motion[0, 0], goal[1] - motion[0, 1])
    return offset * to_vessel, direction_of(goal[2]) * to_vessel


@compiled
def heading_error_of(goal_turn: complex) -> float:
    """Returns the heading of the vessel minus that of the goal, rad, from the goal's direction."""
    return -math.atan2(goal_turn.imag, goal_turn.real)


@compiled
def rests(alignment: complex, slip: complex, rules: Rules) -> bool:
    """Returns whether a boat is aligned with the slots and at rest on the hull."""
    return alignment.real > rules.slot_alignment and size_of(slip) < rules.slot_speed


@compiled
def occupies(distance: float, alignment: complex, slip: complex, rules: Rules) -> bool:
    """Returns whether a boat occupies its slot: near it, aligned and at rest."""
    return distance < rules.slot_distance and rests(alignment, slip, rules)


@compiled
def holds(speed: float, yaw_rate: float, water_speed: float, rules: Rules) -> bool:
    """Returns whether the vessel hardly moves over ground.

    Water that flows past a hull that is held shakes it, so that speed and yaw rate may be larger
    by the factor 1 + c w / v, where w is the water's speed, c the ``water_tolerance`` and v the
    ``speed_tolerance``. The speed v + c w stays below w from w = v / (1 - c) on, 2.7 mm/s by
    default: in faster water a vessel that is carried along does not hold its pose.
    """
    factor = 1.0 + rules.water_growth * water_speed
    slow = speed < rules.speed_tolerance * factor
    return slow and abs(yaw_rate) < rules.yaw_rate_tolerance * factor


@compiled
def passes(
    velocity: complex, yaw_rate: float, water: complex, to_goal: complex, rules: Rules
) -> bool:
    """Returns whether the vessel is slow through the local water and comes no nearer.

    It hardly turns, and its distance to the goal falls by less than ``nearing_tolerance``. The
    vector ``to_goal``, m, is of the world like the velocities.
    """
    nearing = velocity.real * to_goal.real + velocity.imag * to_goal.imag
    slow = (
        size_of(velocity - water) < rules.passing_speed and abs(yaw_rate) < rules.passing_yaw_rate
    )
    return slow and nearing <= rules.nearing_tolerance * size_of(to_goal)


@compiled
def at_goal(motion: Float, goal: Float, water: complex, rules: Rules) -> bool:
    """Returns whether a tick counts for the delivery of the vessel.

    The vessel is within the tolerances of position and heading, and slow by the task's criterion;
    ``water`` is the velocity of the water at the vessel, m/s.
    """
    to_goal = complex(goal[0] - motion[0, 0], goal[1] - motion[0, 1])
    if size_of(to_goal) > rules.position_tolerance:
        return False
    if abs(wrapped(motion[0, 2] - goal[2])) > rules.heading_tolerance:
        return False
    velocity, yaw_rate = complex(motion[0, 3], motion[0, 4]), motion[0, 5]
    if rules.holding:
        return holds(size_of(velocity), yaw_rate, size_of(water), rules)
    return passes(velocity, yaw_rate, water, to_goal, rules)


@compiled
def cost_to_go(goal: complex, heading_error: float, side: float, size: float) -> float:
    """Returns the length of the vessel's path to its goal, m, where a turn is a distance too.

    Either the vessel turns until the goal lies where the team pushes (from ``side``, +1 or -1),
    goes there, and turns to the goal's heading; or, near the goal, it moves there without
    turning first, which costs several times the distance, and turns. The cheaper one counts: a
    plain distance would take the first turn for a step back. The goal is a position in the
    vessel's frame, m, and ``size`` that of the vessel over the nominal one's.
    """
    distance, turn = size_of(goal), -heading_error
    ahead = goal * complex(0.0, side)
    bearing = math.atan2(ahead.imag, ahead.real)
    turns = abs(bearing) + abs(wrapped(turn - bearing))
    straight = SIDEWAYS * distance + size * HEADING_WEIGHT * abs(turn)
    return min(distance + size * HEADING_WEIGHT * turns, straight)


@compiled
def gaussian(distance: float, angle: float, width: float, angle_width: float) -> float:
    """Returns a Gaussian of the distance and the heading error to the goal; 1 at the goal."""
    return math.exp(-((distance / width) ** 2 + (angle / angle_width) ** 2))
