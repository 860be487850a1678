"""The team round the vessel: slots, their assignment, and conditional closure.

Slots and relations are given in the vessel's frame, as complex numbers u + iw: u along its
length, w along n, the side from which it is pushed in the nominal case.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from asv_env.compiled import compiled
from asv_env.geometry import plane
from asv_env.params import SMALLEST_CAGE, EnvParams
from asv_env.tasks.laws import aim, around, direction_of, heading_error_of
from asv_env.types import Bool, Complex, Float, given, zeros


def slots(params: EnvParams, team: int) -> Complex:
    """Returns the slots (team,) of the boats' centres on the +n side, from -u to +u, m.

    From four boats on, the first and last cage the ends and the others are spread along the
    side, at the pitch length / (team - 1); two or three all push from the side.
    """
    vessel, boat = params.vessel, params.boat
    standoff = 1j * (vessel.width + boat.length) / 2
    if team < SMALLEST_CAGE:
        return vessel.length * ((np.arange(team) + 1) / (team + 1) - 0.5) + standoff
    points: Complex = vessel.length * (np.arange(team) / (team - 1) - 0.5) + standoff
    end = (vessel.length + boat.width) / 2 + params.task.end_gap
    points[0], points[-1] = -end, end
    return points


def slot_direction(side: Float) -> Complex:
    """Returns the direction (...,) in which boats in their slots point: across the vessel."""
    return -1j * side


def assign(boats: Complex, points: Complex) -> np.ndarray:
    """Returns the index (A,) of the point for each boat, so that the total distance is least.

    Boats (A,) and points (A,) are positions in the same frame, m.
    """
    return linear_sum_assignment(np.abs(boats[:, None] - points[None, :]))[1]


def assign_slots(params: EnvParams, motion: Float, working: Bool, side: Float | float) -> Complex:
    """Returns the slots (A,) of one world's boats, vessel frame, m, assigned to the working ones.

    They are those of a team of the working boats (A,), on the side +1 or -1 of a motion (B, 6); a
    boat that has failed keeps its place.
    """
    boats = (plane(motion)[1:] - plane(motion)[0]) * np.exp(-1j * motion[0, 2])
    slot = boats.copy()
    points = slots(params, int(working.sum()))
    if side < 0:
        points = points.conj()
    slot[working] = points[assign(boats[working], points)]
    return slot


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
            found = around(now, a + 1, to_vessel, slot[w, a], side[w])
            boat[w, a], slot_gap[w, a], alignment[w, a], slip[w, a] = found
            slot_error[w, a] = abs(found[1])
        goal[w], goal_turn[w] = aim(now, goals[w], to_vessel)
        goal_error[w] = abs(goal[w])
        heading_error[w] = heading_error_of(goal_turn[w])
