"""
What the equations take from all torques at once: compiled sums over their constants.

torques: a tuple of Constants, whose types tell which torques they are.  seen: what a torque is a
function of beside its constants, (t_s, r_i, v_i, q_ib, omega_bi_b).
"""

import math
import re
from functools import cache

from numba import typeof, types
from numba.core import cgutils
from numba.extending import intrinsic

from ..kernel.compile import inlined
from ..kernel.simd import SimdVector, select
from ..kernel.unroll import fold_by_type, unrolled_fold
from ..kernel.vector import add
from .body_torque import KIND_OF
from .central_torque import CentralTorque


def _function(kind, name, length=None):
    """
    Return a function of a kind, compiled where it is called.

    ValueError there, in one sentence: it cannot be compiled, or returns something else than
    length numbers in a tuple, 0: one number, None: any number of them.
    """
    body = inlined(getattr(kind, name))
    if kind.is_shipped():
        return body
    place = f'the torque {kind.full_name()}: its {name}'

    def checked(typing, *given):
        try:
            one = typeof(body).get_call_type(typing, given, {})
        except Exception as error:
            raise ValueError(f'{place} cannot be compiled: {_in_short(str(error))}') from None
        found, is_tuple = one.return_type, isinstance(one.return_type, types.BaseTuple)
        numbers = found.types if is_tuple else (found,)
        fits = is_tuple == (length != 0) and (not length or len(numbers) == length)
        if not (fits and all(isinstance(x, types.Number | SimdVector) for x in numbers)):
            due = 'a number' if length == 0 else f'a tuple of {length or "some"} numbers'
            raise ValueError(f'{place} returns {_told(found)}; it must return {due}')

        def generate(context, builder, signature, values):
            values = cgutils.unpack_tuple(builder, values[0])
            return context.get_function(typeof(body), one)(builder, values)

        return one.return_type(types.StarArgTuple.from_types(given)), generate

    return intrinsic(checked)


@cache
def _adding_field(kind):
    if not issubclass(kind, CentralTorque):
        return None
    field = _function(kind, 'field', 3)

    @inlined
    def added(total, c_b, gradient, constants):
        return add(total, field(c_b, gradient, constants))

    return added


@cache
def _adding_orbit_power(kind):
    if not issubclass(kind, CentralTorque) or kind.orbit_power is None:
        return None
    power = _function(kind, 'orbit_power', 0)

    @inlined
    def added(total, c_b, along_b, gradient, turn_rate, growth_rate, constants):
        return total + power(c_b, along_b, gradient, turn_rate, growth_rate, constants)

    return added


@cache
def _adding_torque(kind):
    if issubclass(kind, CentralTorque):
        return None
    torque = _function(kind, 'torque', 3)

    @inlined
    def added(total, seen, constants):
        t_s, r_i, v_i, q_ib, omega_bi_b = seen
        return add(total, torque(t_s, r_i, v_i, q_ib, omega_bi_b, constants))

    return added


@cache
def _adding_potential(kind):
    if kind.potential is None:
        return None
    potential = _function(kind, 'potential', 0)

    @inlined
    def added(total, seen, constants):
        t_s, r_i, v_i, q_ib, omega_bi_b = seen
        return total + potential(t_s, r_i, v_i, q_ib, omega_bi_b, constants)

    return added


@cache
def _cutting(kind):
    if kind.signs is None:
        return None
    signs = _function(kind, 'signs')

    @inlined
    def cut(part, begin, soon, share, end, constants):
        return _at_first_zero(
            part,
            signs(begin[0], begin[1], begin[2], begin[3], begin[4], constants),
            signs(soon[0], soon[1], soon[2], soon[3], soon[4], constants),
            share,
            signs(end[0], end[1], end[2], end[3], end[4], constants),
        )

    return cut


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


@unrolled_fold
def _at_first_zero(part, i, begin, soon, share, end):
    return min(part, _zero(begin[i], (soon[i] - begin[i]) / share, end[i]))


@inlined
def _zero(begin, slope, end):
    """Return where in 0 to 1 the parabola is zero that has these values and slope; 1: nowhere."""
    # By the root that does not cancel, of begin + slope s + curve s^2, from below to above.
    slope = select(begin < 0.0, slope, -slope)
    size = abs(begin)
    curve = size + abs(end) - slope
    zero = 2.0 * size / (slope + math.sqrt(max(slope * slope + 4.0 * curve * size, 0.0)))
    return select(begin * end < 0.0, zero, 1.0)


# Of (total, torques, c_b, gradient): the total [N m] with the fields of the central ones.
add_fields = fold_by_type(lambda constants: _adding_field(KIND_OF[constants]))
# Of (total, torques, c_b, along_b, gradient, turn_rate, growth_rate): the total [W] with what the
# orbit does on them.
add_orbit_powers = fold_by_type(lambda constants: _adding_orbit_power(KIND_OF[constants]))
# Of (total, torques, seen): the total [N m] with the others.
add_torques = fold_by_type(lambda constants: _adding_torque(KIND_OF[constants]))
# Of (total, torques, seen): the total [J] with the potentials of those that have one.
add_potentials = fold_by_type(lambda constants: _adding_potential(KIND_OF[constants]))
# Of (1.0, torques, begin, soon, share, end): the part of a step after which the first of the signs
# changes, 1: none does.  begin, soon and end are what is seen at the begin of the step, a small
# share of the step later, and at its end.
first_corner = fold_by_type(lambda constants: _cutting(KIND_OF[constants]))
