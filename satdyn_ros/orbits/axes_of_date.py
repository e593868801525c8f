"""What turns slowly, the axes of date and those of SGP4, as tables by days."""

import numpy as np

from ..base.nanoseconds import SECOND_NS
from ..environment.earth import gcrs_to_intermediate, teme_to_gcrs
from .pieces import Pieces, Stretch, fitted

_DAY_S = 86_400


def tabled_teme_to_gcrs(unix_s: np.ndarray) -> np.ndarray:
    """Return teme_to_gcrs at Unix times (N,) [s], (N, 3, 3)."""
    return _FROM_TEME.values(unix_s, np.arange(9)).reshape(-1, 3, 3)


def tabled_gcrs_to_intermediate(unix_ns: np.ndarray) -> np.ndarray:
    """Return gcrs_to_intermediate at Unix times (N,) [ns], (N, 3, 3)."""
    return _TO_INTERMEDIATE.values(unix_ns / SECOND_NS, np.arange(9)).reshape(-1, 3, 3)


def _by_days(turns):
    """Return the table of matrices turns(unix_ns) -> (N, 3, 3)."""

    def values(unix_s):
        return turns(np.rint(unix_s * SECOND_NS).astype(np.int64)).reshape(-1, 9)

    # A leap second is at the end of a day, as a piece is.
    return Pieces(fitted(values, terms=8), [Stretch(0.0, float(_DAY_S))])


_FROM_TEME, _TO_INTERMEDIATE = _by_days(teme_to_gcrs), _by_days(gcrs_to_intermediate)
