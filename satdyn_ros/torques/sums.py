"""
What the equations take from all torques at once: compiled sums over their constants.

torques: a tuple of Constants, whose types tell which torques they are.  seen: what a torque is a
function of beside its constants, (t_s, r_i, v_i, q_ib, omega_bi_b).
"""

import math
from functools import cache

from ..kernel.compile import inlined
from ..kernel.guard import guarded
from ..kernel.simd import select
from ..kernel.unroll import fold_by_type, unrolled_fold
from ..kernel.vector import add
from .body_torque import KIND_OF
from .central_torque import CentralTorque


def _function(kind, name, length=None):
    """Return a compiled function of a kind, which returns so many numbers; as of guarded."""
    function = getattr(kind, name)
    if kind.is_shipped():
        return inlined(function)
    return guarded(function, f'the torque {kind.full_name()}: its {name}', length)


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
