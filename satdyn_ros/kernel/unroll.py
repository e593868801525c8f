"""
Functions of tuples that are written out for every place, in compiled code.

Whether the compiler writes out a loop depends on the processor that it compiles for.  Where it
does not, a tuple that the loop goes through leaves the registers.
"""

from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import typeof, types
from numba.core import cgutils
from numba.extending import intrinsic

from .compile import inlined

_PLACE = ir.IntType(types.intp.bitwidth)


def unrolled_map(function: Callable[..., Any]) -> Any:
    """
    Compile function(i, a, ...) into one of (a, ...) that returns a tuple.

    It holds what the function returns at every place i of the tuple a.
    """
    body = inlined(function)

    def of_all(typing, *given):
        places = range(len(given[0]))
        one = _typed(body, typing, (types.intp, *given)) if places else None
        found = types.UniTuple(one.return_type, len(places)) if one else types.Tuple(())

        def generate(context, builder, signature, values):
            values = cgutils.unpack_tuple(builder, values[0])
            parts = [_call(context, builder, body, one, [_PLACE(i), *values]) for i in places]
            return context.make_tuple(builder, found, parts)

        return found(types.StarArgTuple.from_types(given)), generate

    return intrinsic(of_all)


def unrolled_fold(function: Callable[..., Any]) -> Any:
    """
    Compile function(total, i, a, ...) into one of (total, a, ...) that returns the last total.

    It goes on from one total to the next, at every place i of the tuple a.
    """
    body = inlined(function)

    def to_the_last(typing, *given):
        total, *rest = given
        places = range(len(rest[0]))
        one = _typed(body, typing, (total, types.intp, *rest)) if places else None

        def generate(context, builder, signature, values):
            total, *rest = cgutils.unpack_tuple(builder, values[0])
            for i in places:
                total = _call(context, builder, body, one, [total, _PLACE(i), *rest])
            return total

        return total(types.StarArgTuple.from_types(given)), generate

    return intrinsic(to_the_last)


def fold_by_type(function_of: Callable[[type], Any]) -> Any:
    """
    Return a compiled function of (total, a, ...) that returns the last total.

    a is a tuple of named tuples, perhaps unlike ones.  For each of them, function_of its class is
    the compiled function that goes on, which takes (total, ..., the named tuple); None: the total
    stays as it is.
    """

    def to_the_last(typing, *given):
        total, kinds, *rest = given
        steps = []
        for i, kind in enumerate(kinds):
            body = function_of(kind.instance_class)
            if body is not None:
                step = _typed(body, typing, (total, *rest, kind))
                steps.append((i, body, step))
                total = step.return_type

        def generate(context, builder, signature, values):
            total, parts, *rest = cgutils.unpack_tuple(builder, values[0])
            for i, body, step in steps:
                part = builder.extract_value(parts, i)
                total = _call(context, builder, body, step, [total, *rest, part])
            return total

        return total(types.StarArgTuple.from_types(given)), generate

    return intrinsic(to_the_last)


def by_type(of_tuple: Callable[..., Any], of_number: Callable[..., Any]) -> Any:
    """Compile two functions into one: which it is depends on the type of the first argument."""
    bodies = inlined(of_tuple), inlined(of_number)

    def fitting(typing, *given):
        body = bodies[0 if isinstance(given[0], types.BaseTuple) else 1]
        one = _typed(body, typing, given)

        def generate(context, builder, signature, values):
            return _call(context, builder, body, one, cgutils.unpack_tuple(builder, values[0]))

        return one.return_type(types.StarArgTuple.from_types(given)), generate

    return intrinsic(fitting)


def _typed(body, typing, given):
    """Return the signature of a compiled function for the types that it is given."""
    return typeof(body).get_call_type(typing, given, {})


def _call(context, builder, body, signature, values):
    return context.get_function(typeof(body), signature)(builder, values)
