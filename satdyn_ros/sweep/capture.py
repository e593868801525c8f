"""
Whether the gravity gradient has captured a body, and since when.

A body is captured when its axis of least inertia, or another that is named, does not cross the
local horizontal during at least the last orbit: one end of it, either one, stays below.  With c
the unit vector from the attracting centre and a the axis, it crosses the horizontal where c . a
changes sign; (c . a)' = omega_bl . (a x c).
"""

import numpy as np

from ..dynamics import rotation
from ..dynamics.inertia import principal_axes
from ..dynamics.motion import Motion, States

LEAST = 'least'
AXES = {'x': (1.0, 0.0, 0.0), 'y': (0.0, 1.0, 0.0), 'z': (0.0, 0.0, 1.0)}

# Moments that differ by less, as a part of the largest, are equal.
_ROUNDING = 1e-12
# How far a body may turn between two samples [rad]; a cubic between them is good to 2e-4.
_TURN_RAD = 0.5
# Samples that are held at a time where a motion is followed more closely.
_AT_ONCE = 100_000


def judged_axis(name: str, inertia: np.ndarray) -> np.ndarray | None:
    """
    Return the axis (3,) of a name, x, y, z or least, of a body of inertia (3, 3), body axes.

    None: it has no axis of least inertia, the least two moments are equal.
    """
    if name in AXES:
        return np.array(AXES[name])
    moments, R_bp = principal_axes(inertia)
    least, middle, _ = np.argsort(moments)
    if moments[middle] - moments[least] <= _ROUNDING * np.max(moments):
        return None
    return R_bp[:, least]


def nadir_angle(states: States, axis_b: np.ndarray) -> np.ndarray:
    """Return the angle of an axis (3,), either end of it, to nadir, 0 to pi/2 [rad], (N,)."""
    across = np.linalg.norm(np.cross(states.c_b, axis_b), axis=-1)
    return np.arctan2(across, np.abs(states.c_b @ axis_b))


def captured_since(states: States, axis_b: np.ndarray, motion: Motion) -> float:
    """
    Return the time [s] from which on an axis (3,) does not cross the horizontal.

    states: a table of the motion.  Where the body turns far between two of its rows, the motion
    is asked again, densely enough to miss no crossing; where it is not, to the next row.
    """
    since_s = _since(states, axis_b)
    fastest = np.max(np.linalg.norm(_omega_bl_b(states), axis=-1))
    end_s, step_s = states.t_s[-1], _TURN_RAD / fastest if fastest > 0.0 else np.inf
    if since_s == end_s or np.max(np.diff(states.t_s)) <= step_s:
        return since_s
    count = int(np.ceil((end_s - since_s) / step_s))
    begin_s = since_s
    for first in range(0, count, _AT_ONCE):
        rows = np.arange(first, min(first + _AT_ONCE, count) + 1)
        dense = motion.at(begin_s + rows * ((end_s - begin_s) / count))
        found_s = _since(dense, axis_b)
        since_s = found_s if found_s > dense.t_s[0] else since_s
    return since_s


def _since(states, axis_b):
    """Return the time of the first row after the last crossing; the first: there is none."""
    crossings = np.nonzero(_crosses(states, axis_b))[0]
    return float(states.t_s[np.max(crossings, initial=-1) + 1])


def _crosses(states, axis_b):
    """Return whether the axis crosses the horizontal between rows, (N - 1,)."""
    height = states.c_b @ axis_b
    rate = np.sum(_omega_bl_b(states) * np.cross(axis_b, states.c_b), axis=-1)
    upper = np.where(height[:-1] < 0.0, -1.0, 1.0)
    begin, end = upper * height[:-1], upper * height[1:]
    gap_s = np.diff(states.t_s)
    begin_slope, end_slope = upper * rate[:-1] * gap_s, upper * rate[1:] * gap_s
    # Where it comes down and goes up again, the lowest point of the cubic between the rows.
    crosses = end <= 0.0
    dips = np.nonzero(~crosses & (begin_slope < 0.0) & (end_slope > 0.0))[0]
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


def _omega_bl_b(states):
    to_body = rotation.conjugate(states.q_ib)
    return states.omega_bi_b - rotation.rotate(to_body, states.orbit.lvlh_rate(states.orbit_s))
