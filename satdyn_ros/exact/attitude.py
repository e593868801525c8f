"""
From the numbers of a closed form to the attitude of the body, row by row in compiled code.

alpha = w + i z and beta = x + i y (N,) are the quaternion of the frame k whose third axis the
flow moves (flow.py).
"""

import numpy as np

from ..kernel.compile import compiled, inlined
from ..kernel.vector import product, rotate

_product, _rotated = inlined(product), inlined(rotate)


@compiled
def in_body(
    alpha: np.ndarray, beta: np.ndarray, q_kb: np.ndarray, q_il: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """
    Return the attitude (N, 4) and the third axis of frame l in frame k (N, 3).

    q_il q_lk q_kb with q_lk the numbers, q_kb and q_il (4,); without q_il it is q_lk q_kb.
    """
    n = len(alpha)
    q_ib, axis_k = np.empty((n, 4)), np.empty((n, 3))
    for i in range(n):
        q = x, y, z, w = beta[i].real, beta[i].imag, alpha[i].imag, alpha[i].real
        axis_k[i, 0] = 2.0 * (x * z - w * y)
        axis_k[i, 1] = 2.0 * (y * z + w * x)
        axis_k[i, 2] = 1.0 - 2.0 * (x * x + y * y)
        if q_il is not None:
            q = _product(q_il, q)
        q_ib[i, 0], q_ib[i, 1], q_ib[i, 2], q_ib[i, 3] = _product(q, q_kb)
    return q_ib, axis_k


@compiled
def turned(q_ib: np.ndarray, q_bt: np.ndarray) -> np.ndarray:
    """Return q_ib q_bt (N, 4), for one q_ib (4,) and turns q_bt (N, 4)."""
    q_it = np.empty_like(q_bt)
    for i in range(len(q_bt)):
        q_it[i, 0], q_it[i, 1], q_it[i, 2], q_it[i, 3] = _product(q_ib, q_bt[i])
    return q_it


@compiled
def rotated(q_bk: np.ndarray, v_k: np.ndarray) -> np.ndarray:
    """Return v_b = q_bk v_k q_bk* (N, 3), for one q_bk (4,)."""
    v_b = np.empty_like(v_k)
    for i in range(len(v_k)):
        v_b[i, 0], v_b[i, 1], v_b[i, 2] = _rotated(q_bk, v_k[i])
    return v_b
