"""Everything by which the scripted controller can be tuned, in SI units.

The values were chosen on development seeds, by the share and the time of deliveries; the comments
give their meaning, not their derivation.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class GraspGains:
    """Gains of the approach to the vessel (``GraspController``)."""

    sigma: float = 0.7  #: decay of the spiral (Eq 2), rad
    cruise_speed: float = 0.16  #: speed of the boat with the longest path; others slow down, m/s
    max_speed: float = 0.2  #: speed limit of boats that are late, m/s: a full action
    arrival_gain: float = (
        0.22  #: speed limit per distance to a waypoint, 1/s: half a turn takes 4.5 s
    )
    velocity_time: float = 1.0  #: time constant with which boats change their velocity, s
    avoidance_range: float = 0.2  #: distance below which boats avoid each other on their paths, m
    avoidance_speed: float = 0.08  #: speed at which boats avoid each other at distance 0, m/s
    waypoint_height: float = 0.1  #: height of the waypoints above the slots, m
    patience: float = 10.0  #: time after which the team no longer waits for boats that are late, s
    docking_half_width: float = 0.1  #: half-width of the region where boats dock, m
    docking_height: float = 0.35  #: height of the region above its target where a boat docks, m
    descent_gain: float = 1.0  #: speed of a docking boat per height, 1/s: time constant 1 s
    descent_speed: float = 0.06  #: speed limit of a docking boat, m/s
    lookahead: float = 0.04  #: distance over which docking boats return to their lines, m
    lookahead_time: float = 0.7  #: growth of the lookahead with the speed, s
    pointing_speed: float = 0.09  #: least speed towards the hull that is steered for, m/s
    funnel_slope: float = 0.6  #: growth of the half-width of a slot's funnel with height
    retry_height: float = 0.06  #: height below which a boat outside the funnel has missed, m
    standoff: float = 0.007  #: gap to the hull in which boats wait for closure, m


@dataclass(frozen=True)
class PushGains:
    """Gains of the push (``PushController``)."""

    speed_gain: float = 1.33  #: force per mass and speed error, 1/s: time constant 0.75 s
    moment_reserve: float = 0.6  #: force kept for moments, fraction of the drag at full speed
    contact_force: float = 0.145  #: least force of side boats, fraction of the drag at full speed
    max_end_force: float = 8e-3  #: largest force of the end boats along a hull of 0.40 m, N
    min_end_force: float = 7e-4  #: least force with which each end boat presses on the hull, N
    spread: float = 1.2  #: position of the side boats along the hull, relative to their slots
    gap_gain: float = 0.2  #: closing speed per gap to the hull, 1/s: time constant 5 s
    yaw_offset_gain: float = 2.2  #: yaw offset of side boats per distance to their places, rad/m
    friction_compensation: float = 0.32  #: fraction of lateral friction compensated by a yaw offset
    lateral_gain: float = 0.23  #: speed of end boats per distance to go, 1/s: time constant 4.3 s
    release_error: float = 0.5  #: error of the pose of rest at which the team lets go, tolerances
    stop_short: float = 0.1  #: how far short of the goal the vessel is to rest, tolerances
    hurry: float = 1.0  #: growth of that error with the distance beyond where it was to let go
    release_gap: float = 0.02  #: gap to the hull of boats that stand off, m
    release_gain: float = 0.5  #: speed of standing off per gap, 1/s: time constant 2 s
    release_speed: float = 0.03  #: speed limit of standing off, m/s


@dataclass(frozen=True)
class PathGains:
    """Which paths the vessel takes, and how fast (``PathPlanner``)."""

    widest_radius: float = 3.8  #: radius of the widest arcs considered, half-lengths of the vessel
    tightest_radius: float = 0.56  #: radius of the tightest arcs considered, fraction of the widest
    radius_cost: float = 0.75  #: path length worth an arc wider by a half-length, vessel lengths
    final_straight: float = 0.36  #: longest straight at the end of a path, vessel lengths
    straight_cost: float = 2.2  #: path length worth a straight longer by a length, vessel lengths
    speed: float = 0.069  #: cruising speed of the vessel, m/s
    braking: float = 0.36  #: speed near the goal, fraction of that from which it coasts to rest
    goal_speed: float = 0.004  #: speed at the goal, m/s, of a vessel that is pushed to the end


@dataclass(frozen=True)
class Tolerances:
    """Deviations and efforts that cost the same in ``PreviewLqr`` (Bryson's rule)."""

    cross_track: float = 0.04  #: distance from the path, m
    heading: float = 0.035  #: heading error, rad
    force: float = 3.9e-3  #: force along the hull, N; 0 where no boat can exert one
    moment: float = 3e-4  #: moment on a vessel of 0.40 m, N m; scales with the length squared
