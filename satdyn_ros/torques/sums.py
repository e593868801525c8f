"""
What the equations take from all torques at once.

torques: a tuple of Constants, whose types say which torques they are.  seen: what a torque is a
function of beside its constants, (t_s, r_i, v_i, q_ib, omega_bi_b), and then the variables of all
torques that have any, one behind the other.
"""

from collections.abc import Iterator
from typing import Any, NamedTuple

from ..kernel.functions import divide, maximum, minimum, select, sqrt
from ..kernel.vector import Vector, add
from .body_torque import KIND_OF, scales_of
from .central_torque import CentralTorque
from .own_function import function_of

# What dips by no more than this share of its depth short of zero may be zero in between.
_DOUBT = 0.1
# As many as take a zero of the parabola to one of the cubic.
_NEWTON_STEPS = 2


def _functions(
    torques: tuple[Any, ...], name: str, is_central: bool | None = None
) -> Iterator[tuple[Any, Any]]:
    """Yield a function of the torques that have it, or of the central or others, and constants."""
    for constants in torques:
        kind = KIND_OF[type(constants)]
        is_asked = is_central is None or issubclass(kind, CentralTorque) == is_central
        if is_asked and getattr(kind, name) is not None:
            yield function_of(kind, name), constants


def _found(
    torques: tuple[Any, ...], name: str, seen: tuple[Any, ...], is_central: bool | None = None
) -> Iterator[Any]:
    """Yield what a function returns of those torques that have it, or of some of them."""
    *seen_by_all, variables = seen
    end = 0
    for constants in torques:
        kind = KIND_OF[type(constants)]
        begin, end = end, end + (0 if kind.rates is None else len(scales_of(constants)))
        is_asked = is_central is None or issubclass(kind, CentralTorque) == is_central
        if is_asked and getattr(kind, name) is not None:
            own = () if kind.rates is None else (variables[begin:end],)
            yield function_of(kind, name)(*seen_by_all, constants, *own)


def rates_of_states(torques: tuple[Any, ...], seen: tuple[Any, ...]) -> Vector:
    """Return the rates of the variables of all torques, one behind the other."""
    found: list[Any] = []
    own = [constants for constants in torques if KIND_OF[type(constants)].rates is not None]
    for constants, rates in zip(own, _found(torques, 'rates', seen), strict=True):
        count = len(scales_of(constants))
        if len(rates) != count:
            raise ValueError(
                f'the torque {KIND_OF[type(constants)].full_name()}: its rates returns a tuple of '
                f'{len(rates)}; it must return a tuple of {count} numbers'
            )
        found += rates
    return tuple(found)


def sum_of_torques(torques: tuple[Any, ...], seen: tuple[Any, ...]) -> Vector:
    """Return the torque [N m] of all but the central ones."""
    total: Vector = (0.0, 0.0, 0.0)
    for torque in _found(torques, 'torque', seen, False):
        total = add(total, torque)
    return total


def sum_of_forces(torques: tuple[Any, ...], seen: tuple[Any, ...]) -> Vector:
    """Return the force [N] of those that have one."""
    total: Vector = (0.0, 0.0, 0.0)
    for force in _found(torques, 'force', seen):
        total = add(total, force)
    return total


def sum_of_potentials(torques: tuple[Any, ...], seen: tuple[Any, ...]) -> Any:
    """Return the potential [J] of those that have one."""
    total: Any = 0.0
    for potential in _found(torques, 'potential', seen):
        total = total + potential
    return total


def sum_of_fields(torques: tuple[Any, ...], c_b: Vector, gradient: Any) -> Vector:
    """Return the field [N m] of the central torques."""
    total: Vector = (0.0, 0.0, 0.0)
    for field, constants in _functions(torques, 'field', True):
        total = add(total, field(c_b, gradient, constants))
    return total


def sum_of_orbit_powers(
    torques: tuple[Any, ...],
    c_b: Vector,
    along_b: Vector,
    gradient: Any,
    turn_rate: Any,
    growth_rate: Any,
) -> Any:
    """Return what the orbit does on the central torques [W]."""
    total: Any = 0.0
    for power, constants in _functions(torques, 'orbit_power', True):
        total = total + power(c_b, along_b, gradient, turn_rate, growth_rate, constants)
    return total


class CornerSearch(NamedTuple):
    """
    How the corners of a step are looked for, in shares of it.

    share: by which the slopes at its ends are found.  ahead: by which a step ends before a corner
    that is further away than twice as much: the last stages of a long one might be beyond it; 0:
    it does not, and the corner is the zero of a parabola, not of a cubic.  at_begin, at_end:
    within these a corner is not felt, at_end by a short step.  least: to which a step is cut at
    once.
    """

    share: float
    ahead: float
    at_begin: float
    at_end: float
    least: float


def first_corner(
    torques: tuple[Any, ...],
    begin: tuple[Any, ...],
    soon: tuple[Any, ...],
    late: tuple[Any, ...],
    end: tuple[Any, ...],
    search: CornerSearch,
    sees_pairs: bool,
) -> Any:
    """
    Return the part of a step after which one of the signs may change first, 1: none does.

    begin and end: what is seen at the begin of the step and at its end, soon and late: a small
    share of the step after and before.  Where a pair of changes may be inside the step it is the
    extremum between them; sees_pairs: whether these are looked for.
    """
    part: Any = 1.0
    for signs in zip(
        *(_found(torques, 'signs', seen) for seen in (begin, soon, late, end)), strict=True
    ):
        for a, near_a, near_b, b in zip(*signs, strict=True):
            slope_a, slope_b = (near_a - a) / search.share, (b - near_b) / search.share
            if search.ahead > 0.0:
                # A step may begin at a corner, go away from zero and come back to another.
                a = _past(a, search.at_begin * slope_a)
                near = _zero(a, slope_a, b)
                zero = _before(_on_cubic(near, a, slope_a, b, slope_b, search.share), search)
            else:
                zero = _zero(a, slope_a, b)
            part = minimum(part, zero)
            if sees_pairs:
                dip = _dip(a, slope_a, b, slope_b)
                part = minimum(part, select(dip > search.at_begin, dip, 1.0))
    return part


def _past(begin, rise):
    """Return a value at the begin; where it is zero to within a rise, that after the rise."""
    return select(abs(begin) <= abs(rise), rise, begin)


def _before(zero, search):
    """Return where a step ends for the sake of a zero; 1: it does not feel it."""
    end = select(zero > 2.0 * search.ahead, zero - search.ahead, zero)
    return select(zero < 1.0 - search.at_end, end, 1.0)


def _zero(begin, slope, end):
    """Return where in 0 to 1 the parabola is zero that has these values and slope; 1: nowhere."""
    # By the root that does not cancel, of begin + slope s + curve s^2, from below to above.
    slope = select(begin < 0.0, slope, -slope)
    size = abs(begin)
    curve = size + abs(end) - slope
    zero = divide(2.0 * size, slope + sqrt(maximum(slope * slope + 4.0 * curve * size, 0.0)))
    return select(begin * end < 0.0, zero, 1.0)


def _on_cubic(x, begin, begin_slope, end, end_slope, share):
    """
    Return where in 0 to 1 the cubic through both ends is zero, near x; 1: as x is.

    Its slopes are those of the secants through the first and the last share of the step.
    """
    rise, rest = end - begin, 1.0 - share
    third = (begin_slope + end_slope - 2.0 * rise) / (rest * (rest - share))
    second = (rise - begin_slope) / rest - (1.0 + share) * third
    first = rise - second - third
    for _ in range(_NEWTON_STEPS):
        value = begin + x * (first + x * (second + x * third))
        slope = first + x * (2.0 * second + 3.0 * x * third)
        closer = x - divide(value, slope)
        closer = select((closer > 0.0) & (closer < 1.0), closer, x)
        x = select(x < 1.0, closer, 1.0)
    return x


def _dip(begin, begin_slope, end, end_slope):
    """
    Return where in 0 to 1 the cubic that has these values and slopes comes nearest to zero.

    1: it does not go there between two ends on one side, or stays clear of zero.
    """
    side = select(begin < 0.0, -1.0, 1.0)
    a, b = side * begin, side * end
    falls, rises = side * begin_slope, side * end_slope
    rise = b - a
    third = falls + rises - 2.0 * rise
    second = 3.0 * rise - 2.0 * falls - rises
    # The root of falls + 2 second x + 3 third x^2 where the slope grows, that does not cancel.
    root = sqrt(maximum(second * second - 3.0 * third * falls, 0.0))
    x = select(second < 0.0, divide(root - second, 3.0 * third), divide(-falls, second + root))
    lowest = a + x * (falls + x * (second + x * third))
    # By how much the cubic may err there goes with the depth of the dip below the nearer end.
    may_cross = lowest < _DOUBT * (minimum(a, b) - lowest)
    may_cross = select(begin * end > 0.0, select(may_cross, x, 1.0), 1.0)
    return select(falls < 0.0, select(rises > 0.0, may_cross, 1.0), 1.0)
