"""What the team under the paper's controller remembers from tick to tick."""

from dataclasses import dataclass

import numpy as np

from asv_env.types import Bool, Complex, Float, Int

FAR_AWAY = 1e6  #: distance of the circle's centre before any arc is planned, m


@dataclass
class Memory:
    """State of the controller; every array has the worlds as its first axis."""

    target: Complex  #: (W, A) slot assigned to each boat, vessel frame, m; NaN before the first
    turn_direction: Int  #: (W, A) D of each boat for that target
    pushing: Bool  #: (W,) whether the push has begun
    motors_off: Bool  #: (W,) whether the motors are off for good
    goal: Complex  #: (W,) position where the arcs end, m
    centre: Complex  #: (W, 2) centres of the two circles, m
    rho: Float  #: (W, 2) positions of the centres along the vessel's +x axis, m
    length: Float  #: (W, 2) lengths of the arcs, m
    arc: Int  #: (W,) index of the arc that the vessel is on, 0 or 1
    travelled: Float  #: (W,) path length round the first centre, m
    last_position: Complex  #: (W,) position of the vessel at the last tick, m
    wheels: Float  #: (W, A, 2) left and right wheel speed commanded at the last tick, m/s


def blank_memory(worlds: int, team: int) -> Memory:
    """Returns the memory at the start of episodes: no targets, no arcs, the wheels at rest."""
    return Memory(
        target=np.full((worlds, team), np.nan, dtype=np.complex128),
        turn_direction=np.zeros((worlds, team), dtype=np.int64),
        pushing=np.zeros(worlds, dtype=np.bool_),
        motors_off=np.zeros(worlds, dtype=np.bool_),
        goal=np.zeros(worlds, dtype=np.complex128),
        centre=np.full((worlds, 2), FAR_AWAY, dtype=np.complex128),
        rho=np.full((worlds, 2), FAR_AWAY),
        length=np.zeros((worlds, 2)),
        arc=np.zeros(worlds, dtype=np.int64),
        travelled=np.zeros(worlds),
        last_position=np.zeros(worlds, dtype=np.complex128),
        wheels=np.zeros((worlds, team, 2)),
    )
