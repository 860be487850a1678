"""The controller of the paper, as it stands there, for all worlds at once.

Approach: boats steer the spirals of Eq (2) at the speeds of Eq (7), and the targets are
re-attributed to them at every tick; boats that have reached theirs stop and wait. Push: once all
are there, two arcs are planned (Eqs 9-15), the inner boats push at the speeds of Eq (16) and keep
the vessel facing the centre of its circle, the end boats keep it on the circle, and 20 cm from
the goal the motors are turned off. Whatever a boat does is an instance of one law, Eq (3).

Nothing is added: boats look out neither for each other nor for the hull, and nothing is tried
again. What cannot be used as printed is corrected (see also the modules of the equations):

* Eq (3): the phase is + (2 D - 1) phi with beta > 0, and arctan means arctan2.
* D: looked up anew above the target; else a boat that crosses there is led round it once more.
* Eq (7) asked at every tick: the speed is bounded, as length / time is singular at the end.
* Targets: inside the hull they cannot be reached; they are the slots of the environment.
* Eq (13), singular where h_f = 0: there only alpha_1 = 2 atan2(x_f, -y_f) leads to the goal.
* Eqs (14)-(15): alpha_k - 2 pi sign(alpha_k) where alpha_k rho_k < 0.
* Eq (16) gives magnitudes; the directions are those of Eq (3) about the centre, phi = pi/2.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from asv_env.geometry import direction, mirrored, wrap
from asv_env.params import NOMINAL_LENGTH, TINY, EnvParams
from asv_env.physics.autopilot import SCALE, Autopilot
from asv_env.physics.thrusters import MIX
from asv_env.tasks.formation import Relations, assign, relate
from asv_env.types import (
    Action,
    Bool,
    Complex,
    Float,
    Int,
    Observation,
    Sensed,
    copied,
    put_rows,
    rows,
)
from baselines.paper import braitenberg, pushing, two_arc
from baselines.paper.coasting import coasting_speed
from baselines.paper.inputs import finite, positive
from baselines.paper.spiral import angular_distance, approach_speed, arc_length, bearing_offset

Attribution = Callable[[Complex, Complex, Bool, Complex], Complex]
"""Targets (W, A) from boats (W, A), slots (W, A), which boats work (W, A) and the targets until now
(NaN where there are none yet), all in the vessel's frame, m."""
ARRIVAL_TIME = {"tracking": 80.0, "thrusters": 30.0}
"""T_goal of the paper's experiment and of its simulation, s, for a vessel of 0.40 m."""
IN_RANGE = 0.20
"""Distance of the vessel to the goal at which the motors are turned off, m."""
MEAN_SPEEDS = (0.02, 0.10)
"""Bounds of the vessel's mean speed, m/s, whatever its drag."""
STRAIGHT = 1e-6
"""Curvature that stands for smaller ones, 1/m: the centre of a straight is far away."""
ON_THE_SPOT = 1e3
"""Curvature that stands for larger ones, 1/m."""


@dataclass(frozen=True)
class PaperGains:
    """What the paper leaves open, and sigma.

    Steering is well below the bandwidth of the loops on board. Boats skid, so that much faster
    ones miss their targets and ram the vessel. The others suit pushes of vessels and boats that
    differ from the nominal ones (scenario "mismatch"): with a larger drift the vessel leaves its
    circle, with more facing it swings.

    Attributes:
        sigma: decay of the spiral (Eq 2), rad; 1 in the paper's experiment.
        steering: K = 2 beta / b of Eq (3), and of the loop on the heading, 1/s.
        fastest: largest speed on the approach, m/s.
        facing: yaw rate of the vessel for its angle to the centre of the circle, 1/s.
        drift: distance off their circles or places for which boats turn by 1 rad, m, and
        lean: largest such turn, rad.
        keeping: speed of end boats for their way behind the vessel, 1/s.
    """

    sigma: float = 1.0
    steering: float = 2.0
    fastest: float = 0.04
    facing: float = 0.5
    drift: float = 0.04
    lean: float = 0.5
    keeping: float = 0.5


@dataclass
class Memory:
    """What the team remembers from tick to tick.

    Attributes:
        target: (W, A) vessel-frame slot that each boat is attributed now, m.
        sense: (W, A) D of each boat for that target.
        pushing: (W,) whether the push has begun.
        off: (W,) whether the motors are off for good.
        goal: (W,) where the arcs lead, m.
        centre: (W, 2) of their circles, m.
        rho: (W, 2) the centres as the vessel sees them along its +x axis, m.
        length: (W, 2) of the arcs, m.
        arc: (W,) the one that the vessel is on, 0 or 1.
        way: (W,) that it has made round the first centre, m.
        last: (W,) where it was at the last tick, m.
        wheels: (W, A, 2) left and right wheel speed decided on at the last tick, m/s.
    """

    target: Complex
    sense: Int
    pushing: Bool
    off: Bool
    goal: Complex
    centre: Complex
    rho: Float
    length: Float
    arc: Int
    way: Float
    last: Complex
    wheels: Float


class PaperPolicy:
    """The paper's controller, batched and distributed; reads ``Sensed`` only.

    With tracking actions a yaw rate proportional to the error of the heading closes the paper's
    loops, as in its experiment. With thrusters the wheel speeds of Eq (3) act one tick late as
    printed ("t + 1"), as in its simulation; the autopilot brings them about
    in the water, in steady motion with just the thrust that keeps them up. The mean speed of the
    vessel, which the paper does not give, is that from which it coasts the last 20 cm.

    Args:
        params: of the environment.
        alpha1: turn of the first arc, rad.
        arrival_time: T_goal, s; None takes that of the paper's experiment with tracking actions,
            of its simulation with thrusters, in proportion to the vessel's length.
        gains: what the paper leaves open.
        attribution: of the targets to the boats, asked at every tick.

    Raises:
        ValueError: ``alpha1`` is not finite or ``arrival_time`` not positive.
    """

    def __init__(
        self,
        params: EnvParams,
        alpha1: float = 1.0,
        arrival_time: float | None = None,
        gains: PaperGains = PaperGains(),
        attribution: Attribution | None = None,
    ) -> None:
        if arrival_time is None:
            arrival_time = ARRIVAL_TIME[params.action_mode] * params.vessel.length / NOMINAL_LENGTH
        self._alpha1 = float(finite("alpha1", alpha1))
        self._arrival_time = float(positive("arrival_time", arrival_time))
        self._params, self._gains = params, gains
        self._attribution = attribution or nearest
        vessel, self._boat = params.hulls()
        self._autopilot = Autopilot(self._boat)
        self._mean_speed = float(np.clip(coasting_speed(vessel, IN_RANGE), *MEAN_SPEEDS))

    def act(
        self, sensed: Sensed, observation: Observation, memory: Memory | None, fresh: Bool
    ) -> tuple[Action, Memory]:
        """See ``Policy.act``."""
        blank = _blank(*sensed.slot.shape)
        memory = blank if memory is None else copied(memory)
        put_rows(memory, fresh, rows(blank, fresh))
        flip = np.where(sensed.side < 0, -1.0, 1.0)
        relations = self._attribute(sensed, flip, memory)
        self._begin(relations, sensed, memory)
        self._follow(relations, memory)
        law = np.where(
            memory.pushing[:, None],
            self._push(relations, memory),
            self._approach(relations, sensed, memory),
        )
        return self._action(relations, law, flip, memory), memory

    def _attribute(self, sensed: Sensed, flip: Float, memory: Memory) -> Relations:
        """Attributes the targets to the boats, and D to boats whose target is new."""
        motion, goal = mirrored(sensed.estimate, flip), mirrored(sensed.goal, flip)
        slot = np.where(flip[:, None] < 0, sensed.slot.conj(), sensed.slot)
        boat = relate(motion, goal, slot, np.ones(len(flip))).boat
        target = self._attribution(boat, slot, sensed.working, memory.target)
        anew = braitenberg.turn_direction(boat.real, target.real)
        memory.sense = np.where(target == memory.target, memory.sense, anew)
        memory.target = target
        return relate(motion, goal, target, np.ones(len(flip)))

    def _begin(self, relations: Relations, sensed: Sensed, memory: Memory) -> None:
        """Plans the arcs where closure has come about, from where the vessel is at that moment."""
        new = sensed.closed & ~memory.pushing
        if self._params.task.name == "approach" or not new.any():
            return
        goal = np.stack([relations.goal.real, relations.goal.imag, -relations.heading_error], -1)
        goal = goal[new]
        only = 2 * np.arctan2(goal[:, 0], -goal[:, 1])
        path = two_arc.plan(goal, np.where(np.abs(goal[:, 2]) < TINY, only, self._alpha1))
        joints = path.joints
        position, heading = relations.position[new, :1], relations.heading[new, :1]
        points = position + heading * (joints[..., 0] + 1j * joints[..., 1])
        curvature = np.clip(np.abs(path.curvature), STRAIGHT, ON_THE_SPOT)
        rho = np.where(path.curvature < 0, -1.0, 1.0) / curvature
        memory.centre[new] = points[:, :2] + rho * heading * direction(joints[:, :2, 2])
        memory.rho[new], memory.length[new], memory.goal[new] = rho, path.length, points[:, 2]
        memory.last[new], memory.way[new] = position[:, 0], 0.0
        memory.pushing |= new

    def _follow(self, relations: Relations, memory: Memory) -> None:
        """Switches to the second arc past the end of the first, and the motors off in range."""
        position = relations.position[:, 0]
        centre, rho = memory.centre[:, 0], memory.rho[:, 0]
        memory.way += rho * np.angle((position - centre) * (memory.last - centre).conj())
        memory.last = position
        memory.arc |= memory.pushing & (memory.way >= memory.length[:, 0])
        memory.off |= memory.pushing & (np.abs(memory.goal - position) < IN_RANGE)

    def _approach(self, relations: Relations, sensed: Sensed, memory: Memory) -> Float:
        """Arguments (4, W, A) of Eq (3) on the spirals; boats in place wait and face the hull."""
        gains, near = self._gains, self._params.task.slot_distance
        alpha, distance = np.angle(-relations.slot_gap), relations.slot_error
        left = self._arrival_time - sensed.tick / self._params.clock.control
        speed = approach_speed(
            arc_length(distance, angular_distance(alpha, np.pi / 2), gains.sigma),
            left[:, None],
            stop_radius=near,
            max_speed=gains.fastest,
        )
        sense = braitenberg.updated_turn_direction(
            _pairs(relations.boat), _pairs(memory.target), memory.sense
        )
        there = distance < near
        alpha, speed = np.where(there, np.pi / 2, alpha), np.where(there, 0.0, speed)
        return np.stack([alpha, sense, bearing_offset(alpha, gains.sigma), speed])

    def _push(self, relations: Relations, memory: Memory) -> Float:
        """Arguments (4, W, A) of Eq (3) round the centre of the circle, at the speeds of Eq (16).

        The inner boats keep their places along the hull, and turn the vessel to face the centre
        by the difference of their speeds. The end boats keep beside it, each on the circle of
        its own place on the planned one, and so push a vessel back that drifts off it.
        """
        gains, world = self._gains, np.arange(len(memory.arc))
        centre, rho = memory.centre[world, memory.arc], memory.rho[world, memory.arc][:, None]
        boats, vessel = relations.position[:, 1:], relations.position[:, :1]
        speed = pushing.speeds(
            _pairs(boats), _pairs(centre[:, None]), _pairs(vessel), self._mean_speed
        )
        seen = (relations.position - centre[:, None]) * relations.heading[:, :1].conj()
        facing = np.angle(-np.sign(rho) * seen[:, :1])
        target = memory.target.real
        caging = np.abs(target) > self._params.vessel.length / 2
        off_circle = np.abs(seen[:, 1:]) - np.abs(rho - target)
        outwards = np.where(caging, off_circle, np.sign(rho) * relations.slot_gap.real)
        phi = np.pi / 2 - np.clip(outwards / gains.drift, -gains.lean, gains.lean)
        behind = -gains.keeping * relations.slot_gap.imag
        speed += np.where(caging, behind, -gains.facing * facing * relations.boat.real)
        sense = np.broadcast_to(rho > 0, phi.shape)
        return np.stack([np.angle(seen[:, 1:]), sense, phi, speed])

    def _action(self, relations: Relations, law: Float, flip: Float, memory: Memory) -> Action:
        """What brings about Eq (3), mirrored back, in units of a full action."""
        bow = relations.heading[:, 1:] * relations.heading[:, :1].conj()
        surge = (relations.velocity * relations.heading.conj()).real
        moves = np.stack([surge, relations.yaw_rate], axis=-1)[:, 1:]
        off, flip = memory.off[:, None, None], flip[:, None]
        if self._params.action_mode == "tracking":
            action = np.where(off, self._idling(moves), self._steered(bow, law))
            action[..., 1] *= flip
        else:
            action = np.where(off, 0.0, self._driven(bow, law, moves, memory))
            action = np.where(flip[..., None] < 0, action[..., ::-1], action)
        return np.clip(action, -1.0, 1.0).astype(np.float32)

    def _steered(self, bow: Complex, law: Float) -> Float:
        """Speed and yaw rate (W, A, 2), in units of a full action, that follow Eq (3)."""
        alpha, sense, phi, speed = law
        turn = wrap(braitenberg.desired_heading(alpha, sense, phi) - np.angle(bow))
        return np.stack([speed, self._gains.steering * turn], axis=-1) / SCALE

    def _idling(self, moves: Float) -> Float:
        """Tracking actions (W, A, 2) at which boats that move so hardly run their motors."""
        size = np.maximum(np.abs(moves), TINY)
        return (
            moves
            / SCALE
            * self._autopilot.gains
            * size
            / self._autopilot.demand_at_rest(size / SCALE)
        )

    def _driven(self, bow: Complex, law: Float, moves: Float, memory: Memory) -> Float:
        """Thruster commands (W, A, 2) for the wheel speeds of one tick ago; keeps those of now."""
        boat = self._boat
        alpha, sense, phi, speed = law
        beta = self._gains.steering * boat.lever_arm
        wheels = braitenberg.wheel_speeds(np.angle(bow), alpha, sense, phi, speed, beta)
        (left, right), memory.wheels = np.moveaxis(memory.wheels, -1, 0), np.stack(wheels, -1)
        wanted = np.stack([(left + right) / 2, (right - left) / (2 * boat.lever_arm)], axis=-1)
        demand = self._autopilot.demand_at_rest(wanted / SCALE) - self._autopilot.gains * moves
        thrust = MIX * (demand[..., 0] + 1j * demand[..., 1])
        full = boat.thrust * np.where(_pairs(thrust) < 0, boat.astern, 1.0)
        return _pairs(thrust) / full


def nearest(boat: Complex, slot: Complex, working: Bool, before: Complex) -> Complex:
    """Targets go to the nearest boats, at every tick anew.

    The paper does not say to which boat, where two targets have the same nearest one. With the
    least total distance no two ways cross.
    """
    del before
    target = slot.copy()
    for world, works in enumerate(working):
        points = slot[world, works]
        target[world, works] = points[assign(boat[world, works], points)]
    return target


def _blank(worlds: int, team: int) -> Memory:
    """The memory with which episodes begin: no boat has a target yet, the centre is far away."""
    return Memory(
        target=np.full((worlds, team), np.nan, dtype=np.complex128),
        sense=np.zeros((worlds, team), dtype=np.int64),
        pushing=np.zeros(worlds, dtype=np.bool_),
        off=np.zeros(worlds, dtype=np.bool_),
        goal=np.zeros(worlds, dtype=np.complex128),
        centre=np.full((worlds, 2), 1 / STRAIGHT, dtype=np.complex128),
        rho=np.full((worlds, 2), 1 / STRAIGHT),
        length=np.zeros((worlds, 2)),
        arc=np.zeros(worlds, dtype=np.int64),
        way=np.zeros(worlds),
        last=np.zeros(worlds, dtype=np.complex128),
        wheels=np.zeros((worlds, team, 2)),
    )


def _pairs(points: Complex) -> Float:
    """Points (...) as (..., 2) x, y."""
    return np.stack([points.real, points.imag], axis=-1)
