"""The loop that advances worlds: water, motors and autopilots of all hulls, then Pymunk's step.

Pymunk knows one mass of a hull and moves it by forces. So each hull gets the force by which its
velocity after the step, but for contact, is that of the manoeuvring model. Pymunk first moves the
hulls by their velocities and then changes these. So a velocity belongs to the middle of the next
step (the leapfrog scheme): it is seen from the heading, and is relative to the water, that the
hull will have there. Without contact this is exact to the second order of the step.
"""

import math
from typing import NamedTuple

import numpy as np

from asv_env.compiled import Bound, allocating, compiled
from asv_env.geometry import cos_sin, wrapped
from asv_env.physics import native
from asv_env.physics.autopilot import Axis, effort, referred
from asv_env.physics.exchange import IDS, RECORD, Fields
from asv_env.physics.hull import Hulls, advanced
from asv_env.physics.native import (
    EACH_CONTACT,
    MOVE,
    READ_CONTACT,
    REINDEX,
    SET_ANGLE,
    SET_FRICTION,
    SET_MASS,
    SET_MOMENT,
    STEP,
)
from asv_env.physics.shelter import Cover, shelter
from asv_env.physics.thrusters import Drive, Motors, allocated, driven, signal_for
from asv_env.physics.water import STILL, Flow, velocity
from asv_env.types import Bool, Float, Int

WORD = 8  #: bytes of a number
LINE = 64  #: bytes in which memory is fetched
SPACE, SHAPE = 1024, 576  #: bytes of Chipmunk's records of a Space, with a table, and of a shape


class Wires(NamedTuple):
    """Connections of the worlds to their Spaces; ``T`` threads have their own requests."""

    functions: Int  #: ``native.FUNCTIONS``
    space: Int  #: (W,) addresses of the Spaces
    body: Int  #: (W, B) addresses of the hulls
    shape: Int  #: (W, S) addresses of a shape of each hull (B), then of the vessel's other shapes
    fields: Fields  #: where a hull's numbers are
    body_id: Int  #: (W, B) Pymunk's numbers of the hulls
    contact: Int  #: (T,) addresses of the requests for contacts
    impulse_count: np.ndarray  #: (T, 4) int32, column 0 counts the numbers in ``impulse``
    id_count: np.ndarray  #: (T, 4) int32, column 0 counts the numbers in ``contact_id``
    impulse: Float  #: (T, n) receives x and y of the impulse of each contact, N s
    contact_id: Int  #: (T, k) receives both bodies' numbers and the number of points


class Plant(NamedTuple):
    """Everything that acts on the hulls."""

    per_step: Float  #: (W, B, 2) mass and inertia that Pymunk knows over a step, kg/s, kg m^2/s
    hulls: Hulls
    motors: Motors
    drive: Drive
    surge: Axis
    yaw: Axis
    reference: Float  #: (W, A, 2) reference of the autopilots, m/s and rad/s
    flow: Flow
    gust: Float  #: (W, 2) velocity that gusts add to the flow, m/s
    cover: Cover
    dt: float  #: duration of a physics step, s
    tracking: bool  #: whether actions are set-points of the autopilot, else signals of the motors


class Bodies(NamedTuple):
    """Motion of the hulls and what they feel."""

    motion: Float  #: (W, B, 6) world frame; headings are not wrapped
    direction: Float  #: (W, B, 2) cosine and sine of the headings
    touching: Bool  #: (W, A, 2) whether a hull touches the vessel, another boat or an obstacle
    contact_force: Float  #: (W, A) mean force between boat and vessel in the steps, N
    aground: Bool  #: (W,) whether the vessel touches an obstacle


@compiled
def steered(
    plant: Plant, world: int, boat: int, speed: float, yaw_rate: float, action: Float, works: bool
) -> tuple[float, float, float]:
    """Advances autopilot and motors of a boat by a step; returns the motors' wrench.

    ``speed`` over ground ahead, m/s, and ``yaw_rate``, rad/s, are those of the boat; ``action`` is
    that of all boats (W, A, 2).
    """
    left, right = 0.0, 0.0
    if not works:
        plant.reference[world, boat, 0], plant.reference[world, boat, 1] = speed, yaw_rate
    elif plant.tracking:
        ahead, turning = action[world, boat, 0], action[world, boat, 1]
        surge, yaw, dt = plant.reference[world, boat, 0], plant.reference[world, boat, 1], plant.dt
        surge, acceleration = referred(surge, ahead, plant.surge, dt)
        force = effort(speed, surge, acceleration, plant.surge)
        yaw, acceleration = referred(yaw, turning, plant.yaw, dt)
        moment = effort(yaw_rate, yaw, acceleration, plant.yaw)
        plant.reference[world, boat, 0], plant.reference[world, boat, 1] = surge, yaw
        port, starboard = allocated(force, moment, plant.drive)
        left, right = signal_for(port, plant.drive), signal_for(starboard, plant.drive)
    else:
        left, right = action[world, boat, 0], action[world, boat, 1]
    return driven(plant.motors, plant.drive, world, boat, left, right)


@compiled
def push(
    plant: Plant,
    bodies: Bodies,
    wires: Wires,
    world: int,
    action: Float,
    working: Bool,
    factors: Float,
) -> None:
    """Puts the wrench of the next step on all hulls of a world."""
    dt, fields = plant.dt, wires.fields
    if plant.cover.share > 0.0:
        shelter(plant.cover, bodies.motion[world], factors)
    gust_x, gust_y = plant.gust[world, 0], plant.gust[world, 1]
    for body in range(wires.body.shape[1]):
        x, y = bodies.motion[world, body, 0], bodies.motion[world, body, 1]
        vx, vy = bodies.motion[world, body, 3], bodies.motion[world, body, 4]
        r = bodies.motion[world, body, 5]
        e, f = bodies.direction[world, body, 0], bodies.direction[world, body, 1]
        c, s = cos_sin(0.5 * dt * r)
        cos, sin = e * c - f * s, f * c + e * s
        wx, wy = velocity(plant.flow, x + 0.5 * dt * vx, y + 0.5 * dt * vy)
        wx, wy = wx + gust_x, wy + gust_y
        u, v = cos * (vx - wx) + sin * (vy - wy), cos * (vy - wy) - sin * (vx - wx)
        force = 0.0, 0.0, 0.0
        if body > 0:
            boat, speed = body - 1, cos * vx + sin * vy
            force = steered(plant, world, boat, speed, r, action, working[world, boat])
        hidden = factors[body, 0], factors[body, 1]
        u, v, turn_rate, c, s = advanced(u, v, r, force, plant.hulls, world, body, hidden, dt)
        if plant.flow.kind != STILL:
            wx, wy = velocity(plant.flow, x + 1.5 * dt * vx, y + 1.5 * dt * vy)
            wx, wy = wx + gust_x, wy + gust_y
        cos, sin = cos * c - sin * s, sin * c + cos * s
        mass, inertia = plant.per_step[world, body, 0], plant.per_step[world, body, 1]
        hull = wires.body[world, body]
        native.store(hull + fields.force, mass * (wx + cos * u - sin * v - vx))
        native.store(hull + fields.force + WORD, mass * (wy + sin * u + cos * v - vy))
        native.store(hull + fields.torque, inertia * (turn_rate - r))


@compiled
def row_of(body_id: Int, number: int) -> int:
    """Returns the row of Pymunk's number of a body; -1 of one that is no hull."""
    guess = number - body_id[0]  # The numbers of a world usually follow each other.
    if 0 <= guess < len(body_id) and body_id[guess] == number:
        return guess
    for row in range(len(body_id)):
        if body_id[row] == number:
            return row
    return -1


@compiled
def feel(wires: Wires, bodies: Bodies, world: int, thread: int, share: float) -> None:
    """Reads a world's contacts of the last step into ``touching`` and ``contact_force``.

    ``share`` is what turns an impulse, N s, into its part of the mean force, N.
    """
    wires.impulse_count[thread, 0] = wires.id_count[thread, 0] = 0
    each, visitor = wires.functions[EACH_CONTACT], wires.functions[READ_CONTACT]
    native.visit(each, wires.space[world], visitor, wires.contact[thread])
    found, impulse = wires.contact_id[thread], wires.impulse[thread]
    touching, body_id = bodies.touching[world], wires.body_id[world]
    touching[:] = bodies.aground[world] = False
    for k in range(wires.id_count[thread, 0] // IDS):
        if found[IDS * k + 2] == 0:
            continue
        a, b = row_of(body_id, found[IDS * k]), row_of(body_id, found[IDS * k + 1])
        if a > 0:
            touching[a - 1, int(b != 0)] = True
        if b > 0:
            touching[b - 1, int(a != 0)] = True
        if a * b == 0 and a + b > 0:
            size = math.hypot(impulse[2 * k], impulse[2 * k + 1])
            bodies.contact_force[world, a + b - 1] += share * size
        elif a + b < 0:
            bodies.aground[world] = True  # The vessel's row is 0, that of an obstacle -1.


@compiled
def read(wires: Wires, bodies: Bodies, world: int) -> None:
    """Reads the motion of a world's hulls."""
    fields = wires.fields
    for body in range(wires.body.shape[1]):
        hull = wires.body[world, body]
        bodies.motion[world, body, 0] = native.load(hull + fields.position)
        bodies.motion[world, body, 1] = native.load(hull + fields.position + WORD)
        bodies.motion[world, body, 2] = native.load(hull + fields.heading)
        bodies.motion[world, body, 3] = native.load(hull + fields.velocity)
        bodies.motion[world, body, 4] = native.load(hull + fields.velocity + WORD)
        bodies.motion[world, body, 5] = native.load(hull + fields.yaw_rate)
        bodies.direction[world, body, 0] = native.load(hull + fields.direction)
        bodies.direction[world, body, 1] = native.load(hull + fields.direction + WORD)


@compiled
def put(wires: Wires, world: int, hulls: Float) -> None:
    """Gives the hulls of a world what ``memory.remembered`` tells of them, (B, 9)."""
    functions, fields = wires.functions, wires.fields
    for body in range(len(hulls)):
        hull = wires.body[world, body]
        # A step of no length uses up the bias velocities, which survive a change of position.
        native.give(functions[MOVE], hull, 0.0)
        native.store(hull + fields.position, hulls[body, 0])
        native.store(hull + fields.position + WORD, hulls[body, 1])
        native.give(functions[SET_ANGLE], hull, hulls[body, 2])
        native.store(hull + fields.velocity, hulls[body, 3])
        native.store(hull + fields.velocity + WORD, hulls[body, 4])
        native.store(hull + fields.yaw_rate, hulls[body, 5])
        native.store(hull + fields.force, 0.0)
        native.store(hull + fields.force + WORD, 0.0)
        native.store(hull + fields.torque, 0.0)
        native.give(functions[SET_MASS], hull, hulls[body, 6])
        native.give(functions[SET_MOMENT], hull, hulls[body, 7])
        native.give(functions[SET_FRICTION], wires.shape[world, body], hulls[body, 8])
    for shape in range(len(hulls), wires.shape.shape[1]):
        native.give(functions[SET_FRICTION], wires.shape[world, shape], hulls[0, 8])


@allocating
def begin(world: int, hulls: Float, gain: Float, keep: float, bound: Bound) -> None:
    """Puts the hulls of a world where they begin an episode, motors off.

    The autopilots' references are the boats' motion.

    Args:
        world: number of the world.
        hulls: (B, 9) what ``put`` takes.
        gain: (A, 2) factors on the thrust.
        keep: share of a signal's distance from the wanted one that a step leaves.
        bound: ``Plant``, ``Bodies`` and ``Wires``.
    """
    plant, bodies, wires = bound.content
    motors = plant.motors
    put(wires, world, hulls)
    for body in range(len(hulls)):
        native.call(wires.functions[REINDEX], wires.space[world], wires.body[world, body])
        plant.per_step[world, body, 0] = hulls[body, 6] / plant.dt
        plant.per_step[world, body, 1] = hulls[body, 7] / plant.dt
    read(wires, bodies, world)
    motors.keep[world] = keep
    for boat in range(len(gain)):
        motion = hulls[boat + 1]
        ahead = motion[3] * math.cos(motion[2]) + motion[4] * math.sin(motion[2])
        plant.reference[world, boat, 0], plant.reference[world, boat, 1] = ahead, motion[5]
        for side in range(2):
            motors.signal[world, boat, side] = motors.thrust[world, boat, side] = 0.0
            motors.gain[world, boat, side] = gain[boat, side]


@compiled
def ask(place: int, size: int) -> None:
    """Asks for so many bytes at an address."""
    for line in range(place, place + size, LINE):
        native.prefetch(line)


@compiled
def fetch(wires: Wires, world: int) -> None:
    """Asks for the memory of a world, which is far away when there are many."""
    ask(wires.space[world], SPACE)
    for body in range(wires.body.shape[1]):
        ask(wires.body[world, body], RECORD)
    for shape in range(wires.shape.shape[1]):
        ask(wires.shape[world, shape], SHAPE)


@compiled
def copy(bodies: Bodies, world: int, motion: Float) -> None:
    """Copies the motion of a world's hulls to (W, B, 6), headings wrapped."""
    for body in range(motion.shape[1]):
        for k in range(motion.shape[2]):
            motion[world, body, k] = bodies.motion[world, body, k]
        motion[world, body, 2] = wrapped(bodies.motion[world, body, 2])


@allocating
def advance(
    first: int,
    last: int,
    thread: int,
    steps: int,
    share: float,
    action: Float,
    working: Bool,
    bound: Bound,
    motion: Float,
) -> None:
    """Advances worlds ``first`` to ``last - 1`` by some physics steps under one action.

    Args:
        first: first world.
        last: world after the last one.
        thread: number of the thread, for what it needs alone.
        steps: number of physics steps.
        share: factor that turns an impulse, N s, into its part of the mean contact force, N.
        action: (W, A, 2) in [-1, 1].
        working: (W, A) boats whose thrusters answer.
        bound: ``Plant``, ``Bodies`` and ``Wires``; contact forces are added to what is there.
        motion: (W, B, 6) receives the motion after the steps, headings wrapped.
    """
    plant, bodies, wires = bound.content
    factors = np.ones((working.shape[1] + 1, 2))
    for world in range(first, last):
        if world + 1 < last:
            fetch(wires, world + 1)
        for _ in range(steps):
            push(plant, bodies, wires, world, action, working, factors)
            native.give(wires.functions[STEP], wires.space[world], plant.dt)
            read(wires, bodies, world)
            feel(wires, bodies, world, thread, share)
        copy(bodies, world, motion)
