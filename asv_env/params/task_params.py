"""Numbers of a task: distances, tolerances, times, and the weights of its reward."""

import math
from dataclasses import dataclass, replace
from typing import Annotated, Any, Self

from asv_env import geometry
from asv_env.checks import Name, Number, check_fields, numbers
from asv_env.params.ranges import (
    AngleLimit,
    AngleTolerance,
    Distance,
    DistanceOrZero,
    Distances,
    Duration,
    DurationOrZero,
    Fraction,
    Spacing,
    Tolerance,
    ToleranceOrZero,
    Weight,
)
from asv_env.text import shown

SIDES = ("+n", "-n", "goal")
GOAL_ANCHORS = ("world", "closure")
DELIVERIES = ("holding", "passing")


@dataclass(frozen=True)
class TaskParams:
    """Distances, tolerances and times of a task; lengths fit the nominal 0.40 m vessel.

    A vessel is delivered by "holding" when it keeps the goal pose, within ``position_tolerance``
    and ``heading_tolerance``, for ``delivery_time`` without a break, hardly moving over ground.
    By "passing" it is delivered at an instant, as in the paper: within both tolerances, slow
    through the water, and no longer coming nearer. ``asv_env.tasks.termination`` has the laws.
    """

    name: str = "transport"  #: see ``asv_env.tasks.TASKS``
    goal: tuple[float, float, float] | None = None  #: fixed pose, m, m, rad; None samples each
    goal_distance: Distances = (0.4, 1.2)  #: (smallest, largest) of a sampled goal, m
    #: largest angle between the direction of a sampled goal and that in which the team pushes, rad
    goal_bearing: AngleLimit = math.pi
    goal_turn: AngleLimit = math.pi  #: largest heading of a sampled goal, to either side, rad
    #: "world", or "closure": relative to the vessel's pose at closure
    goal_anchor: Annotated[str, Name(GOAL_ANCHORS)] = "world"
    #: from which boats push: "+n", "-n", or "goal", the side away from the goal
    side: Annotated[str, Name(SIDES)] = "+n"
    start_distance: Distances = (0.5, 1.5)  #: (smallest, largest), of boats, m
    start_spacing: Spacing = 1.5  #: smallest distance between boats at first, boat lengths
    arena: Distance = 3.0  #: half the side of the square that no body may leave, m
    time_limit: Duration = 180.0  #: after which an episode is truncated, s
    position_tolerance: Tolerance = 0.05  #: largest distance of a delivered vessel to its goal, m
    heading_tolerance: AngleTolerance = 0.1  #: largest heading error of a delivered vessel, rad
    delivery: Annotated[str, Name(DELIVERIES)] = "holding"  #: "holding" or "passing"
    delivery_time: DurationOrZero = 3.0  #: for which a vessel holds the goal pose, s
    speed_tolerance: Tolerance = 0.002  #: speed over ground of a vessel that holds a pose, m/s
    yaw_rate_tolerance: Tolerance = 0.01  #: yaw rate of a vessel that holds a pose, rad/s
    #: growth of ``speed_tolerance`` with the speed of the water at the vessel; that of the yaw
    #: rate grows in proportion
    water_tolerance: Annotated[float, Number(0.0, 0.95)] = 0.25
    passing_speed: Tolerance = 0.01  #: speed through the local water of a vessel that passes, m/s
    passing_yaw_rate: Tolerance = 0.05  #: yaw rate of a vessel that passes, rad/s
    #: speed to the goal below which a vessel that passes comes no nearer, m/s
    nearing_tolerance: ToleranceOrZero = 0.001
    slot_distance: Tolerance = 0.03  #: distance within which a boat occupies its slot, m
    slot_angle: AngleTolerance = 0.3  #: heading error within which a boat occupies its slot, rad
    slot_speed: Tolerance = 0.02  #: speed on the vessel below which a boat occupies its slot, m/s
    #: for which all slots must be occupied to succeed at approach, s
    hold_time: DurationOrZero = 1.0
    end_gap: DistanceOrZero = 0.005  #: between the end boats and the ends of the vessel, m

    def __post_init__(self) -> None:
        check_fields(self)
        if self.goal is not None:
            object.__setattr__(self, "goal", self.checked_goal(self.goal))

    def checked_goal(self, goal: Any) -> tuple[float, float, float]:
        """Returns a goal pose as three floats.

        Raises:
            ValueError: not three finite numbers, or outside the arena.
        """
        pose = numbers(goal, 3)
        if pose is None:
            raise ValueError(
                f"goal = {shown(goal)}: give three numbers, all finite: x m, y m, heading rad"
            )
        x, y, heading = pose
        if max(abs(x), abs(y)) > self.arena:
            raise ValueError(
                f"goal = {pose!r}: outside the arena, whose half-width is {self.arena:g} m; "
                "choose a nearer goal or a larger `arena`"
            )
        return x, y, float(geometry.wrap(heading))

    def scaled(self, factor: float) -> Self:
        """Returns the task for a vessel ``factor`` times as long: distances and time scale.

        Speeds and the times for which something is held stay: mass and drag of the vessel grow
        alike, so that it coasts as far from the same speed.
        """
        sizes = ("arena", "time_limit", "position_tolerance")
        scaled: dict[str, Any] = {name: getattr(self, name) * factor for name in sizes}
        for name in ("goal_distance", "start_distance"):
            scaled[name] = tuple(distance * factor for distance in getattr(self, name))
        return replace(self, **scaled)


@dataclass(frozen=True)
class RewardParams:
    """Weights of the reward terms; ``asv_env.tasks.reward`` defines the terms.

    The weights of time, effort and collision count for a second, so that an episode is worth the
    same at any control rate.
    """

    closure: Weight = 0.5  #: progress towards the slots
    delivery: Weight = 1.0  #: progress towards the goal
    precision: Weight = 2.0  #: the last centimetres to the goal pose
    success: Weight = 4.0  #: reward of an episode that succeeds
    accuracy: Fraction = 0.6  #: fraction of ``success`` that depends on how exact the delivery is
    strayed: Weight = 4.0  #: penalty for leaving the arena
    time: Weight = 0.05  #: penalty of a second
    effort: Weight = 0.001  #: penalty of a second at full thrust
    #: penalty of a second in which a boat touches another one or an obstacle, or the vessel an
    #: obstacle
    collision: Weight = 0.01

    def __post_init__(self) -> None:
        check_fields(self)
