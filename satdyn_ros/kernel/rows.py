"""
Vectors and quaternions as rows of arrays, (..., 3) and (..., 4), and by their components.

The sums are written out: a row has the same bits alone and among thousands, which a matrix
product of the linear algebra libraries does not promise.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

# The type of what table_of returns, with any strides, in the signatures of compiled functions.
MANY_ROWS = 'Array(float64, 3, "A", readonly=True)'


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return a . b, (...)."""
    return a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1] + a[..., 2] * b[..., 2]


def length(a: np.ndarray) -> np.ndarray:
    """Return |a|, (...)."""
    return np.sqrt(dot(a, a))


def times(M: np.ndarray, v: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Return the components of M v for a matrix M (..., 3, 3) and the components v."""
    x, y, z = v
    return [M[..., i, 0] * x + M[..., i, 1] * y + M[..., i, 2] * z for i in range(3)]


def table_of(a: np.ndarray, rows: tuple[int, ...]) -> np.ndarray:
    """Return a (..., k), broadcast to rows (..., N), as a table (M, N, k)."""
    many = int(np.prod(rows[:-1]))
    return np.broadcast_to(a, (*rows, a.shape[-1])).reshape(many, rows[-1], a.shape[-1])


def components(v: ArrayLike) -> list[np.ndarray]:
    """Return the components of vectors or quaternions (..., k), an array (...) each."""
    v = np.asarray(v, float)
    return [v[..., i] for i in range(v.shape[-1])]


def from_components(parts: ArrayLike) -> np.ndarray:
    """
    Return vectors or quaternions (..., k) from k components (...).

    In memory, all of a component lie side by side: what follows works component by component.
    """
    table = np.array(parts)
    # For one vector np.moveaxis costs more than all the arithmetic.
    return table.transpose(*range(1, table.ndim), 0)
