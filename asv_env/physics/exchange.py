"""Requests by which Pymunk's C code copies fields of bodies and contacts from and to arrays."""

import numpy as np
from pymunk.batch import ArbiterFields, BodyFields, ffi

from asv_env.types import Float, Int

MOTION = BodyFields.POSITION | BodyFields.ANGLE | BodyFields.VELOCITY | BodyFields.ANGULAR_VELOCITY
WRENCH = BodyFields.FORCE | BodyFields.TORQUE
CONTACT = (
    ArbiterFields.BODY_A_ID
    | ArbiterFields.BODY_B_ID
    | ArbiterFields.TOTAL_IMPULSE
    | ArbiterFields.CONTACT_COUNT
)
IDS = 3  #: whole numbers of a contact: both bodies, number of points
SLACK = 4  #: numbers that must stay free: Pymunk replaces an array by its own before it is full


class Requests:
    """One request a row: the fields asked for, and the arrays that they are copied from or to.

    Args:
        fields: ``MOTION``, ``WRENCH`` or ``CONTACT``.
        floats: (rows, n) contiguous, the last ``SLACK`` unused.
        ints: (rows, k) contiguous, as ``floats``; None where nothing whole is asked for.
    """

    def __init__(
        self, fields: BodyFields | ArbiterFields, floats: Float, ints: Int | None = None
    ) -> None:
        count = len(floats)
        ints = np.zeros((count, SLACK + 1), dtype=np.int64) if ints is None else ints
        records = ffi.new("pmBatchedData[]", count)
        float_arrays = ffi.new("pmFloatArray[]", count)
        int_arrays = ffi.new("pmIntArray[]", count)
        for row in range(count):
            for arrays, numbers, kind in (
                (float_arrays, floats, "double *"),
                (int_arrays, ints, "uintptr_t *"),
            ):
                arrays[row].arr = ffi.cast(kind, numbers[row].ctypes.data)
                arrays[row].max = numbers.shape[1]
            records[row].fields = fields.value
            records[row].floatArray = ffi.addressof(float_arrays, row)
            records[row].intArray = ffi.addressof(int_arrays, row)
        self._alive = records, float_arrays, int_arrays, floats, ints
        #: (rows,) addresses of the requests
        self.address = _addresses(records, count)
        #: (rows, 4) int32; column 0 counts the floats copied, and is set to 0 before a call
        self.floats_copied = _counters(float_arrays, count)
        #: (rows, 4) int32; column 0 counts the whole numbers copied
        self.ints_copied = _counters(int_arrays, count)


def _addresses(records: object, count: int) -> Int:
    first, size = int(ffi.cast("uintptr_t", records)), ffi.sizeof("pmBatchedData")
    return first + size * np.arange(count, dtype=np.int64)


def _counters(arrays: object, count: int) -> np.ndarray:
    return np.frombuffer(ffi.buffer(arrays), dtype=np.int32).reshape(count, 4)
