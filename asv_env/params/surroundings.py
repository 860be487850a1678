"""What surrounds the hulls: water, sensors, clocks, and what varies between episodes."""

import math
from dataclasses import dataclass

from asv_env.checks import TINY, check_interval, check_numbers, check_whole, choice

CURRENTS = ("still", "uniform", "gyre", "double_gyre")


@dataclass(frozen=True)
class WaterParams:
    """The water: drag model, current, contact friction and walls.

    Attributes:
        drag: "quadratic" for the full model, "linear" for plain linear and angular damping.
        linear_speed: Speed at which linear drag equals the full one, m/s.
        linear_yaw_rate: Yaw rate at which linear drag equals the full one, rad/s.
        current: "still", "uniform", "gyre" (one vortex round the origin) or "double_gyre"
            (two side by side, with a jet between them through the origin).
        current_speed: Peak speed of the current, m/s.
        current_heading: Direction in which a uniform current flows, rad.
        gyre_size: Side of one square vortex cell, m; the pattern repeats beyond.
        contact_friction: Coulomb friction coefficient between hulls.
        walls: Half the side of a square basin with walls, m; None is open water.
    """

    drag: str = "quadratic"
    linear_speed: float = 0.10
    linear_yaw_rate: float = 0.5
    current: str = "still"
    current_speed: float = 0.0
    current_heading: float = 0.0
    gyre_size: float = 1.5
    contact_friction: float = 0.3
    walls: float | None = None

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
    """Noise of the measurement, independent at each sensing tick, and expectations of its filter.

    Attributes:
        position_noise: Standard deviation of x and of y, m.
        heading_noise: Standard deviation of the heading, rad.
        speed_noise: Standard deviation of vx and of vy, m/s.
        yaw_rate_noise: Standard deviation of the yaw rate, rad/s.
        acceleration: Acceleration that the filter expects of a boat, m/s^2.
        yaw_acceleration: Yaw acceleration that the filter expects of a boat, rad/s^2.
        vessel_acceleration: Acceleration that the filter expects of the vessel, m/s^2.
        vessel_yaw_acceleration: Yaw acceleration that it expects of the vessel, rad/s^2.
    """

    position_noise: float = 0.0
    heading_noise: float = 0.0
    speed_noise: float = 0.0
    yaw_rate_noise: float = 0.0
    acceleration: float = 0.05
    yaw_acceleration: float = 0.5
    vessel_acceleration: float = 0.02
    vessel_yaw_acceleration: float = 0.05

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
    """Rates of the clocks; physics is a whole multiple of sensing, sensing of control.

    Attributes:
        physics: Rate of physics steps, Hz.
        sensing: Rate of measurements, Hz.
        control: Rate of actions, Hz.
    """

    physics: int = 50
    sensing: int = 10
    control: int = 10

    def __post_init__(self) -> None:
        for name in ("physics", "sensing", "control"):
            check_whole(self, name, 1)
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
    """Random differences of each episode from the nominal world; a width of zero is none.

    Attributes:
        thrust: Largest relative difference of each motor's thrust.
        drag: Largest relative difference of each hull's drag.
        mass: Largest relative difference of each hull's mass.
        lag: (smallest, largest) thruster time constant, s; None keeps that of the boat.
        friction: (smallest, largest) contact friction; None keeps that of the water.
        failures: Number of boats whose thrusters fail.
        failure_time: (earliest, latest) time of a failure, s.
    """

    thrust: float = 0.0
    drag: float = 0.0
    mass: float = 0.0
    lag: tuple[float, float] | None = None
    friction: tuple[float, float] | None = None
    failures: int = 0
    failure_time: tuple[float, float] = (5.0, 60.0)

    def __post_init__(self) -> None:
        check_numbers(self, "thrust drag mass", 0.0, 0.95)
        for name in ("lag", "friction"):
            if getattr(self, name) is not None:
                check_interval(self, name, TINY)
        check_interval(self, "failure_time", 0.0)
        check_whole(self, "failures", 0)
