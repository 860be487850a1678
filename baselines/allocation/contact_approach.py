"""How boats come to their places: round the hull, and down the line of the place.

Each boat follows its path (``Detours``) to the waypoint in front of its place and docks from there,
by the law of the script's descent (``Docking``): a boat that misses its place goes astern and tries
again. Boats that are early wait a little off the hull. As in the script's approach they steer for
a velocity relative to the hull and not for a heading, because they skid.
"""

from functools import cache

import numpy as np

from asv_env import polygons
from asv_env.params import EnvParams
from asv_env.tasks.formation import Relations, assigned
from asv_env.types import Bool, Complex, Float, Int, Sensed, rows
from baselines.allocation.allocation_gains import AllocationGains
from baselines.allocation.boats import Boats
from baselines.allocation.contact_points import PAIR, Formation, formation, pairs
from baselines.allocation.detours import Detours
from baselines.scripted.docking import Docking
from baselines.scripted.gains import GraspGains
from baselines.scripted.grasp_controller import REPULSION, avoidance_velocity, lead
from baselines.scripted.routes import Routes
from baselines.scripted.ways import ClearRoutes, Way

CLEARANCE = 1.6
"""Distance of boats' centres from the hull on their paths, lengths: that of a docked boat, half the
width of another, and a third of a length to spare."""
SKID_TIME = 1.0  #: time for which a docking boat skids along the hull, s
BESIDE = 0.02  #: distance from the line of its place beyond which a boat comes down slowly, m
LEAST_HEIGHT = 0.015  #: height above its place by which its speed is then given at least, m


class ContactApproach:
    """Speeds and headings of boats on their way to their places."""

    def __init__(self, params: EnvParams, gains: AllocationGains) -> None:
        self._vessel, self._boat = params.hulls()
        self._gains, self._grasp = gains, GraspGains()
        self._docking = Docking(params, self._grasp)
        self._lead = lead(self._boat, self._grasp)
        self.detours = cache(self._detours)
        self._routes = ClearRoutes(params, CLEARANCE * self._boat.length)

    def formation(self, team: int) -> Formation:
        """Returns the formation of a team."""
        return formation(self._vessel, self._boat, team)

    def spans(self, working: Bool) -> Bool:
        """Returns the worlds (W,) in which the boats that work (W, A) have a formation that spans.

        See ``Formation.spans``.
        """
        count = working.sum(axis=1)
        spans = np.zeros(working.shape[1] + 1, dtype=np.bool_)
        for team in np.unique(count).tolist():
            spans[team] = team > 0 and self.formation(team).spans
        return np.asarray(spans[count])

    def assign(self, boat: Complex) -> tuple[Formation, Int]:
        """Returns the formation of boats (n,), vessel frame, and the number of each one's point.

        The sum of the squares of the paths' lengths is least, so that no boat is late.
        """
        length = self.detours(len(boat)).lengths(boat)
        return self.formation(len(boat)), assigned(np.ascontiguousarray(length**2))

    def assign_pair(self, boat: Complex, kind: int) -> tuple[Complex, Complex, Int]:
        """Returns places, inward directions and numbers (2,) of two boats (2,) for a manoeuvre."""
        place, inward = self.points(PAIR)
        length = self.detours(PAIR).lengths(boat)[:, PAIR * kind : PAIR * (kind + 1)]
        number = PAIR * kind + assigned(np.ascontiguousarray(length**2))
        return place[number], inward[number], number

    def points(self, team: int) -> tuple[Complex, Complex]:
        """Returns the contact points (n,) that a team may go to, and inward directions (n,)."""
        if team == PAIR:
            found = pairs(self._vessel, self._boat)
            return found.place.ravel(), found.inward.ravel()
        formed = self.formation(team)
        return formed.place, formed.inward

    def _detours(self, team: int) -> Detours:
        """Returns the paths to the waypoints in front of a team's contact points."""
        (place, inward), boat = self.points(team), self._boat
        hull = polygons.complex_corners(polygons.convex_hull(self._vessel.corners))
        clearance = CLEARANCE * boat.length
        waypoint = place - inward * (clearance - boat.length / 2)
        return Detours(hull, clearance, waypoint)

    def among(
        self, boats: Boats, relations: Relations, sensed: Sensed, known: Routes, coming: Bool
    ) -> Way:
        """Returns the ways of boats to their waypoints among obstacles.

        ``known`` has their routes so far, and is updated where boats are ``coming`` (W,).
        """
        shape = boats.place.shape
        far, sees = np.full(shape, np.inf), np.ones(shape, np.bool_)
        nowhere = np.zeros(shape, np.complex128)
        way = Way(nowhere, np.zeros(shape), far, sees, nowhere.copy())
        waypoint = boats.place - boats.inward * (CLEARANCE - 0.5) * self._boat.length
        here = Routes(known.via[coming], known.left[coming], known.target[coming])
        given = rows(relations, coming), waypoint[coming], sensed.obstacle[coming]
        tick = sensed.tick[coming]
        found = self._routes.find(*given, np.ones(len(tick)), here, tick)
        for each, new in zip((*way, *known), (*found, *here), strict=True):
            each[coming] = new
        return way

    def _open_water(self, boats: Boats) -> Way:
        """Returns the ways of boats where there are no obstacles."""
        shape = boats.place.shape
        far, sees = np.full(shape, np.inf), np.ones(shape, np.bool_)
        return Way(*self.course(boats), far, sees, np.zeros(shape, np.complex128))

    def course(self, boats: Boats) -> tuple[Complex, Float]:
        """Returns the directions (W, A) of the boats' paths, and their lengths (W, A), m."""
        course, length = np.zeros_like(boats.place), np.zeros(boats.place.shape)
        count = boats.working.sum(axis=1)
        for team in np.unique(count).tolist():
            of = count == team
            known = boats.position[of], boats.number[of]
            course[of], length[of] = self.detours(team).course(*known)
        return course, length

    def command(
        self,
        boats: Boats,
        astern: Bool,
        recoils: Bool,
        standoff: Float,
        among: Way | None = None,
    ) -> tuple[Float, Float, Bool]:
        """Returns speeds, m/s, heading errors, rad, and which boats are to go astern, (W, A).

        Args:
            boats: with the hull's velocity as it is.
            astern: (W, A) boats that went astern.
            recoils: (W, A) boats that something keeps from their places, so that they go astern.
            standoff: (W,) gap to the hull in which boats are to wait, m.
            among: the ways of the boats among obstacles; None: there are none.
        """
        gains, grasp, inward = self._gains, self._grasp, boats.inward
        way = self._open_water(boats) if among is None else among
        distance = np.minimum(way.length, way.to_bend)
        speed = np.minimum(grasp.max_speed, gains.approach_speed + gains.arrival_gain * distance)
        limits = grasp.avoidance_range, grasp.avoidance_speed
        wanted = speed * way.course + avoidance_velocity(boats.position, boats.seen, *limits)
        wanted += REPULSION * grasp.cruise_speed * way.away
        target = boats.place - inward * standoff[:, None]
        upright = -1j / inward  # Turns a boat to where it would come from the vessel's +n side.
        gap = (target - boats.position) * upright
        now = boats.position * upright, boats.alignment, gap, boats.place * upright
        docks, astern = self._docking.update(*now, astern)
        docks, astern = docks & way.sees, astern & way.sees
        # A boat beside its line comes to the hull slowly, where it would only miss its place.
        skid = SKID_TIME * ((boats.velocity - boats.hull) * upright).real
        beside = np.maximum(np.abs(gap.real - skid) - BESIDE, 0.0)
        height = np.maximum(-gap.imag - beside, np.minimum(-gap.imag, LEAST_HEIGHT))
        back = astern | recoils
        docking = self._docking.velocity(gap.real - 1j * height, back) / upright
        wanted = np.where(docks, docking, wanted) + boats.hull
        ahead = (wanted / boats.bow).real
        either = docks | (way.away != 0.0)
        ahead = np.where(either, ahead, np.maximum(ahead, 0.0))  # Others turn before they go.
        aim = wanted - boats.water + self._lead * (wanted - boats.velocity)
        aim = np.where(docks & back, -aim, aim) / inward
        to_hull = np.maximum(aim.real, grasp.pointing_speed) + 1j * aim.imag
        aim = np.where(docks, to_hull, aim) * inward  # Docking boats point to the hull.
        return ahead, np.angle(aim / boats.bow), astern
