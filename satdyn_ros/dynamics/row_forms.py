"""The forms of torque.py for many rows, compiled as in row_products.py."""

from functools import partial

import numpy as np

from ..kernel.compile import compiled, inlined
from ..kernel.rows import MANY_ROWS, shape_of, table_of
from ..kernel.vector import vector
from .torque import forms_of_components

_forms = inlined(forms_of_components, fused=False)
_SIGNATURE = f'void(float64[:, :, ::1], {MANY_ROWS}, {MANY_ROWS}, {MANY_ROWS}, {MANY_ROWS})'


def forms(omega: np.ndarray, c: np.ndarray, K: np.ndarray, I: np.ndarray) -> np.ndarray:
    """Return forms_of_components (7, ...); omega, c (..., 3), K, I (3, 3) or (M, 1, 3, 3)."""
    rows = omega.shape[:-1]
    found = np.empty((7, *rows))
    matrices = (np.broadcast_to(M, (*rows[:-1], 1, 3, 3)).reshape(-1, 3, 3) for M in (K, I))
    _write_forms(
        found.reshape(7, *shape_of(rows)), table_of(omega, rows), table_of(c, rows), *matrices
    )
    return found


@inlined
def _matrix(M):
    return vector(M[0]), vector(M[1]), vector(M[2])


@partial(compiled, signature=_SIGNATURE, fused=False)
def _write_forms(found, omega, c, K, I):
    for m in range(found.shape[1]):
        K_m, I_m = _matrix(K[m]), _matrix(I[m])
        for n in range(found.shape[2]):
            forms = _forms(vector(omega[m, n]), vector(c[m, n]), K_m, I_m)
            for i in range(7):
                found[i, m, n] = forms[i]
