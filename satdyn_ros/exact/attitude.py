"""
From the numbers of a closed form to the attitude of the body, row by row in compiled code.

alpha = w + i z and beta = x + i y (N,) are the quaternion of the frame k whose third axis the
flow moves (flow.py).  Products are rounded before they are added, as in dynamics/rotation.py.
"""

from functools import partial

import numpy as np

from ..compiled import compiled, inlined


@partial(compiled, fused=False)
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


@partial(compiled, fused=False)
def turned(q_ib: np.ndarray, q_bt: np.ndarray) -> np.ndarray:
    """Return q_ib q_bt (N, 4), for one q_ib (4,) and turns q_bt (N, 4)."""
    q_it = np.empty_like(q_bt)
    for i in range(len(q_bt)):
        q_it[i, 0], q_it[i, 1], q_it[i, 2], q_it[i, 3] = _product(q_ib, q_bt[i])
    return q_it


@partial(compiled, fused=False)
def rotated(q_bk: np.ndarray, v_k: np.ndarray) -> np.ndarray:
    """Return v_b = q_bk v_k q_bk* (N, 3), for one q_bk (4,)."""
    x, y, z, w = q_bk
    v_b = np.empty_like(v_k)
    for i in range(len(v_k)):
        a, b, c = v_k[i]
        twice = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
        v_b[i, 0] = a + w * twice[0] + (y * twice[2] - z * twice[1])
        v_b[i, 1] = b + w * twice[1] + (z * twice[0] - x * twice[2])
        v_b[i, 2] = c + w * twice[2] + (x * twice[1] - y * twice[0])
    return v_b


@partial(inlined, fused=False)
def _product(q, p):
    """Return the Hamilton product q p (x, y, z, w)."""
    x1, y1, z1, w1 = q
    x2, y2, z2, w2 = p
    return (
        w1 * x2 + x1 * w2 + y1 * z2 - z1 * y2,
        w1 * y2 - x1 * z2 + y1 * w2 + z1 * x2,
        w1 * z2 + x1 * y2 - y1 * x2 + z1 * w2,
        w1 * w2 - x1 * x2 - y1 * y2 - z1 * z2,
    )
