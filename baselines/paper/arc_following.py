"""The push of the paper's controller: two arcs, and the boats that keep the vessel on them."""

import numpy as np

from asv_env.geometry import direction, xy
from asv_env.params import TINY
from asv_env.tasks.formation import Relations
from asv_env.types import Bool, Float
from baselines.paper import pushing, two_arc
from baselines.paper.arcs import ArcPath, pick
from baselines.paper.paper_numbers import PaperGains
from baselines.paper.steering import Memory, Steering

BOUNDS = 6  #: number of bounds of the radii that are tried
CURVATURES = (
    1e-6,
    1e3,
)  #: bounds of the curvature, 1/m, for straights and turns on the spot


def two_arcs(goal: Float, half_length: float, longest: Float | float, gains: PaperGains) -> ArcPath:
    """Returns the two arcs (Eqs 9-15) to goals (n, 3), m, m, rad, in the frame of the vessel.

    The first arc turns by ``alpha1``, but where the goal's heading leaves no choice. Where the
    gains have none, it is that of the shortest path under a bound of the radii. The bound falls
    from ``min_radius`` to the legal one, half the length of the vessel, m, until a path is no
    longer than ``longest`` (n,) m; if none is, the legal one is taken.
    """
    if gains.alpha1 is None:
        bounds = half_length * np.linspace(gains.min_radius, 1.0, BOUNDS)[:, None]
        paths = two_arc.shortest(goal, bounds)
        taken = two_arc.feasible(paths, bounds) & (paths.total_length <= longest)
        return pick(paths, np.where(taken.any(axis=0), taken.argmax(axis=0), BOUNDS - 1))
    only = 2 * np.arctan2(goal[:, 0], -goal[:, 1])
    return two_arc.plan(goal, np.where(np.abs(goal[:, 2]) < TINY, only, gains.alpha1))


def plan_arcs(
    relations: Relations,
    new: Bool,
    memory: Memory,
    half_length: float,
    longest: Float,
    gains: PaperGains,
) -> None:
    """Plans the two arcs of the worlds ``new`` (W,) to the push, into the memory.

    See ``two_arcs``; ``longest`` is (W,).
    """
    goal = np.stack([relations.goal.real, relations.goal.imag, -relations.heading_error], -1)[new]
    path = two_arcs(goal, half_length, longest[new], gains)
    joints = path.joints
    position, heading = relations.position[new, :1], relations.heading[new, :1]
    points = position + heading * (joints[..., 0] + 1j * joints[..., 1])
    rho = np.where(path.curvature < 0, -1.0, 1.0) / np.clip(np.abs(path.curvature), *CURVATURES)
    memory.centre[new] = points[:, :2] + rho * heading * direction(joints[:, :2, 2])
    memory.rho[new], memory.length[new], memory.goal[new] = rho, path.length, points[:, 2]
    memory.last_position[new], memory.travelled[new] = position[:, 0], 0.0
    memory.pushing |= new


def follow_arcs(relations: Relations, memory: Memory, gains: PaperGains) -> None:
    """Switches to the second arc at the end of the first, and the motors off near the goal."""
    position = relations.position[:, 0]
    centre, rho = memory.centre[:, 0], memory.rho[:, 0]
    turned = np.angle((position - centre) * (memory.last_position - centre).conj())
    memory.travelled += rho * turned
    memory.last_position = position
    left = memory.length[:, 0] - memory.travelled
    memory.arc |= memory.pushing & (left <= gains.switch_distance)
    memory.motors_off |= memory.pushing & (np.abs(memory.goal - position) < gains.stop_distance)


def integrate_speed_error(
    relations: Relations, memory: Memory, mean_speed: float, dt: float, gains: PaperGains
) -> None:
    """Integrates how much slower than ``mean_speed``, m/s, the vessel is over a time ``dt``, s.

    The autopilots control the boats' speeds in proportion to the error. Boats that push a vessel
    lag behind their set-points, as its drag takes such an error: integral action makes up for it.
    It is bounded by the speed itself.
    """
    across = -1j * relations.heading[:, 0]
    speed = (relations.velocity[:, 0] * across.conj()).real
    error = np.where(memory.pushing & ~memory.motors_off, mean_speed - speed, 0.0)
    lost = memory.lost_speed + gains.speed_integral * dt * error
    memory.lost_speed = np.clip(lost, 0.0, mean_speed)


def push_steering(
    relations: Relations, memory: Memory, mean_speed: float, half_length: float, gains: PaperGains
) -> Steering:
    """Steers round the centre of the circle, at the speeds of Eq (16) for a vessel's speed in m/s.

    The inner boats keep their places along the hull, and by the difference of their speeds turn
    the vessel's axis to the centre. Each end boat, whose target lies beyond the half length of the
    hull, m, keeps abreast of the vessel on the planned circle of its own place, and so pushes back
    a vessel that drifts off. Relations are those to the assigned targets.
    """
    world = np.arange(len(memory.arc))
    centre, rho = memory.centre[world, memory.arc], memory.rho[world, memory.arc][:, None]
    boats, vessel = relations.position[:, 1:], relations.position[:, :1]
    wanted = (mean_speed + memory.lost_speed)[:, None]
    speed = pushing.speeds(xy(boats), xy(centre[:, None]), xy(vessel), wanted)
    from_centre = (relations.position - centre[:, None]) * relations.heading[:, :1].conj()
    axis_error = np.angle(-np.sign(rho) * from_centre[:, :1])
    target = memory.target.real
    end_boat = np.abs(target) > half_length
    off_circle = np.abs(from_centre[:, 1:]) - np.abs(rho - target)
    outwards = np.where(end_boat, off_circle, np.sign(rho) * relations.slot_gap.real)
    limit = gains.max_yaw_offset
    phi = np.pi / 2 - np.clip(outwards / gains.cross_track, -limit, limit)
    behind = -gains.keep_up * relations.slot_gap.imag
    speed += np.where(end_boat, behind, -gains.vessel_yaw * axis_error * relations.boat.real)
    return Steering(np.angle(from_centre[:, 1:]), np.broadcast_to(rho > 0, phi.shape), phi, speed)
