"""Whether hulls fit between obstacles, and reach each other: circles on a grid.

A circle can go wherever its centre stays a radius away from all obstacles. The grid is
conservative: neighbouring cells that both are free can be sailed between.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from asv_env.capsules import POLYGON, clearance, encloses, gap_to, segment_distance
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
def blocks(free: Bool, obstacle: Float, first: int, last: int, low: Float, cell: float,
           radius: float) -> None:  # fmt: skip
    """Marks the cells of a grid in which a circle would touch a group of rows."""
    west = south = math.inf
    east = north = -math.inf
    for k in range(first, last):
        reach = obstacle[k, 4] + radius
        west = min(west, obstacle[k, 0] - reach, obstacle[k, 2] - reach)
        east = max(east, obstacle[k, 0] + reach, obstacle[k, 2] + reach)
        south = min(south, obstacle[k, 1] - reach, obstacle[k, 3] - reach)
        north = max(north, obstacle[k, 1] + reach, obstacle[k, 3] + reach)
    columns, rows = free.shape
    i_first = int(min(max((west - low[0]) / cell, 0.0), columns))
    i_last = int(min(max((east - low[0]) / cell + 1.0, 0.0), columns))
    j_first = int(min(max((south - low[1]) / cell, 0.0), rows))
    j_last = int(min(max((north - low[1]) / cell + 1.0, 0.0), rows))
    for i in range(i_first, i_last):
        for j in range(j_first, j_last):
            if not free[i, j]:
                continue
            x, y = low[0] + (i + 0.5) * cell, low[1] + (j + 0.5) * cell
            for k in range(first, last):
                row = obstacle[k]
                gap = segment_distance(row[0], row[1], row[2], row[3], x, y) - row[4]
                if gap < radius:
                    free[i, j] = False
                    break
            if free[i, j] and last - first >= POLYGON:
                free[i, j] = not encloses(obstacle, first, last, x, y)


@allocating
def flooded(
    obstacle: Float, groups: Int, low: Float, cell: float, columns: int, rows: int,
    radius: float, x: float, y: float,
) -> Bool:  # fmt: skip
    """Returns the cells (columns, rows) that a circle reaches from a point.

    Args:
        obstacle: (M, 5) rows.
        groups: (G + 1,) first rows of the groups.
        low: (2,) lower left corner of the grid, m.
        cell: side of a cell, m.
        columns: number of cells along x.
        rows: number of cells along y.
        radius: of the circle, m.
        x: of the point, m.
        y: of the point, m.
    """
    free = np.ones((columns, rows), np.bool_)
    for group in range(len(groups) - 1):
        blocks(free, obstacle, groups[group], groups[group + 1], low, cell, radius + 0.5 * cell)
    reached = np.zeros((columns, rows), np.bool_)
    stack = np.empty((columns * rows + 25, 2), np.int64)
    i, j, count = int((x - low[0]) / cell), int((y - low[1]) / cell), 0
    for column in range(max(i - 2, 0), min(i + 3, columns)):
        for row in range(max(j - 2, 0), min(j + 3, rows)):
            if free[column, row]:
                reached[column, row] = True
                stack[count] = column, row
                count += 1
    while count:
        count -= 1
        i, j = stack[count, 0], stack[count, 1]
        for di, dj in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            column, row = i + di, j + dj
            inside = 0 <= column < columns and 0 <= row < rows
            if inside and free[column, row] and not reached[column, row]:
                reached[column, row] = True
                stack[count] = column, row
                count += 1
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
        groups = self._grouping.groups
        radius = self.params.boat.reach
        return self._of_boat.holds(x, y) and all(
            gap_to(self.obstacle, groups, group, x, y)[0] > radius
            for group in range(len(groups) - 1)
        )

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
        low, known = np.array([-half, -half]), (self.obstacle, self._grouping.groups)
        return Grid(flooded(*known, low, cell, count, count, radius, 0.0, 0.0), low, cell)
