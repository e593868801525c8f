"""
Many propagations side by side: the method of dop853.py with rows of lanes for numbers.

Every lane is one motion with steps of its own; when it has reached its last time, the next motion
takes its place.  A motion's numbers do not depend on its neighbours.  The loops over the lanes are
what the compiler turns into vector instructions.

The loops of dop853.py stand beside these because lanes of width one cannot replace them: measured
on reference cases, they take 1.1 to 1.4 times the processor time, and sum the stages in another
order, so that bags would no longer verify byte for byte (attitudes differ by up to 3e-12).
"""

from collections import defaultdict
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..compiled import compiled, inlined, replaced
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
    line_zeros,
    make_dense,
    step_arrays,
    step_ratio,
)
from .equations import (
    CENTRE,
    MOMENTUM,
    OMEGA,
    Parameters,
    RotorParameters,
    initial_values,
    numbers_of_many,
    parameters,
    rates,
)
from .motion import Halted, States
from .propagator import Propagation, columns, mean_anomaly, wanted_variables
from .system import State, System
from .tableau import COLUMNS, ENTRIES, ERROR_3, ERROR_5, LENGTHS

# Enough for two vector registers of the widest kind; more would crowd the first-level cache.
LANES = 16
# The most steps of a slice, in all lanes.
_SLICE_STEPS = 500
_CORE = (0.0,) * MOMENTUM
# The tableau's columns; unsigned, as in _at.
_COLUMNS = COLUMNS.astype(np.uintp)


def _numbers(part) -> list[float]:
    """Return the numbers of nested tuples, such as Parameters, one after the other."""
    numbers: list[float] = []
    for each in part:
        if isinstance(each, tuple):
            numbers += _numbers(each)
        else:
            numbers.append(each)
    return numbers


def _begins(parts) -> Any:
    """Return where the numbers of each part begin among those of all."""
    return np.cumsum([0] + [len(_numbers((part,))) for part in parts])[:-1].tolist()


# Where each of the Parameters begins among their numbers, and each constant of a rotor among its.
_SAMPLE = parameters(System(np.eye(3)))
_AT: Any = Parameters(*_begins(_SAMPLE))
_ROTOR = _SAMPLE.rotors[0]
_IN_ROTOR: Any = RotorParameters(*_begins(_ROTOR))
_ROTOR_SIZE = len(_numbers(_ROTOR))


class Flights(NamedTuple):
    """
    The starts and the results of M motions.

    begin (M, V): the variables at the start; numbers (M, P): the Parameters, one after the
    other; anomaly (M, 3), tolerance (M,), steps_allowed (M,): as of a Propagation.  out (M, W, N):
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
    step over the tolerance, and next length over this one; y_0, y, k, e_3, e_5: variables at start
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
    zeros: np.ndarray
    error: np.ndarray
    ratio: np.ndarray


def propagate_all(motions: Sequence[Propagation], t_s: np.ndarray) -> list[States | Halted]:
    """
    Return each motion's states at the ascending t_s (N,), or the error that ended it.

    The same as motion.at(t_s) of each, to rounding, in a fraction of the time.
    """
    t_s, found = np.asarray(t_s, float), {}
    alike = defaultdict(list)
    for motion in motions:
        alike[tuple(motion.wanted), len(motion.constants.rotors)].append(motion)
    for some in alike.values():
        flights = _flights(
            begin=np.array([initial_values(motion.system, motion.state) for motion in some]),
            numbers=np.array([_numbers(motion.constants) for motion in some]),
            anomaly=np.array([motion.anomaly for motion in some]),
            tolerance=np.array([motion.tolerance for motion in some]),
            steps_allowed=np.array([motion.steps_allowed for motion in some]),
            shape=(len(some[0].wanted), len(t_s)),
        )
        _fly_together(flights, some[0].wanted, some[0].constants, t_s)
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
    like, numbers = numbers_of_many(system, count)
    wanted = wanted_variables(system, like.does_work)
    flights = _flights(
        begin=initial_values(system, state)[:, 0],
        numbers=numbers,
        anomaly=np.column_stack(
            [np.broadcast_to(np.ravel(each), count) for each in mean_anomaly(system, 0.0)]
        ),
        tolerance=tolerance,
        steps_allowed=np.full(count, np.inf),
        shape=(len(wanted), len(t_s)),
    )
    _fly_together(flights, wanted, like, t_s)
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


def _fly_together(flights, wanted, like, t_s):
    """Fly all to the end of t_s, or to theirs."""
    size = flights.begin.shape[1]
    lanes = Lanes(
        motion=np.full(LANES, -1),
        waiting=np.zeros(1, int),
        steps=np.zeros(LANES, int),
        since=line_zeros(LANES),
        t=line_zeros(LANES),
        h=line_zeros(LANES),
        largest_growth=line_zeros(LANES),
        tolerance=np.ones(LANES),
        constants=line_zeros(flights.numbers.shape[1] * LANES),
        y_0=line_zeros(size * LANES),
        y=line_zeros(size * LANES),
        k=line_zeros(12 * size * LANES),
        e_3=line_zeros(size * LANES),
        e_5=line_zeros(size * LANES),
        zeros=line_zeros(size * LANES),
        error=line_zeros(LANES),
        ratio=line_zeros(LANES),
    )
    single = np.zeros(7), *step_arrays(size)
    # Slices, between which Ctrl-C and other threads get their turn.
    while len(t_s) and not _fly(t_s, wanted, flights, lanes, single, like):
        pass


@compiled
def _fly(t_s, wanted, flights, lanes, single, like):
    """
    Fly on for a slice; return whether all flights have ended.

    single: see _take_lane.  like: the Parameters of one motion, which tell the compiler how many
    rotors there are, and whether work is done, in all.
    """
    begin, outcome, rows = flights.begin, flights.outcome, flights.rows
    motion, steps, since, t, h = lanes.motion, lanes.steps, lanes.since, lanes.t, lanes.h
    y_0, y, error, ratio, constants = lanes.y_0, lanes.y, lanes.error, lanes.ratio, lanes.constants
    # Variables beyond those are constant, or not wanted.
    changing = max(MOMENTUM, wanted[-1] + 1)
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
                h[l] = first_step(
                    _vector(y_0, OMEGA, l), _constants(constants, l, like, like.does_work)
                )
                rows[m] = _rows_at_begin(t_s, wanted, begin[m], flights.out[m], single)
            if motion[l] < 0:
                idle += 1
            elif steps[l] % STEPS_PER_FIX == 0:
                cos_f, sin_f = direction_of_centre(flights.anomaly[motion[l]], t[l])
                y_0[_at(CENTRE, l)], y_0[_at(CENTRE + 1, l)] = cos_f, sin_f
                y[_at(CENTRE, l)], y[_at(CENTRE + 1, l)] = cos_f, sin_f
        if idle == LANES:
            return True

        _attempt(lanes, like, changing * LANES)
        for l in range(LANES):
            m = motion[l]
            if m < 0:
                continue
            if error[l] <= 1.0:
                end = t[l] + h[l]
                first = last = rows[m]
                while last < len(t_s) and t_s[last] <= end:
                    last += 1
                since[l] += 1.0
                if last > first:
                    _take_lane(l, t[l], h[l], y_0, y, lanes.k, single)
                    make_dense(*single, _constants(constants, l, like, like.does_work))
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
        _advance(error, changing, y, y_0)
    return False


@inlined
def _rows_at_begin(t_s, wanted, begin, out, single):
    """Fill the rows at t = 0, whatever the first step will be; return how many there are."""
    clock, _, _, dense = single
    clock[:], dense[:] = 0.0, 0.0
    dense[0, : len(begin)] = begin
    last = 0
    while last < len(t_s) and t_s[last] <= 0.0:
        last += 1
    interpolate(t_s, wanted, out, 0, last, clock, dense)
    return last


@inlined
def _attempt(lanes, like, size):
    """Take a step h of every lane from y_0 at t to y, and write what _errors does."""
    t, h, constants, k, y_0, y = lanes.t, lanes.h, lanes.constants, lanes.k, lanes.y_0, lanes.y
    width = np.uintp(len(y))
    for l in range(LANES):
        h[l] = (t[l] + h[l]) - t[l]
    for i in range(12):
        _stage(y, h, constants, like, i, k)
        _combine(i + 1, y_0, k, width, size, y)
    for row, e in ((ERROR_3, lanes.e_3), (ERROR_5, lanes.e_5)):
        _combine(row, lanes.zeros, k, width, size, e)
    _errors(lanes, like)


@inlined
def _stage(y, h, constants, like, i, k):
    """Write k_i = h f(y)."""
    # A constant flag lets the compiler vectorise the loop.
    if like.does_work:
        for l in range(LANES):
            _stage_of_lane(l, y, h, _constants(constants, l, like, True), i, k)
    else:
        for l in range(LANES):
            _stage_of_lane(l, y, h, _constants(constants, l, like, False), i, k)


@inlined
def _stage_of_lane(l, y, h, constants, i, k):
    f, h = rates(_variables(y, l, constants), constants), h[l]
    begin = _at(i * len(f), l)
    for n in range(len(f)):
        # A product with the stage i in here would keep the compiler from vectors.
        k[begin + np.uintp(n * LANES)] = h * f[n]


@inlined
def _combine(row, y, k, width, size, z):
    """Write z = y + sum_j a_j k_j with row's entries a_j to the first size numbers of z."""
    a, i = _entries(row, 0), _stages(row, 0, width)
    if LENGTHS[row] <= 4:
        for m in range(size):
            z[m] = y[m] + _sum(a, i, k, m)
        return
    b, j = _entries(row, 4), _stages(row, 4, width)
    if LENGTHS[row] <= 8:
        for m in range(size):
            z[m] = y[m] + _sum(a, i, k, m) + _sum(b, j, k, m)
        return
    c, n = _entries(row, 8), _stages(row, 8, width)
    for m in range(size):
        z[m] = y[m] + _sum(a, i, k, m) + _sum(b, j, k, m) + _sum(c, n, k, m)


@inlined
def _entries(row, n):
    return ENTRIES[row, n], ENTRIES[row, n + 1], ENTRIES[row, n + 2], ENTRIES[row, n + 3]


@inlined
def _stages(row, n, width):
    """Return where four of the stages begin that a row of the tableau combines."""
    return (
        _COLUMNS[row, n] * width,
        _COLUMNS[row, n + 1] * width,
        _COLUMNS[row, n + 2] * width,
        _COLUMNS[row, n + 3] * width,
    )


@inlined
def _sum(a, i, k, m):
    m = np.uintp(m)
    return a[0] * k[i[0] + m] + a[1] * k[i[1] + m] + a[2] * k[i[2] + m] + a[3] * k[i[3] + m]


@inlined
def _errors(lanes, like):
    """Write the error of each lane's step over its tolerance, and the next step over this one."""
    for l in range(LANES):
        constants = _constants(lanes.constants, l, like, like.does_work)
        e = error_of(
            _variables(lanes.y_0, l, like),
            _variables(lanes.y, l, like),
            _vector(lanes.k, OMEGA, l),
            _variables(lanes.e_3, l, like),
            _variables(lanes.e_5, l, like),
            lanes.h[l],
            constants,
        )
        lanes.error[l] = e / lanes.tolerance[l]
        lanes.ratio[l] = step_ratio(e / lanes.tolerance[l])


@inlined
def _advance(error, changing, y, y_0):
    """Let the lanes whose step is accepted go on from its end."""
    for i in range(changing):
        for l in range(len(error)):
            at = _at(i, l)
            y_0[at] = y[at] = y[at] if error[l] <= 1.0 else y_0[at]


@inlined
def _take_lane(l, t, h, y_0, y, k, single):
    """Copy a lane's step to the clock, end, stages and dense output of a single propagation."""
    clock, end, stages, dense = single
    size = len(y) // LANES
    clock[0], clock[1] = t, t + h
    end[:size], dense[0, :size] = y[l::LANES], y_0[l::LANES]
    for i in range(12):
        stages[i, :size] = k[i * len(y) + l : (i + 1) * len(y) : LANES]


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
def _variables(y, l, constants):
    """Return a lane's variables."""
    values = _CORE + constants.zeros + constants.zeros + (0.0,)
    for i in range(len(values)):
        values = replaced(values, i, y[_at(i, l)])
    return values


@inlined
def _constants(numbers, l, like, does_work):
    """Return a lane's Parameters."""
    rotors = like.rotors
    for i in range(len(rotors)):
        at = _AT.rotors + i * _ROTOR_SIZE
        rotor = RotorParameters(
            axis=_vector(numbers, at + _IN_ROTOR.axis, l),
            torque=numbers[_at(at + _IN_ROTOR.torque, l)],
            friction=numbers[_at(at + _IN_ROTOR.friction, l)],
            inertia_inverse=numbers[_at(at + _IN_ROTOR.inertia_inverse, l)],
        )
        rotors = replaced(rotors, i, rotor)
    return Parameters(
        inertia=_matrix(numbers, _AT.inertia, l),
        carrier_inertia=_matrix(numbers, _AT.carrier_inertia, l),
        carrier_inverse=_matrix(numbers, _AT.carrier_inverse, l),
        weight_moment=_vector(numbers, _AT.weight_moment, l),
        applied=_vector(numbers, _AT.applied, l),
        eccentricity=numbers[_at(_AT.eccentricity, l)],
        anomaly_rate=numbers[_at(_AT.anomaly_rate, l)],
        gradient=numbers[_at(_AT.gradient, l)],
        to_pericentre=_vector(numbers, _AT.to_pericentre, l),
        ahead=_vector(numbers, _AT.ahead, l),
        slow_rate=numbers[_at(_AT.slow_rate, l)],
        does_work=does_work,
        rotors=rotors,
        zeros=like.zeros,
    )
