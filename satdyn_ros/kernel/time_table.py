"""
Functions of time as tables of Chebyshev polynomials, in compiled code and outside.

A table is made where any library may compute the function; the equations see polynomials.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import lower_builtin, type_callable
from numpy.polynomial import chebyshev

from .compile import inlined
from .simd import SimdVector, in_lanes, llvm_function

_PLACE = ir.IntType(64)


class Table(NamedTuple):
    """
    Several functions of time, each a polynomial in every piece of it.

    grid (2,): where the first piece begins and how long each is [s].  coefficients
    (pieces, functions, terms): of the Chebyshev polynomials, in ascending order.
    """

    grid: np.ndarray
    coefficients: np.ndarray

    @property
    def ends_s(self) -> np.ndarray:
        """The times at which a piece ends and the next begins."""
        begin_s, piece_s = self.grid
        return begin_s + piece_s * np.arange(1.0, len(self.coefficients))


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
    Return the table of function(t_s (N,)) -> (N, C), by its values at the nodes of each piece.

    >>> table = table_of(lambda t: np.sin(t)[:, None], 0.0, 1.0, 10)
    >>> round(interpolate(table, 0, 2.5), 12) == round(math.sin(2.5), 12)
    True
    """
    nodes = chebyshev.chebpts1(terms)
    values_to_terms = np.linalg.inv(chebyshev.chebvander(nodes, terms - 1))
    parts = []
    for piece in range(pieces):
        t_s = begin_s + piece_s * (piece + (nodes + 1.0) / 2.0)
        parts.append((values_to_terms @ function(t_s)).T)
    return Table(np.array([begin_s, piece_s]), np.array(parts))


@inlined
def interpolate(table: Table, i: int, t_s: float) -> float:
    """Return the i-th function of a table at t_s; beyond the table, what its end pieces say."""
    pieces, functions, terms = table.coefficients.shape
    since = (t_s - table.grid[0]) / table.grid[1]
    piece = min(max(whole(since), 0.0), pieces - 1.0)
    x = 2.0 * (since - piece) - 1.0
    first = (piece * functions + i) * terms
    # Clenshaw's recurrence.
    b_1, b_2 = 0.0 * x, 0.0 * x
    for k in range(terms - 1, 0, -1):
        b_1, b_2 = look_up(table.coefficients, first + k) + 2.0 * x * b_1 - b_2, b_1
    return look_up(table.coefficients, first) + x * b_1 - b_2


@inlined
def interpolate_vector(table: Table, i: int, t_s: float) -> tuple[float, float, float]:
    """Return the functions i, i + 1 and i + 2 of a table at t_s."""
    return (
        interpolate(table, i, t_s),
        interpolate(table, i + 1, t_s),
        interpolate(table, i + 2, t_s),
    )


def whole(x: float) -> float:
    """
    Return the largest whole number that is not above x, as a float.

    >>> whole(-0.5)
    -1.0
    """
    return float(math.floor(x))


@type_callable(whole)
def _type_of_whole(context):
    return lambda x: x if isinstance(x, SimdVector) else types.float64


@lower_builtin(whole, types.float64)
@lower_builtin(whole, SimdVector)
def _whole(context, builder, signature, values):
    return llvm_function('llvm.floor')(context, builder, *values)


def look_up(array: np.ndarray, place: float) -> float:
    """
    Return what is at a place of an array, counted row by row; place: a whole number, as a float.

    >>> look_up(np.array([1.0, 2.0]), 1.0)
    np.float64(2.0)
    """
    return array.flat[int(place)]


@type_callable(look_up)
def _type_of_look_up(context):
    return lambda array, place: place if isinstance(place, SimdVector) else types.float64


@lower_builtin(look_up, types.Array, types.float64)
@lower_builtin(look_up, types.Array, SimdVector)
def _look_up(context, builder, signature, values):
    array, place = values
    data = context.make_array(signature.args[0])(context, builder, array).data

    def load(place):
        return builder.load(builder.gep(data, [builder.fptosi(place, _PLACE)]))

    is_vector = isinstance(signature.args[1], SimdVector)
    return in_lanes(builder, place, load) if is_vector else load(place)
