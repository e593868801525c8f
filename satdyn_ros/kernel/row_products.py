"""
The products of many rows of quaternions and vectors, compiled.

They are the functions of components of rows.py, each operation of which is rounded as in NumPy: a
row has the same bits here and there.
"""

from collections.abc import Callable
from functools import partial

import numpy as np

from .compile import compiled, inlined
from .rows import MANY_ROWS, product_of_components, rotated_components, shape_of, table_of
from .vector import quaternion, vector

_product = inlined(product_of_components, fused=False)
_rotated = inlined(rotated_components, fused=False)
_SIGNATURE = f'void(float64[:, :, ::1], {MANY_ROWS}, {MANY_ROWS})'


def products(q: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Return rotation.multiply(q, p)."""
    return _fill(_write_products, 4, q, p)


def rotated(q_ab: np.ndarray, v_b: np.ndarray) -> np.ndarray:
    """Return rotation.rotate(q_ab, v_b)."""
    return _fill(_write_rotated, 3, q_ab, v_b)


def _fill(write: Callable[..., None], width, a, b):
    rows = np.broadcast_shapes(a.shape[:-1], b.shape[:-1])
    # In memory, all of a component lie side by side, as from from_components.
    found = np.empty((width, *rows))
    table = shape_of(rows)
    write(found.reshape(width, *table), table_of(a, rows), table_of(b, rows))
    return found.transpose(*range(1, found.ndim), 0)


@partial(compiled, signature=_SIGNATURE, fused=False)
def _write_products(found, q, p):
    for m in range(found.shape[1]):
        for n in range(found.shape[2]):
            product = _product(quaternion(q[m, n]), quaternion(p[m, n]))
            for i in range(4):
                found[i, m, n] = product[i]


@partial(compiled, signature=_SIGNATURE, fused=False)
def _write_rotated(found, q, v):
    for m in range(found.shape[1]):
        for n in range(found.shape[2]):
            rotated = _rotated(quaternion(q[m, n]), vector(v[m, n]))
            for i in range(3):
                found[i, m, n] = rotated[i]
