"""
Many propagations side by side: a step of dop853.py in every lane.

A lane's numbers do not depend on its neighbours.
"""

from typing import Any, NamedTuple

import numpy as np

from ..dynamics.constants import Parameters
from ..kernel.compile import inlined
from ..kernel.simd import all_less, filled, load, spread, store, where_less, zero
from .dop853 import GROWTH, Stages, attempt, cut, line_zeros, step_ratio

# As many doubles as the widest vector registers hold.
LANES = 8


def numbers_of(part: tuple) -> list[float]:
    """Return the numbers of nested tuples, such as Parameters, one after the other."""
    numbers: list[float] = []
    for each in part:
        if isinstance(each, tuple):
            numbers += numbers_of(each)
        else:
            numbers.append(each)
    return numbers


class Lanes(NamedTuple):
    """
    The steps in all lanes, each an array of a number per lane, or of rows of such numbers.

    motion: which of them flies there, -1: none; waiting (1,): the next to take a lane; t, h and
    error: begin and length of the step, and its error over the tolerance; steps: taken from the
    start; row_s: the time of the next row; limit: a motion that has taken so many steps before it
    is given up; constants: rows of the Parameters.
    """

    motion: np.ndarray
    waiting: np.ndarray
    steps: np.ndarray
    limit: np.ndarray
    row_s: np.ndarray
    t: np.ndarray
    h: np.ndarray
    largest_growth: np.ndarray
    tolerance: np.ndarray
    constants: np.ndarray
    stages: Stages
    error: np.ndarray

    @classmethod
    def empty(cls, size: int, numbers: int) -> 'Lanes':
        """Return lanes in which nothing flies: of `size` variables and as many `numbers`."""
        return cls(
            motion=np.full(LANES, -1),
            waiting=np.zeros(1, int),
            steps=line_zeros(LANES),
            limit=line_zeros(LANES),
            row_s=line_zeros(LANES),
            t=line_zeros(LANES),
            h=line_zeros(LANES),
            largest_growth=line_zeros(LANES),
            tolerance=np.ones(LANES),
            constants=line_zeros(numbers * LANES),
            stages=Stages.empty(size * LANES),
            error=line_zeros(LANES),
        )


@inlined
def attempt_all(lanes: Lanes, like: Parameters, changing: int) -> bool:
    """
    Take a step h of every lane from y_0 at t to y, and write its error.

    Return whether one may have reached its next row.  like: the Parameters of one motion, as in
    batch.py; changing: variables that do, the first.
    """
    every = zero(LANES)
    t, tolerance = load(lanes.t, 0, every), load(lanes.tolerance, 0, every)
    h = (t + load(lanes.h, 0, every)) - t
    constants = filled(like, lanes.constants, every)
    store(lanes.h, 0, h)
    store(lanes.error, 0, attempt(lanes.stages, h, constants, changing * LANES, every) / tolerance)
    return not all_less(t + h, load(lanes.row_s, 0, every))


@inlined
def advance(lanes: Lanes, like: Parameters, changing: int) -> bool:
    """
    Let the lanes whose step is accepted go on from its end, and shorten the step of the others.

    Return whether one can go no further.
    """
    every = zero(LANES)
    one, error = spread(1.0, every), load(lanes.error, 0, every)
    t, h, steps = load(lanes.t, 0, every), load(lanes.h, 0, every), load(lanes.steps, 0, every)
    ratio = step_ratio(error)
    longest = filled(like, lanes.constants, every).longest_step
    longer = _lesser(h * _lesser(load(lanes.largest_growth, 0, every), ratio), longest)
    shorter = h * cut(error, ratio)
    # Where 1 < error the step is not accepted.
    growth = where_less(one, error, one, spread(GROWTH, every))
    steps = where_less(one, error, steps, steps + 1.0)
    t = where_less(one, error, t, t + h)
    h = where_less(one, error, shorter, longer)
    store(lanes.largest_growth, 0, growth)
    store(lanes.steps, 0, steps)
    store(lanes.t, 0, t)
    store(lanes.h, 0, h)
    y_0, y = lanes.stages.y_0, lanes.stages.y
    for i in range(changing):
        start = load(y_0, i, every)
        there = where_less(one, error, start, load(y, i, every))
        store(y_0, i, there)
        store(y, i, there)
    is_step = all_less(t, t + h) and all_less(t + h, spread(np.inf, every))
    return not (is_step and all_less(steps, load(lanes.limit, 0, every)))


@inlined
def _lesser(a, b):
    return where_less(a, b, a, b)


@inlined
def give_lane(numbers: np.ndarray, l: int, rows: np.ndarray) -> None:
    """Write numbers as those of a lane in rows."""
    for i in range(len(numbers)):
        rows[at_lane(i, l)] = numbers[i]


@inlined
def take_lane(l: int, lanes: Lanes, single: tuple[Any, ...]) -> None:
    """Copy a lane's step to the clock, stages and dense output of a single propagation."""
    clock, stages, _ = single
    y_0, y, k = lanes.stages.y_0, lanes.stages.y, lanes.stages.k
    size, length = len(y) // LANES, len(stages.y)
    clock[0], clock[1] = lanes.t[l], lanes.t[l] + lanes.h[l]
    for i in range(size):
        stages.y[i], stages.y_0[i] = y[at_lane(i, l)], y_0[at_lane(i, l)]
    for j in range(12):
        for i in range(size):
            stages.k[j * length + i] = k[at_lane(j * size + i, l)]


@inlined
def at_lane(row: int, l: int) -> int:
    """Return where a lane's number of a row is."""
    return row * LANES + l
