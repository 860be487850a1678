"""The approach phase: every boat goes to the waypoint above its slot, then the team descends.

Each boat follows its ``ApproachPath`` at the speed that brings the team to the waypoints together
(Eq 7). From there the boats dock (``docking``), and wait a little off the hull until the vessel is
in conditional closure.

Boats skid: the sideways velocity of a hull dies away only within about a second. So a boat steers
for a velocity relative to the hull and not for a heading: it points where its velocity is to
change, and against the water that drifts past the hull, which it notices because it is carried.
"""

import numpy as np

from asv_env.params import BoatParams, EnvParams
from asv_env.tasks import formation
from asv_env.tasks.formation import Relations
from asv_env.types import Bool, Complex, Float, Sensed
from baselines.paper.spiral import approach_speed
from baselines.scripted.approach_path import ApproachPath
from baselines.scripted.docking import Docking, GraspMemory
from baselines.scripted.gains import GraspGains
from baselines.scripted.helm import Helm
from baselines.scripted.hull_sides import HullSides
from baselines.scripted.observer import VesselMemory
from baselines.scripted.ways import Ways

MIN_SPEED = 0.02  #: least speed on the path to the waypoint, m/s
MAX_SIDESTEP = 0.5  #: limit of the step aside from a failed boat, fraction of the slot's tolerance
REPULSION = 2.0  #: velocity away from an obstacle at no distance from it, cruising speeds
STARBOARD = np.exp(0.8j)  #: turn of the velocity of avoidance, so that no two boats get stuck
TINY = 1e-9  #: floor of the distance between boats, m


class GraspController:
    """Speed and yaw rate of boats that approach their slots and wait there."""

    def __init__(self, params: EnvParams, gains: GraspGains) -> None:
        vessel, self._boat = params.hulls()
        self._shape = HullSides(vessel, self._boat)
        self._max_sidestep = MAX_SIDESTEP * params.task.slot_distance
        self._hz = params.clock.control
        self._helm = Helm(params)
        self._gains, self._docking = gains, Docking(params, gains)
        sides = {"+n": [1.0], "-n": [-1.0]}.get(params.task.side, [1.0, -1.0])
        slots = np.array([formation.slots(params, params.num_boats, side) for side in sides])
        highest = float(np.abs(slots.imag).max())
        left, right, bottom, top = vessel.extents
        length, width = 2 * max(right, -left), 2 * max(top, -bottom)  # of a box round the centre
        # Slots on a side near the centre may lie within that box; boats then come down to them.
        clearance = max(highest + gains.waypoint_height - width / 2, self._boat.reach)
        reach = float(np.abs(slots.real).max())
        path = ApproachPath(length, width, clearance, reach, gains.sigma)
        self._row = highest + self._boat.length
        self._ways = Ways(params, path)
        self._lead = lead(self._boat, gains)

    def act(
        self,
        relations: Relations,
        sensed: Sensed,
        vessel: VesselMemory,
        memory: GraspMemory,
        begins: Bool,
    ) -> Float:
        """Returns the speeds, m/s, and yaw rates, rad/s, of the boats (W, A, 2).

        An approach begins in the worlds ``begins`` (W,), and where slots change. ``memory`` is
        updated, and ``vessel`` receives what the boats exert: nothing.
        """
        gains, waypoint = self._gains, sensed.slot + 1j * self._gains.waypoint_height
        vessel.force[:], vessel.moment[:] = 0.0, 0.0
        begins = begins | (memory.slot != sensed.slot).any(axis=1)
        way = self._ways.find(relations, waypoint, sensed, memory, begins)
        self._begin(way.length, sensed, memory, begins)
        to_vessel = relations.heading[:, :1].conj()
        bow = relations.heading[:, 1:] * to_vessel
        hull = relations.velocity[:, :1] * to_vessel
        hull = hull + 1j * relations.yaw_rate[:, :1] * relations.boat
        velocity = relations.velocity[:, 1:] * to_vessel - hull
        drift = vessel.drift[:, None] * to_vessel - hull
        self._docking.update_team(relations, waypoint, sensed, memory)
        end = self._shape.end(sensed.slot)
        off_hull = np.where(end == 0, 1j, end)
        holding_position = sensed.slot + gains.standoff * off_hull
        target = np.where(memory.descending[:, None], holding_position, waypoint)
        failed = ~sensed.working & (relations.boat.imag < self._row)
        target += sidestep(target, relations.boat, failed, self._boat.width, self._max_sidestep)
        gap = target - relations.boat
        docks = self._docking.update_boats(relations, gap, sensed.slot, memory, way.sees)

        distance = np.minimum(np.abs(gap), way.to_bend)
        wanted = self._cruising_speed(way.length, distance, sensed, memory) * way.course
        limits = gains.avoidance_range, gains.avoidance_speed
        wanted += avoidance_velocity(relations.boat, sensed.seen[:, 1:], *limits)
        wanted += REPULSION * gains.cruise_speed * way.away
        wanted = np.where(docks, self._docking.velocity(gap, memory.astern), wanted)
        speed = ((wanted + hull) * bow.conj()).real
        either = docks | (way.away != 0.0)
        speed = np.where(either, speed, np.maximum(speed, 0.0))  # Others turn before they go.
        aim = wanted - drift + self._lead * (wanted - velocity)
        aim = np.where(docks & memory.astern, -aim, aim)  # Docking boats point to the hull.
        to_hull = aim.real + 1j * np.minimum(aim.imag, -gains.pointing_speed)
        aim = np.where(docks, to_hull, aim)
        error = np.angle(aim * bow.conj())
        return np.stack([speed, self._helm.turn(error)], axis=-1)

    def blocked(self, sensed: Sensed, memory: GraspMemory) -> Bool:
        """Returns in which worlds (W,) a failed boat keeps the others from their slots."""
        return self._docking.late(sensed, memory) & memory.descending & ~sensed.working.all(axis=1)

    def _begin(self, length: Float, sensed: Sensed, memory: GraspMemory, new: Bool) -> None:
        """Starts approaches of these lengths (W, A) in the worlds ``new`` (W,)."""
        if not new.any():
            return
        longest = (length * sensed.working)[new].max(axis=1)
        memory.slot[new] = sensed.slot[new]
        memory.due[new] = sensed.tick[new] + longest / self._gains.cruise_speed * self._hz
        memory.descending[new] = memory.astern[new] = False

    def _cruising_speed(
        self, length: Float, distance: Float, sensed: Sensed, memory: GraspMemory
    ) -> Float:
        """Returns the speeds (W, A) m/s that bring all boats to their waypoints when due (Eq 7)."""
        left = (memory.due - sensed.tick)[:, None] / self._hz
        speed = approach_speed(length, left, max_speed=self._gains.max_speed, min_speed=MIN_SPEED)
        return np.minimum(speed, MIN_SPEED + self._gains.arrival_gain * distance)


def lead(boat: BoatParams, gains: GraspGains) -> float:
    """Returns by how much a boat points ahead of its velocity, per change of it that is wanted.

    A boat that points along the force it needs changes its velocity in ``velocity_time``.
    """
    damping = boat.sway[0] + boat.sway[1] * gains.descent_speed
    return boat.masses[1] / (max(damping, TINY) * gains.velocity_time)


def avoidance_velocity(boat: Complex, seen: Bool, reach: float, speed: float) -> Complex:
    """Returns the velocity (W, A) m/s of boats (W, A) away from those within ``reach``, m.

    Only those that are ``seen`` (W, A) are avoided: nobody knows where the others are.

    It grows from 0 to ``speed``, m/s, as the distance shrinks to 0.
    """
    away = boat[:, :, None] - boat[:, None, :]
    distance = np.abs(away)
    nearness = np.maximum(1.0 - distance / reach, 0.0) * seen[:, None, :]
    return speed * STARBOARD * (nearness * away / np.maximum(distance, TINY)).sum(axis=2)


def sidestep(target: Complex, boat: Complex, obstacle: Bool, width: float, limit: float) -> Complex:
    """Returns shifts (W, A) m of the boats' targets along the hull, to clear failed boats.

    ``obstacle`` (W, A) marks these among the boats (W, A). Targets keep the distance ``width`` from
    them along the hull, but are shifted by ``limit`` at most, m.
    """
    offset = target.real[:, :, None] - boat.real[:, None, :]
    overlap = np.maximum(width - np.abs(offset), 0.0) * obstacle[:, None, :]
    return np.clip((np.sign(offset) * overlap).sum(axis=2), -limit, limit) + 0j
