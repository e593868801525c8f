"""Functions of one's own among the compiled ones: what is wrong with them, in one sentence."""

import re
from collections.abc import Callable
from typing import Any

from numba import typeof, types
from numba.core import cgutils
from numba.extending import intrinsic

from .compile import inlined
from .simd import SimdVector


def guarded(function: Callable[..., Any], place: str, length: int | None) -> Any:
    """
    Return a function of one's own, compiled where it is called.

    length: of the tuple of numbers that it must return; 0: one number, None: any tuple of them.
    ValueError there, in one sentence that begins with place: it cannot be compiled, or returns
    something else.
    """
    body = inlined(function)

    def checked(typing, *given):
        try:
            one = typeof(body).get_call_type(typing, given, {})
        except Exception as error:
            raise ValueError(f'{place} cannot be compiled: {_in_short(str(error))}') from None
        found, is_tuple = one.return_type, isinstance(one.return_type, types.BaseTuple)
        numbers = found.types if is_tuple else (found,)
        fits = is_tuple == (length != 0) and (not length or len(numbers) == length)
        if not (
            fits and all(isinstance(x, types.Integer | types.Float | SimdVector) for x in numbers)
        ):
            due = 'a number' if length == 0 else f'a tuple of {length or "some"} numbers'
            raise ValueError(f'{place} returns {_told(found)}; it must return {due}')

        def generate(context, builder, signature, values):
            values = cgutils.unpack_tuple(builder, values[0])
            return context.get_function(typeof(body), one)(builder, values)

        return one.return_type(types.StarArgTuple.from_types(given)), generate

    return intrinsic(checked)


def _told(found):
    """Return what a function returns, by its type."""
    if isinstance(found, types.BaseTuple):
        return f'a tuple of {len(found)}, {found}'
    return 'nothing' if isinstance(found, types.NoneType) else f'a value of type {found}'


def _in_short(text):
    """Return what numba says in many lines as the end of a sentence, with the line it is about."""
    lines = [line.strip() for line in text.splitlines()]
    said = [line for line in lines if line and not line.startswith('Failed in ')]
    reason = said[0] if said else 'the compiler does not say why'
    if called := [line for line in lines if line.startswith('>>> ')]:
        reason = f'there is no {called[0].removeprefix(">>> ")}'
    if 'NRT required' in text or 'Only accept returning of array' in text:
        reason = 'it makes an array or a list, which it may not'
    if 'Mask(' in text:
        reason = 'it is computed for many motions at once and must choose by select, not by if'
    reason = reason.partition('. Raised from')[0].removesuffix('.')
    place = re.search(r'([^/"\s]+\.py)(?:", line | \()(\d+)', text)
    return f'{reason} ({place[1]}, line {place[2]})' if place else reason
