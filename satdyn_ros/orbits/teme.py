"""The frame of SGP4, true equator and mean equinox of date, as a table by days."""

import numpy as np

from ..base.nanoseconds import SECOND_NS
from ..environment.earth import teme_to_gcrs
from .pieces import Pieces, Stretch, fitted

_DAY_S = 86_400


def tabled_teme_to_gcrs(unix_s: np.ndarray) -> np.ndarray:
    """Return teme_to_gcrs at Unix times (N,) [s], (N, 3, 3), from a table by days."""
    return _TURNS.values(unix_s, np.arange(9)).reshape(-1, 3, 3)


def _turns(unix_s):
    return teme_to_gcrs(np.rint(unix_s * SECOND_NS).astype(np.int64)).reshape(-1, 9)


# A leap second is at the end of a day, as a piece is.
_TURNS = Pieces(fitted(_turns, terms=8), [Stretch(0.0, float(_DAY_S))])
