"""The end of a delivery: the team lets go of the vessel where it will come to rest at its goal.

Nobody can brake the vessel, but how it coasts is known, because the boats know the model by which
it moves. The team brakes it by pushing less than its drag, lets go when the pose at which it will
rest is near the goal, and stands off, so that no contact disturbs it. Where the vessel would rest
too far from its goal the team pushes again.
"""

import math

import numpy as np

from asv_env.compiled import allocating
from asv_env.params import EnvParams
from asv_env.physics.hull import Hulls, advanced, equip, hulls, kinds
from asv_env.tasks.formation import Relations
from asv_env.types import Bool, Complex, Float
from baselines.scripted.gains import PushGains
from baselines.scripted.hull_sides import HullSides
from baselines.scripted.observer import VesselMemory

GRASPS_AGAIN = 1.4
"""Error of the pose of rest at which the team pushes again, tolerances: with noise the estimate may
be off by that much more than the pose, and pushing disturbs a vessel that would rest well."""
FACING = 0.1  #: cosine of the angle to the hull within which a boat backs off
END_GAP = 0.006  #: gap to the hull of end boats that stand off, m
MOST_ERROR = 0.85  #: largest error of the pose of rest at which the team lets go, tolerances
COASTING_TIMES = 10.0  #: duration for which a coasting hull is followed, time constants in sway
STEPS = 40  #: number of steps in which it is followed: right to within about a hundredth
STILL = (0.0, 0.0, 0.0)  #: force and moment on a hull that nobody pushes
UNSHELTERED = (1.0, 1.0)  #: factors on the drag of a hull that lies alone


class Settling:
    """Decides when the team lets go, and where boats stand off."""

    def __init__(self, params: EnvParams, gains: PushGains, still_water: float) -> None:
        self._vessel, boat = params.hulls()
        self._gains, self._task, self._still_water = gains, params.task, still_water
        self._shape = HullSides(self._vessel, boat)
        vessel, self._hulls = self._vessel, hulls(1, 1)
        self._step = COASTING_TIMES / STEPS * vessel.masses[1] / vessel.sway[0]
        one = np.ones(1)
        equip(self._hulls, 0, kinds([vessel]), one, one, one, self._step)

    def update(self, relations: Relations, vessel: VesselMemory, released: Bool) -> Bool:
        """Returns in which worlds (W,) the team has let go, given where it had."""
        still = np.abs(vessel.drift) <= self._still_water  # Then its drift is an error.
        goal, turned = self.rest(relations, np.where(still, 0.0, vessel.drift))
        task, gains = self._task, self._gains
        error = np.maximum(
            np.abs(goal) / task.position_tolerance, np.abs(turned) / task.heading_tolerance
        )
        # The longer the team waits for a better pose, the farther the vessel gets.
        beyond = goal.imag / task.position_tolerance - gains.overrun
        worst = gains.release_error + gains.hurry * np.maximum(beyond, 0.0)
        lets_go = still & (beyond >= 0.0) & (error < np.minimum(worst, MOST_ERROR))
        return np.where(released, error < GRASPS_AGAIN, lets_go)

    def rest(self, relations: Relations, drift: Complex) -> tuple[Complex, Float]:
        """Returns where the goal will be when the vessel rests in the water, if nobody pushes it.

        Args:
            relations: estimated relations.
            drift: (W,) velocity of the water, m/s, world frame.

        Returns:
            Position (W,) of the goal in the vessel's frame, m, and heading error (W,), rad.
        """
        velocity = (relations.velocity[:, 0] - drift) * relations.heading[:, 0].conj()
        motion = velocity.real, velocity.imag, relations.yaw_rate[:, 0]
        way, turn = coasted(np.stack(motion, axis=-1), self._hulls, self._step)
        return (relations.goal - way) * np.exp(-1j * turn), relations.heading_error + turn

    def stand_off(self, relations: Relations, hull: Complex, end: Float, side: Float) -> Float:
        """Returns the speeds (W, A) m/s, along their bows, of boats that leave the hull alone.

        Args:
            relations: estimated relations.
            hull: (W, A) velocity of the hull at the boats, in its frame, m/s.
            end: (W, A) -1 or +1 where a boat is at that end of the hull, 0 at its side.
            side: (W,) of the hull that faces the teams, +1 or -1.
        """
        gains, bow = self._gains, relations.heading[:, 1:] * relations.heading[:, :1].conj()
        missing = np.where(end == 0, gains.release_gap, END_GAP)
        missing = missing - self._shape.clearance(relations, end, side)
        away = np.clip(gains.release_gain * missing, -gains.release_speed, gains.release_speed)
        towards = np.where(end == 0, -bow.imag, -end * bow.real)
        # A boat whose flank touches the hull cannot back off, so it goes along.
        return (hull * bow.conj()).real - np.where(towards > FACING, away, 0.0)


@allocating
def coasted(motion: Float, hulls: Hulls, step: float) -> tuple[Complex, Float]:
    """Returns where free hulls come to rest: positions (W,) m in their frames, and turns (W,) rad.

    Args:
        motion: (W, 3) through the water: surge and sway m/s, yaw rate rad/s.
        hulls: mass and drag of the one hull.
        step: duration of a step, s.
    """
    way, turned = np.zeros(len(motion), np.complex128), np.zeros(len(motion))
    for w in range(len(motion)):
        u, v, r = motion[w]
        heading = complex(1.0, 0.0)
        for _ in range(STEPS):
            before = complex(u, v)
            u, v, r, cos, sin = advanced(u, v, r, STILL, hulls, 0, 0, UNSHELTERED, step)
            turn = complex(cos, sin)
            way[w] += step / 2 * heading * (before + turn * complex(u, v))
            heading *= turn
            turned[w] += math.atan2(sin, cos)
    return way, turned
