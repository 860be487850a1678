"""The push phase: boats that carry the vessel along a path to its goal.

Boats at the side exert the force and the moment, those at the ends the force along the hull, that
``PathFollower`` demands. Each does so by the speed and the heading at which it goes with the hull.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from asv_env.geometry import direction
from asv_env.params import EnvParams
from asv_env.physics.autopilot import bandwidth
from asv_env.tasks.formation import Relations
from asv_env.types import Bool, Complex, Float, Sensed
from baselines.scripted.allocation import allocate
from baselines.scripted.drag import drag
from baselines.scripted.gains import PushGains, Tolerances
from baselines.scripted.path_following import PathFollower, PathMemory
from baselines.scripted.planner import PathPlanner

MAX_PLACE_OFFSET = 0.3
"""Limit of the yaw offset by which a side boat returns to its place, rad."""
MAX_FRICTION_OFFSET = 0.6
"""Limit of the yaw offset by which a side boat moves sideways with the hull, rad."""
MAX_PRESS_OFFSET = 0.6
"""Limit of the yaw offset by which an end boat presses on the hull, rad."""
MAX_END_OFFSET = 1.0
"""Limit of the total yaw offset of an end boat from the direction of its slot, rad."""
LEAST_SPEED = 0.02
"""Floor of a boat's speed where a heading follows from it, m/s."""
LEAST_FORCE = 1e-3
"""Floor of divisors that are forces, N, or sway damping, kg/s."""
TINY = 1e-6
"""Floor of a distance by which another is divided, m."""


@dataclass
class Contact:
    """The hull as each boat meets it at its place.

    Attributes:
        gap: (W, A) from the boat to its place, in the vessel's frame, m.
        forward: (W, A) velocity of the hull there towards -n, m/s.
        sideways: (W, A) velocity of the hull there along +u, m/s.
        yaw_rate: (W, 1) of the vessel, rad/s.
        surge_drag: (W, A) drag of a boat that goes forward with the hull, N.
        sway_damping: (W, A) force per velocity of a boat that goes sideways with it, kg/s.
    """

    gap: Complex
    forward: Float
    sideways: Float
    yaw_rate: Float
    surge_drag: Float
    sway_damping: Float


class PushController:
    """Speed and yaw rate of boats that push the vessel to its goal.

    Args:
        params: parameters of the environment.
        planner: plans the vessel's paths.
        gains: gains of the push.
        tolerances: tolerated deviations of the vessel from its path.
    """

    def __init__(
        self, params: EnvParams, planner: PathPlanner, gains: PushGains, tolerances: Tolerances
    ) -> None:
        self._vessel, self._boat = params.hulls()
        self._gains = gains
        self._follower = PathFollower(self._vessel, planner, gains, tolerances)
        self._full_drag = drag(self._vessel.sway, planner.gains.speed)

    def act(
        self,
        relations: Relations,
        sensed: Sensed,
        drift: Complex,
        memory: PathMemory,
        replan: Bool,
    ) -> tuple[Float, Complex, Float]:
        """Commands for the boats, and what they exert by them.

        Args:
            relations: estimated relations.
            sensed: measurement, for slots and failures: a failed boat is left out.
            drift: (W,) velocity of the water, m/s, world frame.
            memory: the paths, which are updated.
            replan: (W,) worlds that need a new path.

        Returns:
            Speed m/s and yaw rate rad/s (W, A, 2); force (W,) on the vessel in its frame, N;
            moment (W,), N m.
        """
        self._follower.plan(relations, drift, memory, replan)
        at_end = np.abs(sensed.slot.real) > self._vessel.length / 2
        pushing = sensed.working & ~at_end
        caged = np.asarray((sensed.working & at_end).any(axis=1))
        demand = self._follower.demand(relations, drift, caged, memory)
        places = self.places(sensed.slot, pushing)
        force, moment = self.allocate(demand.forward, demand.moment, places.real, pushing)
        contact = self._contact(relations, places)
        speed, offset = np.where(
            at_end,
            self._end_command(contact, np.sign(places.real), demand.along),
            self._side_command(contact, force),
        )
        turn = direction(offset - np.pi / 2) * relations.heading[:, :1] / relations.heading[:, 1:]
        yaw_rate = self._gains.heading_gain * np.arctan2(turn.imag, turn.real)
        command = np.stack([speed, contact.yaw_rate + yaw_rate], axis=-1)
        return command, demand.along - 1j * force.sum(axis=1), moment

    def places(self, slot: Complex, pushing: Bool) -> Complex:
        """Places of the boats (W, A), m: those that push are spread as far as the ends allow."""
        farthest = np.abs(np.where(pushing, slot.real, 0.0)).max(axis=1, keepdims=True)
        room = self._vessel.length / 2 - self._boat.width
        spread = np.clip(room / np.maximum(farthest, TINY), 1.0, self._gains.spread)
        return np.where(pushing, spread, 1.0) * slot.real + 1j * slot.imag

    def allocate(
        self, forward: Float, moment: Float, position: Float, pushing: Bool
    ) -> tuple[Float, Float]:
        """See ``allocation.allocate``."""
        reserve = self._gains.moment_reserve * self._full_drag
        contact = self._gains.contact_force * self._full_drag
        return allocate(forward, moment, position, pushing, reserve, contact)

    def _contact(self, relations: Relations, places: Complex) -> Contact:
        """The hull as the boats meet it at their places (W, A)."""
        velocity = (relations.velocity[:, 0] * relations.heading[:, 0].conj())[:, None]
        yaw_rate = relations.yaw_rate[:, :1]
        forward = -velocity.imag - yaw_rate * places.real
        sideways = velocity.real - yaw_rate * places.imag
        return Contact(
            gap=places - relations.boat,
            forward=forward,
            sideways=sideways,
            yaw_rate=yaw_rate,
            surge_drag=drag(self._boat.surge, forward),
            sway_damping=self._boat.sway[0] + self._boat.sway[1] * np.abs(sideways),
        )

    def _side_command(self, contact: Contact, force: Float) -> tuple[Float, Float]:
        """Speed and yaw offset (W, A) of side boats: the hull's, and more by their force.

        The autopilot turns an excess of speed into thrust. Friction takes the boats along with
        the hull, which hinders its turning; a yaw offset by which their thrust would take them
        along by itself takes some of that away. Too much of it would push the vessel sideways.
        """
        gains, boat = self._gains, self._boat
        force_per_speed = boat.total_mass * bandwidth(boat)
        sideways = boat.total_mass * contact.yaw_rate * contact.forward
        sideways = sideways + contact.sway_damping * contact.sideways
        per_offset = np.maximum(force, 0.0) + np.maximum(contact.surge_drag, 0.0)
        per_offset += contact.sway_damping * np.maximum(contact.forward, 0.0)
        friction = gains.friction_compensation * sideways / np.maximum(per_offset, LEAST_FORCE)
        to_place = gains.yaw_offset_gain * contact.gap.real
        offset = np.clip(to_place, -MAX_PLACE_OFFSET, MAX_PLACE_OFFSET)
        offset += np.clip(friction, -MAX_FRICTION_OFFSET, MAX_FRICTION_OFFSET)
        speed = contact.forward + gains.gap_gain * np.maximum(-contact.gap.imag, 0.0)
        return speed * np.cos(offset) + force / force_per_speed, offset

    def _end_command(self, contact: Contact, end: Float, force: Float) -> tuple[Float, Float]:
        """Speed and yaw offset (W, A) of end boats: they go with the hull and press on it.

        The water carries a boat whose heading is off its course sideways, so that a small yaw
        offset presses hard.

        Args:
            contact: the hull as the boats meet it.
            end: (W, A) -1 or +1, at which end a boat is.
            force: (W,) wanted along the hull, N.
        """
        gains, boat = self._gains, self._boat
        forward = np.maximum(contact.forward, LEAST_SPEED)
        course = np.arctan2(contact.sideways + gains.lateral_gain * contact.gap.real, forward)
        drift_angle = boat.total_mass * contact.yaw_rate / max(boat.sway[0], LEAST_FORCE)
        press = np.maximum(-force[:, None] * end, 0.0) + gains.min_end_force
        per_offset = (boat.sway[0] + boat.sway[1] * LEAST_SPEED) * forward
        per_offset = per_offset + np.maximum(contact.surge_drag, LEAST_FORCE)
        inwards = np.minimum(press / per_offset, MAX_PRESS_OFFSET)
        offset = course + gains.drift_compensation * drift_angle - end * inwards
        speed = contact.forward - 2 * gains.gap_gain * contact.gap.imag
        return speed, np.clip(offset, -MAX_END_OFFSET, MAX_END_OFFSET)
