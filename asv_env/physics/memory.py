"""What Pymunk remembers of bodies and contacts from one step to the next.

Chipmunk begins to solve a contact from the impulses of the step before.
"""

from typing import Any

import pymunk
from pymunk.batch import ffi

POINT = "struct cpContact"  #: Chipmunk's record of one point of a contact
Contacts = dict[frozenset[int], bytes]
"""Contacts of a Space: Chipmunk's points by the numbers of both shapes."""


def remembered(body: pymunk.Body) -> list[float]:
    """Returns motion (6 numbers), mass, inertia and friction of a hull; see ``kernel.put``."""
    shape = next(iter(body.shapes))  # All have the same friction.
    motion = [*body.position, body.angle, *body.velocity, body.angular_velocity]
    return [*motion, body.mass, body.moment, shape.friction]


def stay(body: pymunk.Body, dt: float) -> None:
    """Leaves a body where it is: the position function of one that has moved already."""


def forget_contacts(body: pymunk.Body) -> None:
    """Makes the next contacts of a body begin like those of one that touched nothing."""
    body.each_arbiter(_forget)


def _forget(arbiter: pymunk.Arbiter) -> None:
    arbiter._arbiter.count = 0


def contacts(space: pymunk.Space) -> Contacts:
    """Returns the contacts of the last step, by the numbers of both shapes: Chipmunk's points."""
    numbers = _numbers(space)
    return {_pair(arbiter, numbers): bytes(_points(arbiter)) for arbiter in _arbiters(space)}


def put_contacts(space: pymunk.Space, contacts: Contacts) -> None:
    """Gives the contacts of the last step the points of others, taken at the same poses."""
    numbers = _numbers(space)
    for arbiter in _arbiters(space):
        found, points = _points(arbiter), contacts.get(_pair(arbiter, numbers), b"")
        if len(found) == len(points):
            found[:] = points
        else:
            arbiter.count = 0  # It counts as new.


def _arbiters(space: pymunk.Space) -> list[Any]:
    """Returns Chipmunk's records of pairs that touch."""
    return [arbiter for arbiter in space._get_arbiters() if arbiter.count]


def _points(arbiter: Any) -> Any:
    """Returns the memory in which the points of a contact are."""
    return ffi.buffer(arbiter.contacts, arbiter.count * ffi.sizeof(POINT))


def _numbers(space: pymunk.Space) -> dict[Any, int]:
    return {shape._shape: number for number, shape in enumerate(space.shapes)}


def _pair(arbiter: Any, numbers: dict[Any, int]) -> frozenset[int]:
    return frozenset((numbers[arbiter.a], numbers[arbiter.b]))
