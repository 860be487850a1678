"""The push phase: boats that carry the vessel along a path to its goal.

Boats at the side exert the force and the moment, those at the ends the force along the hull, that
``PathFollower`` demands. Each does so by the speed and the heading at which it goes with the hull.
"""

import numpy as np

from asv_env.geometry import direction
from asv_env.params import EnvParams
from asv_env.physics.autopilot import bandwidth
from asv_env.tasks.formation import Relations
from asv_env.types import Bool, Complex, Float, Sensed
from baselines.paper.coasting import drag
from baselines.scripted.clear_planner import ClearPlanner
from baselines.scripted.gains import PushGains, Tolerances
from baselines.scripted.helm import Helm
from baselines.scripted.holding import Holding
from baselines.scripted.hull_sides import HullSides
from baselines.scripted.observer import VesselMemory
from baselines.scripted.path_following import PathFollower, PathMemory
from baselines.scripted.planner import PathPlanner
from baselines.scripted.settling import Settling

MAX_PLACE_OFFSET = 0.3  #: limit of the yaw offset by which a side boat returns to its place, rad
MAX_FRICTION_OFFSET = 0.6  #: limit of the yaw offset that compensates friction, rad
MAX_PRESS_OFFSET = 1.5  #: limit of the yaw offset by which an end boat presses on the hull, rad
MAX_END_OFFSET = 1.57  #: limit of an end boat's total yaw offset from its slot's direction, rad
LEAST_SPEED = 0.02  #: floor of a boat's speed where a heading follows from it, m/s
LEAST_FORCE = 1e-3  #: floor of divisors that are forces, N, or sway damping, kg/s
TINY = 1e-6  #: floor of divisors that are positions along the hull, m, or their squares, m^2


class PushController:
    """Speed and yaw rate of boats that push the vessel to its goal."""

    def __init__(
        self,
        params: EnvParams,
        planner: PathPlanner,
        gains: PushGains,
        tolerances: Tolerances,
        among: ClearPlanner | None = None,
    ) -> None:
        self._vessel, self._boat = params.hulls()
        self._gains, self._helm = gains, Helm(params)
        self._settling = Settling(params, gains, planner.gains.still_water)
        self._shape = HullSides(self._vessel, self._boat)
        room = self._shape.rooms(params.water.contact_friction)
        self._room = np.array(room) - self._boat.width
        self._follower = PathFollower(params, planner, gains, tolerances, among)
        self._drag = drag(self._vessel.sway, planner.gains.speed)
        self._holding = Holding(params, gains, planner.gains.still_water)

    def act(
        self,
        relations: Relations,
        sensed: Sensed,
        vessel: VesselMemory,
        memory: PathMemory,
        begins: Bool,
    ) -> Float:
        """Returns the speeds, m/s, and yaw rates, rad/s, of the boats (W, A, 2).

        A push begins in the worlds ``begins`` (W,). Failed boats are left out. ``memory`` is
        updated, and ``vessel`` receives what the boats exert.
        """
        gains, ends = self._gains, self._shape.end(sensed.slot)
        at_end = ends != 0
        pushing = sensed.working & ~at_end
        caged = np.asarray((sensed.working & at_end).any(axis=1))
        memory.released &= ~begins
        memory.held[begins] = 0.0
        memory.released = self._settling.update(relations, vessel, memory.released)
        memory.replan &= ~memory.released
        plans = begins | memory.replan
        brake = self._holding.brake(sensed.working, ends)
        self._follower.plan(relations, vessel, memory, plans, sensed.obstacle, brake > 0)
        here, there = self._holding.loses(relations, vessel.drift, brake)
        memory.switch = here | (memory.switch & ~there)
        forward, along, moment = self._follower.wrench(relations, vessel, caged, memory)
        self._follower.watch(relations, memory, begins)
        places = self.places(sensed.slot, pushing, sensed.side)
        reserve, least = gains.moment_reserve * self._drag, gains.contact_force * self._drag
        # Boats that hold the vessel between its ends turn it, and the others need not.
        gripped = memory.held * (brake > 0)
        turning = (1 - gripped) * moment
        force, vessel.moment = allocate(forward, turning, places.real, pushing, reserve, least)
        vessel.moment = vessel.moment + gripped * moment
        vessel.force = along - 1j * force.sum(axis=1)
        gap, yaw_rate = places - relations.boat, relations.yaw_rate[:, :1]
        hull = relations.velocity[:, :1] * relations.heading[:, :1].conj() + 1j * yaw_rate * places
        water = (vessel.drift * relations.heading[:, 0].conj())[:, None]
        half = np.sign(places.real)
        end = self._end_command(relations, places, hull, water, yaw_rate, half, along)
        side = self._side_command(gap, hull, water, yaw_rate, force)
        moving, held = np.where(at_end, end, side), memory.held[:, None]
        speed, offset = moving
        if held.any():
            wrench = along, gripped * np.clip(-forward, 0.0, brake), gripped * moment
            gripping = self._holding.grip(relations, hull, water, ends, wrench)
            stemming = self._holding.stem(gap, hull, water, force)
            holding = np.where(at_end, gripping, stemming)
            speed, offset = (1 - held) * moving + held * holding
        turn = direction(offset - np.pi / 2) * relations.heading[:, :1] / relations.heading[:, 1:]
        error = np.arctan2(turn.imag, turn.real)
        slides = memory.slides[:, None]  # Boats that turn must not leave the ends meanwhile.
        speed = np.where(slides, speed * np.maximum(np.cos(error), 0.0), speed)
        yaw_rate = yaw_rate + self._helm.turn(error)
        free = memory.released
        vessel.force[free], vessel.moment[free] = 0.0, 0.0
        off = self._settling.stand_off(relations, hull, ends, sensed.side)
        speed = np.where(free[:, None], off, speed)
        yaw_rate = np.where(free[:, None] & at_end, 0.0, yaw_rate)
        return np.stack([speed, yaw_rate], axis=-1)

    def places(self, slot: Complex, pushing: Bool, side: Float) -> Complex:
        """Returns the boats' places (W, A), m.

        Side boats are spread as far as the ends allow, and friction on the hull's side (W,).
        """
        farthest = np.abs(np.where(pushing, slot.real, 0.0)).max(axis=1, keepdims=True)
        room = np.where(side < 0, self._room[1], self._room[0])[:, None]
        spread = np.clip(room / np.maximum(farthest, TINY), 1.0, self._gains.spread)
        u = np.where(pushing, spread, 1.0) * slot.real
        height = self._shape.height(u, side) - self._shape.height(slot.real, side)
        return u + 1j * (slot.imag + height)

    def _side_command(
        self, gap: Complex, hull: Complex, water: Complex, yaw_rate: Float, force: Float
    ) -> tuple[Float, Float]:
        """Returns speed and yaw offset (W, A) of side boats, which exert ``force`` (W, A) N."""
        gains, boat, forward, through = self._gains, self._boat, -hull.imag, hull - water
        sway_damping = boat.sway[0] + boat.sway[1] * np.abs(through.real)
        sway_force = boat.masses[0] * yaw_rate * forward + sway_damping * through.real
        resistance = drag(boat.surge, -through.imag)
        per_offset = np.maximum(force, 0.0) + np.maximum(resistance, 0.0)
        per_offset += sway_damping * np.maximum(-through.imag, 0.0)
        # A yaw offset takes away some of the friction by which boats hinder the hull's turning.
        friction = gains.friction_compensation * sway_force / np.maximum(per_offset, LEAST_FORCE)
        to_place = gains.yaw_offset_gain * gap.real
        offset = np.clip(to_place, -MAX_PLACE_OFFSET, MAX_PLACE_OFFSET)
        offset += np.clip(friction, -MAX_FRICTION_OFFSET, MAX_FRICTION_OFFSET)
        speed = forward + gains.gap_gain * np.maximum(-gap.imag, 0.0)
        # The autopilot makes up for the drag of the speed over ground.
        force = force + resistance - drag(boat.surge, forward)
        return speed * np.cos(offset) + force / (boat.masses[0] * bandwidth(boat)), offset

    def _end_command(
        self,
        relations: Relations,
        places: Complex,
        hull: Complex,
        water: Complex,
        yaw_rate: Float,
        end: Float,
        force: Float,
    ) -> tuple[Float, Float]:
        """Returns speed and yaw offset (W, A) of boats that press on the ``end`` -1 or +1."""
        gains, boat = self._gains, self._boat
        gap, forward, through = places - relations.boat, -hull.imag, hull - water
        press = np.maximum(-force[:, None] * end, 0.0) + gains.min_end_force
        # The boat on the outer side of a turn also needs the force that keeps it in the turn.
        needed = press - end * boat.masses[0] * yaw_rate * np.maximum(forward, 0.0)
        inwards = press_angle(
            boat.sway, np.maximum(needed, gains.min_end_force), np.maximum(-through.imag, TINY)
        )
        inwards = np.minimum(inwards, MAX_PRESS_OFFSET)
        course = through.real - end * gains.lateral_gain * self._shape.gap(relations, end)
        course = np.arctan2(course, np.maximum(-through.imag, LEAST_SPEED))
        offset = np.clip(course - end * inwards, -MAX_END_OFFSET, MAX_END_OFFSET)
        ahead = forward - 2 * gains.gap_gain * gap.imag
        speed = ahead * np.cos(offset) + hull.real * np.sin(offset)
        return speed + press * np.sin(inwards) / (boat.masses[0] * bandwidth(boat)), offset


def press_angle(sway: tuple[float, float], force: Float, speed: Float) -> Float:
    """Returns the angles (...) by which boats at an end of the hull point inwards, rad.

    A boat that goes along with the hull at a speed (...), m/s, and presses on its end with a
    force (...), N, is kept from sliding forward by its drag in sway: with the angle a,

        (Y + Yv speed sin a) speed sin a = force cos a.
    """
    linear, quadratic = sway
    angle = np.arctan2(force, linear * speed)
    for _ in range(4):
        angle = np.arctan2(force, (linear + quadratic * speed * np.sin(angle)) * speed)
    return angle


def allocate(
    forward: Float, moment: Float, position: Float, pushing: Bool, reserve: float, contact: float
) -> tuple[Float, Float]:
    """Returns the force (W, A) N of each boat, which can only push, and the moment (W,) N m of all.

    The moment has priority: where it asks for more force than the speed does, the vessel gets
    faster. A vessel that is too fast is left alone.

    Args:
        forward: (W,) force towards -n that the speed asks for, N; negative where it is too high.
        moment: (W,) wanted, N m.
        position: (W, A) of the boats along the hull, m.
        pushing: (W, A) boats that take part.
        reserve: force that may always be used for the moment, N.
        contact: least force of all boats together, N.
    """
    lever = np.where(pushing, position, 0.0)
    pushers = np.maximum(pushing.sum(axis=1), 1)
    levers = np.maximum((lever**2).sum(axis=1), TINY)
    per_moment = pushers * np.maximum(np.abs(lever).max(axis=1), TINY) / levers
    limit = np.maximum(forward, reserve) / per_moment
    moment = np.clip(moment, -limit, limit)
    total = np.maximum(np.maximum(forward, 0.0), per_moment * np.abs(moment))
    force = (total / pushers)[:, None] - (moment / levers)[:, None] * lever
    least = (contact / pushers)[:, None]
    surplus = np.minimum(forward / pushers, 0.0)[:, None]
    force = np.maximum(force, least) + np.where(surplus < 0, surplus - least, 0.0)
    force = np.where(pushing, force, 0.0)
    return force, -(force * lever).sum(axis=1)
