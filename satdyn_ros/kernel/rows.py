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


def shape_of(rows: tuple[int, ...]) -> tuple[int, int]:
    """Return the shape (M, N) in which rows (..., N) are a table."""
    return int(np.prod(rows[:-1])), rows[-1]


def table_of(a: np.ndarray, rows: tuple[int, ...]) -> np.ndarray:
    """Return a (..., k), broadcast to rows (..., N), as a table (M, N, k)."""
    return np.broadcast_to(a, (*rows, a.shape[-1])).reshape(*shape_of(rows), a.shape[-1])


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


def product_of_components(q: Sequence, p: Sequence) -> tuple:
    """Return the components (x, y, z, w) of q p from those of q and p."""
    x1, y1, z1, w1 = q
    x2, y2, z2, w2 = p
    return (
        w1 * x2 + x1 * w2 + y1 * z2 - z1 * y2,
        w1 * y2 - x1 * z2 + y1 * w2 + z1 * x2,
        w1 * z2 + x1 * y2 - y1 * x2 + z1 * w2,
        w1 * w2 - x1 * x2 - y1 * y2 - z1 * z2,
    )


def rotated_components(q: Sequence, v: Sequence) -> tuple:
    """Return the components of q v q* from those of q and v."""
    x, y, z, w = q
    a, b, c = v
    t_x, t_y, t_z = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    return (
        a + w * t_x + (y * t_z - z * t_y),
        b + w * t_y + (z * t_x - x * t_z),
        c + w * t_z + (x * t_y - y * t_x),
    )
