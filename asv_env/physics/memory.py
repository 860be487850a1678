"""What Pymunk remembers of bodies and contacts from one step to the next, read and written.

Chipmunk begins to solve a contact from the impulses of the step before.
"""

from collections.abc import Sequence
from typing import Any

import pymunk
from pymunk.batch import ffi, lib

POINT = "struct cpContact"  #: Chipmunk's record of one point of a contact
ACTIVE = 1  #: Chipmunk's state of an arbiter that was active in the step before


def put(
    body: pymunk.Body,
    x: float,
    y: float,
    heading: float,
    vx: float,
    vy: float,
    yaw_rate: float,
    mass: float,
    inertia: float,
    friction: float,
) -> None:
    """Gives a body a motion in the Space, mass, inertia, and the friction of its shape."""
    # A step of no length uses up the bias velocities, which survive a change of position.
    pymunk.Body.update_position(body, 0.0)
    body.mass, body.moment = float(mass), float(inertia)
    body.position, body.angle = (x, y), heading
    body.velocity, body.angular_velocity = (vx, vy), yaw_rate
    body.force, body.torque = (0.0, 0.0), 0.0
    for shape in body.shapes:
        shape.friction = friction


def remembered(body: pymunk.Body) -> list[float]:
    """Returns what ``put`` takes."""
    (shape,) = body.shapes
    motion = [*body.position, body.angle, *body.velocity, body.angular_velocity]
    return [*motion, body.mass, body.moment, shape.friction]


def stay(body: pymunk.Body, dt: float) -> None:
    """Leaves a body where it is: the position function of one that has moved already."""


def _address(pointer: Any) -> int:
    return int(ffi.cast("uintptr_t", pointer))


def contacts(space: pymunk.Space) -> list[tuple[int, int, bytes]]:
    """Returns the contacts of the last step: the numbers of both shapes, and Chipmunk's points."""
    number = {_address(shape._shape): index for index, shape in enumerate(space.shapes)}
    return [
        (number[_address(arbiter.a)], number[_address(arbiter.b)], _points(arbiter))
        for arbiter in space._get_arbiters()
        if arbiter.count
    ]


def _points(arbiter: Any) -> bytes:
    return bytes(ffi.buffer(arbiter.contacts, arbiter.count * ffi.sizeof(POINT)))


def put_contacts(space: pymunk.Space, contacts: Sequence[tuple[int, int, bytes]]) -> list[Any]:
    """Gives a Space the contacts of its last step, and no others.

    Returns:
        Memory that must live until the next step has read it.
    """
    known = {}
    for arbiter in space._get_arbiters():
        arbiter.count = 0
        known[frozenset((_address(arbiter.a), _address(arbiter.b)))] = arbiter
    shapes, kept = [shape._shape for shape in space.shapes], []
    for first, second, points in contacts:
        a, b = shapes[first], shapes[second]
        arbiter = known.get(frozenset((_address(a), _address(b))))
        if arbiter is None:
            arbiter = lib.cpArbiterNew(a, b)
            lib.cpSpaceAddCachedArbiter(space._space, arbiter)
        memory = ffi.new(f"{POINT}[]", len(points) // ffi.sizeof(POINT))
        ffi.buffer(memory)[:] = points
        kept.append(memory)
        arbiter.contacts, arbiter.count = memory, len(memory)
        arbiter.stamp, arbiter.state = lib.cpSpaceGetTimestamp(space._space), ACTIVE
    return kept
