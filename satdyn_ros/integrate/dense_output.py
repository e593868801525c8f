"""
The dense output of a step of dop853.py, of order 7.

Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, 1993, II.6, II.10.
"""

import math

import numpy as np

from ..dynamics.constants import Constants
from ..dynamics.equations import OMEGA
from ..kernel.compile import inlined
from ..kernel.simd import PACK, zero
from ..kernel.vector import add, add_cross, dot, scale
from .dop853 import (
    BEGIN,
    DENSE_OF,
    END,
    FROM_S,
    STEPS,
    UNTIL_S,
    Stages,
    combine,
    evaluate,
    stage_time,
)
from .tableau import DENSE

# Gauss and Legendre's rule of four nodes is exact for polynomials of degree 7, which these are.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)
_INNER, _OUTER = map(float, _NODES[2:])
_OF_INNER, _OF_OUTER = map(float, _WEIGHTS[2:])


@inlined
def make_dense(clock: np.ndarray, stages: Stages, dense: np.ndarray, constants: Constants) -> None:
    """Write the terms of the dense output of the current step, which starts at y_0 = dense[0]."""
    h, y_0, y, k, z = clock[END] - clock[BEGIN], dense[0], stages.y, stages.k, dense[7]
    size, some = len(y), zero(PACK)
    t, span = clock[BEGIN], (clock[FROM_S], clock[UNTIL_S])
    evaluate(stage_time(12, t, h, span, constants), y, h, constants, k, 12)
    for i in range(13, 16):
        combine(i, y_0, k, z, size, some)
        evaluate(stage_time(i, t, h, span, constants), z, h, constants, k, i)
    for i in range(size):
        rise = y[i] - y_0[i]
        dense[1, i] = rise
        dense[2, i] = k[i] - rise
        dense[3, i] = 2.0 * rise - (k[i] + k[12 * size + i])
    for n in range(4):
        combine(DENSE + n, stages.zeros, k, dense[4 + n], size, some)
    clock[DENSE_OF] = clock[STEPS]


@inlined
def interpolate(
    t_s: np.ndarray,
    out: np.ndarray,
    first: int,
    last: int,
    clock: np.ndarray,
    dense: np.ndarray,
    constants: Constants,
) -> None:
    """
    Evaluate the dense output at t_s[first:last], with q_ib in the place of q.

    out (V, N): the first V variables; the quaternions come out as unit.
    """
    t_s, begin, h = t_s[first:last], clock[BEGIN], clock[END] - clock[BEGIN]
    per_step = 1.0 / h if h > 0.0 else 0.0
    half_rate = 0.5 * constants.axes_rate
    cosine, sine = math.cos(half_rate * begin), math.sin(half_rate * begin)
    q_0, q_1 = out[0][first:last], out[1][first:last]
    q_2, q_3 = out[2][first:last], out[3][first:last]
    d_0, d_1, d_2, d_3 = terms(dense, 0), terms(dense, 1), terms(dense, 2), terms(dense, 3)
    for n in range(len(t_s)):
        x = (t_s[n] - begin) * per_step
        a, b = polynomial(d_0, x), polynomial(d_1, x)
        c, d = polynomial(d_2, x), polynomial(d_3, x)
        square = a * a + b * b + c * c + d * d
        # A quaternion that is unit to rounding stays as it is: a requested one is kept exactly.
        unit = 1.0 if abs(square - 1.0) < 1e-15 else 1.0 / math.sqrt(square)
        v, d = (unit * a, unit * b, unit * c), unit * d
        # q_ib = (u, w) (v, d), where (u, w) is what the axes of q have turned by.
        cos_x, sin_x = _cosine_sine(half_rate * (t_s[n] - begin))
        u = scale(sine * cos_x + cosine * sin_x, constants.normal)
        w = cosine * cos_x - sine * sin_x
        q_0[n], q_1[n], q_2[n] = add_cross(add(scale(w, v), scale(d, u)), u, v)
        q_3[n] = w * d - dot(u, v)
    for j in range(OMEGA, len(out)):
        row, d_0 = out[j][first:last], terms(dense, j)
        for n in range(len(t_s)):
            row[n] = polynomial(d_0, (t_s[n] - begin) * per_step)


@inlined
def add_turn(
    turn_b: np.ndarray, from_s: float, to_s: float, clock: np.ndarray, dense: np.ndarray
) -> None:
    """Add to turn_b (3,) the integral of omega over a part of the step, from from_s to to_s."""
    begin, h = clock[BEGIN], clock[END] - clock[BEGIN]
    per_step = 1.0 / h if h > 0.0 else 0.0
    half = 0.5 * (to_s - from_s)
    middle, reach = (from_s - begin + half) * per_step, half * per_step
    for j in range(3):
        d = terms(dense, OMEGA + j)
        inner = polynomial(d, middle - _INNER * reach) + polynomial(d, middle + _INNER * reach)
        outer = polynomial(d, middle - _OUTER * reach) + polynomial(d, middle + _OUTER * reach)
        turn_b[j] += half * (_OF_INNER * inner + _OF_OUTER * outer)


@inlined
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


@inlined
def terms(dense: np.ndarray, i: int) -> tuple[float, ...]:
    """Return the terms of a variable."""
    return (
        dense[0, i],
        dense[1, i],
        dense[2, i],
        dense[3, i],
        dense[4, i],
        dense[5, i],
        dense[6, i],
        dense[7, i],
    )


@inlined
def polynomial(d: tuple[float, ...], x: float) -> float:
    """Return the value at a share x of the step of what has the terms d."""
    y = 1.0 - x
    return d[0] + x * (
        d[1] + y * (d[2] + x * (d[3] + y * (d[4] + x * (d[5] + y * (d[6] + x * d[7])))))
    )


@inlined
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
