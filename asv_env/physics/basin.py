"""Rigid bodies with contact, many worlds at once. The only user of Pymunk.

Worlds share Spaces, each world on a tile of its own, too far from the others to touch them.
World 0 of every Space lies at the origin. Bodies are made once and then placed, never removed:
``pymunk.batch`` reads them in the order in which they were added.
"""

import math
from dataclasses import dataclass
from itertools import chain

import numpy as np
import pymunk
from pymunk import batch
from pymunk.batch import ArbiterFields, BodyFields, Buffer, ffi, lib

from asv_env.params import EnvParams, HullParams
from asv_env.physics import memory
from asv_env.types import Bool, Float

MOTION = BodyFields.POSITION | BodyFields.ANGLE | BodyFields.VELOCITY | BodyFields.ANGULAR_VELOCITY
WRENCH = BodyFields.FORCE | BodyFields.TORQUE
CONTACT = ArbiterFields.BODY_A_ID | ArbiterFields.BODY_B_ID | ArbiterFields.CONTACT_COUNT
READER, WRITER = "pmSpaceBodyGetIteratorFuncBatched", "pmSpaceBodySetIteratorFuncBatched"
WALL_THICKNESS = 0.5  #: thickness of a wall, m
CELLS_PER_BODY = 200  #: size of the spatial hash table; enough for some hundred worlds


class _Transfer:
    """Copies fields of all bodies of a Space from or to an array, in the order of their adding.

    It does what ``pymunk.batch`` does, but makes the request once and not at every call: for few
    worlds making it costs more than the physics. ``rows`` (bodies or more, fields) is contiguous,
    ``visitor`` names the function in Pymunk's C code that is called for each body.
    """

    def __init__(self, space: pymunk.Space, fields: BodyFields, rows: Float, visitor: str) -> None:
        buffer = Buffer()
        buffer.set_float_buf(rows.reshape(-1))
        self._alive, self._floats = (buffer, space), buffer._float_arr
        request = ffi.new("pmBatchedData *")
        request.fields = fields.value
        request.floatArray, request.intArray = buffer._float_arr, buffer._int_arr
        self._arguments = space._space, ffi.addressof(lib, visitor), request

    def __call__(self) -> None:
        self._floats.num = 0
        lib.cpSpaceEachBody(*self._arguments)


@dataclass
class _Pool:
    """One Space with some of the worlds, and the transfers to and from it."""

    space: pymunk.Space
    read: _Transfer
    write: _Transfer
    contacts: Buffer


@dataclass(frozen=True)
class BasinSnapshot:
    """All that a ``Basin`` remembers from one physics step to the next."""

    #: (W, B, 9) pose and velocity as the next step finds them, mass, inertia, friction
    bodies: Float
    motion: Float  #: (W, B, 6) motion after the last step
    contacts: list[memory.Contacts]  #: of each Space, in the last step


class Basin:
    """Bodies of ``num_worlds`` worlds, ``B = 1 + num_boats`` each, row 0 the vessel."""

    def __init__(self, params: EnvParams, num_worlds: int, worlds_per_space: int) -> None:
        self._params, self._worlds_per_space = params, worlds_per_space
        self._dt = params.clock.dt
        shape = (num_worlds, 1 + params.num_boats)
        rows = shape[0] * shape[1]
        # A Space with walls has one more body, read last: its row falls on the first row of the
        # next Space, which is read after it, or on a spare row. A second spare row is needed
        # because Pymunk replaces a buffer that has been filled by one of its own.
        self._motion_rows = np.zeros((rows + 2, 6))
        self._force_rows = np.zeros((rows + 2, 3))
        #: (W, B, 6) motion after the last step in the Space's coordinates, headings not wrapped
        self.motion = self._motion_rows[:rows].reshape(*shape, 6)
        #: (W, B, 3) world-frame force N, N and moment N m during the next step
        self.force = self._force_rows[:rows].reshape(*shape, 3)

        self._tile = np.zeros((num_worlds, 1, 2))
        self._bodies: list[list[pymunk.Body]] = []
        self._walls: list[list[pymunk.Segment]] = [[] for _ in range(num_worlds)]
        self._pools: list[_Pool] = []
        self._moved = False  # whether the bodies have made the next step's change of position
        for first in range(0, num_worlds, worlds_per_space):
            self._add_pool(range(first, min(first + worlds_per_space, num_worlds)))
        identities = np.array([body.id for bodies in self._bodies for body in bodies], np.uintp)
        self._by_identity = np.argsort(identities)
        self._identities = identities[self._by_identity]
        for pool in self._pools:
            pool.read()

    def step(self) -> None:
        """Advances every world by one physics step under ``force`` and reads ``motion``."""
        for pool in self._pools:
            pool.write()
            pool.space.step(self._dt)
            pool.read()
        if self._moved:
            self._moved = False
            for body in chain.from_iterable(self._bodies):
                body.position_func = pymunk.Body.update_position

    def snapshot(self) -> BasinSnapshot:
        """Returns all that the next steps depend on, for the simulation to copy.

        Chipmunk shows everything but the bias velocities, by which hulls that overlap move apart
        at the beginning of the next step. So the bodies make that change of position now, and
        not in the next step: the outcome is the same to the bit.
        """
        if not self._moved:
            for body in chain.from_iterable(self._bodies):
                pymunk.Body.update_position(body, self._dt)
                body.position_func = memory.stay
            self._moved = True
        bodies = [[memory.remembered(body) for body in world] for world in self._bodies]
        contacts = [memory.contacts(pool.space) for pool in self._pools]
        return BasinSnapshot(np.array(bodies), self.motion, contacts)

    def restore(self, snapshot: BasinSnapshot) -> None:
        """Continues as the basin did, with the same arguments, whose ``snapshot`` this is.

        A step in which the bodies rest where they were finds the same contacts again.
        """
        self.motion[...] = snapshot.motion
        at_rest = snapshot.bodies.copy()
        at_rest[..., :3], at_rest[..., 3:6] = snapshot.motion[..., :3], 0.0
        self._put(at_rest)
        for pool, contacts in zip(self._pools, snapshot.contacts, strict=True):
            pool.space.step(self._dt)
            memory.put_contacts(pool.space, contacts)
        self._put(snapshot.bodies)
        self._moved = True

    def _put(self, bodies: Float) -> None:
        """Gives all bodies what ``memory.remembered`` returned, (W, B, 9); they stay there."""
        for hulls, walls, rows in zip(self._bodies, self._walls, bodies, strict=True):
            for body, row in zip(hulls, rows.tolist(), strict=True):
                memory.put(body, *row)
                body.position_func = memory.stay
            for wall in walls:
                wall.friction = rows[0, -1].item()

    def world_motion(self) -> Float:
        """Returns a copy of the motion (W, B, 6) in each world's own coordinates."""
        motion = self.motion.copy()
        motion[..., :2] -= self._tile
        return motion

    def place(
        self, world: int, motion: Float, masses: Float, inertias: Float, friction: float
    ) -> None:
        """Gives the bodies of one world a motion, as if the world had just been built.

        The motion (B, 6) is in the world's own coordinates; masses (B,), kg, and inertias (B,),
        kg m^2, are effective; ``friction`` is the Coulomb coefficient of every contact.
        """
        space = self._pools[world // self._worlds_per_space].space
        tile_x, tile_y = self._tile[world, 0]
        root = math.sqrt(friction)  # Chipmunk multiplies the coefficients of the two shapes.
        for row, body in enumerate(self._bodies[world]):
            x, y, heading, vx, vy, yaw_rate = motion[row].tolist()
            pose, velocity = (x + tile_x, y + tile_y, heading), (vx, vy, yaw_rate)
            memory.put(body, *pose, *velocity, masses[row], inertias[row], root)
            body.position_func = pymunk.Body.update_position
            memory.forget_contacts(body)
            space.reindex_shapes_for_body(body)
        for wall in self._walls[world]:
            wall.friction = root
        self.motion[world] = motion
        self.motion[world, :, :2] += self._tile[world]

    def touching(self) -> Bool:
        """Returns (W, A, 2): whether each hull touches the vessel, another boat or a wall."""
        num_worlds, count = self.motion.shape[:2]
        touches = np.zeros((num_worlds, count, 2), dtype=np.bool_)
        for pool in self._pools:
            pool.contacts.clear()
            batch.get_space_arbiters(pool.space, CONTACT, pool.contacts)
            found = np.frombuffer(pool.contacts.int_buf(), dtype=np.uintp).reshape(-1, 3)
            if len(found):
                self._scatter(found[found[:, 2] > 0, :2], touches)
        return touches[:, 1:]

    def _scatter(self, pairs: np.ndarray, touches: Bool) -> None:
        """Marks the bodies of touching pairs (n, 2) in ``touches``, whatever the order of pairs."""
        count = touches.shape[1]
        index = np.searchsorted(self._identities, pairs)
        index[index == len(self._identities)] = 0
        is_hull = self._identities[index] == pairs  # all but the walls
        world, row = np.divmod(self._by_identity[index], count)
        for body, partner in ((0, 1), (1, 0)):
            hull = is_hull[:, body]
            by_vessel = is_hull[:, partner] & (row[:, partner] == 0)
            touches[world[hull, body], row[hull, body], 1 - by_vessel[hull]] = True

    def _add_pool(self, worlds: range) -> None:
        """Adds a Space with the bodies of these worlds."""
        params, count = self._params, self.motion.shape[1]
        vessel, boat = params.hulls()
        space = pymunk.Space()
        cell = vessel.length
        # The size of the table orders the contacts, so it must not depend on the other worlds.
        space.use_spatial_hash(cell, CELLS_PER_BODY * count)
        space.iterations = 10
        space.collision_slop = 1e-4
        # Contacts that have ended are forgotten at once; ``place`` forgets the others.
        space.collision_persistence = 1
        spacing, columns = self._tile_spacing(cell), math.ceil(math.sqrt(len(worlds)))
        for index, world in enumerate(worlds):
            tile = (spacing * (index % columns), spacing * (index // columns))
            self._tile[world] = tile
            if params.water.walls is not None:
                self._walls[world] = _add_walls(space, tile, params.water.walls)
            hulls = [vessel] + [boat] * params.num_boats
            self._bodies.append([_add_hull(space, tile, hull) for hull in hulls])
        first = worlds[0] * count
        read = _Transfer(space, MOTION, self._motion_rows[first:], READER)
        write = _Transfer(space, WRENCH, self._force_rows[first:], WRITER)
        self._pools.append(_Pool(space, read, write, Buffer()))

    def _tile_spacing(self, cell: float) -> float:
        """Returns the distance between tiles, m: arena, hulls across its edge, and clearance."""
        arena = max(self._params.task.arena, self._params.water.walls or 0.0)
        return cell * math.ceil((2 * arena + 4 * cell + 2 * WALL_THICKNESS + 1.0) / cell)


def _add_hull(space: pymunk.Space, tile: tuple[float, float], hull: HullParams) -> pymunk.Body:
    """Adds a body at the tile's centre, with its centre of mass amidships, and returns it."""
    body = pymunk.Body(hull.total_mass, hull.total_inertia)
    body.position = tile
    space.add(body, pymunk.Poly(body, hull.outline))
    return body


def _add_walls(space: pymunk.Space, tile: tuple[float, float], half: float) -> list[pymunk.Segment]:
    """Adds four walls whose inner sides lie ``half`` m from the tile's centre; returns them."""
    x, y = tile
    d = half + WALL_THICKNESS / 2
    corners = [(x - d, y - d), (x + d, y - d), (x + d, y + d), (x - d, y + d)]
    sides = zip(corners, corners[1:] + corners[:1], strict=True)
    walls = [pymunk.Segment(space.static_body, a, b, WALL_THICKNESS / 2) for a, b in sides]
    space.add(*walls)
    return walls
