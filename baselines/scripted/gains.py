"""Everything by which the scripted controller can be tuned, in SI units.

Gains that follow from a time constant, a size or a speed say so. The others, ``FOUND``, are those
that ``baselines.scripted.tune`` searches on development seeds: it begins with the values in the
file from which they are read, and writes its result there. Lengths, speeds and times are those of a
boat of 12 cm and a vessel of 0.40 m.
"""

import json
from dataclasses import dataclass
from pathlib import Path

FILE = Path(__file__).with_name("tuned.json")
FOUND: dict[str, float] = json.loads(FILE.read_text(encoding="utf-8"))["gains"]
"""Gains by name that are searched."""


@dataclass(frozen=True)
class GraspGains:
    """Gains of the approach to the vessel (``GraspController``)."""

    sigma: float = 0.7  #: decay of the spiral (Eq 2), rad; a tighter one than the paper's 1
    #: speed of the boat with the longest path, m/s: four fifths of a full action, so that it can
    #: catch up; others slow down
    cruise_speed: float = 0.16
    max_speed: float = 0.2  #: speed limit of boats that are late, m/s: a full action
    #: speed limit per distance to a waypoint, 1/s: half a turn takes 4.5 s, in which the distance
    #: is not to be covered
    arrival_gain: float = 0.22
    velocity_time: float = FOUND["velocity_time"]  #: time constant of boats' velocities, s
    #: distance below which boats avoid each other on their paths, m
    avoidance_range: float = FOUND["avoidance_range"]
    #: speed at which boats avoid each other at distance 0, m/s
    avoidance_speed: float = FOUND["avoidance_speed"]
    waypoint_height: float = 0.1  #: height of the waypoints above the slots, m: bows clear hulls
    #: time after which the team no longer waits for boats that are late, s: two half turns
    patience: float = 10.0
    #: time after which a descent has failed, because boats are in each other's way, s: three times
    #: the patience with boats that are late
    descent_patience: float = 30.0
    #: half-width of the region where boats dock, m: the height of the waypoints, a slope of 1
    docking_half_width: float = 0.1
    #: height of the region above its target where a boat docks, m: half a vessel's and two boats'
    #: lengths
    docking_height: float = 0.35
    descent_gain: float = 1.0  #: speed of a docking boat per height, 1/s: time constant 1 s
    descent_speed: float = FOUND["descent_speed"]  #: speed limit of a docking boat, m/s
    #: distance over which docking boats return to their lines, m, and its growth with speed, s
    lookahead: float = FOUND["lookahead"]
    lookahead_time: float = FOUND["lookahead_time"]
    #: least speed towards the hull that is steered for, m/s: bows point within 45 degrees of it
    #: where a boat is to move sideways as fast as this
    pointing_speed: float = 0.09
    funnel_slope: float = (
        0.6  #: growth of the half-width of a slot's funnel with height: 31 degrees
    )
    #: height below which a boat outside the funnel has missed, m: half its length
    retry_height: float = 0.06
    #: gap to the hull in which boats wait for closure, m: a quarter of the slot's tolerance
    standoff: float = 0.007


@dataclass(frozen=True)
class PushGains:
    """Gains of the push (``PushController``)."""

    speed_gain: float = 1.33  #: force per mass and speed error, 1/s: time constant 0.75 s
    #: force kept for moments, fraction of the drag at full speed
    moment_reserve: float = FOUND["moment_reserve"]
    #: least force of side boats, fraction of the drag at full speed
    contact_force: float = FOUND["contact_force"]
    #: largest force of the end boats along a hull of 0.40 m, N: two fifths of a boat's thrust
    max_end_force: float = 8e-3
    #: least force with which each end boat presses on the hull, N
    min_end_force: float = FOUND["min_end_force"]
    spread: float = 1.2  #: position of the side boats along the hull, relative to their slots
    gap_gain: float = 0.2  #: closing speed per gap to the hull, 1/s: time constant 5 s
    #: yaw offset of side boats per distance to their places, rad/m: those that slide freely return
    #: to them while the vessel goes its own length
    yaw_offset_gain: float = 2.5
    #: fraction of lateral friction compensated by a yaw offset
    friction_compensation: float = FOUND["friction_compensation"]
    lateral_gain: float = 0.23  #: speed of end boats per clearance, 1/s: time constant 4.3 s
    #: error of the pose of rest at which the team lets go, tolerances
    release_error: float = FOUND["release_error"]
    #: growth of that error with the distance beyond where it was to let go
    hurry: float = FOUND["hurry"]
    #: how far beyond the goal the vessel is to rest by the estimate at which the team lets go,
    #: tolerances: with noise the first such estimate runs ahead of the truth, and boats that leave
    #: the hull take some of its way
    overrun: float = FOUND["overrun"]
    release_gap: float = FOUND["release_gap"]  #: gap to the hull of boats that stand off, m
    release_gain: float = 0.5  #: speed of standing off per gap, 1/s: time constant 2 s
    release_speed: float = 0.03  #: speed limit of standing off, m/s


@dataclass(frozen=True)
class PathGains:
    """Which paths the vessel takes, and how fast (``PathPlanner``)."""

    #: radius of the widest arcs considered, half-lengths of the vessel
    widest_radius: float = FOUND["widest_radius"]
    #: radius of the tightest arcs considered, fraction of the widest
    tightest_radius: float = FOUND["tightest_radius"]
    #: path length worth an arc wider by a half-length, vessel lengths
    radius_cost: float = FOUND["radius_cost"]
    #: longest straight at the end of a path, vessel lengths
    final_straight: float = FOUND["final_straight"]
    #: path length worth a straight longer by a length, vessel lengths
    straight_cost: float = FOUND["straight_cost"]
    speed: float = FOUND["speed"]  #: cruising speed of the vessel, m/s
    #: speed near the goal, fraction of that from which it coasts to rest
    braking: float = FOUND["braking"]
    #: speed at the goal of a vessel that is pushed to the end, m/s
    goal_speed: float = FOUND["goal_speed"]
    #: the same in moving water, m/s: slow enough to pass by the paper's instant, no slower, so that
    #: the water has no time to carry the vessel off
    passing_speed: float = 0.0072
    #: speed through the water at a goal where the vessel is held, m/s: half the tolerance of its
    #: speed over ground
    held_speed: float = 0.001
    #: time in which the team goes round and grasps the vessel from the other side, s
    turning_time: float = 25.0
    #: path length over which a current is taken to last, vessel lengths
    current_length: float = 1.25
    #: speed of the water, m/s, from which it moves: in 10 s it carries the vessel as far as the
    #: tolerance of its position; in slower water the team lets go of the vessel
    still_water: float = 0.005
    #: radius of the tightest arcs among obstacles, half-lengths of the vessel: on tighter ones the
    #: vessel leaves its path
    narrow_radius: float = 1.75
    narrow_cost: float = 1.0  #: path length worth arcs that are not narrow, vessel lengths
    turning_clearance: float = 0.25  #: least clearance on arcs, vessel lengths: 10 cm
    straight_clearance: float = 0.05  #: least clearance on straights, vessel lengths: 2 cm
    wanted_clearance: float = 0.5  #: clearance beyond which more is worth nothing, vessel lengths
    clearance_cost: float = 1.0  #: path length worth that clearance, vessel lengths
    #: path length worth the time for switching to the other side, vessel lengths: half a minute
    switch_cost: float = 7.0


@dataclass(frozen=True)
class Tolerances:
    """Deviations and efforts that cost the same in ``PreviewLqr`` (Bryson's rule)."""

    cross_track: float = FOUND["cross_track"]  #: distance from the path, m
    heading: float = FOUND["heading"]  #: heading error, rad
    force: float = FOUND["force"]  #: force along the hull, N; 0 where no boat can exert one
    #: moment on a vessel of 0.40 m, N m; scales with the length squared
    moment: float = FOUND["moment"]
