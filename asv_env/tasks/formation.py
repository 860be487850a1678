"""Where the boats belong round the hull, who goes where, and whether the vessel is grasped.

Slots and relations are given in the vessel's frame, as complex numbers u + iw: u along its
length, w along n, the side from which it is pushed in the nominal case.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from asv_env.geometry import direction, plane
from asv_env.params import SMALLEST_CAGE, EnvParams, TaskParams
from asv_env.types import Bool, Complex, Float


def slots(params: EnvParams, team: int) -> Complex:
    """Slots (team,) of the boats' centres on the +n side, from -u to +u, m.

    From four boats on, the first and last cage the ends and the others are spread along the
    side, at the pitch length / (team - 1); two or three all push from the side.
    """
    vessel, boat = params.vessel, params.boat
    standoff = 1j * (vessel.width + boat.length) / 2
    if team < SMALLEST_CAGE:
        inner: Complex = vessel.length * ((np.arange(team) + 1) / (team + 1) - 0.5) + standoff
        return inner
    points: Complex = vessel.length * (np.arange(team) / (team - 1) - 0.5) + standoff
    end = (vessel.length + boat.width) / 2 + params.task.end_gap
    points[0], points[-1] = -end, end
    return points


def slot_direction(side: Float) -> Complex:
    """Direction (...,) in the vessel's frame that boats in their slots face: across it."""
    across: Complex = -1j * side
    return across


def assign(boats: Complex, points: Complex) -> np.ndarray:
    """Which of the points each boat takes, so that the total distance is least.

    Args:
        boats: (A,) positions.
        points: (A,) slots in the same frame.

    Returns:
        (A,) index into ``points``.
    """
    return linear_sum_assignment(np.abs(boats[:, None] - points[None, :]))[1]


def assign_slots(params: EnvParams, motion: Float, working: Bool, side: float) -> Complex:
    """Slot (A,) of every boat of one world; boats that fail keep out of the assignment.

    Args:
        params: the environment's.
        motion: (B, 6) motion of the world.
        working: (A,) whether each boat's thrusters work.
        side: +1 or -1, the side from which the vessel is pushed.

    Returns:
        (A,) vessel-frame slots of a team of the working boats' size; a boat that does not
        work is given the place where it is.
    """
    boats = (plane(motion)[1:] - plane(motion)[0]) * np.exp(-1j * motion[0, 2])
    slot = boats.copy()
    points = slots(params, int(working.sum()))
    if side < 0:
        points = points.conj()
    slot[working] = points[assign(boats[working], points)]
    return slot


@dataclass
class Relations:
    """How vessel, boats and goal stand to each other; everything the task asks of a motion.

    Attributes:
        position: (W, B) of the bodies in the world, m.
        velocity: (W, B) of the bodies in the world, m/s.
        heading: (W, B) unit vectors along the hulls.
        yaw_rate: (W, B) rad/s.
        boat: (W, A) the boats in the vessel's frame, m.
        slot_gap: (W, A) from each boat to its slot, in the vessel's frame, m.
        slot_error: (W, A) distance to the slot, m.
        alignment: (W, A) the boats' directions relative to that of their slots.
        slip: (W, A) the boats' velocities relative to the hull below, in the world, m/s.
        goal: (W,) the goal in the vessel's frame, m.
        goal_turn: (W,) direction of the goal relative to the vessel's.
        goal_error: (W,) distance of the vessel to the goal, m.
        heading_error: (W,) heading of the vessel less that of the goal, rad, signed.
    """

    position: Complex
    velocity: Complex
    heading: Complex
    yaw_rate: Float
    boat: Complex
    slot_gap: Complex
    slot_error: Float
    alignment: Complex
    slip: Complex
    goal: Complex
    goal_turn: Complex
    goal_error: Float
    heading_error: Float


def relate(motion: Float, goal: Float, slot: Complex, side: Float) -> Relations:
    """Relations of a motion (W, B, 6), goals (W, 3), slots (W, A) and sides (W,)."""
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


def holding(relations: Relations, task: TaskParams) -> Bool:
    """(W, A) whether each boat holds its slot: near it, facing across it, at rest in it.

    Args:
        relations: of the motion.
        task: with the tolerances ``slot_distance``, ``slot_angle`` and ``slot_speed``.
    """
    return (relations.slot_error < task.slot_distance) & at_rest(relations, task)


def at_rest(relations: Relations, task: TaskParams) -> Bool:
    """(W, A) whether each boat is at rest on the water beside the hull and faces across it."""
    faces = relations.alignment.real > math.cos(task.slot_angle)
    return faces & (np.abs(relations.slip) < task.slot_speed)
