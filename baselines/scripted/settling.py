"""The end of a delivery: the team lets go of the vessel where it will come to rest at its goal.

Nobody can brake the vessel, but how far it coasts is known: along an axis with effective mass m
and drag (Y + Yq |v|) v a hull that nobody touches comes to rest after m / Yq ln(1 + Yq |v| / Y).
The team brakes it by pushing less than its drag, lets go when the pose at which it will rest is
near the goal, and stands off, so that no contact disturbs it. Where the vessel would rest too far
from its goal the team pushes again.
"""

import numpy as np

from asv_env.geometry import plane
from asv_env.params import EnvParams
from asv_env.tasks.formation import Relations
from asv_env.types import Bool, Complex, Float
from baselines.scripted.gains import PushGains
from baselines.scripted.observer import VesselMemory

GRASPS_AGAIN = 1.0  #: error of the pose of rest at which the team pushes again, tolerances
FACING = 0.1  #: cosine of the angle to the hull within which a boat backs off
END_GAP = 0.006  #: gap to the hull of end boats that stand off, m
MOST_ERROR = 0.85  #: largest error of the pose of rest at which the team lets go, tolerances
TINY = 1e-9  #: floor of drag coefficients


class Settling:
    """Decides when the team lets go, and where boats stand off."""

    def __init__(self, params: EnvParams, gains: PushGains, still_water: float) -> None:
        self._vessel, boat = params.hulls()
        self._gains, self._task, self._still_water = gains, params.task, still_water
        self._corners = plane(np.array(boat.outline))

    def update(self, relations: Relations, vessel: VesselMemory, released: Bool) -> Bool:
        """Returns in which worlds (W,) the team has let go, given where it had."""
        goal, turned = self.rest(relations, vessel.drift)
        task, gains = self._task, self._gains
        error = np.maximum(
            np.abs(goal) / task.position_tolerance, np.abs(turned) / task.heading_tolerance
        )
        # The longer the team waits for a better pose, the farther the vessel gets.
        beyond = goal.imag / task.position_tolerance - gains.overrun
        worst = gains.release_error + gains.hurry * np.maximum(beyond, 0.0)
        still = np.abs(vessel.drift) <= self._still_water
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
        vessel = self._vessel
        velocity = (relations.velocity[:, 0] - drift) * relations.heading[:, 0].conj()
        axes = zip(vessel.masses, (vessel.surge, vessel.sway, vessel.yaw), strict=True)
        motions = velocity.real, velocity.imag, relations.yaw_rate[:, 0]
        ahead, aside, turn = (coasted(*a, m) for a, m in zip(axes, motions, strict=True))
        # Its course is half turned on average.
        way = (ahead + 1j * aside) * np.exp(0.5j * turn)
        return (relations.goal - way) * np.exp(-1j * turn), relations.heading_error + turn

    def stand_off(self, relations: Relations, hull: Complex, end: Float) -> Float:
        """Returns the speeds (W, A) m/s, along their bows, of boats that leave the hull alone.

        Args:
            relations: estimated relations.
            hull: (W, A) velocity of the hull at the boats, in its frame, m/s.
            end: (W, A) -1 or +1 where a boat is at that end of the hull, 0 at its side.
        """
        gains, bow = self._gains, relations.heading[:, 1:] * relations.heading[:, :1].conj()
        missing = np.where(end == 0, gains.release_gap, END_GAP) - self.clearance(relations, end)
        away = np.clip(gains.release_gain * missing, -gains.release_speed, gains.release_speed)
        towards = np.where(end == 0, -bow.imag, -end * bow.real)
        # A boat whose flank touches the hull cannot back off, so it goes along.
        return (hull * bow.conj()).real - np.where(towards > FACING, away, 0.0)

    def clearance(self, relations: Relations, end: Float) -> Float:
        """Returns the gaps (W, A) between boats and the hull's side or end where they are, m."""
        bow = relations.heading[:, 1:] * relations.heading[:, :1].conj()
        corners = relations.boat[..., None] + self._corners * bow[..., None]
        beside = corners.imag.min(axis=-1) - self._vessel.width / 2
        beyond = (end[..., None] * corners.real).min(axis=-1) - self._vessel.length / 2
        return np.where(end == 0, beside, beyond)


def coasted(mass: float, coefficients: tuple[float, float], velocity: Float) -> Float:
    """Returns the distances (...), m or rad, after which a free hull rests along an axis.

    Args:
        mass: effective mass, kg, or inertia, kg m^2.
        coefficients: linear and quadratic drag coefficient.
        velocity: (...) through the water, m/s or rad/s.
    """
    linear, quadratic = max(coefficients[0], TINY), max(coefficients[1], TINY)
    way = np.log1p(np.abs(velocity) * quadratic / linear) * mass / quadratic
    return np.sign(velocity) * way
