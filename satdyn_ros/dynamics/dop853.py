"""
One step of Dormand and Prince's method of order 8, its error, and the dense output within it.

The error is estimated by orders 5 and 3, the dense output is of order 7 (Hairer, Norsett and
Wanner, Solving Ordinary Differential Equations I, 1993, II.5, II.6, II.10).

clock (7,), by the names below: where the current step begins and ends, the proposed length of the
next one, the number of steps taken, the number of the step that the dense output belongs to, the
furthest row that was ever reached, and the number of steps begun since.
y (V,): the variables at the end of the step; k (16, V): its stages, h times the derivatives, of
which stages 12 to 15 are made with the dense output, which alone needs them;
dense (8, V): the terms of its dense output, the first of them the variables at its start.
constants: the Parameters of the equations, whose number of rotors tells the compiler V.
Rows may be longer than V, which keeps vectors of four numbers within a cache line (step_arrays).
"""

import numpy as np

from ..compiled import inlined, replaced
from .equations import CENTRE, MOMENTUM, OMEGA, Parameters, rates
from .orbit import true_anomaly
from .tableau import COLUMNS, DENSE, ENTRIES, ERROR_3, ERROR_5, LENGTHS
from .vector import dot

# The places of the clock.
BEGIN, END, NEXT, STEPS, DENSE_OF, FURTHEST, SINCE = range(7)
# How a walk ends: it goes on in another slice, all rows are reached, no step meets the tolerance,
# or too many steps are needed.
UNFINISHED, REACHED, STUCK, TOO_MANY_STEPS = range(4)

# The place on the orbit, integrated with the rest, is corrected every so many steps.
STEPS_PER_FIX = 8
# What a step may grow to or shrink to at once.
GROWTH, CUT = 6.0, 0.2
# A step aims at this share of the length that should just meet the tolerance.
SAFETY = 0.9
# Above it a variable counts as infinite: the dense output multiplies it by up to some thousand.
LARGEST = 1e300
# Keeps a quotient of zeros finite and changes no other.
TINY = 1e-300
# What the first step turns the body or the orbit by [rad]; a rate below the slowest [rad/s] counts
# as the slowest, for which such a step takes four months.
FIRST_TURN, SLOWEST = 0.01, 1e-9
# Numbers in a cache line, and in a vector register.
_LINE, _VECTOR = 8, 4
# Sums of the variables whose error counts with any number of rotors: q, omega, cos f and sin f.
_COUNTED = (0.0,) * MOMENTUM
_TWELVE = (0.0,) * 12
_FOUR = (0.0,) * _VECTOR


def line_zeros(count: int) -> np.ndarray:
    """Return zeros (count,) from the start of a cache line on: no vector straddles two lines."""
    numbers = np.zeros(count + _LINE)
    begin = -numbers.ctypes.data // numbers.itemsize % _LINE
    return numbers[begin : begin + count]


def step_arrays(size: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return y, k and dense of zeros for `size` variables."""
    length = -(-size // _VECTOR) * _VECTOR
    rows = line_zeros(25 * length).reshape(25, length)
    return rows[0], rows[1:17], rows[17:]


@inlined
def step(
    clock: np.ndarray,
    y: np.ndarray,
    k: np.ndarray,
    dense: np.ndarray,
    anomaly: np.ndarray,
    constants: Parameters,
    tolerance: float,
) -> bool:
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
        h = first_step((y[4], y[5], y[6]), constants)
    largest_growth = GROWTH
    while True:
        if not t < t + h < np.inf:
            return False
        h = (t + h) - t
        for i in range(12):
            _stage(y, h, constants, k[i])
            _combine(i + 1, y_0, k, y, constants)
        error = _error(y_0, y, h, k, constants) / tolerance
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
def variables(y: np.ndarray, constants: Parameters) -> tuple[float, ...]:
    """Return the variables of an array as a tuple."""
    p, angle, n = constants.zeros, constants.zeros, len(constants.zeros)
    for i in range(n):
        p = replaced(p, i, y[MOMENTUM + i])
        angle = replaced(angle, i, y[MOMENTUM + n + i])
    core = y[0], y[1], y[2], y[3], y[4], y[5], y[6], y[7], y[8]
    return core + p + angle + (y[MOMENTUM + 2 * n],)


@inlined
def _stage(y, h, constants, k):
    """Write k = h f(y)."""
    f, n = rates(variables(y, constants), constants), len(constants.zeros)
    k[0], k[1], k[2], k[3] = h * f[0], h * f[1], h * f[2], h * f[3]
    k[4], k[5], k[6], k[7], k[8] = h * f[4], h * f[5], h * f[6], h * f[7], h * f[8]
    for i in range(MOMENTUM, MOMENTUM + n):
        k[i], k[i + n] = h * f[i], h * f[i + n]
    k[MOMENTUM + 2 * n] = h * f[MOMENTUM + 2 * n]


@inlined
def _combine(row, y, k, z, constants):
    """Write z = y + sum_j a_j k_j with row's entries a_j."""
    # Twelve sums are what the compiler holds in registers; the others follow in vectors.
    sums = _sums(row, k, 0, _TWELVE)
    for i in range(len(sums)):
        z[i] = y[i] + sums[i]
    for begin in range(len(sums), MOMENTUM + 2 * len(constants.zeros) + 1, _VECTOR):
        more = _sums(row, k, begin, _FOUR)
        for i in range(_VECTOR):
            z[begin + i] = y[begin + i] + more[i]


@inlined
def _sums(row, k, begin, sums):
    """Return sum_j a_j k_j of the variables from `begin` on, as many as the zeros in sums."""
    for n in range(LENGTHS[row]):
        a, j = ENTRIES[row, n], COLUMNS[row, n]
        for i in range(len(sums)):
            sums = replaced(sums, i, sums[i] + a * k[j, begin + i])
    return sums


@inlined
def _sum(row, k, i):
    """Return sum_j a_j k_j of one variable."""
    found = 0.0
    for n in range(LENGTHS[row]):
        found += ENTRIES[row, n] * k[COLUMNS[row, n], i]
    return found


@inlined
def _error(y_0, y, h, k, constants):
    """Return the error of a step from y_0 to y, as error_of."""
    p_3, p_5 = constants.zeros, constants.zeros
    for i in range(len(constants.rotors)):
        # Without friction a momentum has no error.
        if constants.rotors[i].friction > 0.0:
            p_3 = replaced(p_3, i, _sum(ERROR_3, k, MOMENTUM + i))
            p_5 = replaced(p_5, i, _sum(ERROR_5, k, MOMENTUM + i))
    return error_of(
        variables(y_0, constants),
        variables(y, constants),
        (k[0, 4], k[0, 5], k[0, 6]),
        _sums(ERROR_3, k, 0, _COUNTED) + p_3,
        _sums(ERROR_5, k, 0, _COUNTED) + p_5,
        h,
        constants,
    )


@inlined
def first_step(omega: tuple[float, ...], constants: Parameters) -> float:
    """Return the length of the step that is tried first."""
    return FIRST_TURN / (np.sqrt(dot(omega, omega)) + constants.anomaly_rate + SLOWEST)


@inlined
def error_of(
    y_0: tuple[float, ...],
    y: tuple[float, ...],
    k_omega: tuple[float, ...],
    e_3: tuple[float, ...],
    e_5: tuple[float, ...],
    h: float,
    constants: Parameters,
) -> float:
    """Return the error of a step h from y_0 to y: of attitude, rate, orbit and damped momenta."""
    # The natural scale of a rate: the rate itself and the root of the acceleration.  At rest both
    # may be rounding, which needs no digits.
    omega = (y_0[4], y_0[5], y_0[6])
    acceleration = np.sqrt(dot(k_omega, k_omega)) / h
    rate = np.sqrt(dot(omega, omega)) + np.sqrt(acceleration) + constants.slow_rate + TINY
    square_3, square_5 = _square(e_3, 1.0 / rate), _square(e_5, 1.0 / rate)
    for i in range(len(constants.rotors)):
        rotor = constants.rotors[i]
        # Without friction a momentum has no error.  Friction acts by the relative speed, which may
        # be far below the rate of the body: nearly all of p / J may be due to that rate.
        # A tenth of that rate is the least speed that its error is relative to.
        speed = abs(_speed(y_0, i, rotor)) + abs(_speed(y, i, rotor))
        per_momentum = rotor.inertia_inverse / (speed + 0.1 * rate)
        per_momentum = per_momentum if rotor.friction > 0.0 else 0.0
        square_3 += (e_3[MOMENTUM + i] * per_momentum) ** 2
        square_5 += (e_5[MOMENTUM + i] * per_momentum) ** 2
    # The error does not look at the other variables: they must be finite.  So must the squares,
    # or a quotient by infinity would take the worst of steps for one without an error.
    rest = square_3 + square_5
    for i in range(MOMENTUM, len(y)):
        rest += abs(y[i])
    # The root mean square of the estimate of order 5, damped by that of order 3 (II.10).
    error = square_5 / np.sqrt(len(_COUNTED) * (square_5 + 0.01 * square_3) + TINY)
    # Chosen at the end: a branch would keep the lanes of batch.py from being vectorised.
    return error if rest < LARGEST else np.inf


@inlined
def _speed(y, i, rotor):
    """Return the speed of rotor i relative to the body."""
    return y[MOMENTUM + i] * rotor.inertia_inverse - dot(rotor.axis, (y[4], y[5], y[6]))


@inlined
def step_ratio(error: float) -> float:
    """Return 0.9 error^(-1/8): of order 8, so changed, a step should meet the tolerance."""
    # An error below 1e-12 allows far more than the greatest growth.
    return SAFETY / np.sqrt(np.sqrt(np.sqrt(max(error, 1e-12))))


@inlined
def cut(error: float, ratio: float) -> float:
    """Return by what a step is shortened that misses the tolerance; ratio: its step_ratio."""
    # nan fails every comparison: such a step is cut, until it is too short to be one.
    return max(CUT, ratio) if error < np.inf else CUT


@inlined
def direction_of_centre(anomaly: np.ndarray, t: float) -> tuple[float, float]:
    """Return cos f and sin f at t, anomaly as of a Propagation."""
    f = true_anomaly(anomaly[0] + anomaly[1] * t, anomaly[2])
    return np.cos(f), np.sin(f)


@inlined
def _square(e, per_rate):
    attitude = e[0] * e[0] + e[1] * e[1] + e[2] * e[2] + e[3] * e[3]
    rate = (e[4] * e[4] + e[5] * e[5] + e[6] * e[6]) * per_rate * per_rate
    return attitude + rate + e[7] * e[7] + e[8] * e[8]


@inlined
def make_dense(
    clock: np.ndarray, y: np.ndarray, k: np.ndarray, dense: np.ndarray, constants: Parameters
) -> None:
    """Write the terms of the dense output of the current step, which starts at y = dense[0]."""
    h, y_0, z = clock[END] - clock[BEGIN], dense[0], dense[7]
    _stage(y, h, constants, k[12])
    for i in range(13, 16):
        _combine(i, y_0, k, z, constants)
        _stage(z, h, constants, k[i])
    for i in range(len(y)):
        rise = y[i] - y_0[i]
        dense[1, i] = rise
        dense[2, i] = k[0, i] - rise
        dense[3, i] = 2.0 * rise - (k[0, i] + k[12, i])
    for n in range(4):
        dense[4 + n] = 0.0
        _combine(DENSE + n, dense[4 + n], k, dense[4 + n], constants)
    clock[DENSE_OF] = clock[STEPS]


@inlined
def interpolate(
    t_s: np.ndarray,
    wanted: np.ndarray,
    out: np.ndarray,
    first: int,
    last: int,
    clock: np.ndarray,
    dense: np.ndarray,
) -> None:
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
