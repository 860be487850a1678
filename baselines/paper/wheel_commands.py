"""Actions that bring about the steering law, Eq (3), on boats with an autopilot or thrusters."""

import numpy as np

from asv_env.geometry import wrap
from asv_env.params import EnvParams
from asv_env.physics import autopilot, thrusters
from asv_env.tasks.formation import Relations
from asv_env.types import Action, Complex, Float
from baselines.paper import braitenberg
from baselines.paper.steering import Memory, Steering


class WheelCommands:
    """Commands of boats with either kind of action, with the gain K of Eq (3), 1/s.

    With tracking actions a yaw rate in proportion to the heading error closes the loop, as in the
    paper's experiment. With thrusters the wheel speeds of Eq (3) act one tick late as printed
    ("t + 1"), as in its simulation: the autopilot's law turns them into thrust, in steady motion
    just as much as the drag takes.
    """

    def __init__(self, params: EnvParams, gain: float) -> None:
        self._tracking = params.action_mode == "tracking"
        self._boat, self._gain = params.hulls()[1], gain
        self._scale = autopilot.scale(self._boat)

    def action(
        self, relations: Relations, steering: Steering, flip: Float, memory: Memory
    ) -> Action:
        """Returns actions (W, A, 2) in units of a full action; the memory keeps the wheel speeds.

        Relations and steering are those of a team that pushes from the +n side; ``flip`` (W,) is -1
        where the world has been mirrored for that, else 1.
        """
        bow = relations.heading[:, 1:] * relations.heading[:, :1].conj()
        surge = (relations.velocity * relations.heading.conj()).real
        velocity = np.stack([surge, relations.yaw_rate], axis=-1)[:, 1:]
        off, flip = memory.motors_off[:, None, None], flip[:, None]
        if self._tracking:
            action = np.where(off, self._coasting(velocity), self._tracked(bow, steering))
            action[..., 1] *= flip
        else:
            action = np.where(off, 0.0, self._driven(bow, steering, velocity, memory))
            action = np.where(flip[..., None] < 0, action[..., ::-1], action)
        return np.clip(action, -1.0, 1.0).astype(np.float32)

    def _tracked(self, bow: Complex, steering: Steering) -> Float:
        """Returns tracking actions (W, A, 2) that follow Eq (3)."""
        turn = wrap(braitenberg.desired_heading(*steering[:3]) - np.angle(bow))
        return np.stack([steering.speed, self._gain * turn], axis=-1) / self._scale

    def _coasting(self, velocity: Float) -> Float:
        """Returns tracking actions (W, A, 2) at which the motors of moving boats hardly run."""
        return autopilot.coasting(velocity, self._boat) / self._scale

    def _driven(self, bow: Complex, steering: Steering, velocity: Float, memory: Memory) -> Float:
        """Returns thruster commands (W, A, 2) for the wheel speeds of the last tick."""
        arm = self._boat.lever_arm
        commanded = braitenberg.wheel_speeds(np.angle(bow), *steering, self._gain * arm)
        applied = memory.wheels
        memory.wheels = np.stack(commanded, axis=-1)
        left, right = applied[..., 0], applied[..., 1]
        wanted = np.stack([(left + right) / 2, (right - left) / (2 * arm)], axis=-1)
        return thrusters.signals(autopilot.efforts(velocity, wanted, self._boat), self._boat)
