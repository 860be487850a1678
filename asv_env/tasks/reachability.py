"""Whether hulls fit between obstacles, and reach each other: circles on a grid.

A circle can go wherever its centre stays a radius away from all obstacles. The grid is
conservative: neighbouring cells that both are free can be sailed between.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from asv_env.capsules import clearance, nearest_gap, segment_distance
from asv_env.compiled import allocating, compiled
from asv_env.geometry import direction, xy
from asv_env.params import EnvParams, HullParams
from asv_env.params.obstacle_params import Grouping, grouping
from asv_env.polygons import complex_corners
from asv_env.types import Bool, Float, Int

VESSEL_CELLS, BOAT_CELLS = 4, 2  #: cells in the radius of the circle round a vessel, a boat
MOST_CELLS = 400  #: most cells along an axis of a grid
STRAIGHT = 4.0  #: farthest straight push into a goal pose, vessel lengths
PUSHES = 40  #: steps of such a push that are looked at


@compiled
def cells_between(low: float, high: float, start: float, cell: float, count: int) -> range:
    """Returns the cells of an axis, from ``start`` on, that an interval touches, and one more."""
    first = min(max((low - start) / cell, 0.0), count)
    return range(int(first), int(min(max((high - start) / cell + 1.0, 0.0), count)))


@compiled
def block_near(free: Bool, row: Float, low: Float, cell: float, radius: float) -> None:
    """Marks the cells of a grid in which a circle would touch a row.

    In each column it looks at the cells beside the part of the row that is near enough along x.
    """
    ax, ay, bx, by = row[0], row[1], row[2], row[3]
    columns, rows = free.shape
    west, east, reach = min(ax, bx), max(ax, bx), row[4] + radius
    slope = (by - ay) / (bx - ax) if ax != bx else 0.0
    for i in cells_between(west - reach, east + reach, low[0], cell, columns):
        x = low[0] + (i + 0.5) * cell
        start, end = ay, by
        if ax != bx:
            start = ay + slope * (min(max(x - reach, west), east) - ax)
            end = ay + slope * (min(max(x + reach, west), east) - ax)
        south, north = min(start, end) - reach, max(start, end) + reach
        for j in cells_between(south, north, low[1], cell, rows):
            y = low[1] + (j + 0.5) * cell
            if free[i, j] and segment_distance(ax, ay, bx, by, x, y) - row[4] < radius:
                free[i, j] = False


@compiled
def visit(i: int, j: int, free: Bool, reached: Bool, stack: Int, count: int) -> int:
    """Puts a cell on the stack if it is free and new; returns how many are on it."""
    if free[i, j]:
        free[i, j], reached[i, j] = False, True
        stack[count, 0], stack[count, 1] = i, j
        count += 1
    return count


@allocating
def flooded(
    obstacle: Float, low: Float, cell: float, columns: int, rows: int, radius: float,
    x: float, y: float,
) -> Bool:  # fmt: skip
    """Returns the cells (columns, rows) that a circle reaches from a point in the water.

    Nothing gets into a polygon past its edges, so that the cells within are not looked at.

    Args:
        obstacle: (M, 5) rows.
        low: (2,) lower left corner of the grid, m.
        cell: side of a cell, m.
        columns: number of cells along x.
        rows: number of cells along y.
        radius: of the circle, m.
        x: of the point, m.
        y: of the point, m.
    """
    free = np.ones((columns, rows), np.bool_)
    for row in range(len(obstacle)):
        block_near(free, obstacle[row], low, cell, radius + 0.5 * cell)
    reached = np.zeros((columns, rows), np.bool_)
    stack = np.empty((columns * rows, 2), np.int64)
    i, j, count = int((x - low[0]) / cell), int((y - low[1]) / cell), 0
    for column in range(max(i - 2, 0), min(i + 3, columns)):
        for row in range(max(j - 2, 0), min(j + 3, rows)):
            count = visit(column, row, free, reached, stack, count)
    while count:
        count -= 1
        i, j = stack[count, 0], stack[count, 1]
        if i > 0:
            count = visit(i - 1, j, free, reached, stack, count)
        if i + 1 < columns:
            count = visit(i + 1, j, free, reached, stack, count)
        if j > 0:
            count = visit(i, j - 1, free, reached, stack, count)
        if j + 1 < rows:
            count = visit(i, j + 1, free, reached, stack, count)
    return reached


@dataclass(frozen=True)
class Grid:
    """The cells that a circle reaches."""

    reached: Bool  #: (columns, rows)
    low: Float  #: (2,) lower left corner, m
    cell: float  #: side of a cell, m

    def holds(self, x: float, y: float) -> bool:
        """Returns whether the circle reaches a point."""
        i, j = int((x - self.low[0]) // self.cell), int((y - self.low[1]) // self.cell)
        columns, rows = self.reached.shape
        return 0 <= i < columns and 0 <= j < rows and bool(self.reached[i, j])


class Waters:
    """The water between the obstacles of an episode, whose vessel begins at the origin.

    Args:
        params: parameters of the environment.
        obstacle: (M, 5) rows, the walls last.
    """

    def __init__(self, params: EnvParams, obstacle: Float) -> None:
        self.params, self.obstacle = params, obstacle
        self._grouping: Grouping = grouping(params)

    def problem(self, goal: Float, side: float) -> str | None:
        """Returns why the vessel cannot begin at the origin and go to a goal pose; None if it can.

        The goal is (3,) m, m, rad; the team pushes from ``side``, +1 or -1.
        """
        vessel = self.params.vessel
        if self.clear(vessel, np.zeros(3)) <= 0.0:
            return "the vessel would begin in an obstacle"
        if self.clear(vessel, goal) <= 0.0:
            x, y, heading = goal.tolist()
            return (
                f"the vessel would lie in an obstacle at its goal ({x:.3g}, {y:.3g}, {heading:.3g})"
            )
        if not self._leads_to(goal, side):
            return (
                "no way from the start to the goal is wide enough for the circle round the vessel, "
                f"of radius {vessel.reach:.3g} m"
            )
        return None

    def clear(self, hull: HullParams, pose: Float) -> float:
        """Returns the distance of a hull at a pose (3,) to the nearest obstacle, m.

        It is 0 or less where they overlap.
        """
        corners = complex_corners(hull.corners)
        turn = direction(np.array(pose[2]))
        placed = np.ascontiguousarray(xy(corners * turn + complex(pose[0], pose[1])))
        return float(clearance(self.obstacle, self._grouping.groups, placed))

    def _leads_to(self, goal: Float, side: float) -> bool:
        """Returns whether the vessel can go to a goal pose.

        It goes as its circle to a place from which it is pushed straight into the pose, unless it
        can go there as a circle.
        """
        away = 1j * side * np.exp(1j * goal[2])
        for step in range(PUSHES + 1):
            distance = STRAIGHT * self.params.vessel.size * step / PUSHES
            place = complex(goal[0], goal[1]) + distance * away
            if self.clear(self.params.vessel, np.array([place.real, place.imag, goal[2]])) <= 0.0:
                return False
            if self._of_vessel.holds(place.real, place.imag):
                return True
        return False

    def free(self, x: float, y: float) -> bool:
        """Returns whether a boat can begin at a point, and reach the vessel from there."""
        gap = nearest_gap(self.obstacle, self._grouping.groups, x, y)
        return gap > self.params.boat.reach and self._of_boat.holds(x, y)

    @cached_property
    def _of_vessel(self) -> Grid:
        return self._grid(self.params.vessel.reach, VESSEL_CELLS)

    @cached_property
    def _of_boat(self) -> Grid:
        return self._grid(self.params.boat.reach, BOAT_CELLS)

    def _grid(self, radius: float, cells: int) -> Grid:
        """Returns what a circle, so many ``cells`` in radius, reaches within arena and walls."""
        params = self.params
        rows = self.obstacle[: len(self.obstacle) - self._grouping.walls]
        ends, reach = np.concatenate([rows[:, :2], rows[:, 2:4]]), rows[:, 4].max(initial=0.0)
        far = max(params.task.start_distance[1], params.task.goal_distance[1])
        if params.task.goal is not None:
            far = max(far, abs(params.task.goal[0]), abs(params.task.goal[1]))
        half = max(far, abs(ends).max(initial=0.0) + reach) + 3 * radius
        half = min(half, params.task.arena, params.water.walls or math.inf)
        cell = max(radius / cells, 2 * half / MOST_CELLS)
        count = math.ceil(2 * half / cell)
        low = np.array([-half, -half])
        reached = flooded(self.obstacle, low, cell, count, count, radius, 0.0, 0.0)
        return Grid(reached, low, cell)
