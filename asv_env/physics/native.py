"""Calls of Pymunk's C functions from compiled code, by their addresses.

Addresses are arguments and no constants, so that compiled code can be kept on disk. A pointer is
passed as an integer of its size.
"""

from typing import Any

from llvmlite import ir
from numba import extending, types
from pymunk.batch import ffi, lib


def address(name: str) -> int:
    """Returns the address of one of Pymunk's C functions."""
    return int(ffi.cast("uintptr_t", ffi.addressof(lib, name)))


intrinsic: Any = extending.intrinsic  # Its type says nothing of the functions that it makes.
NAMES = (
    # void(space or body or shape, double)
    *("cpSpaceStep", "cpBodyUpdatePosition", "cpBodySetMass", "cpBodySetMoment"),
    *("cpBodySetAngle", "cpShapeSetFriction"),
    "cpSpaceReindexShapesForBody",  # void(space, body)
    "cpSpaceEachCachedArbiter",  # void(space, visitor, data), for each contact
    "pmSpaceArbiterIteratorFuncBatched",  # such a visitor
)  #: names of Chipmunk's and Pymunk's C functions
(STEP, MOVE, SET_MASS, SET_MOMENT, SET_ANGLE, SET_FRICTION,
 REINDEX, EACH_CONTACT, READ_CONTACT) = range(len(NAMES))  # fmt: skip
FUNCTIONS = [address(name) for name in NAMES]  #: their addresses


def _call(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    function, *others = arguments
    kind = ir.FunctionType(ir.VoidType(), [argument.type for argument in others])
    builder.call(builder.inttoptr(function, kind.as_pointer()), others)
    return context.get_dummy_value()


@intrinsic
def give(typing: Any, function: Any, record: Any, number: Any) -> Any:
    """Calls a function of a record and a number, such as ``cpSpaceStep``."""
    return types.void(types.intp, types.intp, types.float64), _call


@intrinsic
def call(typing: Any, function: Any, record: Any, other: Any) -> Any:
    """Calls a function of two records."""
    return types.void(types.intp, types.intp, types.intp), _call


@intrinsic
def visit(typing: Any, function: Any, space: Any, visitor: Any, data: Any) -> Any:
    """Lets a visitor copy fields of all contacts of a Space, as ``data`` asks for."""
    return types.void(types.intp, types.intp, types.intp, types.intp), _call


def _double(builder: Any, place: Any) -> Any:
    return builder.inttoptr(place, ir.DoubleType().as_pointer())


@intrinsic
def load(typing: Any, place: Any) -> Any:
    """Returns the number at an address."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.load(_double(builder, arguments[0]))

    return types.float64(types.intp), generate


@intrinsic
def store(typing: Any, place: Any, number: Any) -> Any:
    """Writes a number to an address."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        builder.store(arguments[1], _double(builder, arguments[0]))
        return context.get_dummy_value()

    return types.void(types.intp, types.float64), generate


@intrinsic
def prefetch(typing: Any, place: Any) -> Any:
    """Asks for the memory at an address, which will be needed soon."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        pointer, number = ir.IntType(8).as_pointer(), ir.IntType(32)
        kind = ir.FunctionType(ir.VoidType(), [pointer, number, number, number])
        function = builder.module.declare_intrinsic("llvm.prefetch", [pointer], kind)
        place = builder.inttoptr(arguments[0], pointer)
        builder.call(function, [place, number(0), number(3), number(1)])
        return context.get_dummy_value()

    return types.void(types.intp), generate
