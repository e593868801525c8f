"""
The dense output of a step of dop853.py, of order 7.

Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, 1993, II.6, II.10.

dense: the terms, in rows of so many numbers, one of each variable.
"""

import math
from typing import Any

import numpy as np

from ..dynamics.constants import AXES_RATE, NORMAL_AT
from ..dynamics.variables import RATE

# Gauss and Legendre's rule of four nodes is exact for polynomials of degree 7, which these are.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)
_INNER, _OUTER = map(float, _NODES[2:])
_OF_INNER, _OF_OUTER = map(float, _WEIGHTS[2:])
# Behind the attitude come the rate and all else.
_RATE = RATE.start


def interpolate(
    t_s: Any,
    count: int,
    out: Any,
    stride: int,
    wanted: int,
    begin: float,
    end: float,
    dense: Any,
    row: int,
    constants: Any,
) -> None:
    """
    Evaluate the dense output at the first times of t_s, with q_ib in place of q.

    out: one variable after the other, so many numbers apart; the quaternions come out as unit.
    wanted: variables; begin and end: of the step; constants: the numbers of the Constants.
    """
    h = end - begin
    per_step = 1.0 / h if h > 0.0 else 0.0
    half_rate = 0.5 * constants[AXES_RATE]
    n_x, n_y, n_z = constants[NORMAL_AT], constants[NORMAL_AT + 1], constants[NORMAL_AT + 2]
    cosine, sine = math.cos(half_rate * begin), math.sin(half_rate * begin)
    # Loaded before anything is written, so that the loops may become ones of vectors.
    d_0, d_1 = terms(dense, row, 0), terms(dense, row, 1)
    d_2, d_3 = terms(dense, row, 2), terms(dense, row, 3)
    for n in range(count):
        x = (t_s[n] - begin) * per_step
        a, b, c, d = polynomial(d_0, x), polynomial(d_1, x), polynomial(d_2, x), polynomial(d_3, x)
        square = a * a + b * b + c * c + d * d
        # A quaternion that is unit to rounding stays as it is: a requested one is kept exactly.
        unit = 1.0 if abs(square - 1.0) < 1e-15 else 1.0 / math.sqrt(square)
        a, b, c, d = unit * a, unit * b, unit * c, unit * d
        # q_ib = (u, w) q, where (u, w) is what the axes of q have turned by.
        cos_x, sin_x = _cosine_sine(half_rate * (t_s[n] - begin))
        turn, w = sine * cos_x + cosine * sin_x, cosine * cos_x - sine * sin_x
        u_x, u_y, u_z = turn * n_x, turn * n_y, turn * n_z
        out[n] = w * a + d * u_x + (u_y * c - u_z * b)
        out[stride + n] = w * b + d * u_y + (u_z * a - u_x * c)
        out[2 * stride + n] = w * c + d * u_z + (u_x * b - u_y * a)
        out[3 * stride + n] = w * d - (u_x * a + u_y * b + u_z * c)
    for i in range(_RATE, wanted):
        d_0 = terms(dense, row, i)
        for n in range(count):
            out[i * stride + n] = polynomial(d_0, (t_s[n] - begin) * per_step)


def add_turn(
    turn_b: Any, from_s: float, to_s: float, begin: float, end: float, dense: Any, row: int
) -> None:
    """Add to turn_b (3,) the integral of omega over a part of the step, from from_s to to_s."""
    h = end - begin
    per_step = 1.0 / h if h > 0.0 else 0.0
    half = 0.5 * (to_s - from_s)
    middle, reach = (from_s - begin + half) * per_step, half * per_step
    for j in range(3):
        d = terms(dense, row, _RATE + j)
        inner = polynomial(d, middle - _INNER * reach) + polynomial(d, middle + _INNER * reach)
        outer = polynomial(d, middle - _OUTER * reach) + polynomial(d, middle + _OUTER * reach)
        turn_b[j] += half * (_OF_INNER * inner + _OF_OUTER * outer)


def _cosine_sine(x):
    """Return cos x and sin x to rounding, |x| <= STEP_TURN / 2, by their series."""
    # A loop of library calls would not become one of vectors.
    y = -x * x
    cosine = 1.0 + y / 2.0 * (
        1.0 + y / 12.0 * (1.0 + y / 30.0 * (1.0 + y / 56.0 * (1.0 + y / 90.0 * (1.0 + y / 132.0))))
    )
    sine = x * (
        1.0 + y / 6.0 * (1.0 + y / 20.0 * (1.0 + y / 42.0 * (1.0 + y / 72.0 * (1.0 + y / 110.0))))
    )
    return cosine, sine


def terms(dense: Any, row: int, i: int) -> tuple[float, ...]:
    """Return the terms of variable i."""
    return (
        dense[i],
        dense[row + i],
        dense[2 * row + i],
        dense[3 * row + i],
        dense[4 * row + i],
        dense[5 * row + i],
        dense[6 * row + i],
        dense[7 * row + i],
    )


def polynomial(d: tuple[float, ...], x: float) -> float:
    """Return the value at a share x of the step of what has the terms d."""
    y = 1.0 - x
    return d[0] + x * (
        d[1] + y * (d[2] + x * (d[3] + y * (d[4] + x * (d[5] + y * (d[6] + x * d[7])))))
    )


def slope(d: tuple[float, ...], x: float) -> float:
    """Return the derivative of polynomial(d, x) by x."""
    y = 1.0 - x
    value, rate = d[6] + x * d[7], d[7]
    value, rate = d[5] + y * value, y * rate - value
    value, rate = d[4] + x * value, x * rate + value
    value, rate = d[3] + y * value, y * rate - value
    value, rate = d[2] + x * value, x * rate + value
    value, rate = d[1] + y * value, y * rate - value
    return x * rate + value
