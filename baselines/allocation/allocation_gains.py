"""Everything by which the policy can be tuned, in SI units.

Forces are fractions of a boat's full thrust, lengths and times are those of a boat of 12 cm and a
vessel of 0.40 m. What follows from a size, a time constant or a tolerance says so. ``FOUND`` are
the gains that ``baselines.allocation.tune`` searches on development seeds: it begins with the
values in the file from which they are read, and writes its result there.
"""

import json
from dataclasses import dataclass
from pathlib import Path

FILE = Path(__file__).with_name("tuned.json")
FOUND: dict[str, dict[str, float]] = json.loads(FILE.read_text(encoding="utf-8"))["gains"]
"""Gains by name that are searched: those of ``AllocationGains``, and of ``ManoeuvreGains``."""
TEAM, PAIR = FOUND["team"], FOUND["pair"]


@dataclass(frozen=True)
class AllocationGains:
    """Gains of the policy ``allocation``."""

    # The forces.
    max_force: float = 0.8  #: largest force of a boat on the hull; the rest is for steering
    #: least force of boats in contact: a grasp that noise does not open
    min_force: float = TEAM["min_force"]
    #: largest force by which a boat lets friction hold it sideways
    max_grip: float = 0.6
    hold_grip: float = 0.3  #: further force with which the team holds the vessel at its goal
    #: weight of the moment against forces where not both can be had
    moment_weight: float = TEAM["moment_weight"]

    # The motion of the vessel.
    #: part of the pushers' force that drag takes at full speed
    drive_share: float = TEAM["drive_share"]
    max_speed: float = 0.1  #: limit of the vessel's speed, m/s: half of what boats can go
    #: part of a boat's thrust that its sideways drag takes when the vessel turns at the full rate
    turn_share: float = TEAM["turn_share"]
    #: part of the largest yaw acceleration with which a turn is planned
    turn_braking: float = TEAM["turn_braking"]
    speed_gain: float = 0.5  #: speed per distance near the goal, 1/s: time constant 2 s
    yaw_gain: float = TEAM["yaw_gain"]  #: yaw rate per angle near the wanted heading, 1/s
    slide_gain: float = 0.3  #: sideways speed per distance beside the goal, 1/s
    #: limit of the speed at which boats carry the vessel sideways, m/s
    slide_speed: float = TEAM["slide_speed"]
    full_bearing: float = 0.3  #: bearing of the goal up to which the vessel drives at full speed
    turn_bearing: float = 0.6  #: bearing of the goal from which it turns on the spot, rad
    #: least distance of the point that is steered for, vessel sizes
    lookahead: float = TEAM["lookahead"]

    # The boats.
    #: speed along the hull per distance to the contact point, 1/s
    sideways_gain: float = TEAM["sideways_gain"]
    sideways_time: float = 1.0  #: time constant of the velocity along the hull, s
    gap_gain: float = 0.5  #: closing speed per gap to the hull, 1/s: time constant 2 s
    max_offset: float = 0.6  #: limit of the yaw offset by which a boat moves along the hull, rad
    approach_speed: float = 0.05  #: speed at the waypoint in front of the contact point, m/s
    arrival_gain: float = TEAM["arrival_gain"]  #: growth of that speed with the distance, 1/s
    standoff: float = 0.01  #: gap to the hull in which boats wait for the others, m
    patience: float = 15.0  #: time after which the team no longer waits for boats that are late, s


@dataclass(frozen=True)
class ManoeuvreGains:
    """Gains of teams of two boats (``Manoeuvres``, ``Pushes``)."""

    # Which manoeuvre comes next.
    far: float = PAIR["far"]  #: distance from which a goal is driven to, tolerances
    #: bearing of the goal beyond which the vessel turns first, rad
    turn_bearing: float = PAIR["turn_bearing"]
    turned_bearing: float = 0.3  #: bearing at which it has turned enough, rad
    #: error of the pose of rest at which boats leave the vessel alone, tolerances
    rest_error: float = 0.7
    leave_error: float = 0.95  #: error of the pose of rest at which they push it again, tolerances
    useful_error: float = 0.5  #: error for which a manoeuvre that was chosen is kept, tolerances
    doubt_time: float = 1.0  #: time for which another has to be better before it is dropped, s
    lost_time: float = 0.5  #: time for which a boat may be out of its place in a push, s

    # The motion of the vessel.
    braking: float = PAIR["braking"]  #: speed, fraction of that from which it coasts to the end
    turn_braking: float = PAIR["turn_braking"]  #: likewise the yaw rate
    #: time for which its sideways motion is taken to last, s
    slide_time: float = PAIR["slide_time"]
    #: what is left to go when boats let go, tolerances
    release_error: float = PAIR["release_error"]

    # The boats.
    standoff: float = 0.02  #: gap to the hull in which boats wait for each other, m
    #: gap at which boats have left the hull, m: a boat that turns on the spot needs 1 cm
    clearance: float = 0.03
    leaving_speed: float = 0.04  #: speed at which they leave it, m/s
    rest_gap: float = 0.06  #: gap to the hull of boats that leave the vessel alone, m
