"""
The walk: step after step of motions in lanes, each at its own pace, whatever moves.

It is compiled once.  What depends on the equations, an attempt of a step and the terms of its
dense output, is code that it calls by address (step_code.py).  What is in a lane does not depend
on its neighbours.  The walk goes in slices of a few milliseconds, between which Ctrl-C and other
threads get their turn.

A motion goes on where END is.  Its step is tried until it meets the tolerance; then the rows that
it reaches are written and the next one begins.

p, lanes and single: the tables of a Problem and of two Lanes (lanes.py), l: a lane, m: the motion
in it.
"""

import numpy as np

from ..dynamics.constants import ANOMALY_RATE, LONGEST_STEP, START_S
from ..dynamics.variables import RATE
from ..kernel.looped import looped
from ..orbits.kepler_equation import true_anomaly_of_one
from ..torques.corner_search import CornerSearch
from ..trace.memory import call, floats, integers
from .dense_output import add_turn, interpolate
from .event_location import effort, first_exit
from .lanes import (
    ANOMALY,
    ANOMALY_AT,
    ARRAY_COUNT,
    ARRAYS_AT,
    BEGIN,
    BEGIN_AT,
    BEGINS,
    CONSTANT_COUNT,
    CONSTANTS_AT,
    CUTS_FIRST,
    DENSE_OF,
    ECCENTRICITY,
    EFFORTS_AT,
    END,
    ENDED_AT,
    EVENTS_AT,
    EXIT,
    EXIT_S,
    EXITS,
    FORESEEN,
    FURTHEST,
    HOLDS_UNTIL_S,
    IS_CUT,
    IS_NEW_AT,
    IS_STOPPED,
    IS_STUCK,
    LANE_COUNT,
    LATE,
    LEFT,
    MEAN_MOTION,
    MOMENTA_AT,
    MOST_GROWTH,
    MOTION_AT,
    MOTION_COUNT,
    NEXT,
    OUT_AT,
    OUTCOME_AT,
    PASSED,
    PIECE_ENDS,
    PROPOSED,
    REACHED,
    ROTOR_LEAVES,
    ROTORS,
    ROTORS_AT,
    ROW,
    ROW_COUNT,
    ROWS_AT,
    SETTINGS,
    SETTINGS_AT,
    SINCE,
    SIZE,
    STEP_STATE_SIZE,
    STEP_STATES_AT,
    STEP_UNDERFLOW,
    STEPS,
    STEPS_ALLOWED,
    STEPS_OF_AN_EXIT,
    STOP,
    STOP_COUNT,
    STOPS_AT,
    T_S_AT,
    T_S_STEP,
    TABLE_AT,
    TOLERANCE,
    TOO_MANY_STEPS,
    TRIED,
    TRYING,
    TURN_AT,
    UNFINISHED,
    WAITING,
    WANTED,
)
from .layout import ARRAYS, ERROR, EVALUATED, FROM_S, PART, STAGE_S, TERMS, UNTIL_S, H, T

# The true anomaly, integrated with the rest, is corrected every so many steps.
STEPS_PER_FIX = 8
# What a step may grow to or shrink to at once.
GROWTH, CUT = 6.0, 0.2
# A step aims at this share of the length that should just meet the tolerance.
SAFETY = 0.9
# By this share of what is proposed a step ends before a corner that is foreseen, as it is not
# known so well from afar; where that is no more than twice as far away, the step ends there.
AHEAD = CornerSearch.ahead
# At least the distance of a number from the next one, relative.
ULP = 2.3e-16
# What the first step turns the body or the orbit by [rad]; a rate below the slowest [rad/s] counts
# as the slowest, for which such a step takes four months.
FIRST_TURN, SLOWEST = 0.01, 1e-9
# The most attempts of a slice, and rows of a motion in it.
_SLICE_ATTEMPTS, _SLICE_ROWS = 5000, 200_000
# Where the arrays of code are in the table of lanes.
_FRAME, _Y, _DENSE, _K, _, _CONSTANTS, _ARRAYS = range(len(ARRAYS))
# Bytes of a number.
_BYTES = 8
# Where the body rate begins among the variables.
_RATE = RATE.start


@looped
def walk(problem_at: int, lanes_at: int, single_at: int, attempt: int, make_dense: int) -> bool:
    """
    Walk on for a slice; return whether all motions have ended.

    It ends early where one waits for other constants.  single_at: one lane in which the dense
    output is made.  attempt and make_dense: the code of many lanes and of one.
    """
    p, lanes, single = integers(problem_at), integers(lanes_at), integers(single_at)
    motion, outcome, count = integers(lanes[MOTION_AT]), integers(p[OUTCOME_AT]), lanes[LANE_COUNT]
    for _ in range(_SLICE_ATTEMPTS // count):
        is_busy, waits = False, False
        for l in range(count):
            _take_next(l, p, lanes)
            m, c = motion[l], _step_state(l, lanes)
            if m < 0 or outcome[m] != UNFINISHED:
                continue
            if c[TRYING] == 0.0:
                now, is_whole = _write_rows(l, p, lanes, single, make_dense)
                outcome[m] = now
                waits = waits or not is_whole or now in (PIECE_ENDS, ROTOR_LEAVES)
                if now == UNFINISHED and is_whole:
                    _begin_step(l, p, lanes)
            is_busy = is_busy or outcome[m] == UNFINISHED or p[WAITING] < p[MOTION_COUNT]
        if waits or not is_busy:
            return not (waits or is_busy)
        for l in range(count):
            if motion[l] >= 0 and _step_state(l, lanes)[TRYING] != 0.0:
                _prepare(l, lanes)
        call(attempt, lanes_at)
        for l in range(count):
            if motion[l] >= 0 and _step_state(l, lanes)[TRYING] != 0.0:
                _judge(l, p, lanes, single, make_dense)
    return False


def _step_state(l, lanes):
    return floats(lanes[STEP_STATES_AT] + _BYTES * STEP_STATE_SIZE * l)


def _of(m, array, count, p):
    """Return the numbers of a motion in an array of the problem that has so many of each."""
    return floats(p[array] + _BYTES * count * m)


# -- a motion in its lane -------------------------------------------------------------------------


def _take_next(l, p, lanes):
    """Let a motion begin in a lane: its own anew or, if it is free and there is one, the next."""
    motion, m = integers(lanes[MOTION_AT]), integers(lanes[MOTION_AT])[l]
    is_free = m < 0 or integers(p[OUTCOME_AT])[m] >= REACHED
    if is_free or integers(p[IS_NEW_AT])[m] != BEGINS:
        if not is_free or p[WAITING] == p[MOTION_COUNT]:
            return
        m = p[WAITING]
        motion[l], p[WAITING] = m, m + 1
    count, c = lanes[LANE_COUNT], _step_state(l, lanes)
    y, y_0, begin = floats(lanes[_Y]), floats(lanes[_DENSE]), _of(m, BEGIN_AT, p[SIZE], p)
    for i in range(p[SIZE]):
        y[i * count + l] = y_0[i * count + l] = begin[i]
    furthest = c[FURTHEST] if count == 1 else 0.0
    for i in range(STEP_STATE_SIZE):
        c[i] = 0.0
    c[FURTHEST], c[DENSE_OF], c[EXIT_S] = furthest, -1.0, np.inf
    integers(p[IS_NEW_AT])[m] = 1


def _renew(l, m, p, lanes):
    """Take the constants of a motion that hold from now on."""
    count = lanes[LANE_COUNT]
    to, numbers = floats(lanes[_CONSTANTS]), _of(m, CONSTANTS_AT, p[CONSTANT_COUNT], p)
    for i in range(p[CONSTANT_COUNT]):
        to[i * count + l] = numbers[i]
    to, numbers = floats(lanes[_ARRAYS]), _of(m, ARRAYS_AT, p[ARRAY_COUNT], p)
    for i in range(p[ARRAY_COUNT]):
        to[i * count + l] = numbers[i]
    _step_state(l, lanes)[PASSED] = 0.0
    integers(p[IS_NEW_AT])[m] = 0


def _begin_step(l, p, lanes):
    """Let the next step of a lane be tried."""
    count, m, c = lanes[LANE_COUNT], integers(lanes[MOTION_AT])[l], _step_state(l, lanes)
    if integers(p[IS_NEW_AT])[m]:
        _renew(l, m, p, lanes)
    y, y_0, frame = floats(lanes[_Y]), floats(lanes[_DENSE]), floats(lanes[_FRAME])
    settings = _of(m, SETTINGS_AT, SETTINGS, p)
    constants = _of(m, CONSTANTS_AT, p[CONSTANT_COUNT], p)
    t = c[END]
    if c[STEPS] == 0.0:
        # While a motion waits at its begin, the attempts of other lanes write into its y.
        for i in range(p[SIZE]):
            y[i * count + l] = y_0[i * count + l]
    if p[ANOMALY_AT] > 0 and int(c[STEPS]) % STEPS_PER_FIX == 0:
        f = true_anomaly_of_one(
            settings[ANOMALY] + settings[MEAN_MOTION] * t, settings[ECCENTRICITY]
        )
        y[p[ANOMALY_AT] * count + l], y[(p[ANOMALY_AT] + 1) * count + l] = np.cos(f), np.sin(f)
    for i in range(p[SIZE]):
        y_0[i * count + l] = y[i * count + l]
    if c[NEXT] == 0.0:
        square = 0.0
        for i in range(_RATE, _RATE + 3):
            square += y[i * count + l] * y[i * count + l]
        c[NEXT] = FIRST_TURN / (np.sqrt(square) + constants[ANOMALY_RATE] + SLOWEST)
    stop_times_s, start_s = _of(m, STOPS_AT, p[STOP_COUNT], p), constants[START_S]
    passed = int(c[PASSED])
    while stop_times_s[passed] - start_s <= t:
        passed += 1
    following = stop_times_s[passed]
    c[PASSED], c[STOP] = passed, following - start_s
    frame[FROM_S * count + l] = stop_times_s[passed - 1] if passed > 0 else -np.inf
    # Less a rounding: where a torque jumps, a step computes with what is on its side alone.
    is_last = following == np.inf
    frame[UNTIL_S * count + l] = np.inf if is_last else following - ULP * abs(following)
    c[TRYING], c[TRIED], c[PROPOSED] = 1.0, c[NEXT], c[NEXT]
    c[MOST_GROWTH], c[IS_CUT] = GROWTH, 0.0
    if t < t + c[FORESEEN] < t + c[NEXT]:
        ahead = AHEAD * c[NEXT]
        c[TRIED], c[IS_CUT] = c[FORESEEN] - (ahead if c[FORESEEN] > 2.0 * ahead else 0.0), 1.0


def _prepare(l, lanes):
    """Let the step of a lane be tried in its present length, if there is one."""
    count, c, frame = lanes[LANE_COUNT], _step_state(l, lanes), floats(lanes[_FRAME])
    t = c[END]
    end = min(t + c[TRIED], c[STOP])
    if t < end < np.inf:
        c[TRIED], c[IS_STOPPED] = end - t, end == c[STOP]
        frame[T * count + l], frame[H * count + l] = t, end - t
    else:
        c[TRYING], c[IS_STUCK] = 0.0, 1.0


def _judge(l, p, lanes, single, make_dense):
    """Take the step of a lane if it meets the tolerance, or let a shorter one be tried."""
    count, m, c = lanes[LANE_COUNT], integers(lanes[MOTION_AT])[l], _step_state(l, lanes)
    frame = floats(lanes[_FRAME])
    error = frame[ERROR * count + l] / _of(m, SETTINGS_AT, SETTINGS, p)[TOLERANCE]
    part, t, h = frame[PART * count + l], c[END], c[TRIED]
    # By 0.9 error^(-1/8), so changed, a step of order 8 should meet the tolerance; an error below
    # 1e-12 allows far more than the greatest growth.
    ratio = SAFETY / np.sqrt(np.sqrt(np.sqrt(error if error > 1e-12 else 1e-12)))
    if part < 1.0 and (error <= 1.0 or p[CUTS_FIRST] != 0):
        c[TRIED], c[IS_CUT] = h * part, 1.0
        return
    if not error <= 1.0:
        shorter = h * (ratio if error < np.inf and ratio > CUT else CUT)
        # Of some roundings of t, a little less is rounded to as much again.
        h = shorter if t + shorter < t + h else CUT * h
        c[TRIED], c[PROPOSED], c[MOST_GROWTH] = h, h, 1.0
        return
    grown = h * min(c[MOST_GROWTH], ratio)
    c[BEGIN], c[END] = t, c[STOP] if c[IS_STOPPED] != 0.0 else t + h
    if c[IS_STOPPED] != 0.0 or c[IS_CUT] != 0.0:
        # A stop or a corner cuts the step off; what was proposed is still good.
        grown = max(grown, c[PROPOSED])
    c[NEXT] = min(grown, _of(m, CONSTANTS_AT, p[CONSTANT_COUNT], p)[LONGEST_STEP])
    c[FORESEEN] = h * (part - 1.0) if part > 1.0 else 0.0
    c[STEPS] += 1.0
    c[TRYING] = 0.0
    if p[EVENTS_AT] > 0:
        _end_at_exit(l, p, lanes, single, make_dense)
    if c[BEGIN] >= c[FURTHEST]:
        c[SINCE] += 1.0


def _end_at_exit(l, p, lanes, single, make_dense):
    """
    Let the step of a lane end where the first rotor leaves its range.

    A step that goes beyond is taken back and taken again, up to the instant at which the dense
    output leaves the range.  There the walk stops, and other constants hold.
    """
    count, m, c = lanes[LANE_COUNT], integers(lanes[MOTION_AT])[l], _step_state(l, lanes)
    _show(l, p, lanes, single, make_dense)
    if c[END] >= c[EXIT_S] * (1.0 - 4.0 * ULP):
        c[LEFT], c[EXIT_S] = c[EXIT], np.inf
        return
    t, h, constants = c[BEGIN], c[END] - c[BEGIN], p[CONSTANTS_AT] + _BYTES * p[CONSTANT_COUNT] * m
    rotors, events = constants + _BYTES * p[ROTORS_AT], constants + _BYTES * p[EVENTS_AT]
    dense, row = floats(single[_DENSE]), single[ROW]
    part, which = first_exit(
        floats(rotors), floats(events), p[ROTORS], p[MOMENTA_AT], dense, row, h
    )
    c[EXIT_S] = np.inf
    if part > 1.0:
        return
    y, y_0 = floats(lanes[_Y]), floats(lanes[_DENSE])
    for i in range(p[SIZE]):
        y[i * count + l] = y_0[i * count + l]
    end = t + part * h
    c[END], c[DENSE_OF], c[NEXT], c[FORESEEN] = t, -1.0, h, 0.0
    c[STEPS] -= 1.0
    if t < end:
        c[EXIT_S], c[EXIT], c[NEXT] = end, which, end - t
    else:
        c[LEFT] = which


# -- what is asked for ----------------------------------------------------------------------------


def _write_rows(l, p, lanes, single, make_dense):
    """
    Write the rows that a lane has reached.

    Return how its motion stands, and whether all these rows are written; if not, the rest waits
    for another slice.
    """
    m, c = integers(lanes[MOTION_AT])[l], _step_state(l, lanes)
    t_s, rows = floats(p[T_S_AT] + _BYTES * p[T_S_STEP] * m), p[ROW_COUNT]
    first = last = integers(p[ROWS_AT])[m]
    # The torque that holds a rotor is known when there is a step.
    is_held_back = p[EVENTS_AT] > 0 and c[STEPS] == 0.0 and c[IS_STUCK] == 0.0
    while last < rows and t_s[last] <= c[END] + c[LATE] and not is_held_back:
        last += 1
    is_whole = last - first <= _SLICE_ROWS
    last = min(last, first + _SLICE_ROWS)
    counts = p[TURN_AT] != 0 and last > 0
    if last > first or counts:
        _show(l, p, lanes, single, make_dense)
    begin, end, dense, row = c[BEGIN], c[END], floats(single[_DENSE]), single[ROW]
    if last > first:
        constants = p[CONSTANTS_AT] + _BYTES * p[CONSTANT_COUNT] * m
        at_s = floats(p[T_S_AT] + _BYTES * (p[T_S_STEP] * m + first))
        out = floats(p[OUT_AT] + _BYTES * (m * p[WANTED] * rows + first))
        interpolate(
            at_s, last - first, out, rows, p[WANTED], begin, end, dense, row, floats(constants)
        )
        if p[EVENTS_AT] > 0:
            _write_efforts(m, first, last, begin, end, constants, p, dense, row)
        for i in range(max(first, 1), last if counts else 0):
            turn_b = floats(p[TURN_AT] + _BYTES * 3 * i)
            add_turn(turn_b, max(t_s[i - 1], begin), t_s[i], begin, end, dense, row)
        integers(p[ROWS_AT])[m] = last
        if t_s[last - 1] > c[FURTHEST]:
            c[FURTHEST], c[SINCE], c[EXITS] = t_s[last - 1], 0.0, 0.0
    settings, outcome = _of(m, SETTINGS_AT, SETTINGS, p), UNFINISHED
    if last == rows:
        outcome = REACHED
    elif not is_whole:
        return UNFINISHED, False
    elif c[IS_STUCK] != 0.0:
        outcome = STEP_UNDERFLOW
    elif c[LEFT] != 0.0:
        outcome = ROTOR_LEAVES
    elif end >= settings[HOLDS_UNTIL_S]:
        outcome = PIECE_ENDS
    elif c[SINCE] + STEPS_OF_AN_EXIT * c[EXITS] >= settings[STEPS_ALLOWED]:
        outcome = TOO_MANY_STEPS
    elif counts:
        turn_b = floats(p[TURN_AT] + _BYTES * 3 * last)
        add_turn(turn_b, max(t_s[last - 1], begin), end, begin, end, dense, row)
    if outcome >= REACHED:
        ended = _of(m, ENDED_AT, 3, p)
        ended[0], ended[1], ended[2] = end, c[SINCE], c[EXITS]
    return outcome, True


def _write_efforts(m, first, last, begin, end, constants, p, dense, row):
    """Write the torques [N m] of drives."""
    rotors, events = constants + _BYTES * p[ROTORS_AT], constants + _BYTES * p[EVENTS_AT]
    t_s, h = floats(p[T_S_AT] + _BYTES * p[T_S_STEP] * m), end - begin
    per_step = 1.0 / h if h > 0.0 else 0.0
    for i in range(p[ROTORS]):
        efforts = floats(p[EFFORTS_AT] + _BYTES * p[ROW_COUNT] * (m * p[ROTORS] + i))
        for n in range(first, last):
            x = (t_s[n] - begin) * per_step
            efforts[n] = effort(i, x, floats(rotors), floats(events), p[MOMENTA_AT], dense, row, h)


def _show(l, p, lanes, single, make_dense):
    """Let the single lane hold the dense output of the last step of a lane."""
    count, m, c = lanes[LANE_COUNT], integers(lanes[MOTION_AT])[l], _step_state(l, lanes)
    shown, size, row = integers(single[MOTION_AT]), p[SIZE], single[ROW]
    if c[DENSE_OF] == c[STEPS] and shown[0] == m:
        return
    shown[0], c[DENSE_OF] = m, c[STEPS]
    y, dense = floats(single[_Y]), floats(single[_DENSE])
    if c[STEPS] == 0.0:
        # Not y, which may be an attempt that was rejected.
        begins = floats(lanes[_DENSE])
        for i in range(size):
            dense[i] = begins[i * count + l]
        for i in range(row, TERMS * row):
            dense[i] = 0.0
        return
    if count > 1:
        _gather(size, l, count, floats(lanes[_Y]), y)
        _gather(size, l, count, floats(lanes[_DENSE]), dense)
        for j in range(EVALUATED):
            stage = floats(lanes[_K] + _BYTES * j * size * count)
            _gather(size, l, count, stage, floats(single[_K] + _BYTES * j * row))
        _gather(p[CONSTANT_COUNT], l, count, floats(lanes[_CONSTANTS]), floats(single[_CONSTANTS]))
        _gather(p[ARRAY_COUNT], l, count, floats(lanes[_ARRAYS]), floats(single[_ARRAYS]))
        _gather(STAGE_S, l, count, floats(lanes[_FRAME]), floats(single[_FRAME]))
    frame = floats(single[_FRAME])
    frame[T], frame[H] = c[BEGIN], c[END] - c[BEGIN]
    call(make_dense, single[TABLE_AT])


def _gather(size, l, count, numbers, to):
    for i in range(size):
        to[i] = numbers[i * count + l]
