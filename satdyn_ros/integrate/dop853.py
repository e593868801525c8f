"""
One step of Dormand and Prince's method of order 8, and its error by orders 5 and 3.

Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, 1993, II.5, II.10.

A step is of one motion, its variables floats, or of many side by side, its variables SIMD vectors.

clock (13,), by the names below: where the current step begins and ends, the proposed length of
the next one, the number of steps taken, the number of the step that the dense output belongs to,
the furthest row that was ever reached, the number of steps begun since, how many stops are
passed, the times from tick 0 between which the torques are smooth, and what exits.py tells.
dense (8, V): the terms of the dense output of one motion's step, the first of them the variables
at its start.  constants: the Constants of the equations.
"""

import math
from typing import NamedTuple

import numpy as np

from ..dynamics.constants import Constants
from ..dynamics.equations import (
    MOMENTUM,
    OMEGA,
    place_at,
    place_of,
    rates,
    seen_by_torques,
)
from ..kernel.compile import inlined
from ..kernel.simd import PACK, broadcast, load, packed, select, store, store_all, width, zero
from ..kernel.unroll import unrolled_fold, unrolled_map
from ..kernel.vector import dot
from ..orbits.kepler import true_anomaly
from ..torques.sums import first_corner
from .tableau import COLUMNS, ENTRIES, ERROR_3, ERROR_5, LENGTHS, NODES

# The places of the clock.
BEGIN, END, NEXT, STEPS, DENSE_OF, FURTHEST, SINCE, PASSED, FROM_S, UNTIL_S = range(10)
LEFT, EXIT, EXIT_S = range(10, 13)
# How a walk ends: it goes on in another slice, all rows are reached, no step meets the tolerance,
# too many steps are needed, or the constants hold no further: a piece of time ends, a rotor leaves
# its range.
UNFINISHED, REACHED, STEP_UNDERFLOW, TOO_MANY_STEPS, PIECE_ENDS, ROTOR_LEAVES = range(6)

# The place on an ellipse, integrated with the rest, is corrected every so many steps.
STEPS_PER_FIX = 8
# What a step may grow to or shrink to at once.
GROWTH, CUT = 6.0, 0.2
# A step aims at this share of the length that should just meet the tolerance.
SAFETY = 0.9
# Above it a variable counts as infinite: the dense output multiplies it by up to some thousand.
LARGEST = 1e300
# The share of a step within which a corner at its end is not felt; by which the slope of what has
# a zero there is found; and the least to which a step is cut at once for its sake.
CORNER, SOON, LEAST_PART = 1e-6, 1e-3, 1e-3
# At least the distance of a number from the next one, relative.
ULP = 2.3e-16
# Keeps a quotient of zeros finite and changes no other.
TINY = 1e-300
# What the first step turns the body or the orbit by [rad]; a rate below the slowest [rad/s] counts
# as the slowest, for which such a step takes four months.
FIRST_TURN, SLOWEST = 0.01, 1e-9
# Floats in a cache line.
_LINE = 8
# One number for each of q and omega.
_CORE = (0.0,) * MOMENTUM


class Stages(NamedTuple):
    """
    What a step is computed in: for every variable one number, or one of each motion.

    y_0 and y: the variables at the start and at the end; k: the 16 stages, h times the
    derivatives, of which the last four are made with the dense output, which alone needs them;
    e_3 and e_5: the errors by the two orders; zeros.  All but k have the same length.
    """

    y_0: np.ndarray
    y: np.ndarray
    k: np.ndarray
    e_3: np.ndarray
    e_5: np.ndarray
    zeros: np.ndarray

    @classmethod
    def empty(cls, length: int, y_0: np.ndarray | None = None) -> 'Stages':
        """Return Stages of zeros; y_0: an array that is kept elsewhere."""
        rows = line_zeros(21 * length).reshape(21, length)
        return cls(rows[0] if y_0 is None else y_0, rows[1], rows[5:].ravel(), *rows[2:5])


def line_zeros(count: int) -> np.ndarray:
    """Return zeros (count,) from the start of a cache line on: no vector straddles two lines."""
    numbers = np.zeros(count + _LINE)
    begin = -numbers.ctypes.data // numbers.itemsize % _LINE
    return numbers[begin : begin + count]


def new_clock() -> np.ndarray:
    """Return the clock of a motion that has not begun."""
    clock = np.zeros(13)
    clock[FROM_S], clock[UNTIL_S], clock[EXIT_S] = -np.inf, np.inf, np.inf
    return clock


def step_arrays(size: int) -> tuple[Stages, np.ndarray]:
    """Return the Stages and the dense output of one motion of `size` variables, with room."""
    length = -(-size // PACK) * PACK
    dense = line_zeros(8 * length).reshape(8, length)
    return Stages.empty(length, dense[0]), dense


@inlined
def step(
    clock: np.ndarray,
    stages: Stages,
    anomaly: np.ndarray,
    stops_s: np.ndarray,
    constants: Constants,
    tolerance: float,
) -> bool:
    """
    Take one step of one motion within the tolerance; return whether there is one.

    stops_s: times from tick 0 at which steps end, ascending.  Without a step, what is left in
    clock and stages is of no use.
    """
    t, y_0, y = clock[END], stages.y_0, stages.y
    if len(constants.place) > 0 and int(clock[STEPS]) % STEPS_PER_FIX == 0:
        i = place_at(constants)
        y[i], y[i + 1] = direction_of_centre(anomaly, t)
    _copy(y, y_0)
    h = clock[NEXT]
    if h == 0.0:
        h = first_step((y[4], y[5], y[6]), constants)
    clock[PASSED], clock[FROM_S], clock[UNTIL_S], stop = next_stop(
        int(clock[PASSED]), t, stops_s, constants.start_s
    )
    span, largest_growth, wished, is_cut = (clock[FROM_S], clock[UNTIL_S]), GROWTH, h, False
    while True:
        end = min(t + h, stop)
        if not t < end < np.inf:
            return False
        h = end - t
        error = attempt(stages, t, h, span, constants, len(y), zero(PACK)) / tolerance
        part = part_before_corner(stages, t, h, span, constants)
        if error <= 1.0 and part == 1.0:
            break
        if error <= 1.0:
            h, is_cut = h * part, True
        else:
            h *= cut(error, step_ratio(error))
            wished, largest_growth = h, 1.0
        _copy(y_0, y)
    clock[BEGIN], clock[END] = t, t + h
    grown = h * min(largest_growth, step_ratio(error))
    if end == stop:
        clock[END], is_cut = stop, True
    if is_cut:
        # A stop or a corner cuts the step off; that which was wished is still a good one.
        grown = max(grown, wished)
    clock[NEXT] = min(grown, constants.longest_step)
    clock[STEPS] += 1.0
    return True


@inlined
def next_stop(
    passed: int, t: float, stops_s: np.ndarray, start_s: float
) -> tuple[int, float, float, float]:
    """
    Return how many stops are passed at t, the one before and the next, and when that one comes.

    stops_s: from tick 0; passed: at most that many.  The next is less a rounding: where a torque
    jumps, a step computes with what is on its side alone.  When it comes: from the motion's start.
    """
    while passed < len(stops_s) and stops_s[passed] - start_s <= t:
        passed += 1
    before = stops_s[passed - 1] if passed > 0 else -np.inf
    if passed == len(stops_s):
        return passed, before, np.inf, np.inf
    following = stops_s[passed]
    return passed, before, following - ULP * abs(following), following - start_s


@inlined
def _copy(y, to):
    for i in range(len(y) // PACK):
        store(to, i, load(y, i, zero(PACK)))


@inlined
def attempt(
    stages: Stages,
    t: float,
    h: float,
    span: tuple[float, float],
    constants: Constants,
    changing: int,
    some: float,
) -> float:
    """
    Take the step h from y_0, which is y, at t to y; return its error.

    span: the times from tick 0 between which the torques are smooth.  changing: how many of the
    numbers change, the first ones; some: as many as are summed at once.
    """
    y_0, y, k = stages.y_0, stages.y, stages.k
    for i in range(12):
        evaluate(stage_time(i, t, h, span, constants), y, h, constants, k, i)
        combine(i + 1, y_0, k, y, changing, some)
    combine(ERROR_3, stages.zeros, k, stages.e_3, changing, some)
    combine(ERROR_5, stages.zeros, k, stages.e_5, changing, some)
    return error_of(
        variables(y_0, h, constants),
        variables(y, h, constants),
        (load(k, OMEGA, h), load(k, OMEGA + 1, h), load(k, OMEGA + 2, h)),
        variables(stages.e_3, h, constants),
        variables(stages.e_5, h, constants),
        h,
        constants,
    )


@inlined
def part_before_corner(
    stages: Stages, t: float, h: float, span: tuple[float, float], constants: Constants
) -> float:
    """
    Return the part of the step h after which a torque has a corner; 1: the step needs no cut.

    One as near to either end as the step does not feel it, or time cannot tell it, needs none.
    """
    y_0, f = variables(stages.y_0, h, constants), variables(stages.k, h, constants)
    begin = seen_by_torques(stage_time(0, t, h, span, constants), y_0, constants)
    soon = seen_by_torques(begin[0] + SOON * h, _plus_share(y_0, f), constants)
    end = seen_by_torques(
        stage_time(11, t, h, span, constants), variables(stages.y, h, constants), constants
    )
    part = first_corner(broadcast(1.0, h), constants.torques, begin, soon, SOON, end)
    one = broadcast(1.0, h)
    time = t + max(part, LEAST_PART) * h
    cut_off = select(t < time, select(time < t + h, max(part, LEAST_PART), one), one)
    return select(min(part, 1.0 - part) < CORNER, one, cut_off)


@unrolled_map
def _plus_share(i, y, f):
    return y[i] + SOON * f[i]


@inlined
def variables(y: np.ndarray, like: float, constants: Constants) -> tuple[float, ...]:
    """Return the variables of an array as a tuple, of every motion's numbers where like is."""
    zeros = _CORE + constants.zeros + constants.zeros + (0.0,) + constants.place
    return _loaded(zeros, y, like)


@unrolled_map
def _loaded(i, variables, y, like):
    return load(y, i, like)


@inlined
def stage_time(
    i: int, t: float, h: float, span: tuple[float, float], constants: Constants
) -> float:
    """Return the time of stage i from tick 0 [s]."""
    return min(max(constants.start_s + (t + NODES[i] * h), span[0]), span[1])


@inlined
def evaluate(
    t_s: float, y: np.ndarray, h: float, constants: Constants, k: np.ndarray, i: int
) -> None:
    """Write k_i = h f(t, y); t_s: from tick 0."""
    f = packed(rates(t_s, variables(y, h, constants), constants))
    store_all(k, i * len(y), _scaled(f, h))


@unrolled_map
def _scaled(i, f, h):
    return h * f[i]


@inlined
def combine(
    row: int, y: np.ndarray, k: np.ndarray, z: np.ndarray, changing: int, some: float
) -> None:
    """Write z = y + sum_j a_j k_j with row's entries a_j; changing, some: as of attempt."""
    i, end = 0, changing // width(some)
    # Sums side by side do not wait for each other; more than four do not fit into the registers.
    while end - i > 4:
        _combine_at(i, (some, some, some), row, y, k, z)
        i += 3
    if end - i == 4:
        _combine_at(i, (some, some, some, some), row, y, k, z)
    elif end - i == 3:
        _combine_at(i, (some, some, some), row, y, k, z)
    elif end - i == 2:
        _combine_at(i, (some, some), row, y, k, z)
    elif end - i == 1:
        _combine_at(i, (some,), row, y, k, z)


@inlined
def _combine_at(i, sums, row, y, k, z):
    length = len(z) // width(sums[0])
    for n in range(LENGTHS[row]):
        sums = _plus_products(sums, ENTRIES[row, n], k, COLUMNS[row, n] * length + i)
    store_all(z, i * width(sums[0]), _plus_begins(sums, y, i))


@unrolled_map
def _plus_products(m, sums, a, k, i):
    return sums[m] + a * load(k, i + m, sums[m])


@unrolled_map
def _plus_begins(m, sums, y, i):
    return load(y, i + m, sums[m]) + sums[m]


@inlined
def first_step(omega: tuple[float, ...], constants: Constants) -> float:
    """Return the length of the step that is tried first."""
    return FIRST_TURN / (math.sqrt(dot(omega, omega)) + constants.anomaly_rate + SLOWEST)


@inlined
def error_of(
    y_0: tuple[float, ...],
    y: tuple[float, ...],
    k_omega: tuple[float, ...],
    e_3: tuple[float, ...],
    e_5: tuple[float, ...],
    h: float,
    constants: Constants,
) -> float:
    """Return the error of a step h from y_0 to y: of attitude, rate, orbit and damped momenta."""
    # The natural scale of a rate: the rate itself and the root of the acceleration.  At rest both
    # may be rounding, which needs no digits.
    omega = (y_0[4], y_0[5], y_0[6])
    acceleration = math.sqrt(dot(k_omega, k_omega)) / h
    rate = math.sqrt(dot(omega, omega)) + math.sqrt(acceleration) + constants.slow_rate + TINY
    square_3, square_5 = _square(e_3, 1.0 / rate), _square(e_5, 1.0 / rate)
    square_3 = _plus_square_of_each(square_3, place_of(constants.place, e_3))
    square_5 = _plus_square_of_each(square_5, place_of(constants.place, e_5))
    per_momentum = _per_momentum(constants.rotors, y_0, y, rate)
    square_3 = _plus_squares(square_3, per_momentum, e_3)
    square_5 = _plus_squares(square_5, per_momentum, e_5)
    # The error does not look at the other variables: they must be finite.  So must the squares,
    # or a quotient by infinity would take the worst of steps for one without an error.
    rest = _plus_amounts(square_3 + square_5, y[MOMENTUM:], broadcast(1.0, h))
    # The root mean square of the estimate of order 5, damped by that of order 3 (II.10).
    count = MOMENTUM + len(constants.place)
    error = square_5 / math.sqrt(count * (square_5 + 0.01 * square_3) + TINY)
    return select(rest < broadcast(LARGEST, h), error, broadcast(np.inf, h))


@unrolled_map
def _per_momentum(i, rotors, y_0, y, rate):
    """Return what a rotor's momentum is in proportion to, inverse, and zero without friction."""
    # Without friction a momentum has no error.  Friction acts by the relative speed, which may
    # be far below the rate of the body: nearly all of p / J may be due to that rate.
    # A tenth of that rate is the least speed that its error is relative to.
    rotor = rotors[i]
    speed = abs(_speed(y_0, i, rotor)) + abs(_speed(y, i, rotor))
    per_momentum = rotor.inertia_inverse / (speed + 0.1 * rate)
    none = broadcast(0.0, rate)
    return select(none < rotor.friction, per_momentum, none)


@unrolled_fold
def _plus_squares(total, i, per_momentum, e):
    error = e[MOMENTUM + i] * per_momentum[i]
    return total + error * error


@unrolled_fold
def _plus_amounts(total, i, y, one):
    return total + abs(y[i])


@inlined
def _speed(y, i, rotor):
    """Return the speed of rotor i relative to the body."""
    return y[MOMENTUM + i] * rotor.inertia_inverse - dot(rotor.axis, (y[4], y[5], y[6]))


@inlined
def step_ratio(error: float) -> float:
    """Return 0.9 error^(-1/8): of order 8, so changed, a step should meet the tolerance."""
    # An error below 1e-12 allows far more than the greatest growth.
    least = broadcast(1e-12, error)
    return SAFETY / math.sqrt(math.sqrt(math.sqrt(select(least < error, error, least))))


@inlined
def cut(error: float, ratio: float) -> float:
    """Return by what a step is shortened that misses the tolerance; ratio: its step_ratio."""
    most = broadcast(CUT, error)
    return select(error < broadcast(np.inf, error), select(most < ratio, ratio, most), most)


@inlined
def direction_of_centre(anomaly: np.ndarray, t: float) -> tuple[float, float]:
    """Return cos f and sin f at t, anomaly as of a Propagation."""
    f = true_anomaly(anomaly[0] + anomaly[1] * t, anomaly[2])
    return np.cos(f), np.sin(f)


@inlined
def _square(e, per_rate):
    attitude = e[0] * e[0] + e[1] * e[1] + e[2] * e[2] + e[3] * e[3]
    rate = (e[4] * e[4] + e[5] * e[5] + e[6] * e[6]) * per_rate * per_rate
    return attitude + rate


@unrolled_fold
def _plus_square_of_each(total, i, errors):
    return total + errors[i] * errors[i]
