"""What surrounds the hulls: water, sensors, clocks, and what varies between episodes."""

from dataclasses import dataclass
from typing import Annotated

from asv_env.checks import Name, check_fields, finite
from asv_env.params.ranges import (
    Acceleration,
    Angle,
    Bias,
    Count,
    Distance,
    Duration,
    DurationOrZero,
    Durations,
    Friction,
    Frictions,
    Lags,
    Loads,
    Noise,
    Rate,
    Share,
    SizeSpread,
    Speed,
    Spread,
    Switch,
)

DRAGS = ("quadratic", "linear")
CURRENTS = ("still", "uniform", "gyre", "double_gyre")
FAILURE_CLOCKS = ("start", "closure")


@dataclass(frozen=True)
class WaterParams:
    """The water: drag model, current, contact friction and walls."""

    #: "quadratic", or "linear": plain linear and angular damping
    drag: Annotated[str, Name(DRAGS)] = "quadratic"
    linear_speed: Speed = 0.10  #: at which linear drag equals the full one, m/s
    linear_yaw_rate: Speed = 0.5  #: at which linear drag equals the full one, rad/s
    # A gyre is one vortex round the origin, a double gyre two side by side, with a jet between
    # them through the origin.
    current: Annotated[str, Name(CURRENTS)] = "still"  #: one of ``CURRENTS``
    current_speed: Speed = 0.0  #: peak speed of the current, m/s
    current_heading: Angle = 0.0  #: direction in which a uniform current flows, rad
    gyre_size: Distance = 1.5  #: side of one square vortex cell, m; the pattern repeats beyond
    gyre_phase: Angle = 0.0  #: by which the pattern is shifted along x; a cell is pi long, rad
    # Gusts are added to the current everywhere alike, an Ornstein-Uhlenbeck process.
    gust_speed: Speed = 0.0  #: standard deviation of each component of the gusts, m/s
    gust_time: Duration = 20.0  #: time in which gusts forget what they were, s
    contact_friction: Friction = 0.3  #: Coulomb friction coefficient between hulls
    #: share by which the drag of hulls' sides that face each other falls in contact
    shelter: Share = 0.0
    #: half the side of a square basin with walls, m; None is open water
    walls: Distance | None = None

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True)
class SensorParams:
    """Who measures what, with which noise, delay and losses, and what the filter expects.

    Raises:
        ValueError: also a range within which nothing can be seen, or a range of a measurement that
            all boats share.
    """

    #: whether all boats share one measurement of all bodies; else each has its own
    shared: Switch = True
    #: distance beyond which a boat does not see other bodies, m; None: it sees all. With
    #: ``shared=False`` alone
    range: Distance | None = None
    position_noise: Noise = 0.0  #: standard deviation of x and of y, m
    heading_noise: Noise = 0.0  #: standard deviation of the heading, rad
    speed_noise: Noise = 0.0  #: standard deviation of vx and of vy, m/s
    yaw_rate_noise: Noise = 0.0  #: standard deviation of the yaw rate, rad/s
    #: time until the boats have what was measured and estimated, s, a whole number of control ticks
    delay: DurationOrZero = 0.0
    #: probability that the measurement of a body at a sensing tick is lost; with ``shared=False``
    #: a boat's measurement of itself never is
    dropout: Spread = 0.0
    acceleration: Acceleration = 0.05  #: that the filter expects of a boat, m/s^2
    yaw_acceleration: Acceleration = 1.5  #: that the filter expects of a boat, rad/s^2
    vessel_acceleration: Acceleration = 0.02  #: that the filter expects of the vessel, m/s^2
    vessel_yaw_acceleration: Acceleration = 0.05  #: that the filter expects of the vessel, rad/s^2

    def __post_init__(self) -> None:
        if (reach := finite(self.range)) is not None and reach <= 0.0:
            raise ValueError(
                f"sensors: range = {reach:g} m: a boat would see nothing; give a distance above 0, "
                "or None to see everything"
            )
        check_fields(self)
        if self.shared and self.range is not None:
            raise ValueError(
                f"sensors: range = {self.range:g} m is that of boats which sense for themselves; "
                "give shared=False too, or range=None"
            )

    @property
    def noiseless(self) -> bool:
        """Whether a measurement is the truth of its time."""
        noise = (self.position_noise, self.heading_noise, self.speed_noise, self.yaw_rate_noise)
        return not any(noise)

    @property
    def exact(self) -> bool:
        """Whether the boats always know the truth."""
        return self.noiseless and self.range is None and not (self.delay or self.dropout)


@dataclass(frozen=True)
class ClockParams:
    """Rates of the clocks, Hz; physics is a whole multiple of sensing, sensing of control."""

    physics: Rate = 50  #: physics steps
    sensing: Rate = 10  #: measurements
    control: Rate = 10  #: actions

    def __post_init__(self) -> None:
        check_fields(self)
        for fast, slow in (("physics", "sensing"), ("sensing", "control")):
            if getattr(self, fast) % getattr(self, slow):
                raise ValueError(
                    f"ClockParams: {fast} at {getattr(self, fast)} Hz is not a whole multiple "
                    f"of {slow} at {getattr(self, slow)} Hz; choose rates that divide"
                )

    def ticks(self, time: float) -> int:
        """Returns the nearest whole number of control ticks to a time, s."""
        return round(time * self.control)

    def rounded(self, time: float) -> float:
        """Returns the time, s, of that number of control ticks."""
        return self.ticks(time) / self.control

    @property
    def dt(self) -> float:
        """Duration of a physics step, s."""
        return 1.0 / self.physics


@dataclass(frozen=True)
class VariationParams:
    """Differences of each episode from the nominal world; a width of zero is none."""

    thrust: Spread = 0.0  #: largest relative difference of each motor's thrust
    #: relative difference by which all right motors are stronger and all left ones weaker
    thrust_bias: Bias = 0.0
    drag: Spread = 0.0  #: largest relative difference of each hull's drag
    mass: Spread = 0.0  #: largest relative difference of each hull's mass
    #: largest relative difference of each boat's lengths; its motors stay
    boat_size: SizeSpread = 0.0
    lag: Lags | None = None  #: (smallest, largest), s; None keeps the boat's
    friction: Frictions | None = None  #: (smallest, largest); None: the water's
    #: time after which a command reaches the thrusters, s, a whole number of control ticks
    actuation_delay: DurationOrZero = 0.0
    load: Loads | None = None  #: (smallest, largest) factor on the vessel's mass; None: 1
    failures: Count = 0  #: number of boats whose thrusters fail
    failure_time: Durations = (5.0, 60.0)  #: (earliest, latest) time of a failure, s
    #: from when that time counts: "start" of the episode, or "closure", when it is first formed
    failure_clock: Annotated[str, Name(FAILURE_CLOCKS)] = "start"

    def __post_init__(self) -> None:
        check_fields(self)

    @property
    def largest_thrust(self) -> float:
        """Largest factor on the thrust of a motor."""
        return (1.0 + self.thrust) * (1.0 + abs(self.thrust_bias))
