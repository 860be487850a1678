"""Everything by which the policy can be tuned, in SI units.

Forces are fractions of a boat's full thrust, lengths and times are those of a boat of 12 cm and a
vessel of 0.40 m. What follows from a size, a time constant or a tolerance says so.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class AllocationGains:
    """Gains of the policy ``allocation``."""

    # The forces.
    max_force: float = 0.8  #: largest force of a boat on the hull; the rest is for steering
    min_force: float = 0.15  #: least force of boats in contact: a grasp that noise does not open
    #: largest force by which a boat lets friction hold it sideways
    max_grip: float = 0.6
    hold_grip: float = 0.3  #: further force with which the team holds the vessel at its goal
    moment_weight: float = 2.0  #: weight of the moment against forces where not both can be had

    # The motion of the vessel.
    drive_share: float = 0.6  #: part of the pushers' force that drag takes at full speed
    max_speed: float = 0.1  #: limit of the vessel's speed, m/s: half of what boats can go
    #: part of a boat's thrust that its sideways drag takes when the vessel turns at the full rate
    turn_share: float = 0.2
    turn_braking: float = 0.4  #: part of the largest yaw acceleration with which a turn is planned
    speed_gain: float = 0.5  #: speed per distance near the goal, 1/s: time constant 2 s
    yaw_gain: float = 0.7  #: yaw rate per angle near the wanted heading, 1/s
    slide_gain: float = 0.3  #: sideways speed per distance beside the goal, 1/s
    slide_speed: float = 0.01  #: limit of the speed at which boats carry the vessel sideways, m/s
    full_bearing: float = 0.3  #: bearing of the goal up to which the vessel drives at full speed
    turn_bearing: float = 0.6  #: bearing of the goal from which it turns on the spot, rad
    lookahead: float = 0.375  #: least distance of the point that is steered for, vessel sizes

    # The boats.
    sideways_gain: float = 0.4  #: speed along the hull per distance to the contact point, 1/s
    sideways_time: float = 1.0  #: time constant of the velocity along the hull, s
    gap_gain: float = 0.5  #: closing speed per gap to the hull, 1/s: time constant 2 s
    max_offset: float = 0.6  #: limit of the yaw offset by which a boat moves along the hull, rad
    approach_speed: float = 0.05  #: speed at the waypoint in front of the contact point, m/s
    arrival_gain: float = 0.4  #: growth of that speed with the distance, 1/s
    standoff: float = 0.01  #: gap to the hull in which boats wait for the others, m
    patience: float = 15.0  #: time after which the team no longer waits for boats that are late, s
