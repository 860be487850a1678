"""Numbers that the paper prints, and those of its controller that it leaves open."""

from dataclasses import dataclass
from typing import Annotated

from asv_env.checks import TINY, Number, check_fields
from asv_env.params.ranges import Angle, Distance, DistanceOrZero, Duration

ARRIVAL_TIME = {"tracking": 80.0, "thrusters": 30.0}
"""T_goal of the paper's experiment and of its simulation, s, for a vessel of 0.40 m."""
IN_RANGE = 0.20  #: distance of the vessel to the goal at which the motors are turned off, m
MEAN_SPEEDS = (0.02, 0.10)  #: bounds of the vessel's mean speed, m/s, whatever its drag
PAPER_GOAL = (
    0.55,
    -0.95,
    0.1,
)  #: goal of the experiment from the vessel at closure, m, m, rad
PAPER_TRIALS = 12  #: number of trials of the paper's experiment in the tank, Sec. IV-B
PAPER_POSITION = (
    4.88,
    1.8,
)  #: mean and standard deviation of the smallest distance to the goal, cm
PAPER_HEADING = (-0.26, 0.44)  #: those of the heading error at that instant, rad

Positive = Annotated[float, Number(TINY, 1e3)]
AtLeastOne = Annotated[float, Number(1.0, 1e3)]
NotNegative = Annotated[float, Number(0.0, 1e3)]


@dataclass(frozen=True)
class PaperGains:
    """The free parameters of the paper's controller: as printed, and what the paper leaves open.

    Steering is well below the bandwidth of the autopilot. Boats skid, so that much faster ones
    miss their targets and ram the vessel. The gains of the push suit vessels and boats that differ
    from the nominal ones (scenario "mismatch"): with a larger `cross_track` the vessel leaves its
    circle, with more `vessel_yaw` it swings.

    Raises:
        ValueError: a value is not finite, or out of range.
    """

    #: turn of the first arc, rad, as printed; None: that of the shortest path for each goal
    alpha1: Angle | None = 1.0
    #: least radius of those paths, half-lengths of the vessel, where time permits
    min_radius: AtLeastOne = 1.0
    #: T_goal for a vessel of 0.40 m, s; None: the paper's, by the kind of actions
    arrival_time: Duration | None = None
    sigma: Positive = 1.0  #: decay of the spiral (Eq 2), rad; 1 in the paper's experiment
    steering: Positive = 2.0  #: K = 2 beta / b of Eq (3): yaw rate for the heading error, 1/s
    max_speed: Positive = 0.04  #: largest speed on the approach, m/s
    stop_distance: Distance = IN_RANGE  #: distance to the goal where the motors go off, m
    #: mean speed of the vessel, m/s; None: that from which it coasts the stop distance
    push_speed: Positive | None = None
    #: integral gain of the vessel's speed error, 1/s; as printed, the speed control has none
    speed_integral: NotNegative = 0.0
    switch_distance: DistanceOrZero = 0.0  #: path length before the second arc to switch, m
    vessel_yaw: Positive = 0.5  #: yaw rate for the angle to the centre of the circle, 1/s
    cross_track: Positive = 0.04  #: distance off circle or place for which boats turn by 1 rad, m
    max_yaw_offset: Positive = 0.5  #: largest such turn, rad
    keep_up: Positive = 0.5  #: speed of end boats for their distance behind the vessel, 1/s

    def __post_init__(self) -> None:
        check_fields(self)


GAINS = PaperGains()  #: the gains by default
