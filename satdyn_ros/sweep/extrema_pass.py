"""The pass of extrema.py over the samples of each run, compiled."""

from functools import partial

import numpy as np

from ..kernel.compile import compiled, inlined
from ..kernel.rows import MANY_ROWS
from ..kernel.vector import cross, dot

_dot, _cross = inlined(dot), inlined(cross)
_SIGNATURE = f'void(float64[::1], {", ".join(5 * [MANY_ROWS])}, float64[:, ::1], int64[::1])'


@inlined
def _vector(row):
    return row[0], row[1], row[2]


@inlined
def _widened(extremes, x, n):
    return (min(extremes[0], x), max(extremes[1], x)) if n > 0 else (x, x)


@inlined
def _crosses(begin, begin_slope, end, end_slope):
    """Return whether Hermite's cubic from 0 to 1 crosses zero."""
    if begin < 0.0:
        begin, begin_slope, end, end_slope = -begin, -begin_slope, -end, -end_slope
    if end <= 0.0:
        return True
    return begin_slope < 0.0 < end_slope and _lowest(begin, begin_slope, end, end_slope) <= 0.0


@inlined
def _lowest(begin, begin_slope, end, end_slope):
    """Return the least value of the cubic, which falls first and rises last."""
    rise = end - begin
    third = begin_slope + end_slope - 2.0 * rise
    second = 3.0 * rise - 2.0 * begin_slope - end_slope
    # The root of begin_slope + 2 second x + 3 third x^2 where the slope grows, in the form that
    # does not cancel.
    root = np.sqrt(max(second * second - 3.0 * third * begin_slope, 0.0))
    x = (root - second) / (3.0 * third) if second < 0.0 else -begin_slope / (second + root)
    return begin + x * (begin_slope + x * (second + x * third))


@partial(compiled, signature=_SIGNATURE)
def write_extrema(
    t_s: np.ndarray,
    q_lb: np.ndarray,
    omega_bi_b: np.ndarray,
    lvlh_rate_b: np.ndarray,
    c_b: np.ndarray,
    axes: np.ndarray,
    found: np.ndarray,
    first_after: np.ndarray,
) -> None:
    """
    Write the Extrema of M runs, N samples each: found (5, M), first_after (M,) zeros.

    q_lb (M, N, 4); the rates and c_b (M, N, 3); axes (M, 1, 3).
    """
    for m in range(len(axes)):
        axis = _vector(axes[m, 0])
        lvlh, nadir, fastest, height, climb = (0.0, 0.0), (0.0, 0.0), 0.0, 0.0, 0.0
        for n in range(len(t_s)):
            q, c = q_lb[m, n], _vector(c_b[m, n])
            rate, lvlh_rate = omega_bi_b[m, n], lvlh_rate_b[m, n]
            omega = rate[0] - lvlh_rate[0], rate[1] - lvlh_rate[1], rate[2] - lvlh_rate[2]
            across = _cross(axis, c)
            height_before, climb_before = height, climb
            height, climb = _dot(axis, c), _dot(omega, across)
            lvlh = _widened(lvlh, _dot(q, q) / (q[3] * q[3]), n)
            nadir = _widened(nadir, _dot(across, across) / (height * height), n)
            fastest = max(fastest, _dot(omega, omega))
            if n > 0:
                gap_s = t_s[n] - t_s[n - 1]
                if _crosses(height_before, gap_s * climb_before, height, gap_s * climb):
                    first_after[m] = n
        found[0, m], found[1, m] = lvlh
        found[2, m], found[3, m] = nadir
        found[4, m] = np.sqrt(fastest)
