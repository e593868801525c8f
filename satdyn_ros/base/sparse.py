"""Messages of a topic at some of several ticks, such as those of a sensor with its own rate."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

_Name = TypeVar('_Name')


@dataclass(frozen=True, eq=False)
class SparseMessages:
    """
    M messages of one topic at N consecutive ticks.

    A slice is by ticks, as in a table with one row per tick.

    Attributes
    ----------
    indices : (M,) int64
        their ticks, ascending, 0 to N - 1
    rows : (M,)
        each the bytes of one

    Examples
    --------
    >>> some = SparseMessages(np.array([1, 5]), np.array([b'a', b'b'], 'V1'))
    >>> some[3:].indices
    array([2])
    """

    indices: np.ndarray
    rows: np.ndarray

    def __getitem__(self, ticks: slice) -> 'SparseMessages':
        begin = ticks.start or 0
        first = np.searchsorted(self.indices, begin)
        last = None if ticks.stop is None else np.searchsorted(self.indices, ticks.stop)
        return SparseMessages(self.indices[first:last] - begin, self.rows[first:last])


Rows = np.ndarray | SparseMessages


def dense_and_sparse(
    rows: Mapping[_Name, Rows],
) -> tuple[dict[_Name, np.ndarray], dict[_Name, SparseMessages]]:
    """Return the tables with one row per tick, and the SparseMessages."""
    full = {name: table for name, table in rows.items() if not isinstance(table, SparseMessages)}
    some = {name: table for name, table in rows.items() if isinstance(table, SparseMessages)}
    return full, some
