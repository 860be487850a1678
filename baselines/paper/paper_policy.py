"""The controller of the paper, as it stands there, for all worlds at once.

Approach: boats steer the spirals of Eq (2) at the speeds of Eq (7), and the targets are assigned
to them again at every tick; boats that have reached theirs stop and wait. Push: once all are
there, two arcs are planned (Eqs 9-15), the inner boats push at the speeds of Eq (16) and keep the
vessel's axis on the centre of its circle, the end boats keep the vessel on the circle, and 20 cm
from the goal the motors are turned off. Whatever a boat does is an instance of one law, Eq (3).

Nothing is added: boats avoid neither each other nor the hull, and nothing is tried again. What
cannot be used as printed is corrected (see also the modules of the equations):

* Eq (3): the phase is + (2 D - 1) phi with beta > 0, and arctan means arctan2.
* D: determined again above the target; else a boat that crosses there is led round it once more.
* Eq (7) asked at every tick: the speed is bounded, as length / time is singular at the end.
* Targets: inside the hull they cannot be reached; they are the slots of the environment.
* Eq (13), singular where h_f = 0: there only alpha_1 = 2 atan2(x_f, -y_f) leads to the goal.
* Eqs (14)-(15): alpha_k - 2 pi sign(alpha_k) where alpha_k rho_k < 0.
* Eq (16) gives magnitudes; the directions are those of Eq (3) about the centre, phi = pi/2.
"""

from typing import Any

import numpy as np

from asv_env.checks import choice
from asv_env.geometry import mirrored
from asv_env.params import NOMINAL_LENGTH, EnvParams
from asv_env.tasks.formation import Relations, relate
from asv_env.types import Action, Bool, Float, Observation, Sensed, copied, put_rows, rows
from baselines.paper import braitenberg
from baselines.paper.arc_following import (
    follow_arcs,
    integrate_speed_error,
    plan_arcs,
    push_steering,
)
from baselines.paper.coasting import coasting_distance, coasting_speed, coasting_time
from baselines.paper.paper_numbers import ARRIVAL_TIME, GAINS, MEAN_SPEEDS, PaperGains
from baselines.paper.steering import Assignment, Memory, Steering, approach_steering, nearest
from baselines.paper.wheel_commands import WheelCommands


def arrival_time(params: EnvParams, gains: PaperGains) -> float:
    """Returns T_goal, s; it grows with the vessel's length."""
    nominal = gains.arrival_time or ARRIVAL_TIME[params.action_mode]
    return nominal * params.vessel.size / NOMINAL_LENGTH


def push_speed(params: EnvParams, gains: PaperGains) -> float:
    """Returns the mean speed of the vessel, m/s, which the paper does not give.

    Without one it is that from which the vessel coasts the last 20 cm.
    """
    if gains.push_speed is not None:
        return gains.push_speed
    vessel, _ = params.hulls()
    return float(np.clip(coasting_speed(vessel, gains.stop_distance), *MEAN_SPEEDS))


def longest_path(params: EnvParams, gains: PaperGains, time: Any) -> Any:
    """Returns the lengths (n,) m of paths that are driven in times (n,) s, coasting included."""
    vessel, _ = params.hulls()
    speed, task = push_speed(params, gains), params.task
    settling = coasting_time(vessel, speed, task.speed_tolerance) + task.delivery_time
    coasted = np.minimum(gains.stop_distance, coasting_distance(vessel, speed))
    return speed * np.maximum(time - settling, 0.0) + coasted


class PaperPolicy:
    """The paper's controller, batched and distributed; reads ``Sensed`` only.

    Args:
        params: of the environment.
        gains: the free parameters, by default as printed.
        assignment: of the targets to the boats, called at every tick.

    Raises:
        ValueError: the environment takes discrete actions.
    """

    def __init__(
        self,
        params: EnvParams,
        gains: PaperGains = GAINS,
        assignment: Assignment = nearest,
    ) -> None:
        choice("action_mode of a policy", params.action_mode, ARRIVAL_TIME)
        self._params, self._gains, self._assignment = params, gains, assignment
        self._arrival_time = arrival_time(params, gains)
        self._commands = WheelCommands(params, gains.steering)
        self._mean_speed = push_speed(params, gains)

    def act(
        self, sensed: Sensed, observation: Observation, memory: Memory | None, fresh: Bool
    ) -> tuple[Action, Memory]:
        """See ``Policy.act``."""
        blank = Memory.blank(*sensed.slot.shape)
        memory = blank if memory is None else copied(memory)
        put_rows(memory, fresh, rows(blank, fresh))
        flip = np.where(sensed.side < 0, -1.0, 1.0)
        relations = self._assign_targets(sensed, flip, memory)
        new = sensed.closed & ~memory.pushing
        params, gains = self._params, self._gains
        half_length, stop_radius = params.vessel.length / 2, params.task.slot_distance
        time = sensed.tick / params.clock.control
        if params.definition.has_goal and new.any():
            longest = longest_path(params, gains, params.task.time_limit - time)
            plan_arcs(relations, new, memory, half_length, longest, gains)
        follow_arcs(relations, memory, gains)
        dt = 1 / params.clock.control
        integrate_speed_error(relations, memory, self._mean_speed, dt, gains)
        time_left = self._arrival_time - time
        push = push_steering(relations, memory, self._mean_speed, half_length, gains)
        approach = approach_steering(relations, memory, time_left, stop_radius, gains)
        pairs, pushing = zip(push, approach, strict=True), memory.pushing[:, None]
        steering = Steering(*(np.where(pushing, *pair) for pair in pairs))
        return self._commands.action(relations, steering, flip, memory), memory

    def _assign_targets(self, sensed: Sensed, flip: Float, memory: Memory) -> Relations:
        """Assigns targets, and D where they are new; returns the mirrored relations to them."""
        motion, goal = mirrored(sensed.estimate, flip), mirrored(sensed.goal, flip)
        slot = np.where(flip[:, None] < 0, sensed.slot.conj(), sensed.slot)
        side = np.ones(len(flip))
        boat = relate(motion, goal, slot, side).boat
        target = self._assignment(boat, slot, sensed.working, memory.target)
        new = braitenberg.turn_direction(boat.real, target.real)
        memory.turn_direction = np.where(target == memory.target, memory.turn_direction, new)
        memory.target = target
        return relate(motion, goal, target, side)
