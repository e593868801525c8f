"""Vectors as tuples of three numbers, in compiled code: they live in registers."""

from typing import Any

import numpy as np

from .compile import inlined
from .unroll import by_type, unrolled_map


@inlined
def vector(row: np.ndarray) -> tuple[float, float, float]:
    """Return the components of a row (3,), or the first three of a longer one."""
    return row[0], row[1], row[2]


@inlined
def quaternion(row: np.ndarray) -> tuple[float, float, float, float]:
    """Return the components of a row (4,)."""
    return row[0], row[1], row[2], row[3]


@inlined
def add(a: tuple[float, ...], b: tuple[float, ...]) -> tuple[float, float, float]:
    """Return a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@inlined
def subtract(a: tuple[float, ...], b: tuple[float, ...]) -> tuple[float, float, float]:
    """Return a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@inlined
def scale(s: float, a: tuple[float, ...]) -> tuple[float, float, float]:
    """Return s a."""
    return s * a[0], s * a[1], s * a[2]


@inlined
def dot(a: tuple[float, ...], b: tuple[float, ...]) -> float:
    """Return a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inlined
def cross(a: tuple[float, ...], b: tuple[float, ...]) -> tuple[float, float, float]:
    """Return a x b."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


@inlined
def add_cross(
    a: tuple[float, ...], b: tuple[float, ...], c: tuple[float, ...]
) -> tuple[float, float, float]:
    """Return a + b x c."""
    return (
        a[0] + b[1] * c[2] - b[2] * c[1],
        a[1] + b[2] * c[0] - b[0] * c[2],
        a[2] + b[0] * c[1] - b[1] * c[0],
    )


@unrolled_map
def apply(i: int, M: tuple[Any, ...], a: tuple[float, ...]) -> tuple[float, float, float]:
    """Return M a for a matrix of three row tuples, or of the three numbers of its diagonal."""
    return _row_times(M[i], a, i)


_row_times = by_type(
    lambda row, a, i: row[0] * a[0] + row[1] * a[1] + row[2] * a[2],
    lambda entry, a, i: entry * a[i],
)


@inlined
def attitude_rate(
    q: tuple[float, ...], omega_b: tuple[float, ...], omega_a: tuple[float, ...]
) -> tuple[float, float, float, float]:
    """
    Return q' = q (omega_b, 0) / 2 - (omega_a, 0) q / 2, of q from b to a.

    omega_b: the rate of b in its own axes, omega_a: that of a in its own.
    """
    u, w = q[0:3], q[3]
    b, a = scale(0.5, omega_b), scale(0.5, omega_a)
    x, y, z = add_cross(scale(w, subtract(b, a)), u, add(b, a))
    return x, y, z, dot(u, subtract(a, b))


@inlined
def to_body(q_ib: tuple[float, ...], v_i: tuple[float, ...]) -> tuple[float, float, float]:
    """Return q_ib* v_i q_ib."""
    u, w = (-q_ib[0], -q_ib[1], -q_ib[2]), q_ib[3]
    twice = scale(2.0, cross(u, v_i))
    return add(add(v_i, scale(w, twice)), cross(u, twice))
