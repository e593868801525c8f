"""
The state of a batch: a step of dop853.py in every lane of SIMD vectors.

What is in a lane does not depend on its neighbours.
"""

from typing import Any, NamedTuple

import numpy as np

from ..dynamics.constants import Constants
from ..kernel.compile import inlined
from ..kernel.simd import all_true, broadcast, load, select, store, unflatten, zero
from .dop853 import (
    BEGIN,
    END,
    FROM_S,
    GROWTH,
    UNTIL_S,
    Stages,
    attempt,
    cut,
    line_zeros,
    part_before_corner,
    step_ratio,
)

# The floats of the widest vector registers.
LANES = 8


def flatten(part: tuple) -> list[float]:
    """Return the floats of nested tuples, such as Constants, one after the other."""
    numbers: list[float] = []
    for each in part:
        if isinstance(each, tuple):
            numbers += flatten(each)
        elif not isinstance(each, np.ndarray):
            numbers.append(each)
    return numbers


def shared_by(constants: Constants) -> tuple:
    """Return what motions of one batch have in common: the kinds of torques, and all arrays."""

    def shared(part):
        if isinstance(part, np.ndarray):
            return part.shape, part.tobytes()
        return (type(part), *map(shared, part)) if isinstance(part, tuple) else None

    return shared((constants.table, constants.torques))


class BatchState(NamedTuple):
    """
    The steps of all lanes: arrays of one float per lane, or of rows of one float per lane.

    motion: the motion that is integrated there, -1: none; waiting (1,): the next to take a lane;
    t, h and error: begin and length of the step, and its error over the tolerance; wished: its
    length, had it not been cut off at a stop; part: what of it is before a corner, 1: it has none;
    uncut: its length before it was cut at a corner, 0: it was not; passed, stop, from_s, until_s:
    as of next_stop; steps: taken from the start; row_s: the time of the next row; limit: a motion
    that has taken so many steps before it is given up; constants: rows of the Constants.
    """

    motion: np.ndarray
    waiting: np.ndarray
    steps: np.ndarray
    limit: np.ndarray
    row_s: np.ndarray
    t: np.ndarray
    h: np.ndarray
    wished: np.ndarray
    part: np.ndarray
    uncut: np.ndarray
    passed: np.ndarray
    stop: np.ndarray
    from_s: np.ndarray
    until_s: np.ndarray
    largest_growth: np.ndarray
    tolerance: np.ndarray
    constants: np.ndarray
    stages: Stages
    error: np.ndarray

    @classmethod
    def empty(cls, size: int, count: int) -> 'BatchState':
        """Return idle lanes for `size` variables and Constants of `count` floats."""
        return cls(
            motion=np.full(LANES, -1),
            waiting=np.zeros(1, int),
            steps=line_zeros(LANES),
            limit=line_zeros(LANES),
            row_s=line_zeros(LANES),
            t=line_zeros(LANES),
            h=line_zeros(LANES),
            wished=line_zeros(LANES),
            part=line_zeros(LANES),
            uncut=line_zeros(LANES),
            passed=np.zeros(LANES, int),
            stop=_in_lanes(np.inf),
            from_s=_in_lanes(-np.inf),
            until_s=_in_lanes(np.inf),
            largest_growth=line_zeros(LANES),
            tolerance=np.ones(LANES),
            constants=line_zeros(count * LANES),
            stages=Stages.empty(size * LANES),
            error=line_zeros(LANES),
        )


def _in_lanes(value):
    lanes = line_zeros(LANES)
    lanes[:] = value
    return lanes


@inlined
def attempt_all(batch: BatchState, like: Constants, changing: int) -> bool:
    """
    Take a step h of every lane from y_0 at t to y, and write its error.

    Return whether one may have reached its next row.  like: the Constants of one motion, as in
    batch.py; changing: variables that do, the first.
    """
    every = zero(LANES)
    t, tolerance = load(batch.t, 0, every), load(batch.tolerance, 0, every)
    wished = load(batch.h, 0, every)
    h = min(t + wished, load(batch.stop, 0, every)) - t
    span = load(batch.from_s, 0, every), load(batch.until_s, 0, every)
    constants = unflatten(like, batch.constants, every)
    store(batch.wished, 0, wished)
    store(batch.h, 0, h)
    error = attempt(batch.stages, t, h, span, constants, changing * LANES, every) / tolerance
    one = broadcast(1.0, every)
    part = part_before_corner(batch.stages, t, h, span, constants)
    part = select(one < error, one, part)
    store(batch.part, 0, part)
    # A step across a corner is rejected.
    store(batch.error, 0, select(part < one, broadcast(2.0, every), error))
    return not all_true(t + h < load(batch.row_s, 0, every))


@inlined
def advance(batch: BatchState, like: Constants, changing: int) -> bool:
    """
    Let the lanes whose step is accepted go on from its end, and shorten the step of the others.

    Return whether one can go no further.
    """
    every = zero(LANES)
    one, error = broadcast(1.0, every), load(batch.error, 0, every)
    t, h, steps = load(batch.t, 0, every), load(batch.h, 0, every), load(batch.steps, 0, every)
    ratio = step_ratio(error)
    longest = unflatten(like, batch.constants, every).longest_step
    longer = min(longest, h * min(ratio, load(batch.largest_growth, 0, every)))
    wished, stop = load(batch.wished, 0, every), load(batch.stop, 0, every)
    is_stopped = stop <= t + wished
    longer = select(is_stopped, min(max(longer, wished), longest), longer)
    part, uncut = load(batch.part, 0, every), load(batch.uncut, 0, every)
    longer = min(max(longer, uncut), longest)
    is_rejected, is_cut = one < error, part < one
    shorter = h * select(is_cut, part, cut(error, ratio))
    growth = select(is_rejected, one, broadcast(GROWTH, every))
    growth = select(is_cut, load(batch.largest_growth, 0, every), growth)
    store(batch.uncut, 0, select(is_cut, max(uncut, wished), broadcast(0.0, every)))
    steps = select(is_rejected, steps, steps + 1.0)
    t = select(is_rejected, t, select(is_stopped, stop, t + h))
    h = select(is_rejected, shorter, longer)
    store(batch.largest_growth, 0, growth)
    store(batch.steps, 0, steps)
    store(batch.t, 0, t)
    store(batch.h, 0, h)
    y_0, y = batch.stages.y_0, batch.stages.y
    for i in range(changing):
        start = load(y_0, i, every)
        there = select(is_rejected, start, load(y, i, every))
        store(y_0, i, there)
        store(y, i, there)
    is_step = all_true(t < t + h) and all_true(t + h < broadcast(np.inf, every))
    return not (is_step and all_true(steps < load(batch.limit, 0, every)))


@inlined
def scatter(values: np.ndarray, l: int, rows: np.ndarray) -> None:
    """Write values, one per row, to a lane of rows."""
    for i in range(len(values)):
        rows[at_lane(i, l)] = values[i]


@inlined
def gather(l: int, batch: BatchState, single: tuple[Any, ...]) -> None:
    """Copy a lane's step to the clock, stages and dense output of a single propagation."""
    clock, stages, _ = single
    y_0, y, k = batch.stages.y_0, batch.stages.y, batch.stages.k
    size, length = len(y) // LANES, len(stages.y)
    clock[BEGIN], clock[END] = batch.t[l], batch.t[l] + batch.h[l]
    clock[FROM_S], clock[UNTIL_S] = batch.from_s[l], batch.until_s[l]
    for i in range(size):
        stages.y[i], stages.y_0[i] = y[at_lane(i, l)], y_0[at_lane(i, l)]
    for j in range(12):
        for i in range(size):
            stages.k[j * length + i] = k[at_lane(j * size + i, l)]


@inlined
def at_lane(row: int, l: int) -> int:
    """Return where a lane's number of a row is."""
    return row * LANES + l
