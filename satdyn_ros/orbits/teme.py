"""The frame of SGP4, true equator and mean equinox of date, and the leap seconds."""

import numpy as np
from numpy.typing import ArrayLike

from ..base.extras import brought_by
from ..base.nanoseconds import SECOND_NS
from .pieces import Pieces, Stretch, fitted

_DAY_S = 86_400
_DAY_NS = _DAY_S * SECOND_NS
# The Julian date of 1 January 1970, 00:00.
_UNIX_EPOCH_JD = 2_440_587.5
_TT_FROM_TAI_NS = 32_184_000_000


def tai_from_utc_ns(unix_ns: ArrayLike) -> np.ndarray:
    """Return TAI - UTC at stamps (...) [ns], from pyerfa's table of leap seconds."""
    with brought_by('environment', 'pyerfa'):
        import erfa
    table = erfa.leap_seconds.get()
    months = 12 * (table['year'] - 1970) + table['month'] - 1
    begins_ns = months.astype('datetime64[M]').astype('datetime64[ns]').astype(np.int64)
    entry = np.searchsorted(begins_ns, unix_ns, side='right') - 1
    return np.rint(table['tai_utc'][np.maximum(entry, 0)] * SECOND_NS).astype(np.int64)


def utc_from_tai_ns(tai_ns: np.ndarray) -> np.ndarray:
    """Return the stamps (N,) of instants in TAI, counted as UTC is from 1970 on [ns]."""
    return tai_ns - tai_from_utc_ns(tai_ns - tai_from_utc_ns(tai_ns))


def utc_from_tt_ns(tt_ns: np.ndarray) -> np.ndarray:
    """Return the stamps (N,) of instants in TT, counted as UTC is from 1970 on [ns]."""
    return utc_from_tai_ns(tt_ns - _TT_FROM_TAI_NS)


def teme_to_gcrs(unix_ns: ArrayLike) -> np.ndarray:
    """
    Return the matrices (..., 3, 3) that turn components in TEME of date into those in GCRS.

    TEME is taken into ITRS by the sidereal time of 1982, and from there to GCRS by the transpose
    of R3(ERA) N of IAU 2006/2000A, UT1 taken as UTC and without polar motion: places on the Earth
    are where SGP4 means them to be.
    """
    with brought_by('environment', 'pyerfa'):
        import erfa
    unix_ns = np.asarray(unix_ns, np.int64)
    ut1 = _julian_date(unix_ns)
    ahead = erfa.era00(*ut1) - erfa.gmst82(*ut1)
    tt = _julian_date(unix_ns + tai_from_utc_ns(unix_ns) + _TT_FROM_TAI_NS)
    return erfa.tr(erfa.rz(ahead, erfa.c2i06a(*tt)))


def _julian_date(ns):
    days, rest_ns = np.divmod(ns, _DAY_NS)
    return _UNIX_EPOCH_JD + days, rest_ns / _DAY_NS


def tabled_teme_to_gcrs(unix_s: np.ndarray) -> np.ndarray:
    """Return the same at Unix times (N,), (N, 3, 3), from a table: in a day it changes little."""
    return _TURNS.values(unix_s, np.arange(9)).reshape(-1, 3, 3)


def _turns(unix_s):
    return teme_to_gcrs(np.rint(unix_s * SECOND_NS).astype(np.int64)).reshape(-1, 9)


# A leap second is at the end of a day, as a piece is.
_TURNS = Pieces(fitted(_turns, terms=8), [Stretch(0.0, float(_DAY_S))])
