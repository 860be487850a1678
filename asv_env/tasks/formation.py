"""The team round the vessel: slots, their assignment, and conditional closure.

Slots and relations are given in the vessel's frame, as complex numbers u + iw: u along its
length, w along n, the side from which it is pushed in the nominal case.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from asv_env.geometry import direction, plane
from asv_env.params import SMALLEST_CAGE, EnvParams, TaskParams
from asv_env.types import Bool, Complex, Float

CLOSURE_LOST = 2.0  #: distance of a boat from its slot at which closure is lost, slot tolerances


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
    position, velocity = plane(motion), plane(motion, 3)
    heading, yaw_rate = direction(motion[..., 2]), motion[..., 5]
    to_vessel = heading[:, :1].conj()
    offset = position[:, 1:] - position[:, :1]
    boat = offset * to_vessel
    slot_gap = slot - boat
    goal_offset = (plane(goal) - position[:, 0]) * to_vessel[:, 0]
    goal_turn = direction(goal[:, 2]) * to_vessel[:, 0]
    return Relations(
        position=position,
        velocity=velocity,
        heading=heading,
        yaw_rate=yaw_rate,
        boat=boat,
        slot_gap=slot_gap,
        slot_error=np.abs(slot_gap),
        alignment=heading[:, 1:] * (to_vessel / slot_direction(side)[:, None]),
        slip=velocity[:, 1:] - velocity[:, :1] - (1j * yaw_rate[:, :1]) * offset,
        goal=goal_offset,
        goal_turn=goal_turn,
        goal_error=np.abs(goal_offset),
        heading_error=-np.arctan2(goal_turn.imag, goal_turn.real),
    )


def occupied(relations: Relations, task: TaskParams) -> Bool:
    """Returns (W, A) whether each boat occupies its slot: near it, aligned and at rest."""
    return (relations.slot_error < task.slot_distance) & at_rest(relations, task)


def at_rest(relations: Relations, task: TaskParams) -> Bool:
    """Returns (W, A) whether each boat is aligned with the slots and at rest on the hull."""
    aligned = relations.alignment.real > math.cos(task.slot_angle)
    return aligned & (np.abs(relations.slip) < task.slot_speed)


def everyone(mask: Bool, working: Bool) -> Bool:
    """Returns (W,) whether a mask (W, A) holds for all boats that work."""
    return np.logical_and.reduce(mask | ~working, axis=1)


def closure(
    relations: Relations, formed: Bool, closed: Bool, working: Bool, task: TaskParams
) -> Bool:
    """Returns (W,) whether the vessel is in conditional closure.

    Closure is formed when all slots are occupied (``formed``), and lost when one of the working
    boats (W, A) is far from its slot; ``closed`` tells whether the vessel was in closure until now.
    """
    near = relations.slot_error <= CLOSURE_LOST * task.slot_distance
    return formed | (closed & everyone(near, working))


def misassigned(relations: Relations, closed: Bool, working: Bool, task: TaskParams) -> Bool:
    """Returns (W,) whether all boats rest on the hull and the vessel is not in closure.

    The vessel is then grasped by boats in each other's slots, which are to be assigned again.
    """
    return everyone(at_rest(relations, task), working) & ~closed
