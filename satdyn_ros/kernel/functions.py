"""
The functions of formulas: of floats, of symbols, and of columns of NumPy alike.

A column has the bits of its numbers: what NumPy computes of an array may differ in the last bit
from what the C library computes of each.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from ..trace import ieee
from ..trace.graph import Symbol, apply

# Exact, so that NumPy has the same bits.
_OF_COLUMNS: dict[str, Callable[..., Any]] = {'sqrt': np.sqrt, 'floor': np.floor}


def _of_all(name: str) -> Callable[..., Any]:
    of_floats = ieee.OPERATIONS[name]
    of_columns = _OF_COLUMNS.get(name)

    def function(*x):
        if any(isinstance(each, np.ndarray) for each in x):
            with np.errstate(all='ignore'):
                return of_columns(*x) if of_columns else _one_by_one(of_floats, x)
        return apply(name, *x)

    function.__name__ = function.__qualname__ = name
    function.__doc__ = f"Return {name} as of the C library; infinite or nan where math's raises."
    return function


def _one_by_one(function, columns):
    # Of one row, np.vectorize takes ten times as long.
    same = np.broadcast_arrays(*columns)
    found = map(function, *(each.ravel().tolist() for each in same))
    return np.fromiter(found, float, same[0].size).reshape(same[0].shape)


# All of them by their names.
BY_NAME = {name: _of_all(name) for name in (*_OF_COLUMNS, *ieee.OF_C_LIBRARY)}

sqrt, floor, exp, log = (BY_NAME[name] for name in ('sqrt', 'floor', 'exp', 'log'))
sin, cos, tan = (BY_NAME[name] for name in ('sin', 'cos', 'tan'))
asin, acos, atan, atan2 = (BY_NAME[name] for name in ('asin', 'acos', 'atan', 'atan2'))
sinh, cosh, tanh = (BY_NAME[name] for name in ('sinh', 'cosh', 'tanh'))


def divide(a: Any, b: Any) -> Any:
    """Return a / b, infinite or nan where b is zero."""
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        with np.errstate(all='ignore'):
            return np.true_divide(a, b)
    return apply('fdiv', a, b)


def select(condition: Any, a: Any, b: Any) -> Any:
    """
    Return a where a condition holds, else b; both are computed.

    Parameters
    ----------
    condition : bool
        such as a comparison of numbers
    a, b : numbers
        the values to choose from

    Examples
    --------
    >>> select(1.0 < 2.0, 'a', 'b')
    'a'
    """
    if isinstance(condition, Symbol):
        return apply('select', condition, a, b)
    if isinstance(condition, np.ndarray):
        return np.where(condition, a, b)
    return a if condition else b


def minimum(a: Any, b: Any) -> Any:
    """Return b where b < a, else a."""
    return select(b < a, b, a)


def maximum(a: Any, b: Any) -> Any:
    """Return b where b > a, else a."""
    return select(b > a, b, a)


def subroutine(function: Callable[..., Any], *arguments: Any) -> Any:
    """
    Return function(*arguments), a tuple of numbers.

    Code calls it, where code in place of others is written out.
    """
    for argument in arguments:
        if isinstance(argument, Symbol):
            return argument.graph.call(function, *arguments)
    return function(*arguments)
