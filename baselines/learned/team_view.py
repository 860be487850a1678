"""What each boat of a team sees of itself, its task and three sets, and how it is commanded.

The sets are the other boats, points of the vessel's outline and the nearest points of obstacles,
see ``baselines.learned.seen``. As the boats of ``baselines.allocation`` do, each has a contact
point, which is assigned when an episode begins or a boat fails, and estimates the vessel's motion
by the forces that the team exerts. Its contact point is its slot where the task or the team has no
use for a formation round the hull.

A boat is commanded by its speed relative to the hull and by a direction to point in, because small
differences of these decide what force it exerts: its helm makes the motion of them.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from asv_env import polygons
from asv_env.geometry import direction, plane, wrap
from asv_env.params import EnvParams
from asv_env.sensing import observation
from asv_env.sensing.kalman import predicted
from asv_env.types import Action, Bool, Complex, Float, Observation, Sensed, copied
from baselines.allocation.allocation_gains import AllocationGains
from baselines.allocation.contact import Contact
from baselines.allocation.contact_approach import ContactApproach
from baselines.allocation.direct_path import AGAIN, CAPTURE
from baselines.allocation.team_plan import in_place
from baselines.learned.seen import BOAT, ENVIRONMENT, OBSTACLE, OWN, POINT, WIDTHS, Seen, put
from baselines.mirror import at_scale
from baselines.scripted.helm import Helm
from baselines.scripted.observer import VesselMemory, VesselObserver

OUTLINE_POINTS = 16  #: points of the vessel's outline, one at least on each edge
FINE_FORCE = 0.03  #: speed relative to the hull, m/s, up to which commands are nearly linear in it
OF_ENVIRONMENT = tuple(map(observation.FEATURES.find, ENVIRONMENT))
NEAREST = tuple(map(observation.FEATURES.find, ("obstacles", "vessel_obstacles")))


@dataclass
class ViewMemory:
    """What a team remembers from tick to tick; places are given in the vessel's frame."""

    place: Complex  #: (W, A) where boats are at their contact points, m
    inward: Complex  #: (W, A) directions in which they point there
    axis: Complex  #: (W,) direction in which, or against which, the team drives the vessel
    allocated: Bool  #: (W,) whether the contact points are those of a formation, and not slots
    working: Bool  #: (W, A) boats that worked when they were assigned
    in_place: Bool  #: (W, A) boats that are at their contact points
    grasped: Bool  #: (W,) whether all boats have been there since these were assigned
    arrived: Bool  #: (W,) whether the vessel has been at the goal since, and is still near it
    heading: Complex  #: (W, A) of boats, in the frames of their contact points
    ahead: Float  #: (W, A) speed of the hull where a boat is, along its heading, m/s
    yaw_rate: Float  #: (W,) of the vessel, rad/s
    vessel: VesselMemory
    reference: Float  #: (W, A, 2) that the boats' autopilots follow, m/s and rad/s

    @classmethod
    def empty(cls, worlds: int, team: int) -> Self:
        """Returns memory to be filled when episodes begin."""
        boats = (worlds, team)
        return cls(
            place=np.zeros(boats, dtype=np.complex128),
            inward=np.ones(boats, dtype=np.complex128),
            axis=np.ones(worlds, dtype=np.complex128),
            allocated=np.zeros(worlds, dtype=np.bool_),
            working=np.zeros(boats, dtype=np.bool_),
            in_place=np.zeros(boats, dtype=np.bool_),
            grasped=np.zeros(worlds, dtype=np.bool_),
            arrived=np.zeros(worlds, dtype=np.bool_),
            heading=np.ones(boats, dtype=np.complex128),
            ahead=np.zeros(boats),
            yaw_rate=np.zeros(worlds),
            vessel=VesselMemory.empty(worlds, team),
            reference=np.zeros((*boats, 2)),
        )


class TeamView:
    """What the boats of an environment see, and how they are commanded.

    Args:
        params: parameters of the environment; ``action_mode`` must be "tracking".

    Raises:
        ValueError: the environment takes thruster actions.
    """

    def __init__(self, params: EnvParams) -> None:
        if params.action_mode != "tracking":
            raise ValueError(
                f"the policy gives 'tracking' actions, the environment takes "
                f"{params.action_mode!r}: make it with action_mode='tracking'"
            )
        self._params, self._shrinking = params, 1.0 / params.scale
        self._has_goal = params.definition.has_goal
        self._has_obstacles = bool(params.obstacles) or params.water.walls is not None
        self._delay = params.sensors.delay
        team = np.arange(params.num_boats)
        self._others = np.array([np.delete(team, boat) for boat in team])
        small, gains = params.rescaled(self._shrinking), AllocationGains()
        self._size = small.vessel.size
        self._point, self._normal = outline_points(small)
        self._approach, self._contact = ContactApproach(small, gains), Contact(small, gains)
        self._observer, self._helm = VesselObserver(small), Helm(small)
        self._fastest, self._reach = small.boat.full_speed, small.task.position_tolerance

    def observe(
        self, sensed: Sensed, memory: ViewMemory | None, fresh: Bool
    ) -> tuple[Seen, ViewMemory]:
        """Returns what the boats see, (W, A) in front, and the memory for ``command``.

        In the worlds ``fresh`` (W,) an episode begins; the memory is None at the first time.
        """
        worlds, team = sensed.slot.shape
        if memory is None:
            memory, fresh = ViewMemory.empty(worlds, team), np.ones_like(fresh)
        memory = copied(memory)
        environment = observation.observe(OF_ENVIRONMENT, sensed, self._params)
        obstacles = np.zeros((worlds, team, 0, WIDTHS[3]), dtype=np.float32)
        nearest = None
        if self._has_obstacles:
            nearest = observation.observe(NEAREST, sensed, self._params)
        sensed = at_scale(sensed, self._shrinking)
        motion = self._estimated(sensed, memory, fresh)
        to_vessel = np.exp(-1j * motion[:, :1, 2])
        boat = (plane(motion[:, 1:]) - plane(motion[:, :1])) * to_vessel
        self._assign(boat, sensed, memory, fresh)
        own, boats, to_contact = self._see_boats(sensed, motion, boat, memory)
        own = np.concatenate([environment, own], axis=-1)
        if nearest is not None:
            obstacles = self._see_obstacles(nearest, boat, to_contact, memory.heading)
        return Seen(own, boats, self._see_outline(boat, to_contact), obstacles), memory

    def command(self, wanted: Float, memory: ViewMemory) -> Action:
        """Returns the actions (W, A, 2) of boats that are to move as ``wanted`` (W, A, 3).

        The first number is the speed relative to the hull, in [-1, 1], see ``stretched``; the
        others are the direction to point in, in the frame of the contact point, of any length. The
        memory keeps what the autopilots are asked for.
        """
        speed = memory.ahead + stretched(wanted[..., 0], self._fastest)
        aim = wanted[..., 1] + 1j * wanted[..., 2]
        error = np.angle(aim * memory.heading.conj())
        motion = np.stack([speed, self._helm.turn(error) + _turns(memory)], axis=-1)
        action, memory.reference = self._helm.set_points(motion, memory.reference)
        return action.astype(np.float32)

    def label(self, motion: Float, memory: ViewMemory) -> Float:
        """Returns what ``command`` turns into the motions (W, A, 2), m/s and rad/s; (W, A, 3)."""
        relative = motion[..., 0] - memory.ahead
        aim = memory.heading * direction(self._helm.angle(motion[..., 1] - _turns(memory)))
        return np.stack([shrunk(relative, self._fastest), aim.real, aim.imag], axis=-1)

    def _estimated(self, sensed: Sensed, memory: ViewMemory, fresh: Bool) -> Float:
        """Returns the estimated motion (W, B, 6), that of the vessel by the forces of the boats.

        A boat that touches the vessel pushes with what its autopilot's reference is faster.
        """
        vessel, touching, contact = memory.vessel, sensed.touching[..., 0], self._contact
        before = vessel.motion
        to_vessel = np.exp(-1j * before[:, 2:3])
        bow = direction(sensed.estimate[:, 1:, 2]) * to_vessel
        boat = (plane(sensed.estimate[:, 1:]) - plane(before)[:, None]) * to_vessel
        hull = plane(before, 3)[:, None] * to_vessel + 1j * before[:, 5:] * boat
        lack = memory.reference[..., 0] - (hull * bow.conj()).real
        force = bow * np.clip(contact.servo * lack, 0.0, contact.thrust) * touching
        vessel.force = force.sum(axis=1)
        vessel.moment = (boat.conj() * force).imag.sum(axis=1)
        self._observer.update(sensed, vessel, np.asarray(touching.any(axis=1)))
        self._observer.restart(sensed, vessel, fresh | (sensed.seen[:, 0] & ~vessel.seen))
        vessel.seen = sensed.seen[:, 0].copy()
        memory.reference[fresh] = 0.0
        motion = sensed.estimate.copy()
        motion[:, 0] = vessel.motion
        return predicted(motion, self._delay)

    def _assign(self, boat: Complex, sensed: Sensed, memory: ViewMemory, fresh: Bool) -> None:
        """Assigns contact points to boats (W, A), m, vessel frame, where they have none."""
        spans = self._approach.spans(sensed.working)
        allocated = spans & sensed.anchored & self._has_goal
        begins = fresh | (memory.working != sensed.working).any(axis=1) | ~memory.allocated
        for world in np.flatnonzero(allocated & begins).tolist():
            works = sensed.working[world]
            formation, number = self._approach.assign(boat[world, works])
            memory.place[world], memory.inward[world] = boat[world], 1.0
            memory.place[world, works] = formation.place[number]
            memory.inward[world, works] = formation.inward[number]
            memory.axis[world] = formation.axis
        slotted, across = ~allocated, np.where(sensed.side > 0, -1j, 1j)
        memory.place[slotted] = sensed.slot[slotted]
        memory.inward[slotted] = across[slotted, None]
        memory.axis[slotted] = across[slotted]
        again = begins | (allocated != memory.allocated)
        memory.in_place[again], memory.grasped[again], memory.arrived[again] = False, False, False
        memory.allocated, memory.working = allocated, sensed.working.copy()

    def _see_boats(
        self, sensed: Sensed, motion: Float, boat: Complex, memory: ViewMemory
    ) -> tuple[Observation, Observation, Complex]:
        """Returns what boats at ``boat`` see of themselves, and of each other.

        The last result (W, A) turns vectors of the vessel's frame into those of contact points.
        """
        (worlds, team), others = boat.shape, self._others
        heading, velocity, rate = direction(motion[..., 2]), plane(motion, 3), motion[:, :1, 5]
        to_vessel = heading[:, :1].conj()
        bow, own, hull = (each * to_vessel for each in (heading[:, 1:], velocity[:, 1:], velocity))
        hull = hull[:, :1]
        place, inward = memory.place, memory.inward
        to_contact = inward.conj()
        goal = (plane(sensed.goal)[:, None] - plane(motion[:, :1])) * to_vessel
        turn = wrap(sensed.goal[:, 2:] - motion[:, :1, 2])
        drive = driven(memory.axis[:, None], goal, turn)
        along, gap, pointing = drive.conj(), (place - boat) * to_contact, bow * to_contact
        here = hull + 1j * rate * boat
        memory.heading, memory.ahead = pointing, (here * bow.conj()).real
        memory.yaw_rate = rate[:, 0]
        self._update(gap, pointing, np.abs(goal[:, 0]), sensed.working, memory)
        working = sensed.working.sum(axis=1, keepdims=True)
        contact = {
            "lever_arm": place * along,
            "push": inward * along,
            "moment": (place.conj() * inward).imag,
        }
        itself = {
            "slip": (here - own) * to_contact,
            "gap": gap,
            "heading": pointing,
            "heading_angle": np.angle(pointing),
            "drive": drive * to_contact,
            "vessel": -boat * to_contact,
            "drift": memory.vessel.drift[:, None] * to_vessel * to_contact,
            "in_place": memory.in_place,
            "goal": goal * along,
            "goal_turn": direction(turn),
            "goal_angle": turn,
            "vessel_velocity": hull * along,
            "vessel_yaw_rate": rate,
            "allocated": memory.allocated[:, None],
            "closed": sensed.closed[:, None],
            "grasped": memory.grasped[:, None],
            "arrived": memory.arrived[:, None],
            "share_in_place": memory.in_place.sum(axis=1, keepdims=True) / working,
            "inverse_team": 1.0 / working,
        }
        each = to_contact[:, :, None]
        seen = {
            "present": np.ones(()),
            "position": (boat[:, others] - boat[:, :, None]) * each,
            "heading": bow[:, others] * each,
            "velocity": (own[:, others] - own[:, :, None]) * each,
            "gap": gap[:, others],
            "alignment": pointing[:, others],
            "in_place": memory.in_place[:, others],
            "touches": sensed.touching[:, others, 0],
            "works": sensed.working[:, others],
            "seen": sensed.seen[:, 1:][:, others],
            **{name: value[:, others] for name, value in contact.items()},
        }
        first = WIDTHS[0] - sum(len(column.signs) for column in OWN)
        alone = np.empty((worlds, team, WIDTHS[0] - first), dtype=np.float32)
        put(alone, OWN, itself | contact)
        boats = np.empty((worlds, team, team - 1, WIDTHS[1]), dtype=np.float32)
        put(boats, BOAT, seen)
        return alone, boats, to_contact

    def _update(
        self, gap: Complex, pointing: Complex, distance: Float, working: Bool, memory: ViewMemory
    ) -> None:
        """Updates which boats are in place, what is grasped, and which vessels have arrived."""
        memory.in_place = in_place(gap, pointing.real, memory.in_place) & working
        memory.grasped = memory.grasped | (memory.in_place | ~working).all(axis=1)
        bound = np.where(memory.arrived, AGAIN, CAPTURE) * self._reach
        memory.arrived = memory.grasped & (distance < bound)

    def _see_outline(self, boat: Complex, to_contact: Complex) -> Observation:
        """Returns the points of the outline as boats (W, A) see them."""
        seen = np.empty((*boat.shape, len(self._point), WIDTHS[2]), dtype=np.float32)
        point = (self._point - boat[..., None]) * to_contact[..., None]
        put(seen, POINT, {"point": point, "normal": self._normal * to_contact[..., None]})
        return seen

    def _see_obstacles(
        self, nearest: Observation, boat: Complex, to_contact: Complex, heading: Complex
    ) -> Observation:
        """Returns the points of obstacles as boats (W, A) see them, from features ``NEAREST``."""
        found = nearest.reshape(*boat.shape, 2, -1, 3).astype(np.float64)
        of_boat, of_vessel = np.moveaxis(plane(found) * self._size, 2, 0)
        of_boat, of_vessel = of_boat * heading[..., None], of_vessel * to_contact[..., None]
        centre = -(boat * to_contact)[..., None]
        present = np.concatenate([found[:, :, 0, :, 2], found[:, :, 1, :, 2]], axis=-1)
        items = {
            "present": present,
            "from_boat": np.concatenate([of_boat, of_vessel + centre], axis=-1),
            "from_vessel": np.concatenate([of_boat - centre, of_vessel], axis=-1),
            "nearest_to_vessel": np.repeat([0.0, 1.0], of_boat.shape[-1]),
        }
        seen = np.empty((*present.shape, WIDTHS[3]), dtype=np.float32)
        put(seen, OBSTACLE, items)
        seen *= present[..., None] > 0
        return seen


def stretched(share: Float, fastest: float) -> Float:
    """Returns speeds (...), m/s, of shares (...) in [-1, 1]; small ones are resolved finely."""
    return FINE_FORCE * np.sinh(share * np.arcsinh(fastest / FINE_FORCE))


def shrunk(speed: Float, fastest: float) -> Float:
    """Returns the shares (...) of which ``stretched`` makes speeds (...), m/s; at most 1."""
    share = np.arcsinh(speed / FINE_FORCE) / np.arcsinh(fastest / FINE_FORCE)
    return np.clip(share, -1.0, 1.0)


def _turns(memory: ViewMemory) -> Float:
    """Returns yaw rates (W, A), rad/s, with which boats in place turn with the hull."""
    return np.where(memory.in_place & memory.grasped[:, None], memory.yaw_rate[:, None], 0.0)


def driven(axis: Complex, goal: Complex, turn: Float) -> Complex:
    """Returns the directions (...), along axes or against them, in which vessels turn less.

    They turn to ``goal`` (...) and then to the heading ``turn`` (...), rad.
    """
    bearing = np.angle(goal * axis.conj())
    opposite = wrap(bearing + np.pi)
    turning = np.abs(bearing) + np.abs(wrap(turn - bearing))
    other = np.abs(opposite) + np.abs(wrap(turn - opposite))
    return np.where(other < turning, -axis, axis)


def outline_points(params: EnvParams) -> tuple[Complex, Complex]:
    """Returns points (P,) on the vessel's outline, m, and outward normals, vessel frame."""
    corner = polygons.complex_corners(params.vessel.corners)
    edge = np.roll(corner, -1) - corner
    spacing = np.abs(edge).sum() / OUTLINE_POINTS
    points, normals = [], []
    for begin, along in zip(corner, edge, strict=True):
        count = max(1, round(abs(along) / spacing))
        points.append(begin + (np.arange(count) + 0.5) / count * along)
        normals.append(np.full(count, -1j * along / abs(along)))
    return np.concatenate(points), np.concatenate(normals)
