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
from .extrema import Extrema, extrema_of

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


def capture_times(
    states: States,
    passed: Extrema,
    axis_b: np.ndarray,
    period_s: np.ndarray,
    motion_of: Callable[[int], Motion],
) -> np.ndarray:
    """
    Return the times [s] (M,) from which on axes do not cross the horizontal; nan: it has no axis.

    Runs that look captured and turn far between two samples are followed more closely.

    Parameters
    ----------
    states : States
        (M, N) of M runs
    passed : Extrema
        pass_over of them and of the axis
    axis_b : (3,) or (M, 1, 3), body axes
        the axis
    period_s : (M,), s
        of the orbit
    motion_of : function of int
        returns the motion of a row
    """
    since_s, end_s = states.t_s[passed.first_after], states.t_s[-1]
    since_s = np.where(np.isnan(axis_b).any(axis=-1).ravel(), np.nan, since_s)
    turns_far = passed.fastest * np.max(np.diff(states.t_s)) > _TURN_RAD
    for row in np.nonzero(turns_far & (end_s - since_s >= period_s))[0].tolist():
        axis = axis_b if axis_b.ndim == 1 else axis_b[min(row, len(axis_b) - 1)]
        fastest = passed.fastest[row]
        since_s[row] = _followed(motion_of(row), np.ravel(axis), since_s[row], end_s, fastest)
    return since_s


def _followed(motion, axis_b, begin_s, end_s, fastest):
    """Return the time from begin_s on from which the axis of a motion does not cross."""
    count, since_s = int(np.ceil((end_s - begin_s) * fastest / _TURN_RAD)), begin_s
    for first in range(0, count, _AT_ONCE):
        rows = np.arange(first, min(first + _AT_ONCE, count) + 1)
        dense = motion.at(begin_s + rows * ((end_s - begin_s) / count))
        since = int(extrema_of(dense, axis_b).first_after)
        since_s = float(dense.t_s[since]) if since > 0 else since_s
    return since_s
