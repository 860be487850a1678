"""How boats hold a vessel over ground, at a goal in moving water.

Boats at the side can only push, and water that comes from behind them carries the vessel off.
Those at the ends face each other and hold the vessel between them: leaning back or ahead they brake
and turn it by friction, and against water that flows along it one of them presses more. Those at
the side keep their places. Where the water takes more than such a grip holds, the team is better
off on the other side.
"""

import numpy as np

from asv_env.params import EnvParams
from asv_env.physics.autopilot import bandwidth
from asv_env.tasks.formation import Relations
from asv_env.types import Bool, Complex, Float
from baselines.paper.coasting import drag
from baselines.scripted.gains import PushGains
from baselines.scripted.hull_sides import HullSides

GRIP = 0.7  #: share of the friction that is used: boats are a little off the directions they want
GRIP_THRUST = 0.6  #: share of a boat's thrust with which it presses at most
LOSES = 0.15  #: share of the largest brake that the water may take before the side is changed
LITTLE = 0.1  #: share of the water's speed that may carry the vessel off the boats
LEAST_STEM = 1e-4  #: floor of the thrust ahead of a boat that stems the water, N
TINY = 1e-6  #: floor of the friction


class Holding:
    """Whether a vessel can be held from a side, and how boats do it."""

    def __init__(self, params: EnvParams, gains: PushGains, still_water: float) -> None:
        self._vessel, self._boat = params.hulls()
        self._gains, self._still_water = gains, still_water
        self._holds = params.task.delivery == "holding"
        self._shape = HullSides(self._vessel, self._boat)
        self._grip = max(GRIP * params.water.contact_friction, TINY)
        self._press = GRIP_THRUST * 2 * self._boat.thrust
        self._per_thrust = 1.0 / (self._boat.masses[0] * bandwidth(self._boat))

    def brake(self, working: Bool, end: Float) -> Float:
        """Returns the largest forces (W,), N, with which boats brake hulls.

        It takes a working boat (W, A) at either ``end`` (W, A), -1 and +1; 0 stands for the side.
        """
        stern, bow = ((working & (end == which)).any(axis=1) for which in (-1.0, 1.0))
        return np.where(stern & bow, 2 * self._grip * self._press, 0.0)

    def loses(self, relations: Relations, drift: Complex, brake: Float) -> tuple[Bool, Bool]:
        """Returns (W,) whether water carries vessels off boats at this side, and at the other.

        It is that at the goal, where the vessel is to be held.

        Args:
            relations: estimated relations.
            drift: (W,) velocity of the water, m/s.
            brake: (W,) largest force with which the boats brake, N.
        """
        speed, pushed = np.abs(drift), -1j * relations.heading[:, 0] * relations.goal_turn
        ahead = (drift * pushed.conj()).real
        much = LITTLE * speed
        moves = self._holds & (speed > self._still_water)
        takes = drag(self._vessel.sway, ahead)
        loses = moves & (takes > LOSES * brake) & (ahead > much)
        other = moves & (-takes > LOSES * brake) & (-ahead > much)
        return loses, other

    def grip(
        self,
        relations: Relations,
        hull: Complex,
        water: Complex,
        end: Float,
        wrench: tuple[Float, Float, Float],
    ) -> tuple[Float, Float]:
        """Returns speed and yaw offset (W, A) of boats that hold the hull between its ends.

        Args:
            relations: estimated relations.
            hull: (W, A) velocity of the hull at the boats, in its frame, m/s.
            water: (W, 1) velocity of the water, in that frame, m/s.
            end: (W, A) -1 or +1 where a boat is at that end of the hull, 0 at its side.
            wrench: (W,) force along the hull, N; that of the brake, N; and moment, N m.
        """
        (force, brake, moment), boat, through = wrench, self._boat, hull - water
        bow = relations.heading[:, 1:] * relations.heading[:, :1].conj()
        press = np.maximum(-force[:, None] * end, 0.0) + self._gains.min_end_force
        length = self._shape.bow - self._shape.stern
        leans = brake / 2 + np.abs(moment) / length
        press = press + np.clip(leans / self._grip, 0.0, self._press)[:, None]
        # Boats that do not face each other exactly turn the hull.
        height = (relations.boat + boat.length / 2 * bow).imag
        moment = moment - (end * press * height).sum(axis=1)
        lean = -brake[:, None] / 2 - end * moment[:, None] / length
        lean = np.clip(lean, -self._grip * press, self._grip * press)
        along = drag(boat.surge, through.real) - end * press
        ahead = drag(boat.sway, -through.imag) + lean
        offset = np.arctan2(along, ahead)
        speed = hull.real * np.sin(offset) - hull.imag * np.cos(offset)
        speed += self._gains.lateral_gain * np.maximum(self._shape.gap(relations, end), 0.0)
        return speed + np.hypot(along, ahead) * self._per_thrust, offset

    def stem(
        self, gap: Complex, hull: Complex, water: Complex, force: Float
    ) -> tuple[Float, Float]:
        """Returns speed and yaw offset (W, A) of side boats that keep their places.

        Args:
            gap: (W, A) from the boats to their places, vessel frame, m.
            hull: (W, A) velocity of the hull there, vessel frame, m/s.
            water: (W, 1) velocity of the water, vessel frame, m/s.
            force: (W, A) that they exert on the hull, N.
        """
        boat, wanted = self._boat, hull + 2 * self._gains.gap_gain * gap
        through = wanted - water
        along = drag(boat.surge, through.real)
        ahead = drag(boat.surge, -through.imag) + force
        offset = np.arctan2(along, np.maximum(ahead, LEAST_STEM))
        bow = np.sin(offset) - 1j * np.cos(offset)
        speed = (wanted * bow.conj()).real
        effort = np.hypot(along, ahead) - drag(boat.surge, speed)
        return speed + effort * self._per_thrust, offset
