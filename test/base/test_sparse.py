import numpy as np

from satdyn_ros.base.sparse import SparseMessages


def test_a_slice_is_that_of_the_ticks():
    """As of a table with one row per tick, for every begin and end."""
    indices = np.array([0, 3, 4, 9])
    some = SparseMessages(indices, indices.astype('i4'))
    for begin in (None, 0, 1, 3, 9, 10):
        for end in (None, 3, 4, 5, 10):
            present = [i for i in indices if (begin or 0) <= i < (10 if end is None else end)]
            part = some[begin:end]
            assert part.rows.tolist() == present
            assert part.indices.tolist() == [i - (begin or 0) for i in present]
