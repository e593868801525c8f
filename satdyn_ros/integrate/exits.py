"""
Steps end where a rotor leaves the line of its drive's law, or the jump, that it is on.

A step that goes beyond is taken back and taken again, up to the instant at which the dense output
leaves the range.  There the walk stops, and other constants hold.
"""

import numpy as np

from ..dynamics.constants import Constants
from ..dynamics.equations import MOMENTUM, OMEGA
from ..kernel.compile import inlined
from ..kernel.unroll import unrolled_fold
from .dense_output import make_dense, polynomial, slope, terms
from .dop853 import BEGIN, DENSE_OF, END, EXIT, EXIT_S, LEFT, NEXT, STEPS, ULP, Stages

# Where in a step values are looked at, and how often the place is halved.
_SAMPLES, _HALVINGS = 8, 60


@inlined
def stop_at_exit(
    clock: np.ndarray, stages: Stages, dense: np.ndarray, constants: Constants
) -> None:
    """
    Let the step end where the first rotor leaves its range, or be taken again up to there.

    Without drives nothing is done.  Of the clock, LEFT: which rotor has left at END, as of
    Drives.leave, 0: none; EXIT_S: where the step is to end, EXIT: which rotor leaves there.
    """
    _stop(0, constants.drives, clock, stages, dense, constants)


@unrolled_fold
def _stop(found, i, drives, clock, stages, dense, constants):
    make_dense(clock, stages, dense, constants)
    if clock[END] >= clock[EXIT_S] * (1.0 - 4.0 * ULP):
        clock[LEFT], clock[EXIT_S] = clock[EXIT], np.inf
        return found
    t, h = clock[BEGIN], clock[END] - clock[BEGIN]
    part, which = _first_exit((2.0, 0.0), drives[i].watches, constants.rotors, dense, h)
    clock[EXIT_S] = np.inf
    if part > 1.0:
        return found
    for j in range(len(stages.y)):
        stages.y[j] = dense[0, j]
    end = t + part * h
    clock[END], clock[DENSE_OF] = t, -1.0
    clock[STEPS] -= 1.0
    clock[NEXT] = h
    if t < end:
        clock[EXIT_S], clock[EXIT], clock[NEXT] = end, which, end - t
    else:
        clock[LEFT] = which
    return found


@unrolled_fold
def _first_exit(found, i, watches, rotors, dense, h):
    """Return the part of the step after which a value leaves its range, and whose; 2: none."""
    watch, rotor = watches[i], rotors[i]
    line = _line(dense, i, watch, rotor)
    inside = 0.0
    for n in range(_SAMPLES + 1):
        outside = n / _SAMPLES
        value = _value(line, outside, watch, h)
        if not (value < watch.low or value > watch.high):
            inside = outside
            continue
        is_above = value > watch.high
        for _ in range(_HALVINGS if n > 0 else 0):
            middle = 0.5 * (inside + outside)
            value = _value(line, middle, watch, h)
            if (value > watch.high) if is_above else (value < watch.low):
                outside = middle
            else:
                inside = middle
        if outside < found[0]:
            found = outside, (i + 1.0 if is_above else -i - 1.0)
        break
    return found


@inlined
def write_efforts(
    t_s: np.ndarray,
    efforts: np.ndarray,
    first: int,
    last: int,
    clock: np.ndarray,
    dense: np.ndarray,
    constants: Constants,
) -> None:
    """Write the torques [N m] of drives, if any, at t_s[first:last] into efforts (R, N)."""
    _write(0, constants.drives, t_s, efforts, first, last, clock, dense, constants)


@unrolled_fold
def _write(total, i, drives, t_s, efforts, first, last, clock, dense, constants):
    begin, h = clock[BEGIN], clock[END] - clock[BEGIN]
    per_step = 1.0 / h if h > 0.0 else 0.0
    for n in range(first, last):
        x = (t_s[n] - begin) * per_step
        _write_effort(0, drives[i].watches, constants.rotors, dense, efforts, n, x, h)
    return total


@unrolled_fold
def _write_effort(total, i, watches, rotors, dense, efforts, n, x, h):
    watch = watches[i]
    value = _value(_line(dense, i, watch, rotors[i]), x, watch, h)
    per_value = 1.0 if watch.held_inertia > 0.0 else -watch.gain
    efforts[i, n] = watch.effort + per_value * value
    return total


@inlined
def _line(dense, i, watch, rotor):
    """Return the dense output of a rotor's speed or, where it is held, of its momentum."""
    p = terms(dense, MOMENTUM + i)
    if watch.held_inertia > 0.0:
        return p
    x, y, z = terms(dense, OMEGA), terms(dense, OMEGA + 1), terms(dense, OMEGA + 2)
    return (
        _speed(0, rotor, p, x, y, z),
        _speed(1, rotor, p, x, y, z),
        _speed(2, rotor, p, x, y, z),
        _speed(3, rotor, p, x, y, z),
        _speed(4, rotor, p, x, y, z),
        _speed(5, rotor, p, x, y, z),
        _speed(6, rotor, p, x, y, z),
        _speed(7, rotor, p, x, y, z),
    )


@inlined
def _speed(j, rotor, p, x, y, z):
    a = rotor.axis
    return rotor.inertia_inverse * p[j] - (a[0] * x[j] + a[1] * y[j] + a[2] * z[j])


@inlined
def _value(line, x, watch, h):
    """Return what is watched: a speed [rad/s] or, of a rotor that is held, p' [N m]."""
    if watch.held_inertia > 0.0:
        return slope(line, x) / h if h > 0.0 else 0.0
    return polynomial(line, x)
