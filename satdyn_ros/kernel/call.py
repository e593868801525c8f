"""
Memory by its addresses in compiled functions, and calls of traced code.

Code that takes addresses in place of arrays compiles in a fraction of the time.
"""

from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic


def _pointer(kind: types.Type) -> Callable[..., Any]:
    """Return what makes a pointer of an address, to be indexed as an array is, unchecked."""

    @intrinsic
    def pointer(typing, address):
        pointer_type = types.CPointer(kind)

        def generate(context, builder, signature, values):
            return builder.inttoptr(values[0], context.get_value_type(pointer_type))

        return pointer_type(types.intp), generate

    return pointer


# Of an address, the floats or the integers there.
floats, integers = _pointer(types.float64), _pointer(types.int64)


@intrinsic
def call(typing: Any, address: types.Type, table: types.Type) -> Any:
    """Call the function at an address with that of a table of the addresses of its arrays."""

    def generate(context, builder, signature, values):
        word = ir.IntType(64)
        kind = ir.FunctionType(ir.VoidType(), [word])
        builder.call(builder.inttoptr(values[0], kind.as_pointer()), [values[1]])
        return context.get_dummy_value()

    return types.void(types.intp, types.intp), generate
