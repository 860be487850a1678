"""Everything by which the scripted controller can be tuned, in SI units.

The values were chosen on development seeds, by the share and the time of deliveries; what a
docstring adds to one is its meaning, not its derivation.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class GraspGains:
    """Gains of the approach to the vessel (``GraspController``)."""

    sigma: float = 0.7
    """Decay of the spiral (Eq 2), rad."""
    cruise_speed: float = 0.16
    """Speed of the boat with the longest path, which sets the time when all arrive, m/s."""
    max_speed: float = 0.2
    """Speed limit of boats that are late, m/s: a full action."""
    arrival_gain: float = 0.35
    """Speed limit per distance left to the waypoint, 1/s: time constant 2.9 s."""
    heading_gain: float = 2.5
    """Yaw rate per heading error, 1/s: half the bandwidth of the nominal boats' autopilot."""
    velocity_gain: float = 0.7
    """Fraction of the velocity error that is added to the velocity for which a boat steers."""
    drift_time: float = 3.0
    """Time constant of the filter that estimates how the water drifts past the hull, s."""
    avoidance_range: float = 0.2
    """Distance below which boats avoid each other on their paths, m."""
    avoidance_speed: float = 0.08
    """Speed at which boats avoid each other at distance 0, m/s."""
    waypoint_height: float = 0.1
    """Height of the waypoints above the slots, m."""
    patience: float = 10.0
    """Time after which the team no longer waits for boats that are late, s."""
    docking_half_width: float = 0.1
    """Half-width of the region above its target in which a boat docks, m."""
    docking_height: float = 0.35
    """Height of the region above its target in which a boat docks, m."""
    descent_gain: float = 1.0
    """Speed of a docking boat per height above its target, 1/s: time constant 1 s."""
    descent_speed: float = 0.06
    """Speed limit of a docking boat, m/s."""
    lookahead: float = 0.04
    """Distance over which a docking boat returns to the line of its slot, m."""
    lookahead_time: float = 0.7
    """Growth of the lookahead with the speed, s."""
    pointing_speed: float = 0.09
    """Least speed towards the hull for which a docking boat steers, so that it is aligned, m/s."""
    funnel_slope: float = 0.6
    """Growth of the half-width of the funnel above a slot with the height."""
    retry_height: float = 0.06
    """Height below which a boat outside the funnel has missed its slot and goes astern, m."""
    standoff: float = 0.007
    """Gap to the hull in which boats wait for closure, m."""


@dataclass(frozen=True)
class PushGains:
    """Gains of the push (``PushController``)."""

    speed_gain: float = 1.33
    """Force per mass and speed error of the vessel, 1/s: time constant 0.75 s."""
    moment_reserve: float = 0.6
    """Force that side boats may always use for the moment, fraction of the drag at full speed."""
    contact_force: float = 0.145
    """Least force of all side boats together, for contact, fraction of the drag at full speed."""
    max_end_force: float = 5.6e-3
    """Largest force of the end boats along a hull of 0.40 m, N."""
    min_end_force: float = 7e-4
    """Least force with which each end boat presses on the hull, N."""
    spread: float = 1.2
    """Position of the side boats along the hull, relative to their slots."""
    gap_gain: float = 0.2
    """Closing speed per gap to the hull, 1/s: time constant 5 s."""
    heading_gain: float = 4.0
    """Yaw rate per heading error, 1/s: time constant 0.25 s."""
    yaw_offset_gain: float = 2.2
    """Yaw offset of side boats per distance along the hull to their places, rad/m."""
    friction_compensation: float = 0.32
    """Fraction of the lateral friction compensated by a yaw offset, 0 to 1."""
    lateral_gain: float = 0.23
    """Speed of end boats along the hull per distance to their places, 1/s: time constant 4.3 s."""
    drift_compensation: float = 1.2
    """Fraction of their drift angle in a turn that end boats steer against."""


@dataclass(frozen=True)
class PathGains:
    """Which paths the vessel takes, and how fast (``PathPlanner``)."""

    widest_radius: float = 3.8
    """Radius of the widest arcs considered, half-lengths of the vessel."""
    tightest_radius: float = 0.56
    """Radius of the tightest arcs considered, fraction of the widest."""
    radius_cost: float = 0.75
    """Path length worth an arc wider by a half-length, lengths of the vessel."""
    final_straight: float = 0.36
    """Longest straight considered at the end of a path, lengths of the vessel."""
    straight_cost: float = 2.2
    """Path length worth a final straight longer by a vessel's length, lengths of the vessel."""
    speed: float = 0.069
    """Cruising speed of the vessel, m/s."""
    braking: float = 0.36
    """Speed limit near the goal, fraction of that from which the vessel coasts to rest there."""
    goal_speed: float = 0.0072
    """Speed at the goal, m/s: slow enough to count as delivered."""


@dataclass(frozen=True)
class Tolerances:
    """Deviations and efforts that cost the same in ``PreviewLqr`` (Bryson's rule)."""

    cross_track: float = 0.04
    """Distance from the path, m."""
    heading: float = 0.035
    """Heading error, rad."""
    force: float = 3.9e-3
    """Force along the hull, N; 0 where no boat can exert one."""
    moment: float = 3e-4
    """Moment on a vessel of 0.40 m, N m; it scales with the square of the length."""
