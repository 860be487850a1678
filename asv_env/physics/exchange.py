"""Where Chipmunk keeps a body's numbers, and requests for contacts.

Bodies are read and written where they are, because a call for each of them would take as long as
the equations of motion. Chipmunk does not tell how its record of a body is laid out, so the places
are found by a trial when this module is imported.
"""

from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pymunk
from pymunk.batch import ArbiterFields, ffi

from asv_env.types import Float, Int

RECORD = 256  #: bytes of a body's record that are searched: less than it has
CONTACT = (
    ArbiterFields.BODY_A_ID
    | ArbiterFields.BODY_B_ID
    | ArbiterFields.TOTAL_IMPULSE
    | ArbiterFields.CONTACT_COUNT
)
IDS = 3  #: whole numbers of a contact: both bodies, number of points
SLACK = 4  #: numbers that must stay free: Pymunk replaces an array by its own before it is full


class Fields(NamedTuple):
    """Places of numbers in Chipmunk's record of a body, bytes from its beginning."""

    position: int  #: of x; y is the next
    direction: int  #: of the cosine of the heading; its sine is the next
    heading: int
    velocity: int  #: of x; y is the next
    yaw_rate: int
    force: int  #: of x; y is the next
    torque: int


@cache
def fields() -> Fields:
    """Returns where the numbers are that a body was just given.

    Raises:
        RuntimeError: one of them is not found, or twice.
    """
    body = pymunk.Body(3.0, 5.0)
    # The position is that of the centre of gravity; that of the body is kept elsewhere.
    body.center_of_gravity = (2.0, 4.0)
    body.position, body.angle = (11.0, 13.0), 0.7
    body.velocity, body.angular_velocity = (17.0, 19.0), 23.0
    body.force, body.torque = (29.0, 31.0), 37.0
    record = np.frombuffer(ffi.buffer(ffi.cast("char *", body._body), RECORD))
    given: tuple[Any, ...] = (
        body.local_to_world(body.center_of_gravity),
        body.rotation_vector,
        (body.angle,),
        body.velocity,
        (body.angular_velocity,),
        body.force,
        (body.torque,),
    )
    return Fields(*(_place(record, numbers) for numbers in given))


def _place(record: Float, numbers: Any) -> int:
    """Returns the place, bytes, of neighbouring numbers in a record."""
    rows = np.lib.stride_tricks.sliding_window_view(record, len(numbers))
    found = np.flatnonzero((abs(rows - np.array(numbers)) < 1e-9).all(axis=1))
    if len(found) != 1:
        raise RuntimeError(
            f"Pymunk {pymunk.version}: a number of a body was not found in its record"
        )
    return record.itemsize * int(found[0])


class Requests:
    """A request for contacts for each thread, and the arrays to which they are copied.

    Args:
        floats: (rows, n) contiguous, the last ``SLACK`` unused.
        ints: (rows, k) contiguous, as ``floats``.
    """

    def __init__(self, floats: Float, ints: Int) -> None:
        count = len(floats)
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
            records[row].fields = CONTACT.value
            records[row].floatArray = ffi.addressof(float_arrays, row)
            records[row].intArray = ffi.addressof(int_arrays, row)
        self._alive = records, float_arrays, int_arrays, floats, ints
        first, size = address(records), ffi.sizeof("pmBatchedData")
        #: (rows,) addresses of the requests
        self.address = first + size * np.arange(count, dtype=np.int64)
        #: (rows, 4) int32; column 0 counts the floats copied, and is set to 0 before a call
        self.floats_copied = _counters(float_arrays, count)
        #: (rows, 4) int32; column 0 counts the whole numbers copied
        self.ints_copied = _counters(int_arrays, count)


def address(record: object) -> int:
    """Returns the address of one of Chipmunk's records."""
    return int(ffi.cast("uintptr_t", record))


def _counters(arrays: object, count: int) -> np.ndarray:
    return np.frombuffer(ffi.buffer(arrays), dtype=np.int32).reshape(count, 4)
