"""
Many propagations side by side: the method of dop853.py with rows of lanes for numbers.

Every lane is one motion with steps of its own; when it has reached its last time, the next motion
takes its place.  A motion's numbers do not depend on its neighbours.  The loops over the lanes are
what the compiler turns into vector instructions.
"""

from collections import defaultdict
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..compiled import compiled, inlined
from .dop853 import (
    GROWTH,
    REACHED,
    STEPS_PER_FIX,
    STUCK,
    TOO_MANY_STEPS,
    UNFINISHED,
    cut,
    direction_of_centre,
    error_of,
    first_step,
    interpolate,
    is_finite,
    make_dense,
    step_ratio,
)
from .equations import (
    CENTRE,
    MOMENTUM,
    OMEGA,
    SIZE,
    Parameters,
    initial_values,
    parameters_of_many,
    rates,
)
from .motion import Halted, States
from .propagator import Propagation, columns, mean_anomaly, wanted_variables
from .system import State, System
from .tableau import COLUMNS, ENTRIES, ERROR_3, ERROR_5, LENGTHS

# Enough for two vector registers of today's widest; more would crowd the first-level cache.
LANES = 16
_WIDTH = SIZE * LANES
# The most steps of a slice, in all lanes.
_SLICE_STEPS = 500
_ZERO = np.zeros(_WIDTH)
# Where the stages begin that a row of the tableau combines; unsigned, as in _at.
_BEGINS = (COLUMNS * _WIDTH).astype(np.uintp)


class Flights(NamedTuple):
    """
    What M motions start from and what they come to.

    begin (M, SIZE): the variables at the start; numbers (M, P): the Parameters, one after the
    other; anomaly (M, 3), tolerance (M,), steps_allowed (M,): as of a Propagation.  out (M, V, N):
    the wanted variables; outcome (M,): of dop853.py; reached_s (M,) and rows (M,): where it ended.
    """

    begin: np.ndarray
    numbers: np.ndarray
    anomaly: np.ndarray
    tolerance: np.ndarray
    steps_allowed: np.ndarray
    out: np.ndarray
    outcome: np.ndarray
    reached_s: np.ndarray
    rows: np.ndarray


class Lanes(NamedTuple):
    """
    The steps in all lanes, each an array of a number per lane, or of rows of such numbers.

    motion: which of them flies there, -1: none; waiting (1,): the next to take a lane; steps and
    since: taken from the start, from the last row; t, h, error, ratio: begin, length, error of the
    step over the tolerance, and next length over this one; y_0, y, k, e_3, e_5: variables at begin
    and end, stages, errors.
    """

    motion: np.ndarray
    waiting: np.ndarray
    steps: np.ndarray
    since: np.ndarray
    t: np.ndarray
    h: np.ndarray
    largest_growth: np.ndarray
    tolerance: np.ndarray
    constants: np.ndarray
    y_0: np.ndarray
    y: np.ndarray
    k: np.ndarray
    e_3: np.ndarray
    e_5: np.ndarray
    error: np.ndarray
    ratio: np.ndarray


def propagate_all(motions: Sequence[Propagation], t_s: np.ndarray) -> list[States | Halted]:
    """
    Return each motion's states at the ascending t_s (N,), or the error that ended it.

    As motion.at(t_s) would one by one, to rounding, in a fraction of the time.
    """
    t_s, found = np.asarray(t_s, float), {}
    alike = defaultdict(list)
    for motion in motions:
        alike[tuple(motion.wanted)].append(motion)
    for some in alike.values():
        flights = _flights(
            begin=np.array([initial_values(motion.system, motion.state) for motion in some]),
            numbers=np.array([np.hstack([np.ravel(part) for part in m.of]) for m in some]),
            anomaly=np.array([motion.anomaly for motion in some]),
            tolerance=np.array([motion.tolerance for motion in some]),
            steps_allowed=np.array([motion.steps_allowed for motion in some]),
            shape=(len(some[0].wanted), len(t_s)),
        )
        _fly_together(flights, some[0].wanted, some[0].of.does_work, t_s)
        for motion, rows, outcome, reached_s, count in zip(some, *flights[-4:], strict=True):
            states = motion.states_of(t_s[:count], rows[:, :count])
            halted = outcome != REACHED
            found[motion] = motion.halted(outcome, float(reached_s), states) if halted else states
    return [found[motion] for motion in motions]


def propagate_many(
    system: System, state: State, tolerance: np.ndarray, t_s: np.ndarray
) -> tuple[States, np.ndarray]:
    """
    Return the states of M motions at the ascending t_s (N,), and whether each got there (M,).

    The constants of the system and the state may be arrays: (M, 1), vectors (M, 1, 3), matrices
    (M, 1, 3, 3); q_ib is (M, 1, 4), tolerance (M,).  All begin at tick 0.
    """
    count = len(tolerance)
    numbers = parameters_of_many(system, count)
    does_work = bool(numbers[0, -1])
    wanted = wanted_variables(system, does_work)
    flights = _flights(
        begin=initial_values(system, state)[:, 0],
        numbers=numbers,
        anomaly=np.broadcast_to(np.reshape(mean_anomaly(system, 0.0), (-1, 3)), (count, 3)),
        tolerance=tolerance,
        steps_allowed=np.full(count, np.inf),
        shape=(len(wanted), len(t_s)),
    )
    _fly_together(flights, wanted, does_work, t_s)
    q_ib, omega_bi_b, speed, angle, work = columns(system, wanted, flights.out)
    states = States(t_s, q_ib, omega_bi_b, speed, angle, work, system.orbit, t_s)
    return states, flights.outcome == REACHED


def _flights(begin, numbers, anomaly, tolerance, steps_allowed, shape):
    """Return Flights that have not begun; shape: of the variables that are wanted of each."""
    count = len(begin)
    return Flights(
        begin=begin,
        numbers=numbers,
        anomaly=np.ascontiguousarray(anomaly),
        tolerance=tolerance,
        steps_allowed=steps_allowed,
        out=np.empty((count, *shape)),
        outcome=np.full(count, REACHED if shape[1] == 0 else UNFINISHED),
        reached_s=np.zeros(count),
        rows=np.zeros(count, int),
    )


def _fly_together(flights, wanted, does_work, t_s):
    """Fly all to the end of t_s, or to theirs."""
    lanes = Lanes(
        motion=np.full(LANES, -1),
        waiting=np.zeros(1, int),
        steps=np.zeros(LANES, int),
        since=np.zeros(LANES),
        t=np.zeros(LANES),
        h=np.zeros(LANES),
        largest_growth=np.zeros(LANES),
        tolerance=np.ones(LANES),
        constants=np.zeros(flights.numbers.shape[1] * LANES),
        y_0=np.zeros(_WIDTH),
        y=np.zeros(_WIDTH),
        k=np.zeros(13 * _WIDTH),
        e_3=np.zeros(_WIDTH),
        e_5=np.zeros(_WIDTH),
        error=np.zeros(LANES),
        ratio=np.zeros(LANES),
    )
    single = np.zeros(7), np.zeros(SIZE), np.zeros((16, SIZE)), np.zeros((8, SIZE))
    # Slices, between which Ctrl-C and other threads get their turn.
    while len(t_s) and not _fly(t_s, wanted, flights, lanes, single, does_work):
        pass


@compiled
def _fly(t_s, wanted, flights, lanes, single, does_work):
    """Fly on for a slice; return whether all flights have ended.  single: see _take_lane."""
    begin, outcome, rows = flights.begin, flights.outcome, flights.rows
    motion, steps, since, t, h = lanes.motion, lanes.steps, lanes.since, lanes.t, lanes.h
    y_0, y, error, ratio, constants = lanes.y_0, lanes.y, lanes.error, lanes.ratio, lanes.constants
    size = max(MOMENTUM, wanted[-1] + 1) * LANES
    for _ in range(_SLICE_STEPS):
        idle = 0
        for l in range(LANES):
            if motion[l] < 0 and lanes.waiting[0] < len(begin):
                m = lanes.waiting[0]
                lanes.waiting[0] += 1
                motion[l], steps[l], since[l], t[l], lanes.largest_growth[l] = (
                    m,
                    0,
                    0.0,
                    0.0,
                    GROWTH,
                )
                lanes.tolerance[l], constants[l::LANES] = flights.tolerance[m], flights.numbers[m]
                y_0[l::LANES] = y[l::LANES] = begin[m]
                h[l] = first_step(_vector(y_0, OMEGA, l), _constants(constants, l, does_work))
                rows[m] = _rows_at_begin(t_s, wanted, begin[m], flights.out[m], single)
            if motion[l] < 0:
                idle += 1
            elif steps[l] % STEPS_PER_FIX == 0:
                cos_f, sin_f = direction_of_centre(flights.anomaly[motion[l]], t[l])
                y_0[_at(CENTRE, l)], y_0[_at(CENTRE + 1, l)] = cos_f, sin_f
        if idle == LANES:
            return True

        _attempt(lanes, does_work, size)
        for l in range(LANES):
            m = motion[l]
            if m < 0:
                continue
            if not is_finite(*_vector(y, MOMENTUM, l)):
                error[l] = np.inf
            if error[l] <= 1.0:
                end = t[l] + h[l]
                first = last = rows[m]
                while last < len(t_s) and t_s[last] <= end:
                    last += 1
                since[l] += 1.0
                if last > first:
                    _take_lane(l, t[l], h[l], y_0, y, lanes.k, single)
                    make_dense(*single, _constants(constants, l, does_work))
                    interpolate(t_s, wanted, flights.out[m], first, last, single[0], single[3])
                    rows[m], since[l] = last, 0.0
                t[l], h[l] = end, h[l] * min(lanes.largest_growth[l], ratio[l])
                steps[l], lanes.largest_growth[l] = steps[l] + 1, GROWTH
                if since[l] >= flights.steps_allowed[m]:
                    outcome[m] = TOO_MANY_STEPS
            else:
                h[l] *= cut(error[l], ratio[l])
                lanes.largest_growth[l] = 1.0
                if not t[l] < t[l] + h[l] < np.inf:
                    outcome[m] = STUCK
            if rows[m] == len(t_s):
                outcome[m] = REACHED
            if outcome[m] != UNFINISHED:
                flights.reached_s[m], motion[l], h[l] = t[l], -1, 0.0
        _advance(error, size, y, y_0)
    return False


@inlined
def _rows_at_begin(t_s, wanted, begin, out, single):
    """Fill the rows at t = 0, whatever the first step will be; return how many there are."""
    clock, _, _, dense = single
    clock[:], dense[:] = 0.0, 0.0
    dense[0] = begin
    last = 0
    while last < len(t_s) and t_s[last] <= 0.0:
        last += 1
    interpolate(t_s, wanted, out, 0, last, clock, dense)
    return last


@inlined
def _attempt(lanes, does_work, size):
    """Take a step h of every lane from y_0 at t to y, and write what _errors does."""
    t, h, constants, k, y_0, y = lanes.t, lanes.h, lanes.constants, lanes.k, lanes.y_0, lanes.y
    for l in range(LANES):
        h[l] = (t[l] + h[l]) - t[l]
    _stage(y_0, h, constants, does_work, 0, k)
    for i in range(1, 13):
        _combine(i, y_0, k, size, y)
        _stage(y, h, constants, does_work, i, k)
    _combine(ERROR_3, _ZERO, k, size, lanes.e_3)
    _combine(ERROR_5, _ZERO, k, size, lanes.e_5)
    _errors(lanes)


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
def _errors(lanes):
    """Write the error of each lane's step over its tolerance, and the next step over this one."""
    for l in range(LANES):
        e = error_of(
            _vector(lanes.y_0, OMEGA, l),
            _vector(lanes.k, OMEGA, l),
            _values(lanes.e_3, l)[:9],
            _values(lanes.e_5, l)[:9],
            lanes.h[l],
            lanes.constants[_at(47, l)],
        )
        lanes.error[l] = e / lanes.tolerance[l]
        lanes.ratio[l] = step_ratio(e / lanes.tolerance[l])


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
