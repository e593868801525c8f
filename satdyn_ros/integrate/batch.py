"""
Many propagations side by side, in the lanes of lanes.py.

Every lane is one motion with steps of its own; when it has reached its last time, the next motion
takes its place.  A motion's numbers do not depend on its neighbours.
"""

from collections import defaultdict
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..dynamics.constants import numbers_of_many
from ..dynamics.equations import OMEGA, initial_values, place_at
from ..dynamics.motion import Halted, States
from ..dynamics.system import State, System
from ..kernel.compile import compiled, inlined
from ..kernel.simd import filled
from .batch_state import (
    LANES,
    Lanes,
    advance,
    at_lane,
    attempt_all,
    give_lane,
    numbers_of,
    take_lane,
)
from .dense_output import interpolate, make_dense
from .dop853 import (
    GROWTH,
    REACHED,
    STEPS_PER_FIX,
    STUCK,
    TOO_MANY_STEPS,
    UNFINISHED,
    direction_of_centre,
    first_step,
    step_arrays,
)
from .propagation import Propagation, columns, mean_anomaly, wanted_count

# The most steps of a slice, in all lanes.
_SLICE_STEPS = 500


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


def propagate_all(motions: Sequence[Propagation], t_s: ArrayLike) -> list[States | Halted]:
    """
    Return each motion's states at the ascending t_s (N,), or the error that ended it.

    The same as motion.at(t_s) of each, to rounding, in a fraction of the time.
    """
    t_s, found = np.asarray(t_s, float), {}
    alike = defaultdict(list)
    numbers = {motion: numbers_of(motion.constants) for motion in motions}
    for motion in motions:
        alike[motion.wanted, len(numbers[motion])].append(motion)
    for some in alike.values():
        flights = _flights(
            begin=np.array([initial_values(motion.system, motion.state) for motion in some]),
            numbers=np.array([numbers[motion] for motion in some]),
            anomaly=np.array([motion.anomaly for motion in some]),
            tolerance=np.array([motion.tolerance for motion in some]),
            steps_allowed=np.array([motion.steps_allowed for motion in some]),
            shape=(some[0].wanted, len(t_s)),
        )
        _fly_together(flights, some[0].constants, t_s)
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
    flights = _flights(
        begin=initial_values(system, state)[:, 0],
        numbers=np.ascontiguousarray(numbers),
        anomaly=np.column_stack(
            [np.broadcast_to(np.ravel(each), count) for each in mean_anomaly(system, 0.0)]
        ),
        tolerance=tolerance,
        steps_allowed=np.full(count, np.inf),
        shape=(wanted_count(system, like.does_work), len(t_s)),
    )
    _fly_together(flights, like, t_s)
    q_ib, omega_bi_b, speed, angle, work = columns(system, flights.out)
    states = States(t_s, q_ib, omega_bi_b, speed, angle, work, system.orbit, t_s)
    return states, flights.outcome == REACHED


def _flights(begin, numbers, anomaly, tolerance, steps_allowed, shape):
    """Return Flights that have not begun; shape: of the variables that are wanted of each."""
    count = len(begin)
    return Flights(
        begin=np.ascontiguousarray(begin),
        numbers=np.ascontiguousarray(numbers),
        anomaly=np.ascontiguousarray(anomaly),
        tolerance=tolerance,
        steps_allowed=steps_allowed,
        out=np.empty((count, *shape)),
        outcome=np.full(count, REACHED if shape[1] == 0 else UNFINISHED),
        reached_s=np.zeros(count),
        rows=np.zeros(count, int),
    )


def _fly_together(flights, like, t_s):
    """Fly all to the end of t_s, or to theirs."""
    size = flights.begin.shape[1]
    lanes = Lanes.empty(size, flights.numbers.shape[1])
    single = np.zeros(7), *step_arrays(size)
    # Slices, between which Ctrl-C and other threads get their turn.
    while len(t_s) and not _fly(t_s, flights, lanes, single, like):
        pass


@compiled
def _fly(t_s, flights, lanes, single, like):
    """
    Fly on for a slice; return whether all flights have ended.

    single: see take_lane.  like: the Parameters of one motion, which tell the compiler how many
    rotors there are, and whether work is done, in all.
    """
    begin, rows = flights.begin, flights.rows
    motion, steps, t, h = lanes.motion, lanes.steps, lanes.t, lanes.h
    y_0, y = lanes.stages.y_0, lanes.stages.y
    # Variables beyond those are constant, or not wanted.
    changing = flights.out.shape[1] + len(like.place)
    for _ in range(_SLICE_STEPS):
        idle = 0
        for l in range(LANES):
            while motion[l] < 0 and lanes.waiting[0] < len(begin):
                m = lanes.waiting[0]
                lanes.waiting[0] += 1
                motion[l], steps[l], t[l] = m, 0.0, 0.0
                lanes.largest_growth[l], lanes.tolerance[l] = GROWTH, flights.tolerance[m]
                give_lane(flights.numbers[m], l, lanes.constants)
                give_lane(begin[m], l, y_0)
                give_lane(begin[m], l, y)
                omega = begin[m, OMEGA], begin[m, OMEGA + 1], begin[m, OMEGA + 2]
                constants = filled(like, flights.numbers[m], 0.0)
                h[l] = first_step(omega, constants)
                rows[m] = _rows_at_begin(t_s, begin[m], flights.out[m], single, constants)
                _await_row(t_s, flights, lanes, l, 0.0)
            if motion[l] < 0:
                idle += 1
            elif len(like.place) > 0 and int(steps[l]) % STEPS_PER_FIX == 0:
                i, j = at_lane(place_at(like), l), at_lane(place_at(like) + 1, l)
                y[i], y[j] = direction_of_centre(flights.anomaly[motion[l]], t[l])
                y_0[i], y_0[j] = y[i], y[j]
        if idle == LANES:
            return True

        if attempt_all(lanes, like, changing):
            for l in range(LANES):
                m, end = motion[l], t[l] + h[l]
                if m >= 0 and lanes.error[l] <= 1.0 and lanes.row_s[l] <= end:
                    first = last = rows[m]
                    while last < len(t_s) and t_s[last] <= end:
                        last += 1
                    take_lane(l, lanes, single)
                    clock, _, dense = single
                    constants = filled(like, flights.numbers[m], 0.0)
                    make_dense(*single, constants)
                    interpolate(t_s, flights.out[m], first, last, clock, dense, constants)
                    rows[m] = last
                    _await_row(t_s, flights, lanes, l, steps[l] + 1.0)
        if advance(lanes, like, changing):
            for l in range(LANES):
                if motion[l] < 0:
                    continue
                if steps[l] >= lanes.limit[l]:
                    _end(TOO_MANY_STEPS, flights, lanes, l)
                elif not t[l] < t[l] + h[l] < np.inf:
                    _end(STUCK, flights, lanes, l)
    return False


@inlined
def _await_row(t_s, flights, lanes, l, steps):
    """Let a lane fly on to its motion's next row, if there is one; steps: taken so far."""
    m = lanes.motion[l]
    if flights.rows[m] == len(t_s):
        _end(REACHED, flights, lanes, l)
    else:
        lanes.row_s[l] = t_s[flights.rows[m]]
        lanes.limit[l] = steps + flights.steps_allowed[m]


@inlined
def _end(outcome, flights, lanes, l):
    """End the motion of a lane; what that flies until the next takes it is of no use."""
    m = lanes.motion[l]
    flights.outcome[m], flights.reached_s[m] = outcome, lanes.t[l]
    lanes.motion[l], lanes.row_s[l], lanes.limit[l] = -1, np.inf, np.inf


@inlined
def _rows_at_begin(t_s, begin, out, single, constants):
    """Fill the rows at t = 0, whatever the first step will be; return how many there are."""
    clock, _, dense = single
    clock[:], dense[:] = 0.0, 0.0
    for i in range(len(begin)):
        dense[0, i] = begin[i]
    last = 0
    while last < len(t_s) and t_s[last] <= 0.0:
        last += 1
    interpolate(t_s, out, 0, last, clock, dense, constants)
    return last
