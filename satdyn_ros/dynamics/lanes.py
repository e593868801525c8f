"""
One step of many propagations side by side: that of dop853.py with rows of lanes for numbers.

The loops over the lanes are what the compiler turns into vector instructions.  A lane's numbers do
not depend on its neighbours.

The loops of dop853.py stand beside these because lanes of width one cannot replace them: measured
on reference cases, they take 1.1 to 1.4 times the processor time, and sum the stages in another
order, so that bags would no longer verify byte for byte (attitudes differ by up to 3e-12).
"""

from typing import Any, NamedTuple

import numpy as np

from ..compiled import inlined, replaced
from .dop853 import error_of, line_zeros, step_ratio
from .equations import MOMENTUM, OMEGA, Parameters, RotorParameters, parameters, rates
from .system import System
from .tableau import COLUMNS, ENTRIES, ERROR_3, ERROR_5, LENGTHS

# Enough for two vector registers of the widest kind; more would crowd the first-level cache.
LANES = 16
_CORE = (0.0,) * MOMENTUM
# The tableau's columns; unsigned, as in at_lane.
_COLUMNS = COLUMNS.astype(np.uintp)


def numbers_of(part: tuple) -> list[float]:
    """Return the numbers of nested tuples, such as Parameters, one after the other."""
    numbers: list[float] = []
    for each in part:
        if isinstance(each, tuple):
            numbers += numbers_of(each)
        else:
            numbers.append(each)
    return numbers


def _begins(parts) -> Any:
    """Return where the numbers of each part begin among those of all."""
    return np.cumsum([0] + [len(numbers_of((part,))) for part in parts])[:-1].tolist()


# Where each of the Parameters begins among their numbers, and each constant of a rotor among its.
_SAMPLE = parameters(System(np.eye(3)))
_AT: Any = Parameters(*_begins(_SAMPLE))
_ROTOR = _SAMPLE.rotors[0]
_IN_ROTOR: Any = RotorParameters(*_begins(_ROTOR))
_ROTOR_SIZE = len(numbers_of(_ROTOR))


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

    @classmethod
    def empty(cls, size: int, numbers: int) -> 'Lanes':
        """Return lanes in which nothing flies: of `size` variables and as many `numbers`."""
        return cls(
            motion=np.full(LANES, -1),
            waiting=np.zeros(1, int),
            steps=np.zeros(LANES, int),
            since=line_zeros(LANES),
            t=line_zeros(LANES),
            h=line_zeros(LANES),
            largest_growth=line_zeros(LANES),
            tolerance=np.ones(LANES),
            constants=line_zeros(numbers * LANES),
            y_0=line_zeros(size * LANES),
            y=line_zeros(size * LANES),
            k=line_zeros(12 * size * LANES),
            e_3=line_zeros(size * LANES),
            e_5=line_zeros(size * LANES),
            zeros=line_zeros(size * LANES),
            error=line_zeros(LANES),
            ratio=line_zeros(LANES),
        )


@inlined
def attempt(lanes: Lanes, like: Parameters, size: int) -> None:
    """
    Take a step h of every lane from y_0 at t to y, and write its error and ratio.

    like: the Parameters of one motion, as in batch.py; size: of y, the variables that change.
    """
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
            _stage_of_lane(l, y, h, constants_of_lane(constants, l, like, True), i, k)
    else:
        for l in range(LANES):
            _stage_of_lane(l, y, h, constants_of_lane(constants, l, like, False), i, k)


@inlined
def _stage_of_lane(l, y, h, constants, i, k):
    f, h = rates(_variables(y, l, constants), constants), h[l]
    begin = at_lane(i * len(f), l)
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
        constants = constants_of_lane(lanes.constants, l, like, like.does_work)
        e = error_of(
            _variables(lanes.y_0, l, like),
            _variables(lanes.y, l, like),
            vector(lanes.k, OMEGA, l),
            _variables(lanes.e_3, l, like),
            _variables(lanes.e_5, l, like),
            lanes.h[l],
            constants,
        )
        lanes.error[l] = e / lanes.tolerance[l]
        lanes.ratio[l] = step_ratio(e / lanes.tolerance[l])


@inlined
def advance(error: np.ndarray, changing: int, y: np.ndarray, y_0: np.ndarray) -> None:
    """Let the lanes whose step is accepted go on from its end; changing: variables that do."""
    for i in range(changing):
        for l in range(len(error)):
            at = at_lane(i, l)
            y_0[at] = y[at] = y[at] if error[l] <= 1.0 else y_0[at]


@inlined
def take_lane(
    l: int,
    t: float,
    h: float,
    y_0: np.ndarray,
    y: np.ndarray,
    k: np.ndarray,
    single: tuple[np.ndarray, ...],
) -> None:
    """Copy a lane's step to the clock, end, stages and dense output of a single propagation."""
    clock, end, stages, dense = single
    size = len(y) // LANES
    clock[0], clock[1] = t, t + h
    end[:size], dense[0, :size] = y[l::LANES], y_0[l::LANES]
    for i in range(12):
        stages[i, :size] = k[i * len(y) + l : (i + 1) * len(y) : LANES]


@inlined
def at_lane(row: int, l: int) -> np.uintp:
    """Return where a lane's number of a row is; unsigned, which cannot count from the end."""
    return np.uintp(row * LANES) + np.uintp(l)


@inlined
def vector(y: np.ndarray, i: int, l: int) -> tuple[float, ...]:
    """Return a lane's three numbers of the rows from i on."""
    return y[at_lane(i, l)], y[at_lane(i + 1, l)], y[at_lane(i + 2, l)]


@inlined
def _matrix(of, i, l):
    return vector(of, i, l), vector(of, i + 3, l), vector(of, i + 6, l)


@inlined
def _variables(y, l, constants):
    """Return a lane's variables."""
    values = _CORE + constants.zeros + constants.zeros + (0.0,)
    for i in range(len(values)):
        values = replaced(values, i, y[at_lane(i, l)])
    return values


@inlined
def constants_of_lane(
    numbers: np.ndarray, l: int, like: Parameters, does_work: bool
) -> Parameters:
    """Return a lane's Parameters."""
    rotors = like.rotors
    for i in range(len(rotors)):
        at = _AT.rotors + i * _ROTOR_SIZE
        rotor = RotorParameters(
            axis=vector(numbers, at + _IN_ROTOR.axis, l),
            torque=numbers[at_lane(at + _IN_ROTOR.torque, l)],
            friction=numbers[at_lane(at + _IN_ROTOR.friction, l)],
            inertia_inverse=numbers[at_lane(at + _IN_ROTOR.inertia_inverse, l)],
        )
        rotors = replaced(rotors, i, rotor)
    return Parameters(
        inertia=_matrix(numbers, _AT.inertia, l),
        carrier_inertia=_matrix(numbers, _AT.carrier_inertia, l),
        carrier_inverse=_matrix(numbers, _AT.carrier_inverse, l),
        weight_moment=vector(numbers, _AT.weight_moment, l),
        applied=vector(numbers, _AT.applied, l),
        eccentricity=numbers[at_lane(_AT.eccentricity, l)],
        anomaly_rate=numbers[at_lane(_AT.anomaly_rate, l)],
        gradient=numbers[at_lane(_AT.gradient, l)],
        to_pericentre=vector(numbers, _AT.to_pericentre, l),
        ahead=vector(numbers, _AT.ahead, l),
        slow_rate=numbers[at_lane(_AT.slow_rate, l)],
        does_work=does_work,
        rotors=rotors,
        zeros=like.zeros,
    )
