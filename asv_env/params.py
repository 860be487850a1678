"""Every parameter of the environment: frozen dataclasses in SI units, validated when made."""

from __future__ import annotations

import math
import operator
from dataclasses import dataclass, field, fields, replace
from typing import Any, Self

from asv_env import geometry
from asv_env.checks import (
    check_interval,
    check_number,
    check_numbers,
    check_pair,
    check_whole,
    choice,
)

TASKS = ("approach", "push", "transport")
ACTION_MODES = ("tracking", "thrusters")
CURRENTS = ("still", "uniform", "gyre", "double_gyre")
SIDES = ("+n", "-n", "goal")
GOAL_ANCHORS = ("world", "closure")
NOMINAL_LENGTH = 0.40
SMALLEST_CAGE = 4
"""Smallest team whose first and last boats cage the ends of the vessel."""
TINY = 1e-9


@dataclass(frozen=True)
class HullParams:
    """A floating rigid body: size, mass and the drag of the water on it.

    The drag along each axis is ``(linear + quadratic * |v|) * v`` of the velocity relative to
    the water. Added mass acts as effective mass and inertia, the same along every axis.

    Attributes:
        length: m.
        width: m.
        mass: dry mass, kg.
        added_mass: effective added mass, kg.
        inertia: about the centre, kg m^2; None takes that of a uniform hull of this outline.
        added_inertia: effective added inertia, kg m^2.
        surge: (linear kg/s, quadratic kg/m) drag along the hull's +x axis.
        sway: (linear kg/s, quadratic kg/m) drag along its +y axis.
        yaw: (linear N m s, quadratic N m s^2) drag moment.
    """

    length: float
    width: float
    mass: float
    added_mass: float
    inertia: float | None
    added_inertia: float
    surge: tuple[float, float]
    sway: tuple[float, float]
    yaw: tuple[float, float]

    def __post_init__(self) -> None:
        check_numbers(self, "length width mass", TINY)
        check_numbers(self, "added_mass added_inertia", 0.0)
        if self.inertia is not None:
            check_number(self, "inertia", TINY)
        for name in ("surge", "sway", "yaw"):
            check_pair(self, name, 0.0, "(linear, quadratic) drag")

    @property
    def outline(self) -> list[tuple[float, float]]:
        """Convex polygon of the hull, counter-clockwise, m, bow towards +x."""
        return geometry.rectangle(self.length, self.width)

    @property
    def total_mass(self) -> float:
        """Dry plus added mass, kg."""
        return self.mass + self.added_mass

    @property
    def total_inertia(self) -> float:
        """Dry plus added inertia, kg m^2."""
        dry = self.inertia
        if dry is None:
            dry = self.mass * geometry.polygon_gyration(self.outline)
        return dry + self.added_inertia

    def linearised(self, speed: float, yaw_rate: float) -> Self:
        """The same hull with linear drag, equal to the full drag at one speed.

        Args:
            speed: m/s at which surge and sway drag are to agree.
            yaw_rate: rad/s at which the drag moments are to agree.
        """

        def linear(pair: tuple[float, float], at: float) -> tuple[float, float]:
            return (pair[0] + pair[1] * at, 0.0)

        return replace(
            self,
            surge=linear(self.surge, speed),
            sway=linear(self.sway, speed),
            yaw=linear(self.yaw, yaw_rate),
        )


@dataclass(frozen=True)
class BoatParams(HullParams):
    """A differential-drive micro-ASV. Nominal: 12 cm long, 0.23 m/s at full thrust.

    Attributes:
        bow: width of the flat bow, m.
        thrust: of one motor at full command ahead, N.
        astern: thrust astern as a share of that ahead.
        lever_arm: distance of each motor from the centre line, m.
        lag: first-order time constant of the thrusters, s.
    """

    length: float = 0.12
    width: float = 0.065
    mass: float = 0.10
    added_mass: float = 0.02
    inertia: float | None = 1.55e-4
    added_inertia: float = 0.66e-4
    surge: tuple[float, float] = (0.03, 0.25)
    sway: tuple[float, float] = (0.08, 0.67)
    yaw: tuple[float, float] = (1e-4, 3.6e-5)
    bow: float = 0.02
    thrust: float = 0.010
    astern: float = 0.6
    lever_arm: float = 0.02
    lag: float = 0.1

    def __post_init__(self) -> None:
        super().__post_init__()
        check_number(self, "bow", TINY, min(self.width, self.length))
        check_numbers(self, "thrust lever_arm lag", TINY)
        check_number(self, "astern", 0.0, 1.0)

    @property
    def outline(self) -> list[tuple[float, float]]:
        """Convex polygon of the hull with its flat bow, m."""
        return geometry.boat_hull(self.length, self.width, self.bow)

    def scaled(self, factor: float) -> BoatParams:
        """The hull with every length times ``factor``; masses, drag and thrust as they are."""
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
    """The floating plank, with cross fins at both ends that limit its motion along its length.

    Attributes:
        fins: quadratic surge drag of the fins, kg/m, on top of the bare hull's.
    """

    length: float = NOMINAL_LENGTH
    width: float = 0.15
    mass: float = 0.60
    added_mass: float = 0.08
    inertia: float | None = 9.1e-3
    added_inertia: float = 0.8e-3
    surge: tuple[float, float] = (0.20, 0.75)
    sway: tuple[float, float] = (0.10, 2.0)
    yaw: tuple[float, float] = (1.5e-3, 4e-3)
    fins: float = 3.6

    def __post_init__(self) -> None:
        super().__post_init__()
        check_number(self, "fins", 0.0)

    def stretched(self, length: float) -> VesselParams:
        """The vessel at another length, of the same width and draft, with the same fins.

        Mass and sway drag grow in proportion, the linear yaw drag with the third power and
        the quadratic one with the fourth; the bare hull's surge drag stays.
        """
        k = length / self.length
        return replace(
            self,
            length=length,
            mass=self.mass * k,
            added_mass=self.added_mass * k,
            inertia=self.inertia if k == 1 else None,
            added_inertia=self.added_inertia * k**3,
            sway=(self.sway[0] * k, self.sway[1] * k),
            yaw=(self.yaw[0] * k**3, self.yaw[1] * k**4),
        )


@dataclass(frozen=True)
class WaterParams:
    """The water and what it does.

    Attributes:
        drag: "quadratic" for the full model, "linear" for plain linear and angular damping.
        linear_speed: m/s and
        linear_yaw_rate: rad/s at which linear drag equals the full one.
        current: "still", "uniform", "gyre" (one vortex round the origin) or "double_gyre"
            (two side by side, with a jet between them through the origin).
        current_speed: its (peak) speed, m/s.
        current_heading: where a uniform current flows to, rad.
        gyre_size: side of one square vortex cell, m; the pattern repeats beyond.
        contact_friction: Coulomb coefficient between hulls.
        walls: half the side of a square basin with walls, m; None is open water.
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
        check_number(self, "current_heading", -math.inf)
        check_number(self, "gyre_size", TINY)
        if self.walls is not None:
            check_number(self, "walls", TINY)


@dataclass(frozen=True)
class SensorParams:
    """Standard deviations of the measurement, fresh at each sensing tick, and of its filter.

    Attributes:
        position_noise: m, each of x and y.
        heading_noise: rad.
        speed_noise: m/s, each of vx and vy.
        yaw_rate_noise: rad/s.
        acceleration: m/s^2 and
        yaw_acceleration: rad/s^2 that the filter expects of a boat.
        vessel_acceleration: m/s^2 and
        vessel_yaw_acceleration: rad/s^2 that it expects of the vessel.
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
    """Rates in Hz. Physics is a whole multiple of sensing, sensing of control."""

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
        """Physics step, s."""
        return 1.0 / self.physics


@dataclass(frozen=True)
class TaskParams:
    """What is to be done, where, and when it counts. Lengths fit the nominal 0.40 m vessel.

    Attributes:
        name: "approach", "push" or "transport".
        goal: (x m, y m, heading rad) fixed goal pose; None draws one for each episode.
        goal_distance: (smallest, largest) distance of a drawn goal, m.
        goal_anchor: "world", or "closure": the goal is relative to the vessel's pose at the
            moment of closure, as in the paper's experiment.
        side: of the vessel from which the boats push: "+n", "-n", or "goal", the side away
            from the goal.
        start_distance: (smallest, largest) distance at which boats start, m.
        start_spacing: smallest distance between boats at the start, boat lengths.
        arena: half the side of the square that no body may leave, m.
        time_limit: s; None takes 120 s for approach and push, 180 s for transport.
        position_tolerance: of a delivery, m.
        heading_tolerance: of a delivery, rad.
        speed_tolerance: of a delivered vessel through the local water, m/s.
        yaw_rate_tolerance: of a delivered vessel, rad/s.
        nearing_tolerance: m/s below which a vessel is said to come no nearer.
        slot_distance: within which a slot is held, m.
        slot_angle: within which a slot is held, rad.
        slot_speed: relative to the vessel, below which a slot is held, m/s.
        hold_time: for which all slots must be held to succeed at approach, s.
        end_gap: between the end boats and the ends of the vessel, m.
    """

    name: str = "transport"
    goal: tuple[float, float, float] | None = None
    goal_distance: tuple[float, float] = (0.4, 1.2)
    goal_anchor: str = "world"
    side: str = "+n"
    start_distance: tuple[float, float] = (0.5, 1.5)
    start_spacing: float = 1.5
    arena: float = 3.0
    time_limit: float | None = None
    position_tolerance: float = 0.05
    heading_tolerance: float = 0.1
    speed_tolerance: float = 0.01
    yaw_rate_tolerance: float = 0.05
    nearing_tolerance: float = 0.001
    slot_distance: float = 0.03
    slot_angle: float = 0.3
    slot_speed: float = 0.02
    hold_time: float = 1.0
    end_gap: float = 0.005

    def __post_init__(self) -> None:
        choice("task", self.name, TASKS)
        choice("goal_anchor", self.goal_anchor, GOAL_ANCHORS)
        choice("side", self.side, SIDES)
        check_interval(self, "goal_distance", 0.0)
        check_interval(self, "start_distance", TINY)
        check_numbers(self, "nearing_tolerance hold_time end_gap", 0.0)
        check_number(self, "start_spacing", 1.0)
        check_numbers(
            self,
            "arena position_tolerance speed_tolerance yaw_rate_tolerance slot_distance slot_speed",
            TINY,
        )
        check_numbers(self, "heading_tolerance slot_angle", TINY, math.pi)
        if self.time_limit is None:
            object.__setattr__(self, "time_limit", 180.0 if self.name == "transport" else 120.0)
        check_number(self, "time_limit", TINY)
        if self.goal is not None:
            object.__setattr__(self, "goal", self.checked_goal(self.goal))

    def checked_goal(self, goal: Any) -> tuple[float, float, float]:
        """A goal pose as three floats.

        Raises:
            ValueError: not three finite numbers, or outside the arena.
        """
        try:
            x, y, heading = (float(value) for value in goal)
        except (TypeError, ValueError) as error:
            raise ValueError(f"goal = {goal!r}: give three numbers: x m, y m, rad") from error
        if not all(map(math.isfinite, (x, y, heading))):
            raise ValueError(f"goal = {goal!r}: must be finite")
        if max(abs(x), abs(y)) > self.arena:
            raise ValueError(
                f"goal = {goal!r}: outside the arena, whose half-width is {self.arena:g} m; "
                "choose a nearer goal or a larger `arena`"
            )
        return x, y, float(geometry.wrap(heading))

    def scaled(self, factor: float) -> TaskParams:
        """The task for a vessel ``factor`` times as long: distances and time scale with it."""

        def times(pair: tuple[float, float]) -> tuple[float, float]:
            return pair[0] * factor, pair[1] * factor

        assert self.time_limit is not None
        return replace(
            self,
            goal_distance=times(self.goal_distance),
            start_distance=times(self.start_distance),
            arena=self.arena * factor,
            time_limit=self.time_limit * factor,
            position_tolerance=self.position_tolerance * factor,
        )


@dataclass(frozen=True)
class VariationParams:
    """What is drawn anew for each episode, and what breaks. Zero width: as it should be.

    Attributes:
        thrust: each motor's thrust differs by up to this share.
        drag: each hull's drag differs by up to this share.
        mass: each hull's mass differs by up to this share.
        lag: (smallest, largest) thruster time constant, s; None keeps the boat's.
        friction: (smallest, largest) contact friction; None keeps the water's.
        failures: number of boats whose thrusters die.
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


@dataclass(frozen=True)
class RewardParams:
    """Weights of the reward terms; see ``reward.py`` for the terms.

    ``time``, ``effort`` and ``collision`` are those of a second, so that an episode is worth the
    same at any control rate. ``accuracy`` is the share of ``success`` that is paid for how
    exactly the vessel was delivered.
    """

    closure: float = 0.5
    delivery: float = 1.0
    precision: float = 2.0
    success: float = 4.0
    accuracy: float = 0.6
    strayed: float = 4.0
    time: float = 0.05
    effort: float = 0.001
    collision: float = 0.01

    def __post_init__(self) -> None:
        for f in fields(self):
            check_number(self, f.name, 0.0)
        check_number(self, "accuracy", 0.0, 1.0)


@dataclass(frozen=True)
class EnvParams:
    """All parameters of one environment, consistent with each other.

    Raises:
        ValueError: a team that does not fit the vessel, walls inside the start annulus,
            more failures than boats can bear.
    """

    num_boats: int = 4
    action_mode: str = "tracking"
    boat: BoatParams = field(default_factory=BoatParams)
    vessel: VesselParams = field(default_factory=VesselParams)
    water: WaterParams = field(default_factory=WaterParams)
    sensors: SensorParams = field(default_factory=SensorParams)
    clock: ClockParams = field(default_factory=ClockParams)
    task: TaskParams = field(default_factory=TaskParams)
    variation: VariationParams = field(default_factory=VariationParams)
    reward: RewardParams = field(default_factory=RewardParams)

    def __post_init__(self) -> None:
        check_num_boats(self.num_boats)
        choice("action_mode", self.action_mode, ACTION_MODES)
        room = self.pitch - self.boat.width
        if room < 0:
            raise ValueError(
                f"{self.num_boats} boats of width {self.boat.width:g} m do not fit along a "
                f"vessel of length {self.vessel.length:g} m: they need a pitch of at least "
                f"{self.boat.width:g} m and have {self.pitch:.3g} m; use fewer boats, a longer "
                "vessel, or leave its length out and it grows with the team"
            )
        if self.variation.failures >= self.num_boats:
            raise ValueError(
                f"failures = {self.variation.failures}: fewer than num_boats = "
                f"{self.num_boats} can fail, somebody has to push"
            )
        self._check_places()

    def _check_places(self) -> None:
        """Starts and goals are where hulls can be."""
        walls, task = self.water.walls, self.task
        clear = math.hypot(self.vessel.length, self.vessel.width) / 2
        clear += math.hypot(self.boat.length, self.boat.width) / 2
        if task.name != "push" and task.start_distance[0] < clear:
            raise ValueError(
                f"start_distance = {task.start_distance!r}: boats would start in the vessel; "
                f"begin at {clear:.3g} m or more"
            )
        if walls is not None and task.start_distance[0] > walls:
            raise ValueError(
                f"walls = {walls:g} m lie inside start_distance = {task.start_distance!r} m; "
                "make the basin larger"
            )
        if walls is not None and task.goal is not None and max(map(abs, task.goal[:2])) > walls:
            raise ValueError(
                f"goal = {task.goal!r}: outside the walls at {walls:g} m; choose a nearer goal "
                "or a larger basin"
            )

    @property
    def pitch(self) -> float:
        """Distance between neighbouring slots along the side, m."""
        cells = self.num_boats - 1 if self.num_boats >= SMALLEST_CAGE else self.num_boats + 1
        return self.vessel.length / cells

    @property
    def substeps(self) -> int:
        """Physics steps in a control step."""
        return self.clock.physics // self.clock.control

    @property
    def time_limit_ticks(self) -> int:
        """Control ticks after which an episode is truncated."""
        assert self.task.time_limit is not None
        return max(1, round(self.task.time_limit * self.clock.control))

    def hulls(self) -> tuple[VesselParams, BoatParams]:
        """Vessel and boat with the drag that acts: fins counted, linear if so asked."""
        surge, quadratic = self.vessel.surge
        vessel = replace(self.vessel, surge=(surge, quadratic + self.vessel.fins), fins=0.0)
        boat = self.boat
        if self.water.drag == "linear":
            at = (self.water.linear_speed, self.water.linear_yaw_rate)
            vessel, boat = vessel.linearised(*at), boat.linearised(*at)
        return vessel, boat


def check_num_boats(num_boats: Any) -> int:
    """A team size.

    Raises:
        ValueError: not a whole number from 2 to 100.
    """
    try:
        whole = operator.index(num_boats)
    except TypeError:
        whole = 0
    if isinstance(num_boats, bool) or not 2 <= whole <= 100:
        raise ValueError(f"num_boats = {num_boats!r}: must be a whole number from 2 to 100")
    return whole
