"""The way of a vessel among obstacles: from waypoint to waypoint, each by a direct path of its own.

The way is looked for when contact points are assigned, and again when the team has grasped the
vessel. Where there is none the scripted policy takes over, whose boats leave one side of the vessel
free: in a dock there is no room for boats between vessel and quay.
"""

from dataclasses import dataclass
from functools import cache
from typing import Self

import numpy as np

from asv_env.geometry import direction, wrap
from asv_env.params import EnvParams
from asv_env.polygons import complex_corners
from asv_env.tasks.formation import Relations
from asv_env.types import Bool, Complex, Float, Int, zeros
from baselines.allocation.allocation_gains import AllocationGains
from baselines.allocation.contact_points import Formation, formation
from baselines.allocation.direct_path import Course, Limits
from baselines.allocation.straight_paths import LEGS, Box, Room, Times, search
from baselines.scripted.clear_planner import MARGIN

REACHED = 0.5  #: distance before a waypoint at which the vessel makes for the next one, tolerances
LEAST = 0.25  #: least clearance of a way, tolerances of the position
GRID = 0.5  #: spacing of the grid, radii of the circle round vessel and team


@dataclass
class Way:
    """Where vessels go, leg by leg."""

    point: Complex  #: (W, LEGS) where each leg ends, world frame, m
    heading: Float  #: (W, LEGS) of the vessel on it, rad
    leg: Int  #: (W,) number of the present leg
    legs: Int  #: (W,) how many there are
    begins: Bool  #: (W,) whether the present leg begins
    missing: Bool  #: (W,) whether there is none

    @classmethod
    def empty(cls, worlds: int) -> Self:
        """Returns memory to be filled by ``Waypoints.plan``."""
        world, legs = (worlds,), (worlds, LEGS)
        return zeros(cls, legs, legs, *[world] * 4)

    @property
    def is_last(self) -> Bool:
        """Returns whether the present leg is the last (W,)."""
        return np.asarray(self.leg >= self.legs - 1)


class Waypoints:
    """Plans ways, and tells the direct path what it goes to."""

    def __init__(self, params: EnvParams, gains: AllocationGains) -> None:
        self._vessel, self._boat = params.hulls()
        self._gains, self._tolerance = gains, params.task.position_tolerance
        self._margin = MARGIN * self._vessel.size
        self._box = cache(self._box_of)

    def _box_of(self, team: int) -> Box:
        """Returns what a team drives."""
        found = formation(self._vessel, self._boat, team)
        return driven_box(found, complex_corners(self._vessel.corners), self._corners_of(found))

    def _corners_of(self, found: Formation) -> Complex:
        boat = complex_corners(self._boat.corners)
        return np.asarray(found.place[:, None] + boat * found.inward[:, None])

    def plan(
        self, way: Way, relations: Relations, goal: Float, obstacle: Float, limits: Limits,
        working: Bool, which: Bool,
    ) -> None:  # fmt: skip
        """Plans ways in the worlds ``which`` (W,), into ``way``.

        Args:
            way: updated.
            relations: of the estimated motion.
            goal: (W, 3) m, m, rad.
            obstacle: (W, M, 5) rows.
            limits: of the teams.
            working: (W, A) boats that work.
            which: (W,) where to plan.
        """
        heading = relations.heading[:, 0]
        here, angle = relations.position[:, 0], np.angle(heading)
        for w in np.flatnonzero(which).tolist():
            box = self._box(int(working[w].sum()))
            start = np.array([here[w].real, here[w].imag, angle[w]])
            known = self._times(limits, w), self._room(box), obstacle[w]
            path = search(start, goal[w], box, *known)
            count = len(path.point)
            way.missing[w] = count + way.legs[w] == 0
            if count:
                way.point[w, :count], way.heading[w, :count] = path.point, path.heading
                way.legs[w], way.leg[w], way.begins[w] = count, 0, True

    def _times(self, limits: Limits, w: int) -> Times:
        """Returns what the parts of a path take the team of a world."""
        gains, speed, yaw_rate = self._gains, float(limits.speed[w]), float(limits.yaw_rate[w])
        stop = speed / float(limits.acceleration[w]) + 1 / gains.speed_gain
        turn = yaw_rate / float(limits.yaw_acceleration[w]) + 1 / gains.yaw_gain
        return Times(speed, yaw_rate, stop + turn)

    def _room(self, box: Box) -> Room:
        return Room(LEAST * self._tolerance, self._tolerance, GRID * box.reach, self._margin)

    def target(
        self, way: Way, course: Course, relations: Relations, moves: Bool
    ) -> tuple[Complex, Float, Bool]:
        """Returns what direct paths lead to, in the vessel's frame: next waypoints, or goals.

        Args:
            way: legs that are done are passed.
            course: its axis is that of the leg, where one begins.
            relations: of the estimated motion.
            moves: (W,) worlds whose teams move the vessel.

        Returns:
            Positions (W,), m; headings (W,), rad; whether they are the goals (W,).
        """
        worlds, heading = np.arange(len(way.leg)), relations.heading[:, 0]
        here = relations.position[:, 0]
        axis = course.axis
        bearing = direction(way.heading[worlds, way.leg]) * axis
        to_go = ((way.point[worlds, way.leg] - here) / bearing).real
        done = moves & ~way.begins & ~way.is_last & (to_go < REACHED * self._tolerance)
        way.leg = way.leg + done
        begins = done | (way.begins & moves)
        way.begins &= ~begins
        last = way.is_last
        point, on_leg = way.point[worlds, way.leg], way.heading[worlds, way.leg]
        ahead = ((point - here) / (direction(on_leg) * axis)).real
        course.axis = np.where(begins & (ahead < 0.0), -axis, axis)
        course.arrived &= ~begins
        following = way.heading[worlds, np.minimum(way.leg + 1, LEGS - 1)]
        turn = wrap(following - np.angle(heading))
        goal, final = relations.goal, -relations.heading_error
        return np.where(last, goal, (point - here) / heading), np.where(last, final, turn), last


def driven_box(found: Formation, vessel: Complex, boats: Complex) -> Box:
    """Returns the box round a vessel and its team.

    Args:
        found: where the boats are.
        vessel: (n,) corners, m.
        boats: (A, n) corners of the boats, m.
    """
    corners = np.concatenate([vessel, boats.ravel()]) / found.axis
    length, aside = np.abs(corners.real).max(), np.abs(corners.imag).max()
    axis = float(np.angle(found.axis))
    return Box(float(length), float(aside), float(np.abs(corners).max()), axis)
