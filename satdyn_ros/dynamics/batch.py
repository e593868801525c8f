"""
Many propagations side by side: the method of dop853.py with rows of lanes for numbers.

Every lane is one motion with steps of its own; when it has reached its last time, the next motion
takes its place.  A motion's numbers do not depend on its neighbours.  The loops over the lanes are
what the compiler turns into vector instructions.
"""

from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from ..compiled import compiled, inlined, is_kept
from .dop853 import (
    GROWTH,
    STEPS_PER_FIX,
    cut,
    direction_of_centre,
    error_of,
    first_step,
    interpolate,
    make_dense,
    step_ratio,
)
from .equations import CENTRE, MOMENTUM, OMEGA, SIZE, Parameters, initial_values, rates
from .motion import States
from .propagator import Propagation
from .tableau import COLUMNS, ENTRIES, ERROR_3, ERROR_5, LENGTHS

# Enough for two vector registers of today's widest; more would crowd the first-level cache.
LANES = 16
_WIDTH = SIZE * LANES
_ZERO = np.zeros(_WIDTH)
# Where the stages begin that a row of the tableau combines; unsigned, as in _at.
_BEGINS = (COLUMNS * _WIDTH).astype(np.uintp)


def propagate_all(motions: Sequence[Propagation], t_s: np.ndarray) -> list[States | RuntimeError]:
    """
    Return each motion's states at the ascending t_s (N,), or the error that ended it.

    As motion.at(t_s) would one by one, to rounding, in a fraction of the time.
    """
    t_s, found = np.asarray(t_s, float), {}
    alike = defaultdict(list)
    for motion in motions:
        alike[tuple(motion.wanted)].append(motion)
    for some in alike.values():
        out = np.empty((len(some), len(some[0].wanted), len(t_s)))
        halts_s = _fly(
            t_s,
            some[0].wanted,
            np.array([initial_values(motion.system, motion.state) for motion in some]),
            np.array([np.hstack([np.ravel(part) for part in motion.of]) for motion in some]),
            np.array([motion.anomaly for motion in some]),
            np.array([motion.tolerance for motion in some]),
            some[0].of.does_work,
            out,
        )
        for motion, rows, halt_s in zip(some, out, halts_s, strict=True):
            halted = halt_s < np.inf
            found[motion] = motion.halt(halt_s) if halted else motion.states_of(t_s, rows)
    return [found[motion] for motion in motions]


def is_compiled() -> bool:
    """Return whether the compiled code is on disk; without it, the first use takes seconds."""
    return is_kept(_fly)


@compiled
def _fly(t_s, wanted, begin, numbers, anomaly, tolerances, does_work, out):
    """
    Fill out (M, V, N) with the wanted variables of M motions at t_s (N,).

    Return the time at which each came to a halt (M,), infinite where it did not.

    begin (M, SIZE): the variables at the start.  numbers (M, P): the Parameters, one after the
    other.  anomaly (M, 3), tolerances (M,): as of a Propagation.
    """
    count, size = len(begin), max(MOMENTUM, wanted[-1] + 1) * LANES
    halts, waiting = np.full(count, np.inf), 0
    motion, first, steps = np.full(LANES, -1), np.zeros(LANES, np.int64), np.zeros(LANES, np.int64)
    t, h, largest_growth = np.zeros(LANES), np.zeros(LANES), np.zeros(LANES)
    error, ratio, tolerance = np.zeros(LANES), np.zeros(LANES), np.ones(LANES)
    of = np.zeros(numbers.shape[1] * LANES)
    y_0, y, k = np.zeros(_WIDTH), np.zeros(_WIDTH), np.zeros(13 * _WIDTH)
    e_3, e_5 = np.zeros(_WIDTH), np.zeros(_WIDTH)
    single = np.zeros(5), np.zeros(SIZE), np.zeros((16, SIZE)), np.zeros((8, SIZE))
    while True:
        idle = 0
        for l in range(LANES):
            if motion[l] < 0 and waiting < count:
                m = waiting
                waiting += 1
                motion[l], first[l], steps[l], t[l], largest_growth[l] = m, 0, 0, 0.0, GROWTH
                tolerance[l], of[l::LANES] = tolerances[m], numbers[m]
                y_0[l::LANES] = y[l::LANES] = begin[m]
                h[l] = first_step(_vector(y_0, OMEGA, l), _constants(of, l, does_work))
            if motion[l] < 0:
                idle += 1
            elif steps[l] % STEPS_PER_FIX == 0:
                cos_f, sin_f = direction_of_centre(anomaly[motion[l]], t[l])
                y_0[_at(CENTRE, l)], y_0[_at(CENTRE + 1, l)] = cos_f, sin_f
        if idle == LANES:
            return halts

        _attempt(y_0, t, h, of, does_work, tolerance, size, k, y, e_3, e_5, error, ratio)
        for l in range(LANES):
            m = motion[l]
            if m < 0:
                continue
            if error[l] <= 1.0:
                end = t[l] + h[l]
                last = first[l]
                while last < len(t_s) and t_s[last] <= end:
                    last += 1
                if last > first[l]:
                    _take_lane(l, t[l], h[l], y_0, y, k, single)
                    make_dense(*single, _constants(of, l, does_work))
                    interpolate(t_s, wanted, out[m], first[l], last, single[0], single[3])
                    first[l] = last
                t[l], h[l] = end, h[l] * min(largest_growth[l], ratio[l])
                steps[l], largest_growth[l] = steps[l] + 1, GROWTH
            else:
                h[l] *= cut(error[l], ratio[l])
                largest_growth[l] = 1.0
                if not t[l] + h[l] > t[l]:
                    halts[m], motion[l], h[l] = t[l], -1, 0.0
            if first[l] == len(t_s):
                motion[l], h[l] = -1, 0.0
        _advance(error, size, y, y_0)


@inlined
def _attempt(y_0, t, h, of, does_work, tolerance, size, k, y, e_3, e_5, error, ratio):
    """Take a step h of every lane from y_0 at t to y, and write what _errors does."""
    lanes = len(h)
    for l in range(lanes):
        h[l] = (t[l] + h[l]) - t[l]
    _stage(y_0, h, of, does_work, 0, k)
    for i in range(1, 13):
        _combine(i, y_0, k, size, y)
        _stage(y, h, of, does_work, i, k)
    _combine(ERROR_3, _ZERO, k, size, e_3)
    _combine(ERROR_5, _ZERO, k, size, e_5)
    _errors(y_0, h, of, k, e_3, e_5, tolerance, error, ratio)


@inlined
def _stage(y, h, of, does_work, i, k):
    """Write k_i = h f(y)."""
    # A flag that is known lets the loop be one of vectors.
    if does_work:
        for l in range(len(h)):
            _stage_of_lane(l, y, h, _constants(of, l, True), i, k)
    else:
        for l in range(len(h)):
            _stage_of_lane(l, y, h, _constants(of, l, False), i, k)


@inlined
def _stage_of_lane(l, y, h, of, i, k):
    f, h, r = rates(_values(y, l), of), h[l], i * SIZE
    k[_at(r, l)], k[_at(r + 1, l)], k[_at(r + 2, l)] = h * f[0], h * f[1], h * f[2]
    k[_at(r + 3, l)], k[_at(r + 4, l)], k[_at(r + 5, l)] = h * f[3], h * f[4], h * f[5]
    k[_at(r + 6, l)], k[_at(r + 7, l)], k[_at(r + 8, l)] = h * f[6], h * f[7], h * f[8]
    k[_at(r + 9, l)], k[_at(r + 10, l)], k[_at(r + 11, l)] = h * f[9], h * f[10], h * f[11]


@inlined
def _combine(row, y, k, size, z):
    """Write z = y + sum_j a_j k_j with row's entries a_j to the first size numbers of z."""
    a, i = _entries(row, 0), _stages(row, 0)
    if LENGTHS[row] <= 4:
        for m in range(size):
            z[m] = y[m] + _sum(a, i, k, m)
        return
    b, j = _entries(row, 4), _stages(row, 4)
    if LENGTHS[row] <= 8:
        for m in range(size):
            z[m] = y[m] + _sum(a, i, k, m) + _sum(b, j, k, m)
        return
    c, n = _entries(row, 8), _stages(row, 8)
    for m in range(size):
        z[m] = y[m] + _sum(a, i, k, m) + _sum(b, j, k, m) + _sum(c, n, k, m)


@inlined
def _entries(row, n):
    return ENTRIES[row, n], ENTRIES[row, n + 1], ENTRIES[row, n + 2], ENTRIES[row, n + 3]


@inlined
def _stages(row, n):
    return _BEGINS[row, n], _BEGINS[row, n + 1], _BEGINS[row, n + 2], _BEGINS[row, n + 3]


@inlined
def _sum(a, i, k, m):
    m = np.uintp(m)
    return a[0] * k[i[0] + m] + a[1] * k[i[1] + m] + a[2] * k[i[2] + m] + a[3] * k[i[3] + m]


@inlined
def _errors(y_0, h, of, k, e_3, e_5, tolerance, error, ratio):
    """Write the error of each lane's step over its tolerance, and the next step over this one."""
    for l in range(len(h)):
        omega, k_omega = _vector(y_0, OMEGA, l), _vector(k, OMEGA, l)
        slow_rate = of[_at(47, l)]
        e = error_of(omega, k_omega, _values(e_3, l)[:9], _values(e_5, l)[:9], h[l], slow_rate)
        error[l] = e / tolerance[l]
        ratio[l] = step_ratio(e / tolerance[l])


@inlined
def _advance(error, size, y, y_0):
    """Let the lanes whose step is good begin from its end."""
    for i in range(size // LANES):
        for l in range(len(error)):
            at = _at(i, l)
            y_0[at] = y[at] if error[l] <= 1.0 else y_0[at]


@inlined
def _take_lane(l, t, h, y_0, y, k, single):
    """Copy a lane's step to the clock, end, stages and dense output of a single propagation."""
    clock, end, stages, dense = single
    clock[0], clock[1] = t, t + h
    end[:], dense[0] = y[l::LANES], y_0[l::LANES]
    for i in range(13):
        stages[i] = k[i * _WIDTH + l : (i + 1) * _WIDTH : LANES]


@inlined
def _at(row, l):
    """Return where a lane's number of a row is; unsigned, which cannot count from the end."""
    return np.uintp(row * LANES) + np.uintp(l)


@inlined
def _vector(y, i, l):
    return y[_at(i, l)], y[_at(i + 1, l)], y[_at(i + 2, l)]


@inlined
def _matrix(of, i, l):
    return _vector(of, i, l), _vector(of, i + 3, l), _vector(of, i + 6, l)


@inlined
def _values(y, l):
    """Return a lane's variables."""
    return _vector(y, 0, l) + _vector(y, 3, l) + _vector(y, 6, l) + _vector(y, 9, l)


@inlined
def _constants(of, l, does_work):
    """Return a lane's Parameters."""
    return Parameters(
        _matrix(of, 0, l),
        _matrix(of, 9, l),
        _matrix(of, 18, l),
        _vector(of, 27, l),
        _vector(of, 30, l),
        _vector(of, 33, l),
        of[_at(36, l)],
        of[_at(37, l)],
        of[_at(38, l)],
        of[_at(39, l)],
        of[_at(40, l)],
        _vector(of, 41, l),
        _vector(of, 44, l),
        of[_at(47, l)],
        does_work,
    )
