"""The records that flow between the modules, without logic.

Records are values: a control tick makes new ones and leaves the old ones as they are. The truth
is read-only.

Axes: ``W`` worlds, ``A`` boats, ``B = 1 + A`` bodies (row 0 is the vessel), ``K`` features.
SI units; headings in radians, counter-clockwise from +x, wrapped to (-pi, pi].
"""

from dataclasses import dataclass, field, fields
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.floating[Any]]
Complex = NDArray[np.complexfloating[Any, Any]]
Int = NDArray[np.int64]
Bool = NDArray[np.bool_]
Action = NDArray[np.float32]
Observation = NDArray[np.float32]
Frame = NDArray[np.uint8]  #: a picture (height, width, 3), red, green and blue

DTYPES: dict[Any, Any] = {Float: np.float64, Complex: np.complex128, Int: np.int64, Bool: np.bool_}
Record = TypeVar("Record")


def zeros(kind: type[Record], *shapes: tuple[int, ...]) -> Record:
    """Returns a record of zeros whose arrays have these shapes, in the order of its fields."""
    pairs = zip(fields(cast(Any, kind)), shapes, strict=True)
    return kind(*(np.zeros(shape, DTYPES[field.type]) for field, shape in pairs))


def rows(record: Record, index: Any) -> Record:
    """Returns the record of some worlds: every array indexed along ``W``."""
    return type(record)(**{name: array[index] for name, array in vars(record).items()})


def copied(record: Record) -> Record:
    """Returns the same record with arrays of its own; records in it, or None, are copied too."""
    if record is None:
        return record
    own = {
        name: value.copy() if isinstance(value, np.ndarray) else copied(value)
        for name, value in vars(record).items()
    }
    return made(type(record), own)


def put_rows(record: Record, index: Any, new: Record) -> None:
    """Overwrites some worlds of a record, in place."""
    for name, array in vars(record).items():
        array[index] = getattr(new, name)


def frozen(record: Record) -> Record:
    """Makes the arrays of a record read-only, and returns the record."""
    for array in vars(record).values():
        array.setflags(False)  # ``write``: by name it takes four times as long
    return record


def given(array: Any, dtype: Any = np.float64) -> Any:
    """Returns an array as compiled code takes what it only reads: contiguous and read-only."""
    array = np.ascontiguousarray(array, dtype)
    if array.flags.writeable:
        array = array.view()
        array.setflags(False)
    return array


def made(kind: type[Record], values: dict[str, Any]) -> Record:
    """Returns a record of these fields, as ``kind(**values)`` does in several times the time."""
    record = object.__new__(kind)
    vars(record).update(values)
    return record


@dataclass(frozen=True)
class Standing:
    """How the teams stand round their vessels, judged by one motion; see ``tasks.standing``.

    The truth decides it for the task's judge (``State``), the estimate for the boats (``Sensed``).
    """

    slot: Complex  #: (W, A) vessel-frame position u + iw of the boat's slot, m
    occupied: Bool  #: (W, A) whether the boat occupies its slot
    closed: Bool  #: (W,) whether conditional closure has been formed and not lost since


@dataclass(frozen=True)
class Situation(Standing):
    """A standing, and what the simulation and the boats both know exactly."""

    goal: Float  #: (W, 3) goal pose of the vessel; m, m, rad
    tick: Int  #: (W,) control ticks since the episode began
    side: Float  #: (W,) +1 where the team pushes from the vessel's +n side, -1 from the other
    anchored: Bool  #: (W,) whether the goal is final, see ``TaskParams.goal_anchor``
    working: Bool  #: (W, A) whether the boat's thrusters work
    touching: Bool  #: (W, A, 2) whether the hull touches the vessel, another boat or an obstacle
    #: (W, M, 5) obstacles and walls, rows of ``asv_env.capsules``: both ends and the radius, m
    obstacle: Float


@dataclass(frozen=True)
class State(Situation):
    """The true state of every world: all that persists from one control tick to the next."""

    motion: Float  #: (W, B, 6) x m, y m, heading rad, vx m/s, vy m/s, yaw rate rad/s; world frame
    thrust: Float  #: (W, A, 2) present thrust of the left and right thruster, N
    aground: Bool  #: (W,) whether the vessel touches an obstacle
    #: (W, A) mean size of the force between boat and vessel since the last tick, N
    contact_force: Float
    gust: Float  #: (W, 2) velocity that gusts add to the current, m/s
    boat_size: Float  #: (W, A) factor on the lengths of each boat
    occupied_ticks: Int  #: (W,) control ticks for which every slot was occupied without a break
    delivered_ticks: Int  #: (W,) control ticks for which the vessel was at its goal without a break


@dataclass(frozen=True)
class Sensed(Situation):
    """What the boats, and policies, know: one measurement and one estimate, shared by the team.

    With ``SensorParams.shared=False`` each boat knows something else, and all arrays have a row for
    each: row w A + a is what boat a of world w knows, ``W`` standing for the number of rows.

    Where nothing is unseen, late, lost or noisy both motions are the true one, and the standing is
    that of the truth. Whoever receives it may write to its arrays: they are copies.
    """

    measured: Float  #: (W, B, 6) the latest raw measurement, as ``State.motion``
    estimate: Float  #: (W, B, 6) the filtered motion; observations are computed from it
    received: Bool  #: (W, B) whether the measurement is new since the previous control tick
    seen: Bool  #: (W, B) whether the body is in sight; else the estimate is dead reckoning


@dataclass
class InitialState:
    """Initial state of one world: sampled by ``tasks.starts``, placed by the simulation."""

    motion: Float  #: (B, 6) initial motion
    goal: Float  #: (3,) goal pose; relative to the vessel at closure if ``goal_anchor="closure"``
    side: float  #: +1.0 or -1.0, the side of the vessel that is pushed
    thrust_gain: Float  #: (A, 2) factor on the thrust of each motor
    lag: float  #: time constant of the thrusters, s
    drag_gain: Float  #: (B,) factor on all drag coefficients of a body
    mass_gain: Float  #: (B,) factor on mass and inertia of a body
    friction: float  #: contact friction coefficient
    #: (A,) control tick at which the boat's thrusters fail, from the beginning of the episode or
    #: from closure on (see ``VariationParams.failure_clock``); -1 never
    failure_tick: Int
    boat_size: Float | None = None  #: (A,) factor on the lengths of each boat; None takes 1
    #: (M, 5) obstacles, the walls last, as in ``State``; None takes those of the parameters
    obstacle: Float | None = None


@dataclass(frozen=True)
class Ending:
    """Whether and why episodes end, each (W,) bool."""

    reached: Bool  #: the task is done
    strayed: Bool  #: a body has left the arena
    timed_out: Bool  #: the time limit has been reached
    terminated: Bool = field(init=False)  #: ended by what happened in the episode
    truncated: Bool = field(init=False)  #: ended by the clock alone

    def __post_init__(self) -> None:
        object.__setattr__(self, "terminated", self.reached | self.strayed)
        object.__setattr__(self, "truncated", self.timed_out > self.terminated)

    def within(self, mask: Bool) -> "Ending":
        """Returns the endings of the worlds in a mask (W,), and none of the others."""
        return Ending(self.reached & mask, self.strayed & mask, self.timed_out & mask)


@dataclass(frozen=True)
class TimeStep:
    """Result of one control step."""

    observation: Observation  #: (W, A, K) float32
    reward: Float  #: (W, A)
    ending: Ending  #: whether and why episodes end at this step
    #: weighted reward terms by name, (W, 1) shared or (W, A) for each boat
    terms: dict[str, Float] = field(default_factory=dict)


@dataclass(frozen=True)
class Snapshot:
    """Everything that a ``Simulation`` remembers at one moment; see ``Simulation.snapshot``."""

    params: Any  #: parameters of the simulation
    num_worlds: int
    memory: bytes  #: pickled records, arrays and Generators
