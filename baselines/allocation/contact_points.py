"""Where boats push on a hull so that together they can drive, brake and turn it.

Contact points are sampled along the vessel's convex hull. A formation is a set of them, one for
each boat, with an axis along which it drives the vessel: greedily, and then by exchanges, those
are chosen that exert a force either way along the axis, and a moment either way, with the least
effort. The wrench cone of such a formation contains all that a direct path takes. On a plank these
are pairs that face each other on both long sides.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from asv_env import polygons
from asv_env.params import BoatParams, VesselParams
from asv_env.types import Bool, Complex, Float
from baselines.allocation.force_shares import RIDGE, share

SPACING = 0.25  #: distance of neighbouring points, lengths of a boat
MOST_POINTS = 64  #: most points that are considered, but for one on each edge
ROOM = 0.3  #: room between docked boats, and from a boat to a corner of the hull, boat widths
ROUNDS = 3  #: most rounds of exchanges
MOST_AXES = 8  #: most axes that are considered
PAIR = 2  #: size of the teams that move a vessel by manoeuvres
TIGHT = 1e-6  #: fraction by which two boats on a narrow edge have more room than they need
STEERING = 0.5  #: moment over force that two boats are to exert as they drive
NARROW_STEERING = 0.2  #: the same as they slide a vessel along its narrow side
WEAK = 50.0
"""Effort beyond which the hull has no formation of this size: some wrench cannot be exerted."""


@dataclass(frozen=True)
class Formation:
    """Contact points of a team, vessel frame."""

    place: Complex  #: (n,) where boats are when their bows touch the hull, m
    inward: Complex  #: (n,) directions in which they point, unit vectors
    axis: complex  #: direction in which, or against which, the team drives the vessel
    #: sum of squares of the forces for a force of 1 N along the axis and against it, and for
    #: moments of 1 N times the radius of gyration either way; what is missing counts more
    effort: float

    @property
    def spans(self) -> bool:
        """Whether its wrench cone contains forces along the axis, and moments, either way."""
        return self.effort < WEAK


@dataclass(frozen=True)
class Pairs:
    """Contact points of two boats for each manoeuvre, see ``manoeuvres``; vessel frame."""

    place: Complex  #: (6, 2) as in ``Formation``
    inward: Complex  #: (6, 2)
    axis: complex  #: direction of the first manoeuvre
    effort: float  #: largest sum of squares of the forces that a manoeuvre takes

    @property
    def spans(self) -> bool:
        """Whether every manoeuvre can be done."""
        return self.effort < WEAK


@lru_cache(maxsize=64)
def pairs(vessel: VesselParams, boat: BoatParams) -> Pairs:
    """Returns where two boats push to drive, to turn and to slide a vessel."""
    points = _Points(vessel, boat, narrow=True)
    found = [points.pairs(axis) for axis in points.axes]
    return min(found, key=lambda one: one.effort)


@lru_cache(maxsize=64)
def formation(vessel: VesselParams, boat: BoatParams, team: int) -> Formation:
    """Returns the formation of a team along the axis for which it takes the least effort.

    Args:
        vessel: with its fins, as ``EnvParams.hulls`` returns it.
        boat: the kind of boat.
        team: number of boats.
    """
    points = _Points(vessel, boat)
    found = [points.along(axis, team) for axis in points.axes]
    return min(found, key=lambda one: one.effort)


def gyration(vessel: VesselParams) -> float:
    """Returns the radius of gyration that makes moments comparable with forces, m."""
    surge, sway, inertia = vessel.masses
    return float(np.sqrt(2 * inertia / (surge + sway)))


def columns(point: Complex, inward: Complex, radius: float) -> Float:
    """Returns the wrench (..., 3) per force of boats that push at points (...).

    Its parts are the forces along u and w, and the moment over a ``radius``, m.
    """
    moment = (point.conj() * inward).imag / radius
    return np.stack([inward.real, inward.imag, moment], axis=-1)


def needed(axis: Complex) -> Float:
    """Returns the wrenches (..., 4, 3) that a team must exert to drive along axes (...)."""
    none = np.zeros(axis.shape)
    force = np.stack([axis.real, axis.imag, none], axis=-1)
    moment = np.stack([none, none, none + 1.0], axis=-1)
    return np.stack([force, -force, moment, -moment], axis=-2)


def effort(column: Float, wrench: Float, pushes: Bool) -> Float:
    """Returns the sums of squares (...) of forces for wrenches (..., 3); see ``Formation``.

    Boats (..., A) that do not push have no part in it; their columns are (..., A, 3).
    """
    shape = pushes.shape
    flat = column.reshape(-1, *column.shape[-2:]), wrench.reshape(-1, 3)
    limit = np.where(pushes, np.inf, 0.0).reshape(-1, shape[-1])
    force = share(*flat, np.zeros(limit.shape), limit)
    missing = flat[1] - (flat[0] * force[..., None]).sum(axis=1)
    total = (missing**2).sum(axis=-1) / RIDGE + (force**2).sum(axis=-1)
    return np.asarray(total.reshape(shape[:-1]))


class _Points:
    """Contact points of a hull, and the search for formations among them."""

    def __init__(self, vessel: VesselParams, boat: BoatParams, narrow: bool = False) -> None:
        hull = solid_edges(vessel)
        point, self._inward = _sampled(*hull, boat, narrow)
        self._place = point - self._inward * boat.length / 2
        self._column = columns(point, self._inward, gyration(vessel))
        self._apart = (1 + ROOM) * boat.width
        self.axes = _axes(hull[1])

    def along(self, axis: complex, team: int) -> Formation:
        """Returns the formation for an axis."""
        chosen, total = self._chosen(needed(np.asarray(axis)), team)
        return Formation(self._place[chosen], self._inward[chosen], axis, total)

    def pairs(self, axis: complex) -> Pairs:
        """Returns the pairs for an axis."""
        moment, across = np.array([0.0, 0.0, 1.0]), 1j * axis
        ways = (axis, STEERING), (-axis, STEERING), (across, NARROW_STEERING)
        wanted = [
            np.array([way.real, way.imag, 0.0]) + steering * np.outer([1.0, -1.0], moment)
            for way, steering in (*ways, (-across, NARROW_STEERING))
        ]
        wanted[2:2] = [moment[None], -moment[None]]
        chosen = [self._pair(each) for each in wanted]
        number = np.array([pair for _, pair in chosen])
        effort = max(total for total, _ in chosen)
        return Pairs(self._place[number], self._inward[number], axis, effort)

    def _pair(self, wanted: Float) -> tuple[float, list[int]]:
        """Returns the least effort of two boats for wrenches (k, 3), and their points."""
        total, first, second = min(
            (*self._best([first], wanted), first) for first in range(len(self._place))
        )
        return total, sorted([first, second])

    def _chosen(self, wanted: Float, team: int) -> tuple[list[int], float]:
        """Returns points for wrenches (k, 3), and the effort: greedy insertion, then exchanges."""
        chosen: list[int] = []
        total = least = np.inf
        for _ in range(team):
            total, point = self._best(chosen, wanted)
            chosen.append(point)
        for _ in range(ROUNDS):
            for k in range(team):
                total, point = self._best(chosen[:k] + chosen[k + 1 :], wanted)
                chosen.insert(k, point)
                del chosen[k + 1]
            if total >= least:
                break
            least = total
        chosen.sort()
        return chosen, total

    def _best(self, others: list[int], wanted: Float) -> tuple[float, int]:
        """Returns the least effort of a team of others and one more point, and its number."""
        gaps = np.abs(self._place[:, None] - self._place[others])
        free = np.flatnonzero((gaps >= self._apart).all(axis=1))
        if not len(free):  # There are more boats than room.
            free = gaps.min(axis=1).argmax()[None]
        teams = np.concatenate([np.tile(others, (len(free), 1)).astype(int), free[:, None]], axis=1)
        column = np.repeat(self._column[teams][:, None], len(wanted), axis=1)
        wrench = np.broadcast_to(wanted, (len(free), *wanted.shape))
        total = effort(column, wrench, np.ones(column.shape[:-1], dtype=np.bool_)).sum(axis=1)
        best = np.round(total, 9).argmin()  # Rounded, so that order breaks ties.
        return float(total[best]), int(free[best])


def solid_edges(vessel: VesselParams) -> tuple[Complex, Complex]:
    """Returns where the edges (n,) of the hull begin that belong to its convex hull, and vectors.

    Boats find no hold where the convex hull bridges a bay.
    """
    corners = polygons.complex_corners(vessel.corners)
    edge = np.roll(corners, -1) - corners
    hull = polygons.complex_corners(polygons.convex_hull(vessel.corners))
    outer = np.isin(corners, hull) & np.isin(np.roll(corners, -1), hull)
    normal = -1j * edge / np.abs(edge)
    heights = (normal[:, None].conj() * (hull[None] - corners[:, None])).real
    outer &= heights.max(axis=1) <= polygons.LEVEL * np.abs(hull).max()
    return corners[outer], edge[outer]


def _sampled(
    start: Complex, edge: Complex, boat: BoatParams, narrow: bool
) -> tuple[Complex, Complex]:
    """Returns points on edges (n,), with a boat's room from their ends, and inward normals.

    On ``narrow`` edges on which two boats have no such room they have it if their bows touch.
    """
    spacing = max(SPACING * boat.length, np.abs(edge).sum() / MOST_POINTS)
    margin = (0.5 + ROOM) * boat.width
    points, normals = [], []
    for begin, along in zip(start, edge, strict=True):
        length = abs(along)
        room = max(length - 2 * margin, 0.0)
        apart = (1 + ROOM) * boat.width
        if narrow and room < apart <= length - 2 * boat.bow:
            room = apart * (1 + TIGHT)
        offset = np.linspace(-0.5, 0.5, int(room / spacing) + 1) * room if room > 0 else np.zeros(1)
        points.append(begin + (0.5 + offset / length) * along)
        normals.append(np.full(len(offset), 1j * along / length))
    return np.concatenate(points), np.concatenate(normals)


def _axes(edge: Complex) -> list[complex]:
    """Returns the directions across edges (n,), those of long edges first; opposites are one."""
    found: list[complex] = []
    for along in edge[np.argsort(-np.round(np.abs(edge), 9), kind="stable")]:
        axis = complex(1j * along / abs(along))
        if all(abs((axis * other.conjugate()).imag) > polygons.LEVEL for other in found):
            found.append(axis)
    return found[:MOST_AXES]
