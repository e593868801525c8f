"""The Earth's frames and times: GCRS, ITRS and TEME, UTC and TT; positions on the ellipsoid."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..base.imports import brought_by
from ..base.nanoseconds import DAY_NS, SECOND_NS
from ..kernel.rows import components, times

# Of WGS 84.
EARTH_RATE_RAD_S = 7.292115e-5

# The Julian date of 1 January 1970, 00:00.
_UNIX_EPOCH_JD = 2_440_587.5
_TT_FROM_TAI_NS = 32_184_000_000
_WGS_84 = 1


def terrestrial_time(unix_ns: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """
    Return TT as a Julian date in two parts, days (...) and the fraction of a day (...).

    TT = UTC + leap seconds + 32.184 s, with the leap seconds of pyerfa's table: those announced
    after its release are missing.  Before 1972, when UTC drifted, it is off by up to 6 s.

    Parameters
    ----------
    unix_ns : (...), ns
        Unix time
    """
    return _julian_date(terrestrial_time_ns(unix_ns))


def terrestrial_time_ns(unix_ns: ArrayLike) -> np.ndarray:
    """Return TT at stamps (...), counted as UTC is from 1970 on [ns]; see terrestrial_time."""
    unix_ns = np.asarray(unix_ns, np.int64)
    return unix_ns + tai_from_utc_ns(unix_ns) + _TT_FROM_TAI_NS


def tai_from_utc_ns(unix_ns: ArrayLike) -> np.ndarray:
    """Return TAI - UTC at stamps (...) [ns], from pyerfa's table of leap seconds."""
    begins_ns, ahead_ns = _leap_seconds()
    return ahead_ns[np.maximum(np.searchsorted(begins_ns, unix_ns, side='right') - 1, 0)]


def leap_seconds_ns() -> np.ndarray:
    """Return the stamps (N,) at which a leap second has just gone by [ns], from 1970 on."""
    begins_ns, _ = _leap_seconds()
    return begins_ns[begins_ns > 0]


def leap_seconds_between(begin_ns: int, end_ns: int) -> dict[int, int]:
    """
    Return where TAI - UTC changes, by stamp, ascending, and by what [ns].

    Leap seconds end June or December: within half a year no table is needed.

    Parameters
    ----------
    begin_ns, end_ns : ns
        the stamp after which, and that up to which
    """
    halves = [
        np.datetime64(ns, 'ns').astype('datetime64[M]').astype(int) // 6
        for ns in (begin_ns, end_ns)
    ]
    if halves[0] == halves[1]:
        return {}
    begins_ns, ahead_ns = _leap_seconds()
    inside = (begins_ns > begin_ns) & (begins_ns <= end_ns)
    steps_ns = np.diff(ahead_ns, prepend=0)
    return dict(zip(begins_ns[inside].tolist(), steps_ns[inside].tolist(), strict=True))


def elapsed_ns(begin_ns: int, stamps_ns: np.ndarray) -> np.ndarray:
    """
    Return how much later than a stamp others are [ns], (N,), leap seconds among it.

    Parameters
    ----------
    begin_ns : ns
        the stamp
    stamps_ns : (N,), ns
        those that follow on it, at least one
    """
    found = stamps_ns - begin_ns
    for at_ns, step_ns in leap_seconds_between(begin_ns, int(np.max(stamps_ns))).items():
        found = found + step_ns * (stamps_ns >= at_ns)
    return found


def _leap_seconds():
    """Return the stamps [ns] from which on TAI - UTC is what [ns], both (N,)."""
    with brought_by('environment', 'pyerfa'):
        import erfa
    table = erfa.leap_seconds.get()
    months = 12 * (table['year'] - 1970) + table['month'] - 1
    begins_ns = months.astype('datetime64[M]').astype('datetime64[ns]').astype(np.int64)
    return begins_ns, np.rint(table['tai_utc'] * SECOND_NS).astype(np.int64)


def utc_from_tai_ns(tai_ns: np.ndarray) -> np.ndarray:
    """Return the stamps (N,) of instants in TAI, counted as UTC is from 1970 on [ns]."""
    return tai_ns - tai_from_utc_ns(tai_ns - tai_from_utc_ns(tai_ns))


def utc_from_tt_ns(tt_ns: np.ndarray) -> np.ndarray:
    """Return the stamps (N,) of instants in TT, counted as UTC is from 1970 on [ns]."""
    return utc_from_tai_ns(tt_ns - _TT_FROM_TAI_NS)


# Of each time system in which messages count: stamps (N,) [ns] of what they count.
TO_UTC: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    'UTC': lambda stamps_ns: stamps_ns,
    'TT': utc_from_tt_ns,
    'TAI': utc_from_tai_ns,
}


def gcrs_to_intermediate(unix_ns: ArrayLike) -> np.ndarray:
    """
    Return the matrices (..., 3, 3) of frame bias, precession and nutation of IAU 2006/2000A.

    They turn components in GCRS into those in axes of the pole and the celestial intermediate
    origin of date.

    Parameters
    ----------
    unix_ns : (...), ns
        Unix time
    """
    with brought_by('environment', 'pyerfa'):
        import erfa
    return erfa.c2i06a(*terrestrial_time(unix_ns))


def gcrs_to_itrs(
    unix_ns: ArrayLike, to_intermediate: Callable[[Any], np.ndarray] = gcrs_to_intermediate
) -> np.ndarray:
    """
    Return the matrices (..., 3, 3) that turn components in GCRS into those in ITRS.

    R3(ERA) N, where ERA is the Earth rotation angle at UT1, taken as UTC.  Polar motion is left
    out, so that the third row is the pole, in GCRS.

    Parameters
    ----------
    unix_ns : (...), ns
        Unix time
    to_intermediate : function of unix_ns
        returns N, (..., 3, 3)
    """
    with brought_by('environment', 'pyerfa'):
        import erfa
    return erfa.rz(erfa.era00(*_ut1(unix_ns)), to_intermediate(unix_ns))


def teme_to_gcrs(unix_ns: ArrayLike) -> np.ndarray:
    """
    Return the matrices (..., 3, 3) that turn components in TEME of date into those in GCRS.

    The sidereal time of 1982 turns TEME, the frame of SGP4, into ITRS, and gcrs_to_itrs turns
    that: positions on the Earth are where SGP4 means them to be.

    Parameters
    ----------
    unix_ns : (...), ns
        Unix time
    """
    with brought_by('environment', 'pyerfa'):
        import erfa
    ut1 = _ut1(unix_ns)
    ahead = erfa.era00(*ut1) - erfa.gmst82(*ut1)
    return erfa.tr(erfa.rz(ahead, gcrs_to_intermediate(unix_ns)))


def geodetic(r_t: ArrayLike) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """
    Return latitude [rad], longitude [rad] and height [m] on WGS 84, (...) each.

    Parameters
    ----------
    r_t : (..., 3), m, ITRS
        positions
    """
    with brought_by('environment', 'pyerfa'):
        import erfa
    # Of positions beyond 1e30 m it has none: nan.
    with np.errstate(all='ignore'):
        longitude, latitude, height_m = erfa.gc2gd(_WGS_84, np.asarray(r_t, float))
    return latitude, longitude, height_m


def on_the_ground(latitude_rad: ArrayLike, longitude_rad: ArrayLike) -> np.ndarray:
    """
    Return positions (..., 3) [m] in ITRS at height 0 on WGS 84.

    Parameters
    ----------
    latitude_rad : (...), rad
        north positive
    longitude_rad : (...), rad
        east positive
    """
    with brought_by('environment', 'pyerfa'):
        import erfa
    return erfa.gd2gc(_WGS_84, longitude_rad, latitude_rad, 0.0)


def turned(matrix: np.ndarray, v: ArrayLike) -> np.ndarray:
    """
    Return matrix v, (..., 3); matrix.swapaxes(-1, -2) turns it back.

    Parameters
    ----------
    matrix : (..., 3, 3)
        rotations
    v : (..., 3)
        vectors
    """
    return np.stack(times(matrix, components(v)), axis=-1)


def _ut1(unix_ns):
    return _julian_date(np.asarray(unix_ns, np.int64))


def _julian_date(ns):
    days, rest_ns = np.divmod(ns, DAY_NS)
    return _UNIX_EPOCH_JD + days, rest_ns / DAY_NS
