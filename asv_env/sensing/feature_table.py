"""Columns of the built-in features, in SI units, of what a boat knows: one compiled loop.

``NAMES`` tells what the columns are. A feature takes some of them, see ``Columns``.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from asv_env.compiled import Bound, allocating, bound, compiled
from asv_env.memo import by_identity
from asv_env.params import EnvParams
from asv_env.params.obstacle_params import grouping
from asv_env.polygons import Outline, complex_corners, outline, to_outline
from asv_env.sensing.nearest_obstacles import OBSTACLES, OF_OBSTACLE, put_obstacles
from asv_env.tasks.laws import aim, around, direction_of, heading_error_of
from asv_env.types import Bool, Complex, Float, Int, Observation, Sensed, given

NEIGHBOURS = 4  #: number of boats that a boat observes
OF_NEIGHBOUR = ("x", "y", "vx", "vy", "present")  #: columns of each of them
NAMES = (
    # Vectors in the boat's frame, or relative to the slot.
    *("own_velocity_x", "own_velocity_y", "slot_x", "slot_y"),
    *("slot_alignment_x", "slot_alignment_y", "hull_x", "hull_y"),
    # Vectors in the vessel's frame.
    *("own_position_x", "own_position_y", "slot_position_x", "slot_position_y"),
    *("vessel_velocity_x", "vessel_velocity_y", "goal_x", "goal_y"),
    *("goal_direction_x", "goal_direction_y"),
    # Scalars.
    *("own_yaw_rate", "vessel_yaw_rate", "touches_vessel", "touches_other", "thrusters_work"),
    *("slots_occupied", "closure", "turn_to_goal", "inverse_team_size", "inverse_vessel_length"),
    "vessel_seen",
    # The nearest boats in sight, near to far, in the boat's frame; zeros where there are no more.
    *(f"neighbour_{k + 1}_{name}" for k in range(NEIGHBOURS) for name in OF_NEIGHBOUR),
    # The nearest points of the nearest obstacles to the boat, in its frame, and to the vessel, in
    # its own; likewise.
    *(f"obstacle_{k + 1}_{name}" for k in range(OBSTACLES) for name in OF_OBSTACLE),
    *(f"vessel_obstacle_{k + 1}_{name}" for k in range(OBSTACLES) for name in OF_OBSTACLE),
)  #: names of the columns
WIDTH = len(NAMES)  #: number of columns
OWN_VELOCITY, SLOT, SLOT_ALIGNMENT, HULL, OWN_POSITION = range(0, 10, 2)
SLOT_POSITION, VESSEL_VELOCITY, GOAL, GOAL_DIRECTION = range(10, 18, 2)
OWN_YAW_RATE, VESSEL_YAW_RATE, TOUCHES_VESSEL, TOUCHES_OTHER, THRUSTERS_WORK = range(18, 23)
SLOTS_OCCUPIED, CLOSURE, TURN_TO_GOAL = range(23, 26)
INVERSE_TEAM_SIZE, INVERSE_LENGTH, VESSEL_SEEN = range(26, 29)
FIRST_NEIGHBOUR = 29
FIRST_OBSTACLE = FIRST_NEIGHBOUR + NEIGHBOURS * len(OF_NEIGHBOUR)
FIRST_OF_VESSEL = FIRST_OBSTACLE + OBSTACLES * len(OF_OBSTACLE)
"""Places of the columns; a vector has two."""


class Known(NamedTuple):
    """What the columns are computed from: fields of ``Sensed``, read-only."""

    estimate: Float  #: (W, B, 6)
    goal: Float  #: (W, 3)
    slot: Complex  #: (W, A)
    side: Float  #: (W,)
    working: Bool  #: (W, A)
    occupied: Bool  #: (W, A)
    closed: Bool  #: (W,)
    touching: Bool  #: (W, A, 2)
    seen: Bool  #: (W, B)
    obstacle: Float  #: (W, M, 5)
    groups: Int  #: (G + 1,) first rows of the obstacles, see ``asv_env.capsules``


class Hull(NamedTuple):
    """The vessel as the boats know it."""

    outline: Outline
    inverse_length: float  #: one over its size, 1/m


@by_identity
def hull(params: EnvParams) -> Hull:
    """Returns the vessel of an environment."""
    corners = complex_corners(params.vessel.corners)
    return Hull(outline(corners), 1.0 / params.vessel.size)


def known(sensed: Sensed, params: EnvParams) -> Known:
    """Returns what the columns are computed from."""
    return Known(
        given(sensed.estimate),
        given(sensed.goal),
        given(sensed.slot, np.complex128),
        given(sensed.side),
        given(sensed.working, np.bool_),
        given(sensed.occupied, np.bool_),
        given(sensed.closed, np.bool_),
        given(sensed.touching, np.bool_),
        given(sensed.seen, np.bool_),
        given(sensed.obstacle),
        grouping(params).groups,
    )


@dataclass(frozen=True)
class Columns:
    """Value of a built-in feature: some columns of the table.

    Called with a ``View`` it returns them, as other features' functions do.
    """

    names: tuple[str, ...]  #: among ``NAMES``

    def __call__(self, view: Any) -> np.ndarray:
        """Returns the columns: (W, A) of one, complex (W, A) of two, else (W, A, n)."""
        found = view.columns.take(self.places, axis=-1)
        if len(self.names) == 2:
            return found.view(np.complex128)[..., 0]
        return found[..., 0] if len(self.names) == 1 else found

    @property
    def places(self) -> list[int]:
        """Numbers of the columns."""
        return [NAMES.index(name) for name in self.names]


class Plan(NamedTuple):
    """What the columns of an observation are; read-only."""

    source: np.ndarray  #: (K,) columns of the table, uint64: signed ones can be negative
    factor: Float  #: (K,) on each column
    bound: Float  #: (K,) to which it is clipped after that


def book(params: EnvParams, source: ArrayLike, factor: ArrayLike, limit: ArrayLike) -> Bound:
    """Returns the vessel and the plan by which ``fill`` fills observations; see ``Plan``."""
    plan = Plan(given(source, np.uint64), given(factor), given(limit))
    found: Bound = bound((hull(params), plan))
    return found


@compiled
def put(row: Float, place: int, vector: complex) -> None:
    """Writes a vector into two columns."""
    row[place], row[place + 1] = vector.real, vector.imag


@compiled
def put_shared(
    known: Known, world: int, vessel: complex, inverse_length: float, row: Float
) -> None:
    """Writes the columns that all boats of a world share; ``vessel`` is its direction."""
    motion, to_vessel = known.estimate[world], vessel.conjugate()
    goal, goal_turn = aim(motion, known.goal[world], to_vessel)
    put(row, VESSEL_VELOCITY, complex(motion[0, 3], motion[0, 4]) * to_vessel)
    put(row, GOAL, goal)
    put(row, GOAL_DIRECTION, goal_turn)
    row[VESSEL_YAW_RATE] = motion[0, 5]
    working = occupied = 0
    for a in range(known.working.shape[1]):
        working += known.working[world, a]
        occupied += known.working[world, a] and known.occupied[world, a]
    row[SLOTS_OCCUPIED] = occupied / working
    row[CLOSURE] = known.closed[world]
    row[TURN_TO_GOAL] = -heading_error_of(goal_turn)
    row[INVERSE_TEAM_SIZE] = 1.0 / working
    row[INVERSE_LENGTH] = inverse_length
    row[VESSEL_SEEN] = known.seen[world, 0]


@compiled
def put_own(
    known: Known,
    world: int,
    boat: int,
    heading: complex,
    vessel: complex,
    outline: Outline,
    row: Float,
) -> None:
    """Writes the columns that are a boat's own, but for its neighbours.

    Its direction is ``heading``, and ``vessel`` is that of the vessel, which has this ``outline``.
    """
    motion, body, to_boat = known.estimate[world], boat + 1, heading.conjugate()
    slot, side = known.slot[world, boat], known.side[world]
    position, gap, alignment, _ = around(motion, body, heading, vessel.conjugate(), slot, side)
    put(row, OWN_VELOCITY, complex(motion[body, 3], motion[body, 4]) * to_boat)
    put(row, SLOT, gap * (vessel * to_boat))
    put(row, SLOT_ALIGNMENT, alignment)
    put(row, HULL, to_outline(outline, position) * (vessel * to_boat))
    put(row, OWN_POSITION, position)
    put(row, SLOT_POSITION, slot)
    row[OWN_YAW_RATE] = motion[body, 5]
    row[TOUCHES_VESSEL] = known.touching[world, boat, 0]
    row[TOUCHES_OTHER] = known.touching[world, boat, 1]
    row[THRUSTERS_WORK] = known.working[world, boat]


@compiled
def put_neighbours(
    motion: Float, seen: Bool, boat: int, heading: complex, near: Int, square: Float, row: Float
) -> None:
    """Writes the columns of the nearest boats of a motion (B, 6); of equally near ones in order.

    Those that are not ``seen`` (B,) are left out.

    The boat's direction is ``heading``; ``near`` and ``square`` (of a distance), both
    (``NEIGHBOURS``,), are memory for the search.
    """
    body, found, to_boat = boat + 1, 0, heading.conjugate()
    for other in range(1, motion.shape[0]):
        if other == body or not seen[other]:
            continue
        x, y = motion[other, 0] - motion[body, 0], motion[other, 1] - motion[body, 1]
        gap, place = x * x + y * y, found
        while place > 0 and square[place - 1] > gap:
            place -= 1
        if place == len(near):
            continue
        found = min(found + 1, len(near))
        for k in range(found - 1, place, -1):
            near[k], square[k] = near[k - 1], square[k - 1]
        near[place], square[place] = other, gap
    for k in range(FIRST_NEIGHBOUR + found * len(OF_NEIGHBOUR), len(row)):
        row[k] = 0.0
    for k in range(found):
        other, column = near[k], FIRST_NEIGHBOUR + k * len(OF_NEIGHBOUR)
        x, y = motion[other, 0] - motion[body, 0], motion[other, 1] - motion[body, 1]
        vx, vy = motion[other, 3] - motion[body, 3], motion[other, 4] - motion[body, 4]
        put(row, column, complex(x, y) * to_boat)
        put(row, column + 2, complex(vx, vy) * to_boat)
        row[column + 4] = 1.0


@compiled
def put_boats(
    known: Known,
    view: int,
    first: int,
    last: int,
    hull: Hull,
    plan: Plan,
    near: Int,
    square: Float,
    gap: Float,
    row: Float,
    out: Observation,
) -> None:
    """Writes the observations (A, K) of some boats by what is known in the row ``view``.

    They are the boats from ``first`` to before ``last``; what is between ``plan`` and ``out`` is
    memory.
    """
    neighbours, vessel = near.size > 0, direction_of(known.estimate[view, 0, 2])
    obstacles, rows = len(known.groups) > 1, known.obstacle[view]
    put_shared(known, view, vessel, hull.inverse_length, row)
    if obstacles:
        x, y = known.estimate[view, 0, 0], known.estimate[view, 0, 1]
        columns = row[FIRST_OF_VESSEL:]
        put_obstacles(rows, known.groups, x, y, vessel.conjugate(), gap, columns)
    for boat in range(first, last):
        heading = direction_of(known.estimate[view, boat + 1, 2])
        put_own(known, view, boat, heading, vessel, hull.outline, row)
        if neighbours:
            motion, seen = known.estimate[view], known.seen[view]
            columns = row[:FIRST_OBSTACLE]
            put_neighbours(motion, seen, boat, heading, near, square, columns)
        if obstacles:
            x, y = known.estimate[view, boat + 1, 0], known.estimate[view, boat + 1, 1]
            columns = row[FIRST_OBSTACLE:FIRST_OF_VESSEL]
            put_obstacles(rows, known.groups, x, y, heading.conjugate(), gap, columns)
        seen = out[boat]
        for k in range(len(seen)):
            value, bound = row[plan.source[k]] * plan.factor[k], plan.bound[k]
            seen[k] = min(max(value, -bound), bound)


@allocating
def fill(
    first: int,
    last: int,
    worlds: Int,
    known: Known,
    own: bool,
    book: Bound,
    out: Observation,
) -> None:
    """Writes columns of the table into observations of some worlds.

    Args:
        first: place of the first world in ``worlds``.
        last: place after that of the last one.
        worlds: (n,) numbers of the worlds.
        known: what the boats know.
        own: whether each boat has a row of its own there, A in a world; else they share one.
        book: see ``book``.
        out: (n, A, K), of any float type.
    """
    hull, plan = book.content
    neighbours = len(plan.source) > 0 and plan.source.max() >= FIRST_NEIGHBOUR
    count = NEIGHBOURS if neighbours else 0
    near, square, row = np.zeros(count, np.int64), np.zeros(count), np.zeros(WIDTH)
    gap = np.empty(len(known.groups) - 1)
    memory, team = (near, square, gap, row), known.slot.shape[1]
    for place in range(first, last):
        world, seen = worlds[place], out[place]
        if not own:
            put_boats(known, world, 0, team, hull, plan, *memory, seen)
            continue
        for boat in range(team):
            view, last_boat = world * team + boat, boat + 1
            put_boats(known, view, boat, last_boat, hull, plan, *memory, seen)


def table(sensed: Sensed, params: EnvParams) -> Float:
    """Returns all columns (W, A, n) of what is sensed."""
    columns = np.zeros((*sensed.slot.shape, WIDTH))
    everything = book(params, range(WIDTH), np.ones(WIDTH), np.full(WIDTH, np.inf))
    worlds = given(np.arange(len(columns)), np.int64)
    fill(0, len(columns), worlds, known(sensed, params), False, everything, columns)
    return columns
