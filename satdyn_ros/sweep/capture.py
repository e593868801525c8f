"""
Whether the gravity gradient has captured a body, and from what time on.

A body is captured when its axis of least inertia, or another chosen one, does not cross the local
horizontal during at least the last orbit: one of its ends stays below.  With c the unit vector
from the attracting centre and a the axis, it crosses the horizontal where c . a changes
sign; (c . a)' = omega_bl . (a x c).
"""

from collections.abc import Callable

import numpy as np

from ..dynamics.inertia import ROUNDING, principal_axes
from ..dynamics.motion import Motion, States
from .measures import cross, dot, extremes, length, omega_bl_b

LEAST = 'least'
AXES = {'x': (1.0, 0.0, 0.0), 'y': (0.0, 1.0, 0.0), 'z': (0.0, 0.0, 1.0)}

# How far a body may turn between two samples [rad]; a cubic between them is accurate to 2e-4.
_TURN_RAD = 0.5
# Samples held at a time where a motion is followed more closely.
_AT_ONCE = 100_000


def judged_axis(name: str, inertia: np.ndarray) -> np.ndarray:
    """
    Return the axis (..., 3) named x, y, z or least of inertias (..., 3, 3), body axes.

    nan: the body has no axis of least inertia, as its least two moments are equal.
    """
    if name in AXES:
        return np.array(AXES[name])
    moments, R_bp = principal_axes(inertia)
    least, middle, largest = np.moveaxis(np.sort(moments, axis=-1), -1, 0)
    at = np.argmin(np.asarray(moments), axis=-1, keepdims=True)[..., None]
    axis = np.take_along_axis(R_bp, at, axis=-1)[..., 0]
    return np.where((middle - least > ROUNDING * largest)[..., None], axis, np.nan)


def nadir_angles(states: States, axis_b: np.ndarray) -> dict[str, np.ndarray]:
    """Return the extremes of the angle of axes, either end of them, to nadir, 0 to pi/2 [rad]."""
    across = cross(states.c_b, axis_b)
    with np.errstate(divide='ignore'):
        return extremes('nadir_angle', dot(across, across) / dot(states.c_b, axis_b) ** 2)


def capture_times(
    states: States,
    axis_b: np.ndarray,
    period_s: np.ndarray,
    motion_of: Callable[[int], Motion],
) -> np.ndarray:
    """
    Return the times [s] (M,) from which on axes do not cross the horizontal; nan: it has no axis.

    states (M, N), axis_b (3,) or (M, 1, 3), period_s (M,).  Runs that look captured and turn far
    between two samples are followed more closely: motion_of gives the motion of a row.
    """
    rates = omega_bl_b(states)
    since_s, end_s = states.t_s[_first_after(states, rates, axis_b)], states.t_s[-1]
    since_s = np.where(np.isnan(axis_b).any(axis=-1).ravel(), np.nan, since_s)
    fastest = length(rates).max(axis=-1)
    turns_far = fastest * np.max(np.diff(states.t_s)) > _TURN_RAD
    for row in np.nonzero(turns_far & (end_s - since_s >= period_s))[0].tolist():
        axis = axis_b if axis_b.ndim == 1 else axis_b[min(row, len(axis_b) - 1)]
        since_s[row] = _followed(motion_of(row), np.ravel(axis), since_s[row], end_s, fastest[row])
    return since_s


def _followed(motion, axis_b, begin_s, end_s, fastest):
    """Return the time from begin_s on from which the axis of a motion does not cross."""
    count, since_s = int(np.ceil((end_s - begin_s) * fastest / _TURN_RAD)), begin_s
    for first in range(0, count, _AT_ONCE):
        rows = np.arange(first, min(first + _AT_ONCE, count) + 1)
        dense = motion.at(begin_s + rows * ((end_s - begin_s) / count))
        since = int(_first_after(dense, omega_bl_b(dense), axis_b))
        since_s = float(dense.t_s[since]) if since > 0 else since_s
    return since_s


def _first_after(states, rates, axis_b):
    """Return the first row after the last crossing, shape (...); 0: there is none."""
    crosses = _crosses(states, rates, axis_b)
    count = crosses.shape[-1]
    last = count - np.argmax(crosses[..., ::-1], axis=-1)
    return np.where(crosses.any(axis=-1), last, 0)


def _crosses(states, rates, axis_b):
    """Return whether the axis crosses the horizontal between rows, (..., N - 1)."""
    height = dot(states.c_b, axis_b)
    rate = dot(rates, cross(axis_b, states.c_b))
    begin, end = height[..., :-1], height[..., 1:]
    upper = np.where(begin < 0.0, -1.0, 1.0)
    begin, end = upper * begin, upper * end
    gap_s = upper * np.diff(states.t_s)
    begin_slope, end_slope = gap_s * rate[..., :-1], gap_s * rate[..., 1:]
    # Where it comes down and goes up again, the lowest point of the cubic between the rows.
    crosses = end <= 0.0
    dips = ~crosses & (begin_slope < 0.0) & (end_slope > 0.0)
    lowest = _lowest(begin[dips], begin_slope[dips], end[dips], end_slope[dips])
    crosses[dips] = lowest <= 0.0
    return crosses


def _lowest(begin, begin_slope, end, end_slope):
    """Return the least value of Hermite's cubic from 0 to 1, which falls first and rises last."""
    rise = end - begin
    third = begin_slope + end_slope - 2.0 * rise
    second = 3.0 * rise - 2.0 * begin_slope - end_slope
    # The root of begin_slope + 2 second x + 3 third x^2 where the slope grows, in the form that
    # does not cancel.
    root = np.sqrt(np.maximum(second**2 - 3.0 * third * begin_slope, 0.0))
    falls = second < 0.0
    x = np.where(falls, root - second, -begin_slope) / np.where(falls, 3.0 * third, second + root)
    return begin + x * (begin_slope + x * (second + x * third))
