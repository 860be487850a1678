"""Floating hulls: size, mass, drag, thrust."""

import math
from dataclasses import dataclass, replace
from typing import Annotated, Any, Self

from asv_env import geometry, polygons
from asv_env.checks import TINY, Name, check_fields, check_numbers
from asv_env.params import strips
from asv_env.params.outlines import Corners, Outline
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
NOMINAL_WIDTH = 0.15  #: width of the nominal vessel, and of its fins, m
NOMINAL_FINS = 3.6  #: quadratic surge drag of the nominal vessel's fins, kg/m
FIN_ADDED_MASS = 0.425  #: added mass of the fins over their quadratic drag, widths of the fins
AREAL_MASS = 10.0  #: mass of the nominal vessel over its area, kg/m^2: a draft of 1 cm
BOTTOM_FRICTION = 0.111 / (math.sqrt(NOMINAL_WIDTH) * NOMINAL_LENGTH)
"""Linear friction of the nominal vessel's bottom per area and root of length, kg/(s m^1.5)."""
SAME = 1e-6  #: relative difference of extents that counts as none


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
    def corners(self) -> list[tuple[float, float]]:
        """Corners of the hull as it is drawn and collides, counter-clockwise, m; the bow is at +x.

        The origin is the centre of mass.
        """
        return geometry.rectangle(self.length, self.width)

    @property
    def reach(self) -> float:
        """Distance of the farthest corner from the centre, m."""
        return polygons.reach(self.corners)

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
            dry = self.mass * polygons.gyration(self.corners)
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
    def corners(self) -> list[tuple[float, float]]:
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
    the fins do. A hull of another ``outline`` is made by ``shaped``.
    """

    length: VesselLength = NOMINAL_LENGTH
    width: VesselLength = NOMINAL_WIDTH
    mass: Mass = 0.60
    added_mass: AddedMasses = (0.022, 0.12)
    inertia: Inertia | None = 9.1e-3
    added_inertia: AddedInertia = 1.1e-3
    surge: DragPair = (0.0681, 0.67)
    sway: DragPair = (0.111, 1.8)
    yaw: DragPair = (1.5e-3, 3.6e-3)
    fins: Drag = NOMINAL_FINS  #: quadratic surge drag of the fins, on top of the bare hull's, kg/m
    #: corners (x, y) of the hull, m, shifted so that the centroid is the origin; ``length`` and
    #: ``width`` are its extents; None: a rectangle
    outline: Annotated[Corners, Outline()] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.outline is None:
            return
        left, right, bottom, top = self.extents
        for name, extent in (("length", right - left), ("width", top - bottom)):
            given = getattr(self, name)
            if abs(given - extent) > SAME * extent:
                raise ValueError(
                    f"VesselParams.{name} = {given:g}: the outline's is {extent:g} m; leave it "
                    "out, and make the outline with VesselParams.shaped or the option vessel"
                )
            object.__setattr__(self, name, extent)

    @classmethod
    def shaped(cls, outline: Any, mass: float | None = None) -> Self:
        """Returns a vessel of an outline, whose coefficients follow from it.

        Inertia is that of a uniform hull, added mass and drag are ``strips.coefficients``; the
        fins are the nominal vessel's.

        Args:
            outline: corners (x, y), m.
            mass: kg; None takes that at the nominal vessel's draft.
        """
        corners = Outline().checked("VesselParams.outline", outline)
        left, right, bottom, top = polygons.extents(corners)
        mass = AREAL_MASS * polygons.area(corners) if mass is None else mass
        derived = strips.coefficients(corners, mass, BOTTOM_FRICTION)
        length, width = right - left, top - bottom
        return cls(length, width, mass, inertia=None, outline=corners, **derived)

    @property
    def corners(self) -> list[tuple[float, float]]:
        """Corners of the hull as it is drawn and collides, counter-clockwise, m."""
        return super().corners if self.outline is None else list(self.outline)

    @property
    def extents(self) -> tuple[float, float, float, float]:
        """Least and largest u along the hull, least and largest w across it, m."""
        return polygons.extents(self.corners)

    @property
    def size(self) -> float:
        """The vessel's length as a unit of the task's lengths, m.

        That of another outline is the length of a plank of the nominal proportions and the same
        area, or the larger extent if that is more.
        """
        if self.outline is None:
            return self.length
        alike = math.sqrt(polygons.area(self.outline) * NOMINAL_LENGTH / NOMINAL_WIDTH)
        return max(self.length, self.width, alike)

    @property
    def contact_mass(self) -> float:
        """The one mass that contacts see, kg: that in sway, in which the vessel is pushed."""
        return self.masses[1]

    def stretched(self, length: float) -> Self:
        """Returns the rectangular vessel at another length, with the same width, draft and fins.

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
        breadth = self.fin_breadth
        water = FIN_ADDED_MASS * breadth * self.fins
        return replace(
            self,
            fins=0.0,
            added_mass=(ahead + water, across),
            added_inertia=self.added_inertia + water * breadth**2 / 12,
            surge=(surge, quadratic + self.fins),
            yaw=(moment, moment_quadratic + self.fins * breadth**3 / 32),
        )

    @property
    def fin_breadth(self) -> float:
        """Breadth of the fins, m: a rectangle's width, else that of similar plates of this drag."""
        if self.outline is None:
            return self.width
        return min(self.width, NOMINAL_WIDTH * math.sqrt(self.fins / NOMINAL_FINS))
