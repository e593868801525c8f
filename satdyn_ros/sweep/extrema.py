"""The extreme angles and rates in the states (M, N) of M runs at N times."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..dynamics.motion import States
from ..kernel.rows import table_of


class Extrema(NamedTuple):
    """
    The extrema of runs (...).

    Attributes
    ----------
    lvlh : two of (...)
        the least and the largest tan^2 of half the angle to LVLH
    nadir : two of (...)
        likewise of the angle of an axis to nadir
    fastest : (...), rad/s
        the largest rate relative to LVLH
    first_after : (...) int
        the first row after the last crossing of the horizontal by the axis, 0: there is none
    """

    lvlh: tuple[np.ndarray, np.ndarray]
    nadir: tuple[np.ndarray, np.ndarray]
    fastest: np.ndarray
    first_after: np.ndarray


def extrema_of(states: States, axis_b: np.ndarray) -> Extrema:
    """
    Return the extrema of runs on an orbit.

    Parameters
    ----------
    states : States
        (..., N)
    axis_b : (3,) or (..., 1, 3), body axes
        the axis
    """
    # Compiled, which reading a sweep need not wait for.
    from .extrema_pass import write_extrema

    *runs, count = states.q_ib.shape[:-1]
    rows = states.q_lb, states.omega_bi_b, states.lvlh_rate_b, states.c_b
    tables = (table_of(each, (*runs, count)) for each in rows)
    many = math.prod(runs)
    found, first_after = np.empty((5, many)), np.zeros(many, int)
    write_extrema(states.t_s, *tables, table_of(axis_b, (*runs, 1)), found, first_after)
    lowest, highest, nearest, furthest, fastest = found.reshape(5, *runs)
    return Extrema((lowest, highest), (nearest, furthest), fastest, first_after.reshape(runs))


def angles(name: str, squares_of_tangent: Sequence[np.ndarray], factor: float = 1.0) -> dict:
    """Return the least and the largest of factor times an angle [rad] from those of tan^2 (M,)."""
    least, largest = (factor * np.arctan(np.sqrt(square)) for square in squares_of_tangent)
    return {f'{name}_min_rad': least, f'{name}_max_rad': largest}
