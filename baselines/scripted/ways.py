"""The ways of boats to their waypoints: their usual paths, or routes round obstacles.

A boat keeps to its ``ApproachPath`` where that is clear. Where it is not, the boat goes round the
vessel the other way, or makes a detour along a route.
"""

from typing import NamedTuple

import numpy as np

from asv_env.params import EnvParams
from asv_env.polygons import complex_corners
from asv_env.tasks.formation import Relations
from asv_env.types import Bool, Complex, Float, Int, Sensed
from baselines.scripted.approach_path import ApproachPath
from baselines.scripted.docking import GraspMemory
from baselines.scripted.routes import Routes, are_clear, edge_rows, follow

CLEARANCE = 1.15  #: that boats keep from obstacles, reaches of a boat
WIDE = 1.2  #: clearance from the vessel where there is room, clearances of the usual paths
BEND_GAIN = 2.0  #: distance to a bend of a route that counts like a metre to the waypoint, m
EVERY = 0.3  #: time after which a route is checked, s: a boat makes a third of its clearance in it
TINY = 1e-9  #: floor of the distance to a bend, m


class Way(NamedTuple):
    """How boats get to their waypoints; all (W, A), in the vessel's frame."""

    course: Complex  #: direction in which they go
    length: Float  #: path length left, m
    to_bend: Float  #: distance that limits their speed before a bend of a route, m; else inf
    sees: Bool  #: whether no obstacle is in between
    away: Complex  #: direction away from near obstacles, of a size from 0 to 1


class ClearRoutes:
    """Finds routes of boats round obstacles and the vessel.

    Args:
        params: parameters of the environment.
        wide: clearance that they keep from the vessel where there is room for it, m.
    """

    def __init__(self, params: EnvParams, wide: float) -> None:
        vessel, boat = params.hulls()
        self._corners = complex_corners(vessel.corners)
        self.clearance, self._wide = CLEARANCE * boat.reach, wide
        self._every = max(1, round(EVERY * params.scale**0.5 * params.clock.control))

    def find(
        self,
        relations: Relations,
        end: Complex,
        obstacle: Float,
        side: Float,
        known: Routes,
        tick: Int,
    ) -> Way:
        """Returns the ways along routes to ends (W, A), vessel frame, m.

        Args:
            relations: of the estimated motion.
            end: (W, A) vessel frame, m.
            obstacle: (W, M, 5) rows.
            side: (W,) -1 where the vessel is seen in the mirror image, else +1.
            known: routes so far; updated.
            tick: (W,) control ticks of the episode.
        """
        heading, vessel = relations.heading[:, :1], relations.position[:, :1]
        outline = self._corners.real + 1j * self._corners.imag * side[:, None]
        hull = edge_rows(vessel + heading * outline)
        clearances = self.clearance, self._wide
        place, end = np.ascontiguousarray(relations.position[:, 1:]), vessel + heading * end
        now = tick % self._every == 0
        sees, away = follow(place, end, obstacle, hull, *clearances, known, now)
        ahead = (known.via - place) * heading.conj()
        distance = np.abs(ahead)
        to_bend = np.where(known.left > 0, distance * BEND_GAIN, np.inf)
        course = ahead / np.maximum(distance, TINY)
        return Way(course, distance + known.left, to_bend, sees, away * heading.conj())


class Ways:
    """Finds the ways of boats.

    Args:
        params: parameters of the environment.
        path: the usual paths.
    """

    def __init__(self, params: EnvParams, path: ApproachPath) -> None:
        self._path, self._hz = path, params.clock.control
        self._routes = ClearRoutes(params, WIDE * path.clearance)

    def find(
        self,
        relations: Relations,
        waypoint: Complex,
        sensed: Sensed,
        memory: GraspMemory,
        new: Bool,
    ) -> Way:
        """Returns the ways to waypoints (W, A); ``memory`` is updated.

        Approaches that are ``new`` (W,) choose the turn direction round the vessel first.
        """
        boat = relations.boat
        if not sensed.obstacle.shape[1]:
            if new.any():
                chosen = self._path.turn_direction(boat[new], waypoint[new])
                memory.turn_direction[new] = chosen
            usual = self._path.course(boat, waypoint, memory.turn_direction)
            anywhere = np.full(boat.shape, np.inf), np.ones(boat.shape, dtype=bool)
            return Way(*usual, *anywhere, np.zeros_like(boat))
        memory.end[new] = np.nan  # Routes of earlier approaches are void.
        self._update_detours(relations, waypoint, sensed, memory, new)
        usual = self._path.course(boat, waypoint, memory.turn_direction)
        detour = self._detour(relations, waypoint, sensed, memory)
        course = np.where(memory.detours, detour.course, usual[0])
        length = np.where(memory.detours, detour.length, usual[1])
        to_bend = np.where(memory.detours, detour.to_bend, np.inf)
        return Way(course, length, to_bend, detour.sees, detour.away)

    def _detour(
        self, relations: Relations, waypoint: Complex, sensed: Sensed, memory: GraspMemory
    ) -> Way:
        """Returns the ways along routes, which end above the waypoints (W, A)."""
        above = waypoint.real + 1j * np.maximum(waypoint.imag, self._path.entry)
        known = Routes(memory.via, memory.left, memory.end)
        own = sensed.obstacle, sensed.side, known, sensed.tick
        way = self._routes.find(relations, above, *own)
        return way._replace(length=way.length + (above - waypoint).imag)

    def _update_detours(
        self,
        relations: Relations,
        waypoint: Complex,
        sensed: Sensed,
        memory: GraspMemory,
        new: Bool,
    ) -> None:
        """Finds out every second which boats must leave their usual paths."""
        now = new | (sensed.tick % self._hz == 0)
        if not now.any():
            return
        boat, waypoint, obstacle = relations.boat[now], waypoint[now], sensed.obstacle[now]
        heading, vessel = relations.heading[now, :1, None], relations.position[now, :1, None]
        turn = memory.turn_direction[now]
        turn = np.where(new[now][:, None], self._path.turn_direction(boat, waypoint), turn)
        clear = []
        for each in (turn, 1 - turn):
            points = self._path.points(boat, waypoint, each) * heading + vessel
            clear.append(are_clear(points, obstacle, self._routes.clearance))
        turn = np.where(~clear[0] & clear[1], 1 - turn, turn)
        memory.turn_direction[now], memory.detours[now] = turn, ~(clear[0] | clear[1])
