"""
Where a step ends for the sake of corners: at zeros of the signs of the torques.

Values and slopes at both ends of a step give a cubic in the share x of it: 0 at its begin, 1 at
its end.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ..kernel.functions import divide, maximum, minimum, select, sqrt
from ..kernel.vector import Vector

# What dips by no more than this share of its depth short of zero may be zero in between.
_DOUBT = 0.1
# As many as take a zero of the parabola, or of the tangent at the end, to one of the cubic.
_NEWTON_STEPS = 2


@dataclass(frozen=True)
class CornerSearch:
    """
    How the corners of a step are looked for, in shares of it; by earlier rules in other ways.

    Attributes
    ----------
    share : float
        by which the slopes at its ends are found
    ahead : float
        by which a step ends before a corner that is further away than twice as much: the last
        stages of a long one might be beyond it; 0: it does not, the corner is the zero of a
        parabola, not of a cubic, and a step that misses the tolerance is shortened by its error
        before it is cut
    at_begin, at_end : float
        within these a corner is not felt, at_end by a short step
    least : float
        to which a step is cut at once
    reach : float
        how far beyond the end a corner is foreseen
    sees_pairs : bool
        whether pairs of corners inside are looked for, between which no sign changes
    """

    share: float = 1e-5
    ahead: float = 5e-4
    at_begin: float = 1e-9
    at_end: float = 1e-6
    least: float = 0.0
    reach: float = 1.0
    sees_pairs: bool = True


def first_corner(signs: Sequence[Vector], search: CornerSearch) -> Any:
    """
    Return the part of a step after which one of the signs may change first, 1: none does.

    signs: at the begin of the step, its share after, its share before the end, and at the end.
    Where a pair of changes may be inside the step it is the extremum between them.  Above 1: none
    does inside, and one may so soon after the end.
    """
    part: Any = 1.0
    beyond: Any = 1.0 + search.reach
    for a, near_a, near_b, b in zip(*signs, strict=True):
        slope_a, slope_b = (near_a - a) / search.share, (b - near_b) / search.share
        if search.ahead > 0.0:
            # A step may begin at a corner, go away from zero and come back to another.
            a = _past(a, search.at_begin * slope_a)
            cubic = _cubic(a, slope_a, b, slope_b, search.share)
            zero = _before(_zero_inside(_zero(a, slope_a, b), cubic), search)
            beyond = minimum(beyond, _zero_beyond(1.0 - divide(b, slope_b), cubic, search))
        else:
            zero = _zero(a, slope_a, b)
        part = minimum(part, zero)
        if search.sees_pairs:
            dip = _dip(a, slope_a, b, slope_b)
            part = minimum(part, select(dip > search.at_begin, dip, 1.0))
    return select(part < 1.0, part, select(beyond < 1.0 + search.reach, beyond, 1.0))


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


def _cubic(begin, begin_slope, end, end_slope, share):
    """
    Return the coefficients of the cubic through both ends.

    Its slopes are those of the secants through the first and the last share of the step.
    """
    rise, rest = end - begin, 1.0 - share
    third = (begin_slope + end_slope - 2.0 * rise) / (rest * (rest - share))
    second = (rise - begin_slope) / rest - (1.0 + share) * third
    return begin, rise - second - third, second, third


def _zero_inside(x, cubic):
    """Return where in 0 to 1 a cubic is zero, near x; 1: as x is."""
    for _ in range(_NEWTON_STEPS):
        closer = _closer(x, cubic)
        closer = select((closer > 0.0) & (closer < 1.0), closer, x)
        x = select(x < 1.0, closer, 1.0)
    return x


def _zero_beyond(x, cubic, search):
    """Return where beyond 1 a cubic is zero, near x; 1 + reach: it is at 1, or does not go on."""
    for _ in range(_NEWTON_STEPS):
        x = _closer(x, cubic)
    return select(x > 1.0 + search.at_end, x, 1.0 + search.reach)


def _closer(x, cubic):
    """Return x after a step of Newton's method."""
    begin, first, second, third = cubic
    value = begin + x * (first + x * (second + x * third))
    return x - divide(value, first + x * (2.0 * second + 3.0 * x * third))


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
