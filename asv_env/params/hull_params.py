"""Floating hulls: size, mass, drag, thrust."""

import math
from dataclasses import dataclass, replace
from typing import Annotated, Any, Self

from asv_env import geometry
from asv_env.checks import TINY, Name, check_fields, check_numbers
from asv_env.params.ranges import (
    Accelerations,
    AddedInertia,
    AddedMasses,
    BoatLength,
    Drag,
    DragPair,
    Fraction,
    FullMotion,
    Inertia,
    Lag,
    Mass,
    Responses,
    Thrust,
    VesselLength,
)

THRUST_LAWS = ("linear", "quadratic")
NOMINAL_LENGTH = 0.40  #: length of the nominal vessel, m
FIN_ADDED_MASS = 0.425  #: added mass of the fins over their quadratic drag, widths of the hull


@dataclass(frozen=True)
class HullParams:
    """A floating rigid body: size, mass and the drag of the water on it.

    The drag along each axis is ``(linear + quadratic * |v|) * v`` of the velocity relative to
    the water. The water that a hull moves with it adds to its mass, by axis, and to its inertia.
    """

    length: VesselLength  #: m
    width: VesselLength  #: m
    mass: Mass  #: dry mass, kg
    added_mass: AddedMasses  #: of the water (A11 in surge, A22 in sway), kg
    inertia: Inertia | None  #: about the centre, kg m^2; None takes that of a uniform hull
    added_inertia: AddedInertia  #: of the water (A66 in yaw), kg m^2
    surge: DragPair  #: drag along +x, (linear kg/s, quadratic kg/m)
    sway: DragPair  #: drag along +y, (linear kg/s, quadratic kg/m)
    yaw: DragPair  #: drag moment, (linear N m s, quadratic N m s^2)

    def __post_init__(self) -> None:
        check_fields(self)

    @property
    def outline(self) -> list[tuple[float, float]]:
        """Corners of the hull, convex and counter-clockwise, m; the bow points towards +x."""
        return geometry.rectangle(self.length, self.width)

    @property
    def masses(self) -> tuple[float, float, float]:
        """Effective masses in surge and sway, kg, and effective inertia in yaw, kg m^2."""
        surge, sway = self.added_mass
        return self.mass + surge, self.mass + sway, self.total_inertia

    @property
    def contact_mass(self) -> float:
        """The one mass that contacts see, kg: that of the axis along which the hull is pushed."""
        return self.masses[0]

    @property
    def total_inertia(self) -> float:
        """Dry plus added inertia, kg m^2."""
        dry = self.inertia
        if dry is None:
            dry = self.mass * geometry.polygon_gyration(self.outline)
        return dry + self.added_inertia

    def linearised(self, speed: float, yaw_rate: float) -> Self:
        """Returns the hull with linear drag, that of the full one at a speed, m/s, and yaw rate."""
        linear: dict[str, Any] = {}
        for axis, at in (("surge", speed), ("sway", speed), ("yaw", yaw_rate)):
            slope, curvature = getattr(self, axis)
            linear[axis] = (slope + curvature * at, 0.0)
        return replace(self, **linear)


@dataclass(frozen=True)
class BoatParams(HullParams):
    """A differential-drive micro-ASV. Nominal: 12 cm long, 0.23 m/s at full thrust.

    ``benchmarks/coefficients.py`` derives the nominal coefficients, ``docs/physics.md`` explains
    them.
    """

    length: BoatLength = 0.12
    width: BoatLength = 0.065
    mass: Mass = 0.10
    added_mass: AddedMasses = (0.014, 0.042)
    inertia: Inertia | None = 1.55e-4
    added_inertia: AddedInertia = 2e-5
    surge: DragPair = (0.0278, 0.26)
    sway: DragPair = (0.078, 0.62)
    yaw: DragPair = (3.9e-4, 3.4e-5)
    bow: float = 0.02  #: width of the flat bow, at most that of the hull, m
    thrust: Thrust = 0.010  #: of one motor at full command ahead, N
    astern: Fraction = 0.6  #: thrust astern as a fraction of that ahead
    lever_arm: BoatLength = 0.024  #: distance of each motor from the centre line, m
    lag: Lag = 0.1  #: first-order time constant of the thrusters, s
    #: thrust of a motor by its signal: "linear", or "quadratic" for a propeller's speed
    thrust_law: Annotated[str, Name(THRUST_LAWS)] = "linear"
    full_speed: FullMotion = 0.2  #: forward speed of a full tracking action, m/s
    #: yaw rate of a full tracking action, rad/s; nominal: that of turning on the spot
    full_yaw_rate: FullMotion = 0.7
    #: (surge, yaw) time constants with which the autopilot's reference follows a set-point, s
    response: Responses = (0.4, 0.2)
    #: (surge m/s^2, yaw rad/s^2) largest accelerations of the autopilot's reference
    acceleration: Accelerations = (0.2, 1.0)

    def __post_init__(self) -> None:
        super().__post_init__()
        check_numbers(self, "bow", TINY, min(self.width, self.length))

    @property
    def outline(self) -> list[tuple[float, float]]:
        """Corners of the hull with its flat bow, convex and counter-clockwise, m."""
        return geometry.boat_hull(self.length, self.width, self.bow)

    def scaled(self, factor: float) -> Self:
        """Returns the hull with every length times ``factor``; masses and thrust stay."""
        return replace(
            self,
            length=self.length * factor,
            width=self.width * factor,
            bow=self.bow * factor,
            lever_arm=self.lever_arm * factor,
            inertia=None,
            added_inertia=self.added_inertia * factor**2,
            yaw=(self.yaw[0] * factor**2, self.yaw[1] * factor**3),
        )


@dataclass(frozen=True)
class VesselParams(HullParams):
    """A floating plank with cross fins at both ends, which limit its motion along its length.

    The coefficients are those of the bare hull, derived as the boat's; ``with_fins`` adds what
    the fins do.
    """

    length: VesselLength = NOMINAL_LENGTH
    width: VesselLength = 0.15
    mass: Mass = 0.60
    added_mass: AddedMasses = (0.022, 0.12)
    inertia: Inertia | None = 9.1e-3
    added_inertia: AddedInertia = 1.1e-3
    surge: DragPair = (0.0681, 0.67)
    sway: DragPair = (0.111, 1.8)
    yaw: DragPair = (1.5e-3, 3.6e-3)
    fins: Drag = 3.6  #: quadratic surge drag of the fins, kg/m, on top of the bare hull's

    @property
    def contact_mass(self) -> float:
        """The one mass that contacts see, kg: that in sway, in which the vessel is pushed."""
        return self.masses[1]

    def stretched(self, length: float) -> Self:
        """Returns the vessel at another length, with the same width, draft and fins.

        Mass, added mass in sway and sway drag grow in proportion, added inertia and linear yaw
        drag with the third power, the quadratic one with the fourth. In surge added mass and
        quadratic drag stay, those of the ends; skin friction grows with the root.
        """
        k = length / self.length
        return replace(
            self,
            length=length,
            mass=self.mass * k,
            added_mass=(self.added_mass[0], self.added_mass[1] * k),
            inertia=self.inertia if k == 1 else None,
            added_inertia=self.added_inertia * k**3,
            surge=(self.surge[0] * math.sqrt(k), self.surge[1]),
            sway=(self.sway[0] * k, self.sway[1] * k),
            yaw=(self.yaw[0] * k**3, self.yaw[1] * k**4),
        )

    def with_fins(self) -> Self:
        """Returns the hull whose coefficients are those of hull and fins together.

        The fins are plates across the hull, so they also resist yaw, by how their parts move.
        """
        surge, quadratic = self.surge
        moment, moment_quadratic = self.yaw
        ahead, across = self.added_mass
        water = FIN_ADDED_MASS * self.width * self.fins
        return replace(
            self,
            fins=0.0,
            added_mass=(ahead + water, across),
            added_inertia=self.added_inertia + water * self.width**2 / 12,
            surge=(surge, quadratic + self.fins),
            yaw=(moment, moment_quadratic + self.fins * self.width**3 / 32),
        )
