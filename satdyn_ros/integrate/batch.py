"""
Many motions side by side, in the lanes of batch_state.py.

Every lane is one motion with steps of its own; when it has reached its last time, the next motion
takes its place.  A motion's states do not depend on its neighbours.
"""

from collections import defaultdict
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..dynamics.constants import flat_constants_of_many
from ..dynamics.equations import OMEGA, initial_values, place_at
from ..dynamics.motion import Halted, States
from ..dynamics.system import State, System
from ..kernel.compile import compiled, inlined
from ..kernel.simd import unflatten
from .batch_state import (
    LANES,
    BatchState,
    advance,
    at_lane,
    attempt_all,
    flatten,
    gather,
    scatter,
    shared_by,
)
from .dense_output import interpolate, make_dense
from .dop853 import (
    BEGIN,
    END,
    GROWTH,
    REACHED,
    STEP_UNDERFLOW,
    STEPS_PER_FIX,
    TOO_MANY_STEPS,
    ULP,
    UNFINISHED,
    direction_of_centre,
    first_step,
    new_clock,
    next_stop,
    step_arrays,
)
from .propagation import Propagation, columns, mean_anomaly, stops_of, wanted_count

# The most steps of a slice, in all lanes.
_SLICE_STEPS = 500


class BatchProblem(NamedTuple):
    """
    The starts and the results of M motions.

    begin (M, V): the variables at the start; flat_constants (M, P): the floats of the Constants;
    anomaly (M, 3), tolerance (M,), steps_allowed (M,): as of a Propagation.  out (M, W, N): the
    wanted variables; outcome (M,): of dop853.py; reached_s (M,) and rows (M,): where it ended.
    """

    begin: np.ndarray
    flat_constants: np.ndarray
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
    flat = {motion: flatten(motion.constants) for motion in motions}
    end_s = t_s[-1] if len(t_s) else 0.0
    for motion in motions:
        try:
            constants, stops_s = motion.constants_until(end_s)
        except ValueError:
            # A table that ends or jumps before: step by step it comes as far as it can.
            found[motion] = _alone(motion, t_s)
            continue
        shared = shared_by(constants), stops_s.tobytes()
        alike[motion.wanted, len(flat[motion]), shared].append((motion, constants, stops_s))
    for group in alike.values():
        some = [motion for motion, _, _ in group]
        _, constants, stops_s = group[0]
        problem = _problem(
            begin=np.array([initial_values(motion.system, motion.state) for motion in some]),
            flat_constants=np.array([flat[motion] for motion in some]),
            anomaly=np.array([motion.anomaly for motion in some]),
            tolerance=np.array([motion.tolerance for motion in some]),
            steps_allowed=np.array([motion.steps_allowed for motion in some]),
            shape=(some[0].wanted, len(t_s)),
        )
        _integrate_all(problem, constants, stops_s, t_s)
        for motion, rows, outcome, reached_s, count in zip(some, *problem[-4:], strict=True):
            states = motion.states_of(t_s[:count], rows[:, :count])
            halted = outcome != REACHED
            found[motion] = motion.halted(outcome, float(reached_s), states) if halted else states
    return [found[motion] for motion in motions]


def _alone(motion, t_s):
    try:
        return motion.at(t_s)
    except Halted as error:
        return error


def propagate_many(
    system: System, state: State, tolerance: np.ndarray, t_s: np.ndarray
) -> tuple[States, np.ndarray]:
    """
    Return the states of M motions at the ascending t_s (N,), and whether each got there (M,).

    The constants of the system and the state may be arrays: (M, 1), vectors (M, 1, 3), matrices
    (M, 1, 3, 3); q_ib is (M, 1, 4), tolerance (M,).  All begin at tick 0.
    """
    count = len(tolerance)
    like, flat_constants = flat_constants_of_many(system, count)
    problem = _problem(
        begin=initial_values(system, state)[:, 0],
        flat_constants=np.ascontiguousarray(flat_constants),
        anomaly=np.column_stack(
            [np.broadcast_to(np.ravel(each), count) for each in mean_anomaly(system, 0.0)]
        ),
        tolerance=tolerance,
        steps_allowed=np.full(count, np.inf),
        shape=(wanted_count(system, like.does_work), len(t_s)),
    )
    _integrate_all(problem, like, stops_of(system), t_s)
    q_ib, omega_bi_b, speed, angle, work = columns(system, problem.out)
    states = States(t_s, q_ib, omega_bi_b, speed, angle, work, system.orbit, t_s)
    return states, problem.outcome == REACHED


def _problem(begin, flat_constants, anomaly, tolerance, steps_allowed, shape):
    """Return a BatchProblem that has not begun; shape: of the wanted variables of each motion."""
    count = len(begin)
    return BatchProblem(
        begin=np.ascontiguousarray(begin),
        flat_constants=np.ascontiguousarray(flat_constants),
        anomaly=np.ascontiguousarray(anomaly),
        tolerance=tolerance,
        steps_allowed=steps_allowed,
        out=np.empty((count, *shape)),
        outcome=np.full(count, REACHED if shape[1] == 0 else UNFINISHED),
        reached_s=np.zeros(count),
        rows=np.zeros(count, int),
    )


def _integrate_all(problem, like, stops_s, t_s):
    """Integrate all to the end of t_s, or to theirs."""
    size = problem.begin.shape[1]
    batch = BatchState.empty(size, problem.flat_constants.shape[1])
    single = new_clock(), *step_arrays(size)
    # Slices, between which Ctrl-C and other threads get their turn.
    while len(t_s) and not _integrate(t_s, stops_s, problem, batch, single, like):
        pass


@compiled
def _integrate(t_s, stops_s, problem, batch, single, like):
    """
    Integrate on for a slice; return whether all motions have ended.

    stops_s: as of a Propagation.  single: see gather.  like: the Constants of one motion, which
    tell the compiler how many rotors and which torques there are, and whether work is done.
    """
    begin, rows = problem.begin, problem.rows
    motion, steps, t, h = batch.motion, batch.steps, batch.t, batch.h
    y_0, y = batch.stages.y_0, batch.stages.y
    # Variables beyond those are constant, or not wanted.
    changing = problem.out.shape[1] + len(like.place)
    rounding_s = 4.0 * ULP * max(abs(stops_s[0]), abs(stops_s[-1])) if len(stops_s) > 0 else 0.0
    for _ in range(_SLICE_STEPS):
        idle = 0
        for l in range(LANES):
            while motion[l] < 0 and batch.waiting[0] < len(begin):
                m = batch.waiting[0]
                batch.waiting[0] += 1
                motion[l], steps[l], t[l], batch.passed[l], batch.uncut[l] = m, 0.0, 0.0, 0, 0.0
                batch.largest_growth[l], batch.tolerance[l] = GROWTH, problem.tolerance[m]
                scatter(problem.flat_constants[m], l, batch.constants)
                scatter(begin[m], l, y_0)
                scatter(begin[m], l, y)
                omega = begin[m, OMEGA], begin[m, OMEGA + 1], begin[m, OMEGA + 2]
                constants = unflatten(like, problem.flat_constants[m], 0.0)
                h[l] = first_step(omega, constants)
                rows[m] = _rows_at_begin(t_s, begin[m], problem.out[m], single, constants)
                _await_row(t_s, problem, batch, l, 0.0)
            if motion[l] < 0:
                idle += 1
            elif len(like.place) > 0 and int(steps[l]) % STEPS_PER_FIX == 0:
                i, j = at_lane(place_at(like), l), at_lane(place_at(like) + 1, l)
                y[i], y[j] = direction_of_centre(problem.anomaly[motion[l]], t[l])
                y_0[i], y_0[j] = y[i], y[j]
        if idle == LANES:
            return True
        for l in range(LANES if len(stops_s) > 0 else 0):
            if motion[l] >= 0:
                start_s = unflatten(like, problem.flat_constants[motion[l]], 0.0).start_s
                found = next_stop(batch.passed[l], t[l], stops_s, start_s)
                batch.passed[l], from_s, until_s, batch.stop[l] = found
                # Which piece of a table of several a time is in is told to rounding.
                batch.from_s[l], batch.until_s[l] = from_s + rounding_s, until_s - rounding_s

        if attempt_all(batch, like, changing):
            for l in range(LANES):
                m, end = motion[l], t[l] + h[l]
                if m >= 0 and batch.error[l] <= 1.0 and batch.row_s[l] <= end:
                    first = last = rows[m]
                    while last < len(t_s) and t_s[last] <= end:
                        last += 1
                    gather(l, batch, single)
                    clock, _, dense = single
                    constants = unflatten(like, problem.flat_constants[m], 0.0)
                    make_dense(*single, constants)
                    interpolate(t_s, problem.out[m], first, last, clock, dense, constants)
                    rows[m] = last
                    _await_row(t_s, problem, batch, l, steps[l] + 1.0)
        if advance(batch, like, changing):
            for l in range(LANES):
                if motion[l] < 0:
                    continue
                if steps[l] >= batch.limit[l]:
                    _end(TOO_MANY_STEPS, problem, batch, l)
                elif not t[l] < t[l] + h[l] < np.inf:
                    _end(STEP_UNDERFLOW, problem, batch, l)
    return False


@inlined
def _await_row(t_s, problem, batch, l, steps):
    """Let a lane go on to its motion's next row, if there is one; steps: taken so far."""
    m = batch.motion[l]
    if problem.rows[m] == len(t_s):
        _end(REACHED, problem, batch, l)
    else:
        batch.row_s[l] = t_s[problem.rows[m]]
        batch.limit[l] = steps + problem.steps_allowed[m]


@inlined
def _end(outcome, problem, batch, l):
    """End the motion of a lane; what the lane integrates until the next takes it is of no use."""
    m = batch.motion[l]
    problem.outcome[m], problem.reached_s[m] = outcome, batch.t[l]
    batch.motion[l], batch.row_s[l], batch.limit[l] = -1, np.inf, np.inf


@inlined
def _rows_at_begin(t_s, begin, out, single, constants):
    """Fill the rows at t = 0, whatever the first step will be; return how many there are."""
    clock, _, dense = single
    clock[BEGIN], clock[END], dense[:] = 0.0, 0.0, 0.0
    for i in range(len(begin)):
        dense[0, i] = begin[i]
    last = 0
    while last < len(t_s) and t_s[last] <= 0.0:
        last += 1
    interpolate(t_s, out, 0, last, clock, dense, constants)
    return last
