"""Which boat goes to which target."""

from collections.abc import Callable

from asv_env.tasks.formation import assign
from asv_env.types import Bool, Complex

Assignment = Callable[[Complex, Complex, Bool, Complex], Complex]
"""Function from boats (W, A), slots (W, A), which boats work (W, A) and the last targets (W, A; NaN
before the first) to targets (W, A); positions in the vessel's frame, m."""


def nearest(boat: Complex, slot: Complex, working: Bool, last: Complex) -> Complex:
    """Assigns the targets with the least total distance, whatever the last ones were.

    The paper re-attributes targets to the nearest boats at every tick. It does not say what
    happens where two targets have the same nearest boat. With the least total distance no two
    straight paths cross. A boat that does not work keeps its own slot.
    """
    del last
    target = slot.copy()
    for world, works in enumerate(working):
        points = slot[world, works]
        target[world, works] = points[assign(boat[world, works], points)]
    return target
