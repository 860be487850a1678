"""The time that a simulation spends in Chipmunk's ``cpSpaceStep``, under a native stopwatch.

The compiled loop over the worlds calls Chipmunk by the address of its function. Here it gets the
address of another one, which reads the clock, calls Chipmunk's, and reads the clock again.
"""

import ctypes
from typing import Any

import numba
import numpy as np
from numba import types
from numba.extending import intrinsic

from asv_env.physics import native

BEGIN, END, SPENT, CALLS = 0, 2, 4, 5  #: places in the stopwatch's memory; times are s, ns
CLOCKS = {
    "wall": 1,
    "cpu": 3,
}  #: numbers of the clock that never goes back, and of the thread's own
TRIES, CALLS_PER_TRY = 50, 2000  #: size of the measurement of the stopwatch's own time

_clock = ctypes.CDLL(None).clock_gettime
_clock.argtypes = [ctypes.c_int, ctypes.c_size_t]
_clock.restype = ctypes.c_int


@intrinsic
def _pointer(typing: Any, address: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        kind = context.get_value_type(signature.return_type)
        return builder.inttoptr(arguments[0], kind)

    return types.CPointer(types.int64)(types.intp), generate


def _timed(function: int, memory: int, clock: int) -> Any:
    """Returns a C function that calls one of the same arguments and adds its time to memory."""

    @numba.cfunc(types.void(types.intp, types.float64))
    def call(space: int, dt: float) -> None:
        numbers = numba.carray(_pointer(memory), (6,))
        _clock(clock, memory)
        native.give(function, space, dt)
        _clock(clock, memory + 8 * END)
        seconds = numbers[END] - numbers[BEGIN]
        numbers[SPENT] += 1_000_000_000 * seconds + numbers[END + 1] - numbers[BEGIN + 1]
        numbers[CALLS] += 1

    return call


@numba.cfunc(types.void(types.intp, types.float64))
def _nothing(space: int, dt: float) -> None:
    pass


@numba.njit
def _repeated(function: int, times: int) -> None:
    for _ in range(times):
        native.give(function, 0, 0.0)


class Watch:
    """Times the calls of ``cpSpaceStep`` of a simulation, which has one thread.

    Args:
        simulation: the simulation.
        clock: "wall" or "cpu", for a busy machine; to read the latter takes longer than a step of
            Chipmunk's, which is taken off.
    """

    def __init__(self, simulation: Any, clock: str) -> None:
        self._functions = simulation._dynamics.basin.wires.functions
        self._memory = np.zeros(6, dtype=np.int64)
        address = self._memory.ctypes.data
        self._own = _timed(_nothing.address, address, CLOCKS[clock])
        self._step = _timed(native.address("cpSpaceStep"), address, CLOCKS[clock])
        self._overhead = min(self._try() for _ in range(TRIES))

    def _try(self) -> float:
        """Returns the nanoseconds that a call of nothing is charged."""
        self._memory[:] = 0
        _repeated(self._own.address, CALLS_PER_TRY)
        return float(self._memory[SPENT] / CALLS_PER_TRY)

    def start(self, on: bool) -> None:
        """Begins at zero; ``on`` tells whether calls are timed."""
        self._memory[:] = 0
        timed, plain = self._step.address, native.address("cpSpaceStep")
        self._functions[native.STEP] = timed if on else plain

    @property
    def seconds(self) -> float:
        """Time in ``cpSpaceStep`` so far, without the stopwatch's own, s."""
        spent = self._memory[SPENT] - self._overhead * self._memory[CALLS]
        return float(1e-9 * spent)
