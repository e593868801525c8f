"""
The Earth's magnetic field: the IGRF, and the dipole that is its first degree.

The coefficients are those of the file in ppigrf, which IAGA's working group on the model keeps up
to date.  The library itself is not imported: it imports pandas, and takes 7 ms for few positions.
"""

from functools import cache
from importlib.metadata import distribution
from math import factorial, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..base.imports import brought_by
from ..base.nanoseconds import epoch
from ..kernel.rows import components, dot, length

IGRF_RADIUS_M = 6_371_200.0

# How far outside its interval the model is still used, with a warning.
_MORE_YEARS = 5


class GaussCoefficients(NamedTuple):
    """
    The coefficients of a model at the beginning of some years; in between they are linear.

    Attributes
    ----------
    years : (T,)
        the years
    g, h : (n_max + 1, n_max + 1, T), T
        of degree and order, in Schmidt's seminormalisation
    """

    years: np.ndarray
    g: np.ndarray
    h: np.ndarray

    def outside(self, unix_ns: np.ndarray, more_years: int = 0) -> str | None:
        """Return the sentence about a time outside the years and some more; None: all are in."""
        first, last = self.years[[0, -1]]
        begin_ns, end_ns = _new_year_ns(np.array([first - more_years, last + more_years]))
        beyond = unix_ns[(unix_ns < begin_ns) | (unix_ns > end_ns)]
        if not beyond.size:
            return None
        return f'{epoch(beyond[0])[:10]} is outside the IGRF, which is from {first} to {last}'

    def interval_of(self, unix_ns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the number of the interval of each time, and its share that has gone by."""
        if outside := self.outside(unix_ns, _MORE_YEARS):
            raise ValueError(f'{outside}; it is extrapolated by {_MORE_YEARS} years at most')
        begins_ns = _new_year_ns(self.years)
        interval = np.searchsorted(begins_ns, unix_ns, side='right') - 1
        interval = np.clip(interval, 0, len(begins_ns) - 2)
        begin_ns, end_ns = begins_ns[interval], begins_ns[interval + 1]
        return interval, (unix_ns - begin_ns) / (end_ns - begin_ns)


def igrf_field(unix_ns: ArrayLike, r_t: ArrayLike) -> np.ndarray:
    """
    Return the field of the IGRF (..., 3) [T], in ITRS.

    The potential is a sum of g V + h W, where V + iW = (a/r)^(n+1) P_nm(sin latitude) e^(i m
    longitude).  These functions follow from those of the two degrees before by recursions in
    Cartesian components, which are singular nowhere, and their derivatives are functions of the
    next degree (Montenbruck and Gill, Satellite Orbits, section 3.2).

    Parameters
    ----------
    unix_ns : (...), ns
        Unix time
    r_t : (..., 3), m, ITRS
        positions

    Raises
    ------
    ValueError
        a time is more than five years outside the interval of the model; igrf_warning has a
        sentence for times that are closer
    """
    igrf = _igrf()
    interval, share = igrf.interval_of(np.asarray(unix_ns, np.int64))
    interval, share, x, y, z = np.broadcast_arrays(
        interval, share, *components(np.divide(r_t, IGRF_RADIUS_M))
    )
    q = 1.0 / (x * x + y * y + z * z)
    orders = np.arange(len(igrf.g) + 1.0).reshape(-1, *[1] * q.ndim)

    # V and W of one degree, by their orders, and of the degree before it.
    functions, before = np.zeros((2, 2, len(orders), *q.shape))
    functions[0, 0] = np.sqrt(q)
    B = np.zeros((3, *q.shape))
    for n, factors in enumerate(_factors(), start=1):
        m = orders[:n]
        following = np.zeros_like(functions)
        following[:, :n] = (2 * n - 1) / (n - m) * (z * q) * functions[:, :n]
        following[:, :n] -= (n + m - 1) / (n - m) * q * before[:, :n]
        V, W = (2 * n - 1) * q * functions[:, n - 1]
        following[:, n] = x * V - y * W, x * W + y * V
        functions, before = following, functions

        begin, end = factors[..., interval], factors[..., interval + 1]
        terms = (begin + share * (end - begin)) * functions[:, : n + 1]
        # One by one: the last bits of np.sum would depend on the number of positions.
        for term in np.moveaxis(terms.reshape(3, -1, *q.shape), 1, 0):
            B += term
    return np.moveaxis(B, 0, -1)


def igrf_warning(unix_ns: ArrayLike) -> str | None:
    """
    Return a sentence if any time is outside the interval of the IGRF, else None.

    Parameters
    ----------
    unix_ns : (...), ns
        Unix time
    """
    outside = _igrf().outside(np.asarray(unix_ns, np.int64))
    return outside and f'{outside}; the field is extrapolated'


def igrf_years_ns() -> np.ndarray:
    """Return the stamps (T,) of the years of the IGRF, at which its slope in time jumps [ns]."""
    return _new_year_ns(_igrf().years)


def dipole_vector(unix_ns: int) -> np.ndarray:
    """
    Return g_t = (g11, h11, g10) (3,) [T] of the IGRF at a time, for dipole_field.

    Parameters
    ----------
    unix_ns : ns
        Unix time

    Raises
    ------
    ValueError
        as for igrf_field
    """
    igrf = _igrf()
    interval, share = igrf.interval_of(np.asarray(unix_ns, np.int64))
    first = np.array([igrf.g[1, 1], igrf.h[1, 1], igrf.g[1, 0]])
    return first[:, interval] + share * (first[:, interval + 1] - first[:, interval])


def dipole_field(g_t: ArrayLike, r_t: ArrayLike) -> np.ndarray:
    """
    Return the field of a dipole (..., 3) [T].

    Parameters
    ----------
    g_t : (3,), T, ITRS
        dipole_vector
    r_t : (..., 3), m, ITRS
        positions
    """
    g_t, r_t = np.asarray(g_t, float), np.asarray(r_t, float)
    r = length(r_t)[..., None]
    up = r_t / r
    return (IGRF_RADIUS_M / r) ** 3 * (3.0 * dot(g_t, up)[..., None] * up - g_t)


@cache
def _igrf() -> GaussCoefficients:
    with brought_by('environment', 'ppigrf'):
        files = distribution('ppigrf').files or ()
    newest = max(file for file in files if file.match('IGRF*.shc'))
    lines = newest.read_text(encoding='utf-8').splitlines()
    header, years, *rows = (line.split() for line in lines if not line.startswith('#'))
    g, h = np.zeros((2, int(header[1]) + 1, int(header[1]) + 1, len(years)))
    for n, m, *values_nT in rows:
        (h if m.startswith('-') else g)[int(n), abs(int(m))] = 1e-9 * np.array(values_nT, float)
    return GaussCoefficients(np.array(years, float).astype(int), g, h)


@cache
def _factors() -> list[np.ndarray]:
    """
    Return by what V and W of each degree from 1 on are multiplied in the field.

    Of degree n an array (3, 2, n + 1, T): component of the field, V or W, order.
    """
    _, *coefficients = _igrf()
    n_max = len(coefficients[0]) - 1
    # Room for the orders from -1 to n_max + 2, all of them zero outside the model.
    g, h = np.pad(coefficients, ((0, 0), (0, 0), (1, 2), (0, 0)))
    for n, m in np.ndindex(n_max + 1, n_max + 1):
        if m <= n:
            norm = sqrt((1 + (m > 0)) * factorial(n - m) / factorial(n + m))
            g[n, m + 1] *= norm
            h[n, m + 1] *= norm
    found = []
    for n in range(n_max + 1):
        m = np.arange(n + 2)[:, None]
        g_less, h_less = (c[n, : n + 2] * (1 + (m == 1)) for c in (g, h))
        g_same, h_same = (c[n, 1 : n + 3] * (n - m + 1) for c in (g, h))
        g_more, h_more = (c[n, 2 : n + 4] * (n - m + 1) * (n - m) for c in (g, h))
        x = 0.5 * (g_less - g_more), 0.5 * (h_less - h_more)
        y = -0.5 * (h_less + h_more), 0.5 * (g_less + g_more)
        found.append(np.array([x, y, (g_same, h_same)]))
    return found


def _new_year_ns(years):
    return (years - 1970).astype('datetime64[Y]').astype('datetime64[ns]').astype(np.int64)
