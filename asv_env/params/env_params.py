"""All parameters of an environment, checked against each other."""

import math
from dataclasses import dataclass, field, replace
from typing import Any, Self

from asv_env.checks import check_num_boats, choice
from asv_env.params.hull_params import BoatParams, VesselParams
from asv_env.params.surroundings import ClockParams, SensorParams, VariationParams, WaterParams
from asv_env.params.task_params import RewardParams, TaskParams

ACTION_MODES = ("tracking", "thrusters")
SMALLEST_CAGE = 4  #: smallest team whose first and last boats cage the ends of the vessel


@dataclass(frozen=True)
class EnvParams:
    """All parameters of one environment, consistent with each other.

    ``presets.make_params`` makes them from names and options.

    Raises:
        ValueError: a team that does not fit the vessel, walls inside the start annulus,
            more failures than boats can bear.
    """

    definition: Any  #: the ``asv_env.tasks.Task``: initial states, reward, termination, metrics
    num_boats: int = 4
    action_mode: str = "tracking"  #: speed and yaw rate; or "thrusters"
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
        """Refuses initial positions and goals where no hull can be."""
        walls, task = self.water.walls, self.task
        clear = math.hypot(self.vessel.length, self.vessel.width) / 2
        clear += math.hypot(self.boat.length, self.boat.width) / 2
        if not self.definition.starts_grasped and task.start_distance[0] < clear:
            raise ValueError(
                f"start_distance = {task.start_distance!r}: boats would start in the vessel; "
                f"begin at {clear:.3g} m or more"
            )
        if walls is not None and task.start_distance[0] > walls:
            raise ValueError(
                f"walls = {walls:g} m lie inside start_distance = {task.start_distance!r} m; "
                "make the basin larger"
            )
        if task.goal is not None:
            self.checked_goal(task.goal)

    def checked_goal(self, goal: Any) -> tuple[float, float, float]:
        """Returns a goal pose as three floats, m, m, rad, the heading wrapped.

        Raises:
            ValueError: not three finite numbers, outside the arena, or where the vessel would lie
                in a wall by more than ``position_tolerance``.
        """
        x, y, heading = self.task.checked_goal(goal)
        if not self.goal_fits((x, y, heading)):
            raise ValueError(
                f"goal = {goal!r}: the vessel would lie outside the walls at {self.water.walls:g} "
                "m; choose a nearer goal or a larger basin"
            )
        return x, y, heading

    def goal_fits(self, goal: tuple[float, float, float]) -> bool:
        """Returns whether the vessel fits within the walls at a goal pose, m, m, rad.

        It may lie in them as far as the tolerance of the position reaches.
        """
        if self.water.walls is None:
            return True
        x, y, heading = goal
        along, across = abs(math.cos(heading)), abs(math.sin(heading))
        length, width = self.vessel.length / 2, self.vessel.width / 2
        beyond = (
            abs(x) + length * along + width * across - self.water.walls,
            abs(y) + length * across + width * along - self.water.walls,
        )
        return math.hypot(*(max(0.0, d) for d in beyond)) <= self.task.position_tolerance

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        """Returns the parameters themselves: they never change."""
        return self

    @property
    def pitch(self) -> float:
        """Distance between neighbouring slots along the side, m."""
        cells = self.num_boats - 1 if self.num_boats >= SMALLEST_CAGE else self.num_boats + 1
        return self.vessel.length / cells

    @property
    def time_limit_ticks(self) -> int:
        """Number of control ticks after which an episode is truncated."""
        return max(1, round(self.task.time_limit * self.clock.control))

    def hulls(self) -> tuple[VesselParams, BoatParams]:
        """Returns vessel and boat with the drag that acts: with fins, linear if asked for."""
        surge, quadratic = self.vessel.surge
        vessel = replace(self.vessel, surge=(surge, quadratic + self.vessel.fins), fins=0.0)
        boat = self.boat
        if self.water.drag == "linear":
            at = (self.water.linear_speed, self.water.linear_yaw_rate)
            vessel, boat = vessel.linearised(*at), boat.linearised(*at)
        return vessel, boat
