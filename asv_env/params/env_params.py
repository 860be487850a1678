"""All parameters of an environment, checked against each other."""

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, fields, replace
from itertools import islice
from typing import Annotated, Any, Self

from asv_env.checks import LARGEST_TEAM, Name, Whole, check_fields, plain
from asv_env.params import obstacle_params
from asv_env.params.hull_params import BoatParams, VesselParams
from asv_env.params.scaling import SCALE, scaled, scaled_shapes
from asv_env.params.surroundings import ClockParams, SensorParams, VariationParams, WaterParams
from asv_env.params.task_params import RewardParams, TaskParams
from asv_env.text import shown

ACTION_MODES = ("tracking", "thrusters", "discrete")
SMALLEST_CAGE = 4  #: smallest team whose first and last boats cage the ends of the vessel
MOST_LENGTHS = {"hull": 100.0, "walls": 1e4, "arena": 1e6}
"""Largest sizes in vessel lengths, which are the cells in which contacts are looked for."""
MOST_FEATURES = 1000  #: most features of an observation
LEAP = 100.0  #: most arenas that a boat at full thrust from rest may cross in a control step
SPIN = 1e3  #: most radians that it may turn in one
DELAYS = (("sensors", "delay"), ("variation", "actuation_delay"))
"""Sections and names of times that are whole numbers of control ticks."""
MOST_TICKS = 100  #: largest such number


def pitches(num_boats: int) -> int:
    """Returns the length of the vessel in pitches of the boats along its side."""
    return num_boats - 1 if num_boats >= SMALLEST_CAGE else num_boats + 1


@dataclass(frozen=True)
class EnvParams:
    """All parameters of one environment, consistent with each other.

    ``presets.make_params`` makes them from names and options. They are values: Python's own
    numbers and texts, in tuples, so that equal parameters are equal and have the same hash.

    Raises:
        ValueError: a world that could not begin, such as a team that does not fit the vessel,
            slots, boats or goals outside the walls or the arena, or in obstacles, more failures
            than boats can bear; or one whose sizes or thrusts are too far apart to be computed.
        TypeError: a section that is not of its class.
    """

    definition: Any  #: the ``asv_env.tasks.Task``: initial states, reward, termination, metrics
    num_boats: Annotated[int, Whole(2, LARGEST_TEAM)] = 4
    #: "tracking": speed and yaw rate; "thrusters"; or "discrete", see ``DISCRETE_ACTIONS``
    action_mode: Annotated[str, Name(ACTION_MODES)] = "tracking"
    # Names of features, or features of one's own, see ``asv_env.sensing.observation``; None: all.
    observation: tuple[Any, ...] | None = None
    boat: BoatParams = field(default_factory=BoatParams)
    vessel: VesselParams = field(default_factory=VesselParams)
    water: WaterParams = field(default_factory=WaterParams)
    sensors: SensorParams = field(default_factory=SensorParams)
    clock: ClockParams = field(default_factory=ClockParams)
    task: TaskParams = field(default_factory=TaskParams)
    variation: VariationParams = field(default_factory=VariationParams)
    reward: RewardParams = field(default_factory=RewardParams)
    # Shapes, or a function that samples them, see ``asv_env.params.obstacle_params``.
    obstacles: Any = ()
    #: how many times longer the world is than the nominal one, by Froude's law
    scale: Annotated[float, SCALE] = 1.0

    def __post_init__(self) -> None:
        check_fields(self)
        object.__setattr__(self, "observation", _features(self.observation))
        object.__setattr__(self, "obstacles", obstacle_params.checked(self.obstacles))
        for f in fields(self):
            section, kind = getattr(self, f.name), f.default_factory
            if isinstance(kind, type) and not isinstance(section, kind):
                raise TypeError(f"{f.name} = {shown(section)}: give a {kind.__name__}")
        if not hasattr(self.definition, "initial_states"):
            raise TypeError(f"task = {shown(self.definition)}: give an asv_env.tasks.Task")
        self._check_delays()
        self._check_team()
        self._check_sizes()
        self._check_places()
        self.hulls()  # Their drag must be computable too.
        if isinstance(self.obstacles, tuple):
            obstacle_params.rows(self, self.obstacles)
        self.definition.check(self)

    def _check_delays(self) -> None:
        """Refuses delays that are no whole numbers of control ticks."""
        hz = self.clock.control
        for section, name in DELAYS:
            delay = getattr(getattr(self, section), name)
            if delay * hz > MOST_TICKS:
                raise ValueError(
                    f"{section}: {name} = {delay:g} s: at most {MOST_TICKS} control ticks, "
                    f"{MOST_TICKS / hz:g} s at {hz} Hz; give a shorter one"
                )
            if abs(delay - self.clock.rounded(delay)) > 1e-6 / hz:
                below = math.floor(delay * hz)
                raise ValueError(
                    f"{section}: {name} = {delay:g} s is no whole number of control ticks of "
                    f"{1 / hz:g} s; give {below / hz:g} or {(below + 1) / hz:g} s, the nearest"
                )

    def _check_team(self) -> None:
        """Refuses a team that does not fit the vessel, and failures of all boats."""
        widest = self.boat.width * (1.0 + self.variation.boat_size)
        if self.pitch < widest:
            longer = (
                "a longer vessel, or leave its length out and it grows with the team"
                if self.vessel.outline is None
                else "a larger outline, or a named hull, which grows with the team"
            )
            raise ValueError(
                f"{self.num_boats} boats of width {widest:g} m do not fit along a "
                f"vessel of length {self.vessel.length:g} m: they need a pitch of at least "
                f"{widest:g} m and have {self.pitch:.3g} m; use fewer boats, {longer}"
            )
        if self.variation.failures >= self.num_boats:
            raise ValueError(
                f"failures = {self.variation.failures}: fewer than num_boats = "
                f"{self.num_boats} can fail, somebody has to push"
            )
        task = self.task
        # A short time limit is common in trials, so the usual time of holding is always fine.
        name = "delivery_time" if self.definition.has_goal else "hold_time"
        held = getattr(task, name)
        if held > max(task.time_limit, getattr(TaskParams, name)):
            raise ValueError(
                f"{name} = {held:g} s: longer than time_limit = {task.time_limit:g} s, so no "
                "episode could succeed; hold for a shorter time"
            )

    def _check_sizes(self) -> None:
        """Refuses sizes and accelerations with which a step could not be computed."""
        boat, vessel, task, vary = self.boat, self.vessel, self.task, self.variation
        sizes = (
            ("boat.length and boat.width", math.hypot(boat.length, boat.width), "hull"),
            ("vessel.width", vessel.width, "hull"),
            ("water.walls", self.water.walls or 0.0, "walls"),
            ("arena", task.arena, "arena"),
        )
        for name, size, kind in sizes:
            if size > MOST_LENGTHS[kind] * vessel.length:
                raise ValueError(
                    f"{name}: {size:g} m are more than {MOST_LENGTHS[kind]:g} times "
                    f"vessel.length = {vessel.length:g} m; make them smaller or the vessel longer"
                )
        lightest = (1 - vary.mass) * (1 - vary.boat_size) ** 5  # Inertia falls most.
        force = 2 * boat.thrust * vary.largest_thrust / lightest / self.clock.control**2
        leap, turn = force / boat.masses[0], force * boat.lever_arm / boat.total_inertia
        if leap > LEAP * task.arena or turn > SPIN:
            raise ValueError(
                f"thrust = {boat.thrust:g} N on a boat of {boat.masses[0]:g} kg and "
                f"{boat.total_inertia:g} kg m^2 with lever_arm = {boat.lever_arm:g} m: in one "
                f"control step it would move by {leap:.3g} m and {turn:.3g} rad, in an arena of "
                f"{task.arena:g} m; choose less thrust, more mass or inertia, a larger arena, or "
                "a faster clock.control"
            )

    def _check_places(self) -> None:
        """Refuses initial positions, slots and goals where no hull can be."""
        walls, task, boat, vessel = self.water.walls, self.task, self.boat, self.vessel
        clear = vessel.reach + math.hypot(boat.length, boat.width) / 2
        if not self.definition.starts_grasped and task.start_distance[0] < clear:
            raise ValueError(
                f"start_distance = {task.start_distance!r}: boats would start in the vessel, by "
                f"the length and width of both; begin at {clear:.3g} m or more"
            )
        if walls is not None and task.start_distance[0] > walls:
            raise ValueError(
                f"walls = {walls:g} m lie inside start_distance = {task.start_distance!r} m; "
                "make the basin larger"
            )
        caged = self.num_boats >= SMALLEST_CAGE
        left, right, bottom, top = vessel.extents
        along = max(right, -left) + (boat.width / 2 + task.end_gap if caged else 0.0)
        across = max(top, -bottom) + boat.length / 2
        hull = max(along + boat.width / 2 if caged else along, across + boat.length / 2)
        for name, edge, reach in (
            ("arena", task.arena, max(along, across)),
            ("walls", walls, hull),
        ):
            if edge is not None and reach > edge:
                raise ValueError(
                    f"{name} = {edge:g} m: boats in their slots on the vessel reach {reach:.3g} m "
                    "from its centre, by the length and width of both; choose a larger basin, "
                    "smaller hulls, or a smaller end_gap"
                )
        if task.goal is not None:
            self.checked_goal(task.goal)

    def checked_goal(self, goal: Any) -> tuple[float, float, float]:
        """Returns a goal pose as three floats, m, m, rad, the heading wrapped.

        Raises:
            ValueError: not three finite numbers, outside the arena, or where the vessel would lie
                in a wall by more than ``position_tolerance``.
        """
        pose = self.task.checked_goal(goal)
        if not self.goal_fits(pose):
            raise ValueError(
                f"goal = {pose!r}: the vessel would lie outside the walls at {self.water.walls:g} "
                "m; choose a nearer goal or a larger basin"
            )
        return pose

    def goal_fits(self, goal: tuple[float, float, float]) -> bool:
        """Returns whether the vessel fits within the walls at a goal pose, m, m, rad.

        It may lie in them as far as the tolerance of the position reaches.
        """
        if self.water.walls is None:
            return True
        x, y, heading = goal
        cos, sin = math.cos(heading), math.sin(heading)
        corners = self.vessel.corners
        beyond = (
            max(abs(x + cos * u - sin * w) for u, w in corners) - self.water.walls,
            max(abs(y + sin * u + cos * w) for u, w in corners) - self.water.walls,
        )
        return math.hypot(*(max(0.0, d) for d in beyond)) <= self.task.position_tolerance

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        """Returns the parameters themselves: they never change."""
        return self

    @property
    def pitch(self) -> float:
        """Distance between neighbouring slots along the side, m."""
        return self.vessel.length / pitches(self.num_boats)

    @property
    def time_limit_ticks(self) -> int:
        """Number of control ticks after which an episode is truncated."""
        return max(1, round(self.task.time_limit * self.clock.control))

    def rescaled(self, factor: float) -> Self:
        """Returns the parameters of a world ``factor`` times as long, by Froude's law.

        Delays remain whole numbers of control ticks.
        """
        names = ("boat", "vessel", "water", "sensors", "clock", "task", "variation", "reward")
        sections = {name: scaled(getattr(self, name), factor) for name in names}
        round_delays(sections, {})
        obstacles = scaled_shapes(self.obstacles, factor)
        return replace(self, **sections, obstacles=obstacles, scale=self.scale * factor)

    def hulls(self) -> tuple[VesselParams, BoatParams]:
        """Returns vessel and boat as they move: with fins, and linear drag if asked for."""
        vessel, boat = self.vessel.with_fins(), self.boat
        if self.water.drag == "linear":
            at = (self.water.linear_speed, self.water.linear_yaw_rate)
            vessel, boat = vessel.linearised(*at), boat.linearised(*at)
        return vessel, boat


def round_delays(sections: dict[str, Any], but: Mapping[str, Collection[str]]) -> None:
    """Rounds the delays among sections by name to whole control ticks, in place.

    Args:
        sections: those of an environment, its clock among them.
        but: names of delays, by section, that stay as they are.
    """
    for section, name in DELAYS:
        if name not in but.get(section, ()):
            delay = sections["clock"].rounded(getattr(sections[section], name))
            sections[section] = replace(sections[section], **{name: delay})


def _features(observation: Any) -> tuple[Any, ...] | None:
    """Returns names of features, and features, as a tuple; the names are texts of Python's own.

    Raises:
        ValueError: something else.
    """
    if observation is None:
        return None
    items = plain(observation)
    try:
        listed = () if isinstance(items, str | bytes) else islice(items, MOST_FEATURES + 1)
        found = tuple(map(plain, listed))
        hash(found)
    except TypeError:
        found = ()
    if not 0 < len(found) <= MOST_FEATURES:
        raise ValueError(
            f"observation = {shown(observation)}: give a list of names of features, or features"
        )
    return found
