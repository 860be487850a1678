"""The records that flow between the modules, without logic.

Axes: ``W`` worlds, ``A`` boats, ``B = 1 + A`` bodies (row 0 is the vessel), ``K`` features.
SI units; headings in radians, counter-clockwise from +x, wrapped to (-pi, pi].
"""

from dataclasses import dataclass, field
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.floating[Any]]
Complex = NDArray[np.complexfloating[Any, Any]]
Int = NDArray[np.int64]
Bool = NDArray[np.bool_]
Action = NDArray[np.float32]
Observation = NDArray[np.float32]
Frame = NDArray[np.uint8]  #: a picture (height, width, 3), red, green and blue

Record = TypeVar("Record")


def rows(record: Record, index: Any) -> Record:
    """Returns the record of some worlds: every array indexed along ``W``."""
    return type(record)(**{name: array[index] for name, array in vars(record).items()})


def copied(record: Record) -> Record:
    """Returns the same record with arrays of its own."""
    return type(record)(**{name: array.copy() for name, array in vars(record).items()})


def put_rows(record: Record, index: Any, new: Record) -> None:
    """Overwrites some worlds of a record, in place."""
    for name, array in vars(record).items():
        array[index] = getattr(new, name)


@dataclass
class State:
    """The true state of every world: all that persists from one control tick to the next.

    Attributes:
        motion: (W, B, 6) x m, y m, heading rad, vx m/s, vy m/s, yaw rate rad/s; world frame.
        goal: (W, 3) goal pose of the vessel; m, m, rad.
        tick: (W,) control ticks since the episode began.
        thrust: (W, A, 2) present thrust of the left and right thruster, N.
        working: (W, A) whether the boat's thrusters work.
        slot: (W, A) vessel-frame position u + iw of the boat's slot, m.
        side: (W,) +1 where the team pushes from the vessel's +n side, -1 from the other.
        touching: (W, A, 2) whether the hull touches the vessel, another boat.
        closed: (W,) whether conditional closure has been formed and not lost since.
        occupied_ticks: (W,) control ticks for which every slot has been occupied without a break.
        anchored: (W,) whether the goal is final, see ``TaskParams.goal_anchor``.
    """

    motion: Float
    goal: Float
    tick: Int
    thrust: Float
    working: Bool
    slot: Complex
    side: Float
    touching: Bool
    closed: Bool
    occupied_ticks: Int
    anchored: Bool


@dataclass
class Sensed:
    """What the boats, and policies, know: one measurement and one estimate, shared by the team.

    Without noise all motions are the true one.

    Attributes:
        measured: (W, B, 6) the latest raw measurement, as ``State.motion``.
        estimate: (W, B, 6) the filtered motion; observations are computed from it.
        goal, tick, working, slot, side, touching, closed, anchored: as in ``State``.
    """

    measured: Float
    estimate: Float
    goal: Float
    tick: Int
    working: Bool
    slot: Complex
    side: Float
    touching: Bool
    closed: Bool
    anchored: Bool


@dataclass
class InitialState:
    """Initial state of one world: sampled by ``tasks.starts``, placed by the simulation.

    Attributes:
        motion: (B, 6) initial motion.
        goal: (3,) goal pose; relative to the vessel at closure if ``goal_anchor="closure"``.
        side: +1.0 or -1.0, the side of the vessel that is pushed.
        thrust_gain: (A, 2) factor on the thrust of each motor.
        lag: time constant of the thrusters, s.
        drag_gain: (B,) factor on all drag coefficients of a body.
        mass_gain: (B,) factor on mass and inertia of a body.
        friction: contact friction coefficient.
        failure_tick: (A,) control tick at which the boat's thrusters fail; -1 never.
    """

    motion: Float
    goal: Float
    side: float
    thrust_gain: Float
    lag: float
    drag_gain: Float
    mass_gain: Float
    friction: float
    failure_tick: Int


@dataclass
class Ending:
    """Whether and why episodes end, each (W,) bool.

    Attributes:
        reached, strayed, timed_out: causes; ``strayed`` is leaving the arena.
        terminated: episodes that ended by what happened in them: success or leaving the arena.
        truncated: episodes that ended by the clock alone.
    """

    reached: Bool
    strayed: Bool
    timed_out: Bool

    def __post_init__(self) -> None:
        self.terminated: Bool = self.reached | self.strayed
        self.truncated: Bool = self.timed_out > self.terminated


@dataclass
class TimeStep:
    """Result of one control step.

    Attributes:
        observation: (W, A, K) float32.
        reward: (W, A).
        ending: whether and why episodes end at this step.
        terms: weighted reward terms by name, (W, 1) shared or (W, A) for each boat.
    """

    observation: Observation
    reward: Float
    ending: Ending
    terms: dict[str, Float] = field(default_factory=dict)
