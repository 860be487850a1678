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
FUNCTIONS = [
    address("cpSpaceStep"),  # void(space, double dt)
    address("cpSpaceEachBody"),  # void(space, visitor, data)
    address("cpSpaceEachCachedArbiter"),  # void(space, visitor, data), for each contact
    address("pmSpaceBodyGetIteratorFuncBatched"),
    address("pmSpaceBodySetIteratorFuncBatched"),
    address("pmSpaceArbiterIteratorFuncBatched"),
]
"""Addresses of Pymunk's C functions: three that take a Space, then three visitors of these."""
STEP, EACH_BODY, EACH_CONTACT, READ_BODY, WRITE_BODY, READ_CONTACT = range(len(FUNCTIONS))


def _call(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    function, *others = arguments
    kind = ir.FunctionType(ir.VoidType(), [argument.type for argument in others])
    builder.call(builder.inttoptr(function, kind.as_pointer()), others)
    return context.get_dummy_value()


@intrinsic
def step(typing: Any, function: Any, space: Any, dt: Any) -> Any:
    """Advances a Space by ``dt`` s; ``function`` is the address of that name."""
    return types.void(types.intp, types.intp, types.float64), _call


@intrinsic
def visit(typing: Any, function: Any, space: Any, visitor: Any, data: Any) -> Any:
    """Lets a visitor copy fields of all bodies or contacts of a Space, as ``data`` asks for."""
    return types.void(types.intp, types.intp, types.intp, types.intp), _call
