"""Plans the vessel's path among obstacles, and the side from which it is pushed.

Where the path that would be taken in open water is clear it is kept. Else the cheapest clear path
is looked for, see ``clear_paths``: the team can push the vessel on to a place where it lets go,
goes round to the other side, and pushes it from there. Where no clear path begins, the nearest
places ahead of the vessel and along its length are tried, to which it can be driven or slid first.
"""

from typing import NamedTuple

import numpy as np

from asv_env.params import EnvParams
from asv_env.tasks.layouts import team_reach
from asv_env.types import Bool, Complex, Float, given
from baselines.paper.arcs import ArcPath
from baselines.scripted.clear_paths import (
    BESIDE,
    SEGMENTS,
    clearances_beside,
    gathers_at,
    path_clearance,
    search,
)
from baselines.scripted.gains import GraspGains, PathGains
from baselines.scripted.legs import Outline, Team, Terms

EASED = (1.0, 0.6, 0.3)  #: factors on the least clearances that are tried one after the other
SPACING = 0.6  #: spacing of the grid on which legs meet, vessel lengths
STEP = 0.5  #: steps in which a begin is looked for beside the vessel, spacings of the grid
SLIDE_COST = 5.0  #: further cost of slides per length: they are slow
MARGIN = 2.0  #: how far that grid reaches beyond start and goal, vessel lengths
LAST_STRAIGHT = 1.75
"""Longest last straight, vessel lengths: on it the vessel recovers from the turn before it gets
between the piers of a dock, which are one length long."""


class Search(NamedTuple):
    """What was found for one vessel."""

    path: Float  #: (SEGMENTS, 2) curvatures, 1/m, and lengths, m
    other: bool  #: whether it begins on the other side
    switches: bool  #: whether the team has to switch at its end
    cost: float  #: as path length, m


class Plans(NamedTuple):
    """Paths of vessels up to their goals, or to where the team switches to the other side."""

    path: ArcPath  #: (W,) paths of ``SEGMENTS`` segments
    other: Bool  #: (W,) whether the team has to switch at once, before it pushes
    switches: Bool  #: (W,) whether it has to switch at the end of the path
    slides: Bool  #: (W,) whether the vessel has to be slid along its length to where they begin


class ClearPlanner:
    """Plans paths among obstacles for a vessel and a team; see ``Plans``.

    Args:
        params: parameters of the environment.
        gains: costs of radii, straights and clearance.
        grasp: gains of the approach, for the room in which a team gathers.
        may_switch: whether the team may switch to the other side of the vessel.
    """

    def __init__(
        self, params: EnvParams, gains: PathGains, grasp: GraspGains, may_switch: bool
    ) -> None:
        self._may_switch = may_switch
        length, (along, ahead, behind) = params.vessel.size, team_reach(params)
        self._terms, self._ease_cost = terms_of(gains, length), gains.clearance_cost * length
        self._team = Team(
            box(along, ahead, behind),
            box(along, ahead, behind + grasp.waypoint_height * length / 0.40),
            gains.switch_cost * length if may_switch else np.inf,
        )

    def plan(
        self, pose: Float, goal: Float, obstacle: Float, open_water: ArcPath, can_slide: Bool
    ) -> Plans:
        """Returns paths of vessels at poses (W, 3) to goals (W, 3) among obstacles (W, M, 5).

        Where no clear path begins, but one begins beside the vessel, teams that ``can_slide`` (W,)
        slide it there first. Where there is none either the path is that of ``open_water``, which
        has up to ``SEGMENTS`` segments.
        """
        worlds, obstacle = len(pose), given(obstacle)
        missing = ((0, 0), (0, SEGMENTS - open_water.length.shape[1]))
        curvature = np.pad(open_water.curvature, missing)
        length = np.pad(open_water.length, missing)
        start, (other, switches, slides) = pose.copy(), np.zeros((3, worlds), bool)
        team = self._team
        for w in range(worlds):
            rows = np.stack([curvature[w], length[w]], axis=-1)
            if path_clearance(pose[w], rows, obstacle[w], team, self._terms) >= 0.0:
                continue
            found = self._found(pose[w], goal[w], obstacle[w], (0.0, team.switch_cost))
            if found is None:
                start[w], found = self._beside(pose[w], goal[w], obstacle[w], bool(can_slide[w]))
                slides[w] = (start[w] != pose[w]).any()
            if found is not None:
                curvature[w], length[w] = found.path.T
                other[w], switches[w] = found.other, found.switches
        return Plans(ArcPath(start, curvature, length), other, switches, slides)

    def _beside(
        self, pose: Float, goal: Float, obstacle: Float, slides: bool
    ) -> tuple[Float, Search | None]:
        """Returns the cheapest way out of where no path begins: its start (3,), and what it is.

        Of the poses ahead, and along the vessel if it ``slides``, the nearest of each kind from
        which there is a path are compared.
        """
        step, terms, least = STEP * self._terms.spacing, self._terms, EASED[-1]
        eased = terms._replace(least_straight=least * terms.least_straight)
        clear = clearances_beside(pose, obstacle, self._team, eased, step)
        start, best = pose, None
        for k in range(len(BESIDE) if slides else 1):
            for n in np.flatnonzero(clear[k] >= least * terms.least_turning):
                move = (n + 1) * step
                way = BESIDE[k] * move * np.exp(1j * pose[2])
                there = pose + np.array([way.real, way.imag, 0.0])
                found = self._found(there, goal, obstacle, (0.0, np.inf))
                if found is None:
                    continue
                found.path[0, 1] = 0.0 if k else move
                cost = found.cost + move * (1 + SLIDE_COST * (k > 0))
                if best is None or cost < best.cost:
                    start, best = there if k else pose, found._replace(cost=cost)
                break
        return start, best

    def sides(self, pose: Float, goal: Float, obstacle: Float) -> Bool:
        """Returns whether teams that are on neither side yet should begin on the other one (W,)."""
        other, obstacle = np.zeros(len(pose), dtype=bool), given(obstacle)
        for w in range(len(pose)):
            found = self._found(pose[w], goal[w], obstacle[w], (0.0, 0.0))
            if found is None:  # The team has to begin where it can.
                this, that = gathers_at(pose[w], obstacle[w], self._team, self._terms)
                other[w] = that and not this
            else:
                other[w] = found.other
        return other

    def _found(
        self, pose: Float, goal: Float, obstacle: Float, sides: tuple[float, float]
    ) -> Search | None:
        """Returns what ``search`` finds, or None.

        Less clearance than is asked for is accepted where there is no path with more, or where it
        saves a switch.
        """
        found, cheapest = None, np.inf
        for k, ease in enumerate(EASED):
            least = ease * self._terms.least_turning, ease * self._terms.least_straight
            eased = self._terms._replace(least_turning=least[0], least_straight=least[1])
            team, begins = self._team, sides
            if found is not None:
                team, begins = (
                    team._replace(switch_cost=np.inf),
                    (sides[0], 0.0 if sides[1] == 0 else np.inf),
                )
            path, other, switches, cost = search(pose, goal, obstacle, team, eased, begins)
            cost += k * self._ease_cost
            if cost < cheapest:
                found, cheapest = Search(path, bool(other), bool(switches), cost), cost
            if found is not None and not found.switches and (not found.other or sides[1] == 0):
                break
        return found


def terms_of(gains: PathGains, length: float) -> Terms:
    """Returns what is asked of the paths of a vessel of this length, m."""
    radii = np.array([gains.narrow_radius, gains.widest_radius * gains.tightest_radius])
    straights = np.array([gains.final_straight, 0.0, LAST_STRAIGHT])
    missing = np.maximum(gains.final_straight - straights, 0.0)
    return Terms(
        radii * length / 2,
        (gains.radius_cost * (gains.widest_radius - radii) + [gains.narrow_cost, 0.0]) * length,
        straights * length,
        gains.straight_cost * missing * length,
        gains.turning_clearance * length,
        gains.straight_clearance * length,
        gains.wanted_clearance * length,
        gains.clearance_cost * length,
        SPACING * length,
        MARGIN * length,
    )


def box(along: float, ahead: float, behind: float) -> Outline:
    """Returns the outline that reaches so far from the vessel's centre, m."""
    corners: Complex = np.array(
        [-along - 1j * ahead, along - 1j * ahead, along + 1j * behind, -along + 1j * behind]
    )
    centre = 0.5j * (behind - ahead)
    return Outline(corners, centre, float(np.abs(corners - centre).max()))
