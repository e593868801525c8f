"""
SIMD vectors: floats side by side in the vector registers of the processor, in compiled code.

Whether the compiler makes vectors of a loop depends on the processor that it compiles for: the
same loops took up to nine times as long on one as on another.  A SimdVector is one on all.

SIMD vectors are added, subtracted, multiplied, divided and compared, each float with its
counterpart or all with one float; so are min and max.  A comparison gives a mask, by which select
chooses.  abs and the functions of math, from sqrt to tanh, take each float.  A function that uses
no more than this takes floats as well as SIMD vectors, and gives the same bits.

What reads and writes arrays takes contiguous ones of floats, and does not look where they end.
"""

import itertools
import math
import operator
from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.errors import TypingError
from numba.core.typeconv import Conversion
from numba.core.typing import signature
from numba.core.typing.templates import AbstractTemplate, infer_global
from numba.extending import (
    intrinsic,
    lower_builtin,
    lower_cast,
    models,
    register_model,
    type_callable,
)

# As many floats are stored together, for they are loaded together.
PACK = 4
_DOUBLE, _INDEX, _TRUTH = ir.DoubleType(), ir.IntType(32), ir.IntType(1)


class SimdVector(types.Type):
    """The type of `width` floats side by side."""

    def __init__(self, width: int):
        self.width = width
        super().__init__(name=f'SimdVector({width})')

    def unify(self, typing: Any, other: types.Type) -> types.Type | None:
        """Return the type of a variable that is now a vector and now a number: a vector."""
        return self if isinstance(other, types.Number) else None

    def can_convert_from(self, typing: Any, other: types.Type) -> Any:
        """Return that a number may become a vector: it is broadcast."""
        return Conversion.safe if isinstance(other, types.Number) else None


class Mask(types.Type):
    """The type of `width` truths side by side."""

    def __init__(self, width: int):
        self.width = width
        super().__init__(name=f'Mask({width})')


@register_model(SimdVector)
class _VectorModel(models.PrimitiveModel):
    def __init__(self, manager, of):
        super().__init__(manager, of, ir.VectorType(_DOUBLE, of.width))


@register_model(Mask)
class _MaskModel(models.PrimitiveModel):
    def __init__(self, manager, of):
        super().__init__(manager, of, ir.VectorType(_TRUTH, of.width))


@lower_cast(types.Number, SimdVector)
def _cast(context, builder, kind, vector, value):
    return _broadcast(builder, context.cast(builder, value, kind, types.float64), vector)


# -- to and from arrays ---------------------------------------------------------------------------


@intrinsic(prefer_literal=True)
def zero(typing: Any, count: types.Type) -> Any:
    """Return a SIMD vector of zeros; count: how many, a constant."""
    wide = SimdVector(count.literal_value)

    def generate(context, builder, signature, values):
        return ir.Constant(context.get_value_type(wide), [0.0] * wide.width)

    return wide(count), generate


@intrinsic
def broadcast(typing: Any, value: types.Type, like: types.Type) -> Any:
    """Return a float in every place of a SIMD vector like `like`; of a float, the float."""

    def generate(context, builder, signature, values):
        return _broadcast(builder, values[0], like)

    return like(types.float64, like), generate


def _broadcast(builder, value, like):
    """Return one float in every place of the type `like`."""
    if not isinstance(like, SimdVector):
        return value
    kind = ir.VectorType(_DOUBLE, like.width)
    first = builder.insert_element(ir.Constant(kind, ir.Undefined), value, _INDEX(0))
    everywhere = ir.Constant(ir.VectorType(_INDEX, like.width), [0] * like.width)
    return builder.shuffle_vector(first, ir.Constant(kind, ir.Undefined), everywhere)


@intrinsic
def width(typing: Any, like: types.Type) -> Any:
    """Return how many floats `like` has: 1 for a float."""

    def generate(context, builder, signature, values):
        return context.get_constant(signature.return_type, getattr(like, 'width', 1))

    return types.intp(like), generate


@intrinsic
def load(typing: Any, array: types.Type, i: types.Type, like: types.Type) -> Any:
    """Return the i-th SIMD vector of an array, or the i-th float, as `like` is."""

    def generate(context, builder, signature, values):
        array_value, i_value, _ = values
        place = _place(context, builder, array, array_value, i_value, like)
        return builder.load(place, align=8)

    return like(array, types.intp, like), generate


@intrinsic
def store(typing: Any, array: types.Type, i: types.Type, value: types.Type) -> Any:
    """Write a SIMD vector, or a float, as the i-th of an array."""

    def generate(context, builder, signature, values):
        array_value, i_value, stored = values
        place = _place(context, builder, array, array_value, i_value, value)
        builder.store(stored, place, align=8)
        return context.get_dummy_value()

    return types.void(array, types.intp, value), generate


@intrinsic
def store_all(typing: Any, array: types.Type, begin: types.Type, values: types.Type) -> Any:
    """Write a tuple of SIMD vectors to an array, one after the other from `begin` on."""

    def generate(context, builder, signature, given):
        array_value, begin_value, all_values = given
        first = _place(context, builder, array, array_value, begin_value, types.float64)
        for i, each in enumerate(cgutils.unpack_tuple(builder, all_values)):
            place = builder.gep(first, [_INDEX(i * values.dtype.width)])
            builder.store(each, builder.bitcast(place, each.type.as_pointer()), align=8)
        return context.get_dummy_value()

    return types.void(array, types.intp, values), generate


@intrinsic
def unflatten(typing: Any, like: types.Type, array: types.Type, some: types.Type) -> Any:
    """
    Return nested tuples like the given ones, of the floats of an array one after the other.

    Where `some` is a SIMD vector, of such vectors; a bool or an array stays as it is given.
    """

    def generate(context, builder, signature, values):
        like_value, array_value, _ = values
        first = _place(context, builder, array, array_value, _INDEX(0), some)
        places = itertools.count()

        def fill(kind, value):
            if isinstance(kind, types.Array):
                if context.enable_nrt:
                    context.nrt.incref(builder, kind, value)
                return value
            if isinstance(kind, types.BaseTuple):
                parts = [
                    fill(each, builder.extract_value(value, i)) for i, each in enumerate(kind)
                ]
                return context.make_tuple(builder, _unflattened(kind, some), parts)
            place = builder.gep(first, [_INDEX(next(places))])
            return value if kind == types.boolean else builder.load(place, align=8)

        return fill(like, like_value)

    return _unflattened(like, some)(like, array, some), generate


def _unflattened(kind, some):
    """Return the type of tuples that are unflatten with `some`."""
    if isinstance(kind, types.BaseTuple):
        parts = [_unflattened(each, some) for each in kind]
        return types.BaseTuple.from_types(parts, getattr(kind, 'instance_class', None))
    return kind if kind == types.boolean or isinstance(kind, types.Array) else some


def _place(context, builder, array_type, array, i, like):
    """Return where the i-th value like `like` is in an array; TypingError: it has gaps."""
    if array_type.layout != 'C':
        raise TypingError('SIMD vectors are read from contiguous arrays alone')
    data = context.make_array(array_type)(context, builder, array).data
    kind = context.get_value_type(like)
    return builder.gep(builder.bitcast(data, kind.as_pointer()), [i])


@intrinsic
def packed(typing: Any, values: types.Type) -> Any:
    """
    Return a tuple of floats as a tuple of SIMD vectors, PACK in each, with zeros after the last.

    SIMD vectors are left as they are.
    """
    if isinstance(values.dtype, SimdVector):
        return values(values), lambda context, builder, signature, given: given[0]
    wide = SimdVector(PACK)
    packs = types.UniTuple(wide, -(-len(values) // PACK))

    def generate(context, builder, signature, given):
        floats = cgutils.unpack_tuple(builder, given[0])
        found = []
        for begin in range(0, len(floats), PACK):
            vector = ir.Constant(context.get_value_type(wide), [0.0] * PACK)
            for i, each in enumerate(floats[begin : begin + PACK]):
                vector = builder.insert_element(vector, each, _INDEX(i))
            found.append(vector)
        return context.make_tuple(builder, packs, found)

    return packs(values), generate


# -- arithmetic -----------------------------------------------------------------------------------


def select(where: Any, then: Any, otherwise: Any) -> Any:
    """
    Return what is in `then` where a mask, or a bool, is true, elsewhere what is in `otherwise`.

    >>> select(1.0 < 2.0, 'less', 'not less')
    'less'
    """
    return then if where else otherwise


@type_callable(select)
def _type_of_select(context):
    def typer(where, then, otherwise):
        wide = [each.width for each in (where, then, otherwise) if hasattr(each, 'width')]
        return SimdVector(wide[0]) if wide else types.float64

    return typer


@lower_builtin(select, types.Any, types.Any, types.Any)
def _select(context, builder, signature, values):
    found, (_, *kinds) = signature.return_type, signature.args
    mask, *sides = values
    for i, kind in enumerate(kinds):
        if kind != found:
            value = context.cast(builder, sides[i], kind, types.float64)
            sides[i] = _broadcast(builder, value, found)
    return builder.select(mask, *sides)


@intrinsic
def all_true(typing: Any, mask: types.Type) -> Any:
    """Return whether a mask is true in every place."""

    def generate(context, builder, signature, values):
        bits = builder.bitcast(values[0], ir.IntType(mask.width))
        return builder.icmp_unsigned('==', bits, ir.Constant(bits.type, 2**mask.width - 1))

    return types.boolean(mask), generate


def _with_two(operation, instruction, gives=SimdVector):
    """
    Let an operation take SIMD vectors, or one and a float.

    instruction: makes it of a builder and two values; gives: the type of what it returns.
    """

    @infer_global(operation)
    class _Template(AbstractTemplate):
        def generic(self, given, keywords):
            wide = [each for each in given if isinstance(each, SimdVector)]
            plain = [each for each in given if isinstance(each, types.Number)]
            if len(given) == 2 and wide and len(wide) + len(plain) == 2:
                floats = (each if each in wide else types.float64 for each in given)
                return signature(gives(wide[0].width), *floats)
            return None

    def generate(context, builder, signature, values):
        wide = SimdVector(signature.return_type.width)
        values = (
            value if of == wide else _broadcast(builder, value, wide)
            for of, value in zip(signature.args, values, strict=True)
        )
        return instruction(builder, *values)

    for pair in (
        (SimdVector, SimdVector),
        (SimdVector, types.float64),
        (types.float64, SimdVector),
    ):
        lower_builtin(operation, *pair)(generate)


def _with_one(operation, instruction):
    """Let an operation take SIMD vectors; instruction: makes it of context, builder and value."""

    @infer_global(operation)
    class _Template(AbstractTemplate):
        def generic(self, given, keywords):
            return signature(*given * 2) if isinstance(given[0], SimdVector) else None

    @lower_builtin(operation, SimdVector)
    def generate(context, builder, signature, values):
        return instruction(context, builder, *values)


def llvm_function(name: str) -> Callable[[Any, Any, Any], Any]:
    """Return an instruction that calls a function of LLVM, on a float or a SIMD vector."""

    def call(context, builder, value):
        kind = ir.FunctionType(value.type, [value.type])
        of = f'v{value.type.count}f64' if isinstance(value.type, ir.VectorType) else 'f64'
        function = cgutils.get_or_insert_function(builder.module, kind, f'{name}.{of}')
        return builder.call(function, [value])

    return call


def in_lanes(builder: Any, vector: Any, of_lane: Callable[[Any], Any]) -> Any:
    """Return, in code that is generated, what of_lane makes of each float of a SIMD vector."""
    found = vector
    for i in map(_INDEX, range(vector.type.count)):
        found = builder.insert_element(found, of_lane(builder.extract_element(vector, i)), i)
    return found


def _of_each_lane(function):
    """Return an instruction that calls a function of a float for each lane."""

    def call(context, builder, value):
        scalar = context.get_function(function, signature(types.float64, types.float64))
        return in_lanes(builder, value, lambda lane: scalar(builder, [lane]))

    return call


def _comparison(sign):
    """Return an instruction that compares two values."""
    return lambda builder, a, b: builder.fcmp_ordered(sign, a, b)


def _extreme(sign):
    """Return an instruction that takes the second of two values where it is beyond the first."""
    return lambda builder, a, b: builder.select(builder.fcmp_ordered(sign, b, a), b, a)


_with_two(operator.add, lambda builder, a, b: builder.fadd(a, b))
_with_two(operator.sub, lambda builder, a, b: builder.fsub(a, b))
_with_two(operator.mul, lambda builder, a, b: builder.fmul(a, b))
_with_two(operator.truediv, lambda builder, a, b: builder.fdiv(a, b))
_with_two(operator.lt, _comparison('<'), Mask)
_with_two(operator.le, _comparison('<='), Mask)
_with_two(operator.gt, _comparison('>'), Mask)
_with_two(operator.ge, _comparison('>='), Mask)
_with_two(min, _extreme('<'))
_with_two(max, _extreme('>'))
_with_one(operator.neg, lambda context, builder, value: builder.fneg(value))
_with_one(abs, llvm_function('llvm.fabs'))
_with_one(math.sqrt, llvm_function('llvm.sqrt'))
for _function in (
    *(math.sin, math.cos, math.tan, math.asin, math.acos, math.atan),
    *(math.exp, math.log, math.sinh, math.cosh, math.tanh),
):
    _with_one(_function, _of_each_lane(_function))
