"""
The coefficients of Dormand and Prince's method of order 8(5,3) with dense output of order 7.

Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, 1993, II.5 and II.6, and
their program DOP853; the numbers are SciPy's.
"""

import runpy
from pathlib import Path

import numpy as np
import scipy

# The file alone: its package takes longer to import than all else that a command needs.
_FILE = Path(scipy.__file__).parent / 'integrate' / '_ivp' / 'dop853_coefficients.py'
_SCIPY = runpy.run_path(str(_FILE))

# c_i: where in the step the stages are.
NODES: np.ndarray = _SCIPY['C']


def _packed(rows):
    """Return how many non-zero entries rows have (R,), their columns (R, 12) and them (R, 12)."""
    lengths = np.array([np.count_nonzero(row) for row in rows])
    columns, entries = np.zeros((len(rows), 12), int), np.zeros((len(rows), 12))
    for i, row in enumerate(rows):
        indices = np.flatnonzero(row)
        columns[i, : len(indices)] = indices
        entries[i, : len(indices)] = row[indices]
    return lengths, columns, entries


# a_ij: row i combines the stages j < i into the argument of stage i; row 12 gives the end of the
# step.  Below them the stages' weights in the error estimates of orders 3 and 5, and in the four
# highest terms of the dense output.
LENGTHS, COLUMNS, ENTRIES = _packed(
    [*_SCIPY['A'], _SCIPY['E3'], _SCIPY['E5'], *_SCIPY['D']],
)
ERROR_3, ERROR_5, DENSE = 16, 17, 18
