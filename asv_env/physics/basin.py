"""Rigid bodies with contact, one Space for each world. The only maker of Pymunk's objects.

Bodies and obstacles are made once and then placed, never removed: Pymunk's C code visits them in
the order in which they were added, the vessel first.
"""

from dataclasses import dataclass
from itertools import chain
from typing import Any

import numpy as np
import pymunk
from pymunk import autogeometry

from asv_env import polygons
from asv_env.params import EnvParams, HullParams
from asv_env.params.obstacle_params import grouping
from asv_env.physics import kernel, memory, native
from asv_env.physics.exchange import IDS, SLACK, Requests, address, fields
from asv_env.physics.kernel import Bodies, Wires
from asv_env.types import Float

CELLS_PER_BODY = 10  #: size of the spatial hash table; it orders the contacts
ITERATIONS = 30  #: of the contact solver in a step, see benchmarks/convergence.py
SLOP = 1e-4  #: depth to which hulls may overlap, m at scale 1
BIAS = 0.9**60  #: share of a deeper overlap that is left after a second at scale 1: Chipmunk's
SHORTEST = 1e-6  #: length of a round obstacle, m at scale 1: an edge of none has no normal


@dataclass(frozen=True)
class BasinSnapshot:
    """All that a ``Basin`` remembers from one physics step to the next."""

    #: (W, B, 9) pose and velocity as the next step finds them, mass, inertia, friction
    bodies: Float
    motion: Float  #: (W, B, 6) motion after the last step
    size: Float  #: (W, A) factors on the lengths of the boats
    direction: Float  #: (W, B, 2) cosine and sine of the headings then
    contacts: list[memory.Contacts]  #: of each world, in the last step
    obstacles: Float  #: (W, M, 5) rows of ``asv_env.capsules``


class Basin:
    """Bodies of ``num_worlds`` worlds, ``B = 1 + num_boats`` each, row 0 the vessel."""

    def __init__(self, params: EnvParams, num_worlds: int, num_threads: int) -> None:
        self._params = params
        self._dt = params.clock.dt
        #: whether the bodies have made the next step's change of position already
        self.moved = False
        vessel, boat = params.hulls()
        self._hulls = [vessel] + [boat] * params.num_boats
        count, team = len(self._hulls), params.num_boats
        #: what the kernel reads and writes
        self.bodies = Bodies(
            np.zeros((num_worlds, count, 6)),
            np.zeros((num_worlds, count, 2)),
            np.zeros((num_worlds, team, 2), dtype=np.bool_),
            np.zeros((num_worlds, team)),
            np.zeros(num_worlds, dtype=np.bool_),
        )
        rows = int(grouping(params).groups[-1])
        #: (W, M, 5) where the obstacles are; nowhere yet
        self._placed = np.full((num_worlds, rows, 5), np.nan)
        made = [self._make_world(rows) for _ in range(num_worlds)]
        self._spaces = [space for space, _, _ in made]
        self._bodies = [bodies for _, bodies, _ in made]
        #: (W, A) factors on the lengths of the boats
        self._size = np.ones((num_worlds, team))
        (shape,) = self._bodies[0][1].shapes
        #: corners of a boat in Chipmunk's order
        self._boat = shape.get_vertices()
        self._obstacles = [obstacles for _, _, obstacles in made]
        pieces = len(_pieces(vessel))
        pairs = pieces * team + team * (team - 1) // 2 + rows * (pieces + team)
        impulse = np.zeros((num_threads, 2 * pairs + SLACK))
        contact_id = np.zeros((num_threads, IDS * pairs + SLACK), dtype=np.int64)
        self._contacts = Requests(impulse, contact_id)
        #: how the kernel reaches Pymunk
        self.wires = Wires(
            functions=np.array(native.FUNCTIONS),
            space=np.array([address(space._space) for space in self._spaces]),
            body=np.array([[address(body._body) for body in bodies] for bodies in self._bodies]),
            shape=np.array([list(map(address, _shapes(bodies))) for bodies in self._bodies]),
            fields=fields(),
            body_id=np.array([[body.id for body in bodies] for bodies in self._bodies]),
            contact=self._contacts.address,
            impulse_count=self._contacts.floats_copied,
            id_count=self._contacts.ints_copied,
            impulse=impulse,
            contact_id=contact_id,
        )
        self._warm_up()

    def _warm_up(self) -> None:
        """Lets a boat of every world touch its vessel, apart from the others.

        At its first contact a Space takes the memory for many. So all do now, and need no more
        later.
        """
        hulls = [memory.remembered(body) for body in self._bodies[0]]
        for number, row in enumerate(hulls):
            row[0] = 3.0 * self._hulls[0].length * max(0, number - 1)
        for world, space in enumerate(self._spaces):
            kernel.put(self.wires, world, np.array(hulls))
            space.step(self._dt)
            kernel.read(self.wires, self.bodies, world)
        self.bodies.touching[...] = True  # ``clear`` shall forget these contacts.

    def _make_world(self, rows: int) -> tuple[pymunk.Space, list[pymunk.Body], list[pymunk.Poly]]:
        """Returns a Space with the bodies of one world at its origin, these, and its obstacles.

        So many obstacles are far away until they are placed.
        """
        space = pymunk.Space()
        space.use_spatial_hash(self._hulls[0].length, CELLS_PER_BODY * len(self._hulls))
        space.iterations = ITERATIONS
        space.collision_slop = SLOP * self._params.scale
        space.collision_bias = BIAS ** (self._params.scale**-0.5)
        # Contacts that have ended are forgotten at once; ``place`` forgets the others.
        space.collision_persistence = 1
        away = 2 * self._params.task.arena + self._hulls[0].length * (10 + len(self._hulls))
        obstacles = [
            # A Segment that is moved gets a wrong normal, and with it wrong points of contact.
            pymunk.Poly(space.static_body, [(away, away), (away + SHORTEST, away)])
            for _ in range(rows)
        ]
        space.add(*obstacles)
        return space, [_add_hull(space, hull) for hull in self._hulls], obstacles

    @property
    def motion(self) -> Float:
        """Motion (W, B, 6) after the last step, headings not wrapped: a view."""
        return self.bodies.motion

    def settle(self) -> None:
        """Lets the bodies move again, after the step whose change of position they had made."""
        self.moved = False
        for body in chain.from_iterable(self._bodies):
            body.position_func = pymunk.Body.update_position

    def snapshot(self) -> BasinSnapshot:
        """Returns all that the next steps depend on, for the simulation to copy.

        Chipmunk shows everything but the bias velocities, by which hulls that overlap move apart
        at the beginning of the next step. So the bodies make that change of position now, and
        not in the next step: the outcome is the same to the bit.
        """
        if not self.moved:
            for body in chain.from_iterable(self._bodies):
                pymunk.Body.update_position(body, self._dt)
                body.position_func = memory.stay
            self.moved = True
        bodies = [[memory.remembered(body) for body in world] for world in self._bodies]
        motion = self.motion, self._size, self.bodies.direction
        contacts = list(map(memory.contacts, self._spaces))
        return BasinSnapshot(np.array(bodies), *motion, contacts, self._placed)

    def restore(self, snapshot: BasinSnapshot) -> None:
        """Continues as the basin did, with the same arguments, whose ``snapshot`` this is.

        A step in which the bodies rest where they were finds the same contacts again.
        """
        self.motion[...], self.bodies.direction[...] = snapshot.motion, snapshot.direction
        for world, size in enumerate(snapshot.size):
            self.resize(world, size)
        for world, rows in enumerate(snapshot.obstacles):
            if not np.isnan(rows).any():
                self.put_obstacles(world, rows)
        at_rest = snapshot.bodies.copy()
        at_rest[..., :3], at_rest[..., 3:6] = snapshot.motion[..., :3], 0.0
        self._put(at_rest)
        for space, contacts in zip(self._spaces, snapshot.contacts, strict=True):
            space.step(self._dt)
            memory.put_contacts(space, contacts)
        self._put(snapshot.bodies)
        self.moved = True
        self.bodies.touching[...] = True  # for all that is known before the next step

    def _put(self, bodies: Float) -> None:
        """Gives all bodies what ``memory.remembered`` returned, (W, B, 9); they stay there."""
        for world, rows in enumerate(bodies):
            kernel.put(self.wires, world, rows)
            for obstacle in self._obstacles[world]:
                obstacle.friction = rows[0, -1].item()
        for body in chain.from_iterable(self._bodies):
            body.position_func = memory.stay

    def clear(self, world: int, root: float) -> None:
        """Forgets what the bodies of a world did, which then begin as if it had just been built.

        ``root`` is the square root of the Coulomb coefficient of every contact.
        """
        if self.moved:
            for body in self._bodies[world]:
                body.position_func = pymunk.Body.update_position
        if self._obstacles[world] or self.bodies.touching[world].any():
            for body in self._bodies[world]:
                memory.forget_contacts(body)
        for obstacle in self._obstacles[world]:
            obstacle.friction = root

    def resize(self, world: int, size: Float) -> None:
        """Gives the boats of a world their lengths, by factors (A,) on the nominal ones."""
        changed = size != self._size[world]
        if not changed.any():
            return
        for boat in np.flatnonzero(changed).tolist():
            (shape,) = self._bodies[world][1 + boat].shapes
            shape.unsafe_set_vertices([corner * size[boat].item() for corner in self._boat])
        self._size[world] = size

    def put_obstacles(self, world: int, rows: Float) -> None:
        """Places the obstacles of a world, (M, 5) rows of ``asv_env.capsules``."""
        if (self._placed[world] == rows).all():
            return
        self._placed[world] = rows
        shortest = SHORTEST * self._params.scale
        for obstacle, (ax, ay, bx, by, radius) in zip(
            self._obstacles[world], rows.tolist(), strict=True
        ):
            if ax == bx and ay == by:
                bx += shortest
            obstacle.unsafe_set_vertices([(ax, ay), (bx, by)])
            obstacle.unsafe_set_radius(radius)
        self._spaces[world].reindex_static()


def _add_hull(space: pymunk.Space, hull: HullParams) -> pymunk.Body:
    """Adds a body at the origin, with its centre of mass amidships, and returns it."""
    body = pymunk.Body(hull.contact_mass, hull.total_inertia)
    space.add(body, *(pymunk.Poly(body, piece) for piece in _pieces(hull)))
    return body


def _pieces(hull: HullParams) -> list[polygons.Corners]:
    """Returns convex polygons that make up a hull."""
    corners = hull.corners
    if polygons.is_convex(corners):
        return [corners]
    found = autogeometry.convex_decomposition([*corners, corners[0]], 0.0)
    return [[(x, y) for x, y in piece[:-1]] for piece in found]


def _shapes(bodies: list[pymunk.Body]) -> list[Any]:
    """Returns Chipmunk's records of shapes: one of each body, then the vessel's others."""
    first = [next(iter(body.shapes)) for body in bodies]
    return [shape._shape for shape in [*first, *list(bodies[0].shapes)[1:]]]
