"""Operations on floats by IEEE 754: infinite or nan where Python raises."""

import math
from collections.abc import Callable


def divide(a: float, b: float) -> float:
    """
    Return a / b, of a zero b too.

    >>> divide(-1.0, 0.0), divide(0.0, 0.0)
    (-inf, nan)
    """
    if b:
        return a / b
    if a == 0.0 or a != a:
        return math.nan
    return math.copysign(math.inf, a) * math.copysign(1.0, b)


def floor(x: float) -> float:
    """Return the largest whole number that is not above x, as a float."""
    return math.copysign(float(math.floor(x)), x) if math.isfinite(x) else x


# Where a function is infinite that math does not let be.
_POLES = {
    **{name: {0.0: -math.inf} for name in ('log', 'log2', 'log10')},
    'log1p': {-1.0: -math.inf},
    'atanh': {1.0: math.inf, -1.0: -math.inf},
}


def _total(name: str) -> Callable[..., float]:
    """Return a function of math that returns where that raises."""
    function = getattr(math, name)

    def total(*x: float) -> float:
        try:
            return function(*x)
        except ValueError:
            return _POLES.get(name, {}).get(x[0], math.nan)
        except OverflowError:
            is_negative = name == 'sinh' and x[0] < 0.0
            return -math.inf if is_negative else math.inf

    return total


# Exact everywhere.
EXACT: dict[str, Callable[[float], float]] = {
    'fabs': abs,
    'sqrt': _total('sqrt'),
    'floor': floor,
}
# The C library's, by their names there: they may differ in the last bit from one to another.
OF_C_LIBRARY = {
    name: _total(name)
    for name in (
        *('sin', 'cos', 'tan', 'asin', 'acos', 'atan', 'atan2'),
        *('exp', 'expm1', 'log', 'log2', 'log10', 'log1p', 'erf', 'erfc'),
        *('sinh', 'cosh', 'tanh', 'asinh', 'acosh', 'atanh', 'fmod'),
    )
}
# What each operation gives of operands that are known.
OPERATIONS: dict[str, Callable[..., float]] = {
    'fadd': lambda a, b: a + b,
    'fsub': lambda a, b: a - b,
    'fmul': lambda a, b: a * b,
    'fdiv': divide,
    'fneg': lambda a: -a,
    'olt': lambda a, b: a < b,
    'ole': lambda a, b: a <= b,
    'ogt': lambda a, b: a > b,
    'oge': lambda a, b: a >= b,
    'oeq': lambda a, b: a == b,
    'une': lambda a, b: a != b,
    **EXACT,
    **OF_C_LIBRARY,
}
