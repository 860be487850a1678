"""The team round the vessel: slots, their assignment, and conditional closure.

Slots and relations are given in the vessel's frame, as complex numbers u + iw: u along its
length, w along n, the side from which it is pushed in the nominal case.
"""

from dataclasses import dataclass

import numpy as np

from asv_env.compiled import allocating, compiled
from asv_env.memo import by_identity
from asv_env.params import SMALLEST_CAGE, BoatParams, EnvParams, pitches
from asv_env.polygons import end_height, upper_side
from asv_env.tasks.laws import aim, around, direction_of, heading_error_of, size_of
from asv_env.types import Bool, Complex, Float, Int, given, zeros

SPARE = 0.01  #: room between boats that are spread no wider than they need, m at scale 1


def slots(params: EnvParams, team: int, side: float = 1.0) -> Complex:
    """Returns the slots (team,) of the boats' centres on a side, +1 or -1, from -u to +u, m.

    From four boats on, the first and last cage the ends of the hull, beside its farthest points;
    the others, and a smaller team all, are spread along its side: each touches the convex hull with
    its bow, as it comes across. A rectangle's side is used as a whole, at the pitch
    length / (team - 1) with a cage. Of another hull it is the part on which friction holds a boat
    that pushes, if the team fits there; else as much more as it needs.
    """
    boat, corners = params.boat, params.vessel.corners
    if side < 0:
        corners = [(x, -y) for x, y in corners[::-1]]
    u, w = upper_side(corners)
    caged = team >= SMALLEST_CAGE
    share = np.arange(team) / (team - 1) if caged else (np.arange(team) + 1) / (team + 1)
    low, high = _span(params, u, w, team)
    places = (low + high) / 2 + (high - low) * (share - 0.5)
    slot: Complex = places + 1j * (touch_heights(places, u, w, boat) + boat.length / 2)
    if caged:
        gap = boat.width / 2 + params.task.end_gap
        slot[0] = complex(u[0] - gap, end_height(corners, u[0]))
        slot[-1] = complex(u[-1] + gap, end_height(corners, u[-1]))
    return slot if side > 0 else slot.conj()


def _span(params: EnvParams, u: Float, w: Float, team: int) -> tuple[float, float]:
    """Returns the part of a side, u and w of its corners (n,), over which a team is spread, m."""
    parts, caged = pitches(team), team >= SMALLEST_CAGE
    low, high = holding_part(u, w, params.water.contact_friction)
    beside = max(team - 3 if caged else team - 1, 1)  #: pitches between the outermost side boats
    needed = parts * (params.boat.width + SPARE * params.scale)
    length = min(max((high - low) * parts / beside, needed), u[-1] - u[0])
    middle = min(max((low + high) / 2, u[0] + length / 2), u[-1] - length / 2)
    return middle - length / 2, middle + length / 2


def holding_part(u: Float, w: Float, friction: float) -> tuple[float, float]:
    """Returns the part of a side on which friction holds a boat that pushes across the hull, m.

    The side has the corners ``u`` and ``w`` (n,). Where no edge is flat enough it is the highest
    corner.
    """
    flat = np.flatnonzero(np.abs(np.diff(w)) <= friction * np.diff(u))
    if not len(flat):
        return (float(u[w.argmax()]),) * 2
    return float(u[flat[0]]), float(u[flat[-1] + 1])


def touch_heights(places: Float, u: Float, w: Float, boat: BoatParams) -> Float:
    """Returns the height (n,) at which the bows of boats touch a side, m.

    The boats are at ``places`` (n,) along the hull and point across it; the side has the corners
    ``u`` and ``w``. Both are convex, so they touch at a corner of one of them.
    """
    half = np.array([0.0, boat.bow / 2, boat.width / 2])
    across = np.concatenate([-half, half])
    under_boat = np.interp(np.abs(across), half, [0.0, 0.0, boat.bow])
    at = places[:, None] + across
    beside = np.interp(at, u, w, left=-np.inf, right=-np.inf) - under_boat
    offset = np.abs(places[:, None] - u)
    corners = np.where(
        offset <= boat.width / 2, w - np.interp(offset, half, [0, 0, boat.bow]), -np.inf
    )
    return np.maximum(beside.max(axis=1), corners.max(axis=1))


@by_identity
def slot_table(params: EnvParams) -> Complex:
    """Returns the slots of every size of a team up to the whole one, in rows (2, A + 1, A).

    First those on the +n side, then those on the other.
    """
    table = np.zeros((2, params.num_boats + 1, params.num_boats), dtype=np.complex128)
    for team in range(1, params.num_boats + 1):
        table[0, team, :team] = slots(params, team)
        table[1, team, :team] = slots(params, team, -1.0)
    table.setflags(write=False)
    return table


def slot_direction(side: Float) -> Complex:
    """Returns the direction (...,) in which boats in their slots point: across the vessel."""
    return -1j * side


@allocating
def assigned(cost: Float) -> Int:
    """Returns the column (n,) for each row of costs (n, n), so that their sum is least.

    This is the Hungarian algorithm with potentials (Kuhn 1955; Jonker and Volgenant 1987): row
    after row is added, by the shortest augmenting path.
    """
    n = len(cost)
    of_row, of_column = np.zeros(n + 1), np.zeros(n + 1)  # potentials
    row_at, before = np.zeros(n + 1, np.int64), np.zeros(n + 1, np.int64)
    for row in range(1, n + 1):
        row_at[0], column = row, 0
        least, done = np.full(n + 1, np.inf), np.zeros(n + 1, np.bool_)
        while row_at[column] != 0:
            done[column] = True
            current, step, following = row_at[column], np.inf, 0
            for k in range(1, n + 1):
                if done[k]:
                    continue
                reduced = cost[current - 1, k - 1] - of_row[current] - of_column[k]
                if reduced < least[k]:
                    least[k], before[k] = reduced, column
                if least[k] < step:
                    step, following = least[k], k
            for k in range(n + 1):
                if done[k]:
                    of_row[row_at[k]] += step
                    of_column[k] -= step
                else:
                    least[k] -= step
            column = following
        while column != 0:
            row_at[column] = row_at[before[column]]
            column = before[column]
    columns = np.empty(n, np.int64)
    for column in range(1, n + 1):
        columns[row_at[column] - 1] = column - 1
    return columns


def assign(boats: Complex, points: Complex) -> Int:
    """Returns the index (A,) of the point for each boat, so that the total distance is least.

    Boats (A,) and points (A,) are positions in the same frame, m.
    """
    return assigned(np.abs(boats[:, None] - points[None, :]))


@allocating
def _assign(
    worlds: Int, motion: Float, working: Bool, side: Float, table: Complex, slot: Complex
) -> Bool:
    """Assigns slots in some worlds (n,); returns (n,) whether any of the working boats' changed."""
    changed = np.zeros(len(worlds), np.bool_)
    team = slot.shape[1]
    for number in range(len(worlds)):
        world = worlds[number]
        now, works = motion[world], working[world]
        to_vessel = direction_of(now[0, 2]).conjugate()
        boats, count = np.empty(team, np.complex128), 0
        for boat in range(team):
            x, y = now[boat + 1, 0] - now[0, 0], now[boat + 1, 1] - now[0, 1]
            boats[boat] = complex(x, y) * to_vessel
            count += works[boat]
        points = np.empty(count, np.complex128)
        for k in range(count):
            points[k] = table[0 if side[world] > 0 else 1, count, k]
        cost, row = np.empty((count, count)), 0
        for boat in range(team):
            if works[boat]:
                for k in range(count):
                    cost[row, k] = abs(boats[boat] - points[k])
                row += 1
        columns, row = assigned(cost), 0
        for boat in range(team):
            if works[boat]:
                point = points[columns[row]]
                changed[number] = changed[number] or slot[world, boat] != point
                slot[world, boat] = point
                row += 1
            else:
                slot[world, boat] = boats[boat]
    return changed


def assign_slots(
    params: EnvParams, motion: Float, working: Bool, side: Float, slot: Complex, worlds: Int
) -> Bool:
    """Assigns slots to the working boats of the worlds (n,), in place.

    They are those of a team of the working boats (W, A), on the sides (W,) of motions (W, B, 6), by
    the least total distance; a boat that has failed keeps its place.

    Args:
        params: parameters of the environment.
        motion: (W, B, 6) by which slots are assigned.
        working: (W, A) boats that get slots.
        side: (W,) from which the teams push, +1 or -1.
        slot: (W, A) slots, vessel frame, m.
        worlds: (n,) numbers of the worlds concerned.

    Returns:
        Whether slots of working boats have changed, (n,).
    """
    known = given(motion), given(working, np.bool_), given(side), slot_table(params)
    found: Bool = _assign(given(worlds, np.int64), *known, slot)
    return found


@dataclass(frozen=True)
class Relations:
    """Relations of vessel, boats, slots and goal, derived from a motion."""

    position: Complex  #: (W, B) of the bodies, world frame, m
    velocity: Complex  #: (W, B) of the bodies, world frame, m/s
    heading: Complex  #: (W, B) unit vectors along the hulls, world frame
    yaw_rate: Float  #: (W, B) of the bodies, rad/s
    boat: Complex  #: (W, A) positions of the boats, vessel frame, m
    slot_gap: Complex  #: (W, A) vector from each boat to its slot, vessel frame, m
    slot_error: Float  #: (W, A) distance of each boat to its slot, m
    alignment: Complex  #: (W, A) direction of each boat relative to that of its slot, unit vectors
    slip: Complex  #: (W, A) velocity of each boat relative to the hull, world frame, m/s
    goal: Complex  #: (W,) position of the goal, vessel frame, m
    goal_turn: Complex  #: (W,) direction of the goal relative to that of the vessel, unit vectors
    goal_error: Float  #: (W,) distance of the vessel to the goal, m
    heading_error: Float  #: (W,) heading of the vessel minus that of the goal, rad


def relate(motion: Float, goal: Float, slot: Complex, side: Float) -> Relations:
    """Returns the relations of a motion (W, B, 6), goals (W, 3), slots (W, A) and sides (W,)."""
    worlds, bodies = motion.shape[:2]
    of_body, of_boat, of_world = (worlds, bodies), (worlds, bodies - 1), (worlds,)
    relations = zeros(Relations, *[of_body] * 4, *[of_boat] * 5, *[of_world] * 4)
    found = given(motion), given(goal), given(slot, np.complex128), given(side)
    _fill(*found, *vars(relations).values())
    return relations


@compiled
def _fill(
    motion: Float,
    goals: Float,
    slot: Complex,
    side: Float,
    position: Complex,
    velocity: Complex,
    heading: Complex,
    yaw_rate: Float,
    boat: Complex,
    slot_gap: Complex,
    slot_error: Float,
    alignment: Complex,
    slip: Complex,
    goal: Complex,
    goal_turn: Complex,
    goal_error: Float,
    heading_error: Float,
) -> None:
    """Fills the fields of ``Relations``."""
    for w in range(len(motion)):
        now = motion[w]
        to_vessel = direction_of(now[0, 2]).conjugate()
        for b in range(now.shape[0]):
            position[w, b] = complex(now[b, 0], now[b, 1])
            velocity[w, b] = complex(now[b, 3], now[b, 4])
            heading[w, b] = direction_of(now[b, 2])
            yaw_rate[w, b] = now[b, 5]
        for a in range(now.shape[0] - 1):
            found = around(now, a + 1, heading[w, a + 1], to_vessel, slot[w, a], side[w])
            boat[w, a], slot_gap[w, a], alignment[w, a], slip[w, a] = found
            slot_error[w, a] = size_of(found[1])
        goal[w], goal_turn[w] = aim(now, goals[w], to_vessel)
        goal_error[w] = size_of(goal[w])
        heading_error[w] = heading_error_of(goal_turn[w])
