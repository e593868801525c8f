"""
Many propagations side by side: a step of dop853.py in every lane.

A lane's numbers do not depend on its neighbours.
"""

from typing import Any, NamedTuple

import numpy as np

from ..compiled import inlined
from ..side_by_side import filled, load, spread, store, where_less, zero
from .dop853 import Stages, attempt, line_zeros, step_ratio
from .parameters import Parameters

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

    motion: which of them flies there, -1: none; waiting (1,): the next to take a lane; steps and
    since: taken from the start, from the last row; t, h, error, ratio: begin, length, error of the
    step over the tolerance, and next length over this one; constants: rows of the Parameters.
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
    stages: Stages
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
            stages=Stages.empty(size * LANES),
            error=line_zeros(LANES),
            ratio=line_zeros(LANES),
        )


@inlined
def attempt_all(lanes: Lanes, like: Parameters, changing: int) -> None:
    """
    Take a step h of every lane from y_0 at t to y, and write its error and ratio.

    like: the Parameters of one motion, as in batch.py; changing: variables that do, the first.
    """
    every = zero(LANES)
    t, tolerance = load(lanes.t, 0, every), load(lanes.tolerance, 0, every)
    h = (t + load(lanes.h, 0, every)) - t
    constants = filled(like, lanes.constants, every)
    error = attempt(lanes.stages, h, constants, changing * LANES, every) / tolerance
    store(lanes.h, 0, h)
    store(lanes.error, 0, error)
    store(lanes.ratio, 0, step_ratio(error))


@inlined
def advance(lanes: Lanes, changing: int) -> None:
    """Let the lanes whose step is accepted go on from its end."""
    y_0, y, every = lanes.stages.y_0, lanes.stages.y, zero(LANES)
    error = load(lanes.error, 0, every)
    for i in range(changing):
        start = load(y_0, i, every)
        there = where_less(spread(1.0, every), error, start, load(y, i, every))
        store(y_0, i, there)
        store(y, i, there)


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
