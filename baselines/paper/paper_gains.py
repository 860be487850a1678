"""Numbers of the paper's controller: those that it prints, and those that it leaves open."""

from dataclasses import dataclass

ARRIVAL_TIME = {"tracking": 80.0, "thrusters": 30.0}
"""T_goal of the paper's experiment and of its simulation, s, for a vessel of 0.40 m."""
IN_RANGE = 0.20
"""Distance of the vessel to the goal at which the motors are turned off, m."""
MEAN_SPEEDS = (0.02, 0.10)
"""Bounds of the vessel's mean speed, m/s, whatever its drag."""


@dataclass(frozen=True)
class PaperGains:
    """Sigma, and what the paper leaves open.

    Steering is well below the bandwidth of the autopilot. Boats skid, so that much faster ones
    miss their targets and ram the vessel. The gains of the push suit vessels and boats that differ
    from the nominal ones (scenario "mismatch"): with a larger `cross_track` the vessel leaves its
    circle, with more `vessel_yaw` it swings.

    Attributes:
        sigma: decay of the spiral (Eq 2), rad; 1 in the paper's experiment.
        steering: K = 2 beta / b of Eq (3), and gain from heading error to yaw rate, 1/s.
        max_speed: largest speed on the approach, m/s.
        vessel_yaw: yaw rate of the vessel for its angle to the centre of the circle, 1/s.
        cross_track: distance off their circles or places for which boats turn by 1 rad, m.
        max_yaw_offset: largest such turn, rad.
        keep_up: speed of end boats for their distance behind the vessel, 1/s.
    """

    sigma: float = 1.0
    steering: float = 2.0
    max_speed: float = 0.04
    vessel_yaw: float = 0.5
    cross_track: float = 0.04
    max_yaw_offset: float = 0.5
    keep_up: float = 0.5


GAINS = PaperGains()
"""The gains by default."""
