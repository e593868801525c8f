"""
One step of Dormand and Prince's method of order 8, its error, and the dense output within it.

The error is estimated by orders 5 and 3, the dense output is of order 7 (Hairer, Norsett and
Wanner, Solving Ordinary Differential Equations I, 1993, II.5, II.6, II.10).

clock (7,), by the names below: where the current step begins and ends, the proposed length of the
next one, the number of steps taken, the number of the step that the dense output belongs to, the
furthest row that was ever reached, and the number of steps begun since.
y (SIZE,): the variables at the end of the step; k (16, SIZE): its stages, h times the derivatives;
dense (8, SIZE): the terms of its dense output, the first of them the variables at its begin.
"""

import numpy as np

from ..compiled import inlined
from .equations import CENTRE, OMEGA, SIZE, rates
from .orbit import true_anomaly
from .tableau import COLUMNS, DENSE, ENTRIES, ERROR_3, ERROR_5, LENGTHS
from .vector import dot

# The places of the clock.
BEGIN, END, NEXT, STEPS, DENSE_OF, FURTHEST, SINCE = range(7)
# How a walk ends: it goes on in another slice, all rows are reached, no step meets the tolerance,
# or too many steps are needed.
UNFINISHED, REACHED, STUCK, TOO_MANY_STEPS = range(4)

# The place on the orbit, integrated with the rest, is set right every so many steps.
STEPS_PER_FIX = 8
# What a step may grow to or shrink to at once.
GROWTH, CUT = 6.0, 0.2
# Above it a variable counts as infinite: the dense output multiplies it by up to some thousand.
LARGEST = 1e300
_ZERO = np.zeros(SIZE)


@inlined
def step(clock, y, k, dense, anomaly, of, tolerance):
    """
    Take one step within the tolerance; return whether there is one.

    Without one, what is left in clock, y, k and dense is of no use.
    """
    t, y_0 = clock[END], dense[0]
    if clock[STEPS] % STEPS_PER_FIX == 0.0:
        y[CENTRE], y[CENTRE + 1] = direction_of_centre(anomaly, t)
    y_0[:] = y
    h = clock[NEXT]
    if h == 0.0:
        h = first_step((y[4], y[5], y[6]), of)
    largest_growth = GROWTH
    while True:
        if not t < t + h < np.inf:
            return False
        h = (t + h) - t
        for i in range(12):
            _stage(y, h, of, k[i])
            _combine(i + 1, y_0, k, y)
        _stage(y, h, of, k[12])
        error = (
            _error(y_0, h, k, of.slow_rate) / tolerance
            if is_finite(y[9], y[10], y[11])
            else np.inf
        )
        if error <= 1.0:
            break
        h *= cut(error, step_ratio(error))
        largest_growth = 1.0
        y[:] = y_0
    clock[BEGIN], clock[END] = t, t + h
    clock[NEXT] = h * min(largest_growth, step_ratio(error))
    clock[STEPS] += 1.0
    return True


@inlined
def is_finite(momentum, angle, work):
    """Return whether the variables that the error does not look at are finite."""
    return abs(momentum) + abs(angle) + abs(work) < LARGEST


@inlined
def _stage(y, h, of, k):
    """Write k = h f(y)."""
    y = (y[0], y[1], y[2], y[3], y[4], y[5], y[6], y[7], y[8], y[9], y[10], y[11])
    f = rates(y, of)
    k[0], k[1], k[2], k[3] = h * f[0], h * f[1], h * f[2], h * f[3]
    k[4], k[5], k[6], k[7] = h * f[4], h * f[5], h * f[6], h * f[7]
    k[8], k[9], k[10], k[11] = h * f[8], h * f[9], h * f[10], h * f[11]


@inlined
def _combine(row, y, k, z):
    """Write z = y + sum_j a_j k_j with row's entries a_j: SIZE sums, held in registers."""
    s0 = s1 = s2 = s3 = s4 = s5 = s6 = s7 = s8 = s9 = s10 = s11 = 0.0
    for n in range(LENGTHS[row]):
        a, j = ENTRIES[row, n], COLUMNS[row, n]
        s0, s1, s2 = s0 + a * k[j, 0], s1 + a * k[j, 1], s2 + a * k[j, 2]
        s3, s4, s5 = s3 + a * k[j, 3], s4 + a * k[j, 4], s5 + a * k[j, 5]
        s6, s7, s8 = s6 + a * k[j, 6], s7 + a * k[j, 7], s8 + a * k[j, 8]
        s9, s10, s11 = s9 + a * k[j, 9], s10 + a * k[j, 10], s11 + a * k[j, 11]
    z[0], z[1], z[2], z[3] = y[0] + s0, y[1] + s1, y[2] + s2, y[3] + s3
    z[4], z[5], z[6], z[7] = y[4] + s4, y[5] + s5, y[6] + s6, y[7] + s7
    z[8], z[9], z[10], z[11] = y[8] + s8, y[9] + s9, y[10] + s10, y[11] + s11


@inlined
def _error(y, h, k, slow_rate):
    """Return the error of a step from y, the mean over attitude, rate and orbit."""
    e_3, e_5 = k[13], k[14]
    _combine(ERROR_3, _ZERO, k, e_3)
    _combine(ERROR_5, _ZERO, k, e_5)
    return error_of(
        (y[4], y[5], y[6]),
        (k[0, 4], k[0, 5], k[0, 6]),
        (e_3[0], e_3[1], e_3[2], e_3[3], e_3[4], e_3[5], e_3[6], e_3[7], e_3[8]),
        (e_5[0], e_5[1], e_5[2], e_5[3], e_5[4], e_5[5], e_5[6], e_5[7], e_5[8]),
        h,
        slow_rate,
    )


@inlined
def first_step(omega, of):
    """Return the length of the step that is tried first."""
    return 0.01 / (np.sqrt(dot(omega, omega)) + of.anomaly_rate + 1e-9)


@inlined
def error_of(omega, k_omega, e_3, e_5, h, slow_rate):
    """Return the error of a step h from omega: the mean over attitude, rate and orbit."""
    # The natural scale of a rate: the rate itself and the root of the acceleration.  At rest both
    # may be rounding, which needs no digits.
    acceleration = np.sqrt(dot(k_omega, k_omega)) / h
    per_rate = 1.0 / (np.sqrt(dot(omega, omega)) + np.sqrt(acceleration) + slow_rate + 1e-300)
    square_3, square_5 = _square(e_3, per_rate), _square(e_5, per_rate)
    return square_5 / np.sqrt(9.0 * (square_5 + 0.01 * square_3) + 1e-300)


@inlined
def step_ratio(error):
    """Return 0.9 error^(-1/8): of order 8, so changed, a step should meet the tolerance."""
    return 0.9 / np.sqrt(np.sqrt(np.sqrt(max(error, 1e-12))))


@inlined
def cut(error, ratio):
    """Return by what a step is shortened that misses the tolerance; ratio: its step_ratio."""
    # nan fails every comparison: such a step is cut, until it is too short to be one.
    return max(CUT, ratio) if error < np.inf else CUT


@inlined
def direction_of_centre(anomaly, t):
    """Return cos f and sin f at t, anomaly as of a Propagation."""
    f = true_anomaly(anomaly[0] + anomaly[1] * t, anomaly[2])
    return np.cos(f), np.sin(f)


@inlined
def _square(e, per_rate):
    attitude = e[0] * e[0] + e[1] * e[1] + e[2] * e[2] + e[3] * e[3]
    rate = (e[4] * e[4] + e[5] * e[5] + e[6] * e[6]) * per_rate * per_rate
    return attitude + rate + e[7] * e[7] + e[8] * e[8]


@inlined
def make_dense(clock, y, k, dense, of):
    """Write the terms of the dense output of the step in hand, y at its begin in dense[0]."""
    h, y_0, z = clock[END] - clock[BEGIN], dense[0], dense[7]
    for i in range(13, 16):
        _combine(i, y_0, k, z)
        _stage(z, h, of, k[i])
    for i in range(SIZE):
        rise = y[i] - y_0[i]
        dense[1, i] = rise
        dense[2, i] = k[0, i] - rise
        dense[3, i] = 2.0 * rise - (k[0, i] + k[12, i])
    for n in range(4):
        _combine(DENSE + n, _ZERO, k, dense[4 + n])
    clock[DENSE_OF] = clock[STEPS]


@inlined
def interpolate(t_s, wanted, out, first, last, clock, dense):
    """Evaluate the dense output at t_s[first:last]; the quaternions come out as unit."""
    t_s, begin, h = t_s[first:last], clock[BEGIN], clock[END] - clock[BEGIN]
    per_step = 1.0 / h if h > 0.0 else 0.0
    q_0, q_1 = out[0][first:last], out[1][first:last]
    q_2, q_3 = out[2][first:last], out[3][first:last]
    d_0, d_1, d_2, d_3 = _terms(dense, 0), _terms(dense, 1), _terms(dense, 2), _terms(dense, 3)
    for n in range(len(t_s)):
        x = (t_s[n] - begin) * per_step
        a, b = _polynomial(d_0, x), _polynomial(d_1, x)
        c, d = _polynomial(d_2, x), _polynomial(d_3, x)
        square = a * a + b * b + c * c + d * d
        # A quaternion that is unit to rounding stays as it is: a requested one is kept exactly.
        unit = 1.0 if abs(square - 1.0) < 1e-15 else 1.0 / np.sqrt(square)
        q_0[n], q_1[n], q_2[n], q_3[n] = unit * a, unit * b, unit * c, unit * d
    for j in range(OMEGA, len(wanted)):
        row, d_0 = out[j][first:last], _terms(dense, wanted[j])
        for n in range(len(t_s)):
            row[n] = _polynomial(d_0, (t_s[n] - begin) * per_step)


@inlined
def _terms(dense, i):
    return (
        dense[0, i],
        dense[1, i],
        dense[2, i],
        dense[3, i],
        dense[4, i],
        dense[5, i],
        dense[6, i],
        dense[7, i],
    )


@inlined
def _polynomial(d, x):
    y = 1.0 - x
    return d[0] + x * (
        d[1] + y * (d[2] + x * (d[3] + y * (d[4] + x * (d[5] + y * (d[6] + x * d[7])))))
    )
