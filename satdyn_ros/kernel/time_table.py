"""
Functions of time as tables of Chebyshev polynomials.

A table is made where any library may compute the function; the equations see polynomials.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from ..trace.graph import SymbolArray
from .functions import floor, maximum, minimum, subroutine


class Table(NamedTuple):
    """
    Several functions of time, each a polynomial in every piece of it.

    Attributes
    ----------
    grid : (2,), s
        where the first piece begins and how long each is
    coefficients : (pieces, functions, terms)
        of the Chebyshev polynomials, in ascending order
    """

    grid: np.ndarray
    coefficients: np.ndarray

    @property
    def ends_s(self) -> np.ndarray:
        """The times at which a piece ends and the next begins."""
        begin_s, piece_s = self.grid
        return begin_s + piece_s * np.arange(1.0, len(self.coefficients))


_THREE = np.arange(3.0)[:, None]
# Of no functions, until there is one.
NO_TABLE = Table(np.array([0.0, 1.0]), np.zeros((1, 0, 1)))


def table_of(
    function: Callable[[np.ndarray], np.ndarray],
    begin_s: float,
    piece_s: float,
    pieces: int,
    terms: int = 16,
) -> Table:
    """
    Return the table of a function of time, from its values at the nodes of each piece.

    Parameters
    ----------
    function : function
        of t_s (N,), returns (N, C)
    begin_s : s
        begin of the first piece
    piece_s : s
        length of each piece
    pieces : int
        how many
    terms : int
        terms of each polynomial

    Examples
    --------
    >>> table = table_of(lambda t: np.sin(t)[:, None], 0.0, 1.0, 10)
    >>> round(interpolate(table, 0, 2.5), 12) == round(float(np.sin(2.5)), 12)
    True
    """
    nodes = chebyshev.chebpts1(terms)
    values_to_terms = np.linalg.inv(chebyshev.chebvander(nodes, terms - 1))
    parts = []
    for piece in range(pieces):
        t_s = begin_s + piece_s * (piece + (nodes + 1.0) / 2.0)
        parts.append((values_to_terms @ function(t_s)).T)
    return Table(np.array([begin_s, piece_s]), np.array(parts))


def interpolate(table: Table, i: Any, t_s: Any) -> Any:
    """
    Return one function of a table; beyond the table, that of its first or last piece.

    Parameters
    ----------
    table : Table
        the table
    i : int
        which function; for a column of times also a column (C, 1) of whole numbers
    t_s : s
        the time
    """
    (found,) = _interpolated(table, i, 1, t_s)
    return found


def interpolate_vector(table: Table, i: int, t_s: Any) -> tuple[Any, Any, Any]:
    """Return the functions i, i + 1 and i + 2 of a table at t_s."""
    if isinstance(t_s, np.ndarray):
        x, y, z = interpolate(table, i + _THREE, t_s)
    else:
        x, y, z = _interpolated(table, i, 3, t_s)
    return x, y, z


def _interpolated(table, i, count, t_s):
    """Return so many functions of a table at t_s, from the i-th on."""
    pieces, functions, terms = table.coefficients.shape
    since = (t_s - look_up(table.grid, 0.0)) / look_up(table.grid, 0.0, 1)
    piece: Any = 0.0
    if pieces > 1:
        # A time that is no number is in the first one.
        piece = minimum(maximum(0.0, floor(since)), pieces - 1.0)
    x, first = 2.0 * (since - piece) - 1.0, (piece * functions + i) * terms
    return subroutine(_series, table.coefficients, first, terms, count, x)


def _series(coefficients, first, terms, count, x):
    """Return the sums of so many Chebyshev series, the first of which begins at this index."""
    twice, b_1, b_2 = 2.0 * x, [0.0] * count, [0.0] * count
    for k in range(terms - 1, 0, -1):
        # By Clenshaw's recurrence.  In this order b_1 alone is waited for, of all at once.
        for j in range(count):
            c = look_up(coefficients, first, j * terms + k)
            b_1[j], b_2[j] = c - b_2[j] + twice * b_1[j], b_1[j]
    return tuple(
        look_up(coefficients, first, j * terms) - b_2[j] + x * b_1[j] for j in range(count)
    )


def look_up(array: Any, index: Any, offset: int = 0) -> Any:
    """
    Return what is `offset` after an index of an array, counted row by row.

    index: a whole number, as a float.

    >>> look_up(np.array([1.0, 2.0]), 1.0)
    2.0
    """
    if isinstance(array, SymbolArray):
        return array.at(index, offset)
    if isinstance(index, np.ndarray):
        return array.ravel()[index.astype(int) + offset]
    return float(array.flat[int(index) + offset])
