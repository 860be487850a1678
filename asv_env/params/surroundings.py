"""What surrounds the hulls: water, sensors, clocks, and what varies between episodes."""

import math
from dataclasses import dataclass

from asv_env.checks import TINY, check_interval, check_numbers, check_whole, choice

CURRENTS = ("still", "uniform", "gyre", "double_gyre")


@dataclass(frozen=True)
class WaterParams:
    """The water: drag model, current, contact friction and walls."""

    drag: str = "quadratic"  #: or "linear": plain linear and angular damping
    linear_speed: float = 0.10  #: at which linear drag equals the full one, m/s
    linear_yaw_rate: float = 0.5  #: at which linear drag equals the full one, rad/s
    # A gyre is one vortex round the origin, a double gyre two side by side, with a jet between
    # them through the origin.
    current: str = "still"  #: one of ``CURRENTS``
    current_speed: float = 0.0  #: peak speed of the current, m/s
    current_heading: float = 0.0  #: direction in which a uniform current flows, rad
    gyre_size: float = 1.5  #: side of one square vortex cell, m; the pattern repeats beyond
    contact_friction: float = 0.3  #: Coulomb friction coefficient between hulls
    walls: float | None = None  #: half the side of a square basin with walls, m; None is open water

    def __post_init__(self) -> None:
        choice("drag", self.drag, ("quadratic", "linear"))
        choice("current", self.current, CURRENTS)
        check_numbers(self, "linear_speed linear_yaw_rate current_speed contact_friction", 0.0)
        check_numbers(self, "current_heading", -math.inf)
        check_numbers(self, "gyre_size", TINY)
        if self.walls is not None:
            check_numbers(self, "walls", TINY)


@dataclass(frozen=True)
class SensorParams:
    """White noise of the measurement at each sensing tick, and expectations of its filter."""

    position_noise: float = 0.0  #: standard deviation of x and of y, m
    heading_noise: float = 0.0  #: standard deviation of the heading, rad
    speed_noise: float = 0.0  #: standard deviation of vx and of vy, m/s
    yaw_rate_noise: float = 0.0  #: standard deviation of the yaw rate, rad/s
    acceleration: float = 0.05  #: that the filter expects of a boat, m/s^2
    yaw_acceleration: float = 0.5  #: that the filter expects of a boat, rad/s^2
    vessel_acceleration: float = 0.02  #: that the filter expects of the vessel, m/s^2
    vessel_yaw_acceleration: float = 0.05  #: that the filter expects of the vessel, rad/s^2

    def __post_init__(self) -> None:
        check_numbers(self, "position_noise heading_noise speed_noise yaw_rate_noise", 0.0)
        check_numbers(self, "acceleration yaw_acceleration", TINY)
        check_numbers(self, "vessel_acceleration vessel_yaw_acceleration", TINY)

    @property
    def exact(self) -> bool:
        """Whether the measurement is the truth."""
        noise = (self.position_noise, self.heading_noise, self.speed_noise, self.yaw_rate_noise)
        return not any(noise)


@dataclass(frozen=True)
class ClockParams:
    """Rates of the clocks, Hz; physics is a whole multiple of sensing, sensing of control."""

    physics: int = 50  #: physics steps
    sensing: int = 10  #: measurements
    control: int = 10  #: actions

    def __post_init__(self) -> None:
        check_whole(self, "physics sensing control", 1)
        for fast, slow in (("physics", "sensing"), ("sensing", "control")):
            if getattr(self, fast) % getattr(self, slow):
                raise ValueError(
                    f"ClockParams: {fast} at {getattr(self, fast)} Hz is not a whole multiple "
                    f"of {slow} at {getattr(self, slow)} Hz; choose rates that divide"
                )

    @property
    def dt(self) -> float:
        """Duration of a physics step, s."""
        return 1.0 / self.physics


@dataclass(frozen=True)
class VariationParams:
    """Random differences of each episode from the nominal world; a width of zero is none."""

    thrust: float = 0.0  #: largest relative difference of each motor's thrust
    drag: float = 0.0  #: largest relative difference of each hull's drag
    mass: float = 0.0  #: largest relative difference of each hull's mass
    lag: tuple[float, float] | None = None  #: (smallest, largest), s; None keeps the boat's
    friction: tuple[float, float] | None = None  #: (smallest, largest); None: the water's
    failures: int = 0  #: number of boats whose thrusters fail
    failure_time: tuple[float, float] = (5.0, 60.0)  #: (earliest, latest) time of a failure, s

    def __post_init__(self) -> None:
        check_numbers(self, "thrust drag mass", 0.0, 0.95)
        for name in ("lag", "friction"):
            if getattr(self, name) is not None:
                check_interval(self, name, TINY)
        check_interval(self, "failure_time", 0.0)
        check_whole(self, "failures", 0)
