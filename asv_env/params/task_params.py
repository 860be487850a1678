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
    """Distances, tolerances and times of a task; lengths fit the nominal 0.40 m vessel.

    Attributes:
        name: Name of the task, see ``asv_env.tasks.TASKS``.
        goal: Fixed goal pose (x m, y m, heading rad); None samples one for each episode.
        goal_distance: (smallest, largest) distance of a sampled goal, m.
        goal_anchor: "world", or "closure": the goal is relative to the vessel's pose at the
            moment of closure, as in the paper's experiment.
        side: Side of the vessel from which the boats push: "+n", "-n", or "goal", the side
            away from the goal.
        start_distance: (smallest, largest) distance of the boats' initial positions, m.
        start_spacing: Smallest distance between boats at first, boat lengths.
        arena: Half the side of the square that no body may leave, m.
        time_limit: Time after which an episode is truncated, s.
        position_tolerance: Largest distance of a delivered vessel to its goal, m.
        heading_tolerance: Largest heading error of a delivered vessel, rad.
        speed_tolerance: Speed of a delivered vessel through the local water, m/s.
        yaw_rate_tolerance: Yaw rate of a delivered vessel, rad/s.
        nearing_tolerance: Speed towards the goal below which a vessel comes no nearer, m/s.
        slot_distance: Distance within which a boat occupies its slot, m.
        slot_angle: Heading error within which a boat occupies its slot, rad.
        slot_speed: Speed relative to the vessel below which a boat occupies its slot, m/s.
        hold_time: Time for which all slots must be occupied to succeed at approach, s.
        end_gap: Gap between the end boats and the ends of the vessel, m.
    """

    name: str = "transport"
    goal: tuple[float, float, float] | None = None
    goal_distance: tuple[float, float] = (0.4, 1.2)
    goal_anchor: str = "world"
    side: str = "+n"
    start_distance: tuple[float, float] = (0.5, 1.5)
    start_spacing: float = 1.5
    arena: float = 3.0
    time_limit: float = 180.0
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
        choice("goal_anchor", self.goal_anchor, GOAL_ANCHORS)
        choice("side", self.side, SIDES)
        check_interval(self, "goal_distance", 0.0)
        check_interval(self, "start_distance", TINY)
        check_numbers(self, "nearing_tolerance hold_time end_gap", 0.0)
        check_numbers(self, "start_spacing", 1.0)
        check_numbers(
            self,
            "arena position_tolerance speed_tolerance yaw_rate_tolerance slot_distance slot_speed",
            TINY,
        )
        check_numbers(self, "heading_tolerance slot_angle", TINY, math.pi)
        check_numbers(self, "time_limit", TINY)
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

        def times(pair: tuple[float, float]) -> tuple[float, float]:
            return pair[0] * factor, pair[1] * factor

        return replace(
            self,
            goal_distance=times(self.goal_distance),
            start_distance=times(self.start_distance),
            arena=self.arena * factor,
            time_limit=self.time_limit * factor,
            position_tolerance=self.position_tolerance * factor,
        )


@dataclass(frozen=True)
class RewardParams:
    """Weights of the reward terms; ``asv_env.tasks.reward`` defines the terms.

    The weights of time, effort and collision count for a second, so that an episode is worth the
    same at any control rate.

    Attributes:
        closure: Weight of progress towards the slots.
        delivery: Weight of progress towards the goal.
        precision: Weight of the last centimetres to the goal pose.
        success: Reward of an episode that succeeds.
        accuracy: Fraction of ``success`` that depends on how exactly the vessel was delivered.
        strayed: Penalty for leaving the arena.
        time: Penalty of a second.
        effort: Penalty of a second at full thrust.
        collision: Penalty of a second in contact with another boat or a wall.
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
            check_numbers(self, f.name, 0.0)
        check_numbers(self, "accuracy", 0.0, 1.0)
