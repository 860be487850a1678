"""Numbers of a task: distances, tolerances, times, and the weights of its reward."""

import math
from dataclasses import dataclass, fields, replace
from typing import Any, Self

from asv_env import geometry
from asv_env.checks import TINY, check_interval, check_numbers, choice

SIDES = ("+n", "-n", "goal")
GOAL_ANCHORS = ("world", "closure")


@dataclass(frozen=True)
class TaskParams:
    """Distances, tolerances and times of a task; lengths fit the nominal 0.40 m vessel."""

    name: str = "transport"  #: see ``asv_env.tasks.TASKS``
    goal: tuple[float, float, float] | None = None  #: fixed pose, m, m, rad; None samples each
    goal_distance: tuple[float, float] = (0.4, 1.2)  #: (smallest, largest) of a sampled goal, m
    goal_anchor: str = "world"  #: or "closure": relative to the vessel's pose at closure
    side: str = "+n"  #: from which boats push: "+n", "-n", or "goal", the side away from the goal
    start_distance: tuple[float, float] = (0.5, 1.5)  #: (smallest, largest), of boats, m
    start_spacing: float = 1.5  #: smallest distance between boats at first, boat lengths
    arena: float = 3.0  #: half the side of the square that no body may leave, m
    time_limit: float = 180.0  #: after which an episode is truncated, s
    position_tolerance: float = 0.05  #: largest distance of a delivered vessel to its goal, m
    heading_tolerance: float = 0.1  #: largest heading error of a delivered vessel, rad
    speed_tolerance: float = 0.01  #: speed of a delivered vessel through the local water, m/s
    yaw_rate_tolerance: float = 0.05  #: yaw rate of a delivered vessel, rad/s
    nearing_tolerance: float = 0.001  #: speed to the goal below which a vessel comes no nearer, m/s
    slot_distance: float = 0.03  #: distance within which a boat occupies its slot, m
    slot_angle: float = 0.3  #: heading error within which a boat occupies its slot, rad
    slot_speed: float = 0.02  #: speed on the vessel below which a boat occupies its slot, m/s
    hold_time: float = 1.0  #: for which all slots must be occupied to succeed at approach, s
    end_gap: float = 0.005  #: between the end boats and the ends of the vessel, m

    def __post_init__(self) -> None:
        choice("goal_anchor", self.goal_anchor, GOAL_ANCHORS)
        choice("side", self.side, SIDES)
        check_interval(self, "goal_distance", 0.0)
        check_interval(self, "start_distance", TINY)
        check_numbers(self, "nearing_tolerance hold_time end_gap", 0.0)
        check_numbers(self, "start_spacing", 1.0)
        check_numbers(self, "arena position_tolerance speed_tolerance yaw_rate_tolerance", TINY)
        check_numbers(self, "slot_distance slot_speed time_limit", TINY)
        check_numbers(self, "heading_tolerance slot_angle", TINY, math.pi)
        if self.goal is not None:
            object.__setattr__(self, "goal", self.checked_goal(self.goal))

    def checked_goal(self, goal: Any) -> tuple[float, float, float]:
        """Returns a goal pose as three floats.

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

    def scaled(self, factor: float) -> Self:
        """Returns the task for a vessel ``factor`` times as long: distances and time scale."""
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

    closure: float = 0.5  #: progress towards the slots
    delivery: float = 1.0  #: progress towards the goal
    precision: float = 2.0  #: the last centimetres to the goal pose
    success: float = 4.0  #: reward of an episode that succeeds
    accuracy: float = 0.6  #: fraction of ``success`` that depends on how exact the delivery is
    strayed: float = 4.0  #: penalty for leaving the arena
    time: float = 0.05  #: penalty of a second
    effort: float = 0.001  #: penalty of a second at full thrust
    collision: float = 0.01  #: penalty of a second in contact with another boat or a wall

    def __post_init__(self) -> None:
        for f in fields(self):
            check_numbers(self, f.name, 0.0)
        check_numbers(self, "accuracy", 0.0, 1.0)
