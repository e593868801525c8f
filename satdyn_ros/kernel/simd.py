"""
Numbers side by side in the vector registers of the processor, in compiled code.

Whether the compiler makes vectors of a loop depends on the processor that it compiles for: the
same loops took up to nine times as long on one as on another.  Numbers are vectors on all.

They are added, subtracted, multiplied and divided, each with its counterpart or all with one
float; math.sqrt and abs take the root and the absolute value of each.  A function that uses no
more than this, and what is below, takes floats as well as Numbers.

What reads and writes arrays takes contiguous ones of floats, and does not look where they end.
"""

import itertools
import math
import operator
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.errors import TypingError
from numba.core.typing import signature
from numba.core.typing.templates import AbstractTemplate, infer_global
from numba.extending import intrinsic, lower_builtin, models, register_model

# As many floats are stored together, for they are loaded together.
PACK = 4
_DOUBLE, _INDEX = ir.DoubleType(), ir.IntType(32)


class Numbers(types.Type):
    """The type of `width` floats side by side."""

    def __init__(self, width: int):
        self.width = width
        super().__init__(name=f'Numbers({width})')


@register_model(Numbers)
class _Model(models.PrimitiveModel):
    def __init__(self, manager, of):
        super().__init__(manager, of, ir.VectorType(_DOUBLE, of.width))


# -- to and from arrays ---------------------------------------------------------------------------


@intrinsic(prefer_literal=True)
def zero(typing: Any, count: types.Type) -> Any:
    """Return zeros side by side; count: how many, a constant."""
    wide = Numbers(count.literal_value)

    def generate(context, builder, signature, values):
        return ir.Constant(context.get_value_type(wide), [0.0] * wide.width)

    return wide(count), generate


@intrinsic
def spread(typing: Any, value: types.Type, like: types.Type) -> Any:
    """Return a float as many times as there are numbers in `like`."""

    def generate(context, builder, signature, values):
        return _spread(builder, values[0], like)

    return like(types.float64, like), generate


def _spread(builder, value, like):
    """Return one float as many times as there are numbers in the type `like`."""
    if not isinstance(like, Numbers):
        return value
    kind = ir.VectorType(_DOUBLE, like.width)
    first = builder.insert_element(ir.Constant(kind, ir.Undefined), value, _INDEX(0))
    everywhere = ir.Constant(ir.VectorType(_INDEX, like.width), [0] * like.width)
    return builder.shuffle_vector(first, ir.Constant(kind, ir.Undefined), everywhere)


@intrinsic
def width(typing: Any, like: types.Type) -> Any:
    """Return how many numbers `like` is: 1 for a float."""

    def generate(context, builder, signature, values):
        return context.get_constant(signature.return_type, getattr(like, 'width', 1))

    return types.intp(like), generate


@intrinsic
def load(typing: Any, array: types.Type, i: types.Type, like: types.Type) -> Any:
    """Return the numbers, as many as `like`, that are the i-th so many of an array."""

    def generate(context, builder, signature, values):
        array_value, i_value, _ = values
        place = _place(context, builder, array, array_value, i_value, like)
        return builder.load(place, align=8)

    return like(array, types.intp, like), generate


@intrinsic
def store(typing: Any, array: types.Type, i: types.Type, numbers: types.Type) -> Any:
    """Write numbers as the i-th so many of an array."""

    def generate(context, builder, signature, values):
        array_value, i_value, numbers_value = values
        place = _place(context, builder, array, array_value, i_value, numbers)
        builder.store(numbers_value, place, align=8)
        return context.get_dummy_value()

    return types.void(array, types.intp, numbers), generate


@intrinsic
def store_all(typing: Any, array: types.Type, begin: types.Type, values: types.Type) -> Any:
    """Write all values of a tuple of Numbers to an array, one after the other from `begin` on."""

    def generate(context, builder, signature, given):
        array_value, begin_value, all_values = given
        first = _place(context, builder, array, array_value, begin_value, types.float64)
        for i, each in enumerate(cgutils.unpack_tuple(builder, all_values)):
            place = builder.gep(first, [_INDEX(i * values.dtype.width)])
            builder.store(each, builder.bitcast(place, each.type.as_pointer()), align=8)
        return context.get_dummy_value()

    return types.void(array, types.intp, values), generate


@intrinsic
def filled(typing: Any, like: types.Type, array: types.Type, some: types.Type) -> Any:
    """
    Return nested tuples like the given ones, with the numbers of an array one after the other.

    Each is as many as `some`; in the place of a bool the given one stays.
    """

    def generate(context, builder, signature, values):
        like_value, array_value, _ = values
        first = _place(context, builder, array, array_value, _INDEX(0), some)
        places = itertools.count()

        def fill(kind, value):
            if isinstance(kind, types.BaseTuple):
                parts = [
                    fill(each, builder.extract_value(value, i)) for i, each in enumerate(kind)
                ]
                return context.make_tuple(builder, _filled(kind, some), parts)
            place = builder.gep(first, [_INDEX(next(places))])
            return value if kind == types.boolean else builder.load(place, align=8)

        return fill(like, like_value)

    return _filled(like, some)(like, array, some), generate


def _filled(kind, some):
    """Return the type of tuples that are filled with `some`."""
    if isinstance(kind, types.BaseTuple):
        parts = [_filled(each, some) for each in kind]
        return types.BaseTuple.from_types(parts, getattr(kind, 'instance_class', None))
    return kind if kind == types.boolean else some


def _place(context, builder, array_type, array, i, like):
    """Return where the i-th numbers like some are in an array; TypingError: it has gaps."""
    if array_type.layout != 'C':
        raise TypingError('numbers side by side are read from contiguous arrays alone')
    data = context.make_array(array_type)(context, builder, array).data
    kind = context.get_value_type(like)
    return builder.gep(builder.bitcast(data, kind.as_pointer()), [i])


@intrinsic
def packed(typing: Any, values: types.Type) -> Any:
    """
    Return a tuple of floats as a tuple of Numbers, PACK in each, with zeros after the last.

    Numbers are left as they are.
    """
    if isinstance(values.dtype, Numbers):
        return values(values), lambda context, builder, signature, given: given[0]
    wide = Numbers(PACK)
    packs = types.UniTuple(wide, -(-len(values) // PACK))

    def generate(context, builder, signature, given):
        floats = cgutils.unpack_tuple(builder, given[0])
        found = []
        for begin in range(0, len(floats), PACK):
            numbers = ir.Constant(context.get_value_type(wide), [0.0] * PACK)
            for i, each in enumerate(floats[begin : begin + PACK]):
                numbers = builder.insert_element(numbers, each, _INDEX(i))
            found.append(numbers)
        return context.make_tuple(builder, packs, found)

    return packs(values), generate


# -- arithmetic -----------------------------------------------------------------------------------


@intrinsic
def where_less(
    typing: Any, a: types.Type, b: types.Type, then: types.Type, otherwise: types.Type
) -> Any:
    """Return what is in `then` where a < b, elsewhere what is in `otherwise`, all alike."""

    def generate(context, builder, signature, values):
        a, b, then, otherwise = values
        return builder.select(builder.fcmp_ordered('<', a, b), then, otherwise)

    return then(then, then, then, then), generate


@intrinsic
def all_less(typing: Any, a: types.Type, b: types.Type) -> Any:
    """Return whether every number of `a` is less than that of b beside it, both alike."""
    if not isinstance(a, Numbers):
        raise TypingError('all_less compares Numbers')

    def generate(context, builder, signature, values):
        less = builder.fcmp_ordered('<', *values)
        bits = builder.bitcast(less, ir.IntType(a.width))
        return builder.icmp_unsigned('==', bits, ir.Constant(bits.type, 2**a.width - 1))

    return types.boolean(a, a), generate


def _with_two(operation, instruction):
    """Let an operation take Numbers, or Numbers and a float."""

    @infer_global(operation)
    class _Template(AbstractTemplate):
        def generic(self, given, keywords):
            wide = [each for each in given if isinstance(each, Numbers)]
            plain = [each for each in given if isinstance(each, types.Number)]
            if len(given) == 2 and wide and len(wide) + len(plain) == 2:
                return signature(
                    wide[0], *(each if each in wide else types.float64 for each in given)
                )
            return None

    def generate(context, builder, signature, values):
        wide = signature.return_type
        values = (
            value if of == wide else _spread(builder, value, wide)
            for of, value in zip(signature.args, values, strict=True)
        )
        return getattr(builder, instruction)(*values)

    for pair in (Numbers, Numbers), (Numbers, types.float64), (types.float64, Numbers):
        lower_builtin(operation, *pair)(generate)


def _with_one(operation, instruction):
    """Let an operation take Numbers; instruction: makes it of a builder and a value."""

    @infer_global(operation)
    class _Template(AbstractTemplate):
        def generic(self, given, keywords):
            return signature(*given * 2) if isinstance(given[0], Numbers) else None

    @lower_builtin(operation, Numbers)
    def generate(context, builder, signature, values):
        return instruction(builder, *values)


def _own_function(name):
    """Return an instruction that calls a function of the compiler itself."""

    def call(builder, value):
        kind = ir.FunctionType(value.type, [value.type])
        whole_name = f'{name}.v{value.type.count}f64'
        function = cgutils.get_or_insert_function(builder.module, kind, whole_name)
        return builder.call(function, [value])

    return call


_with_two(operator.add, 'fadd')
_with_two(operator.sub, 'fsub')
_with_two(operator.mul, 'fmul')
_with_two(operator.truediv, 'fdiv')
_with_one(operator.neg, lambda builder, value: builder.fneg(value))
_with_one(abs, _own_function('llvm.fabs'))
_with_one(math.sqrt, _own_function('llvm.sqrt'))
