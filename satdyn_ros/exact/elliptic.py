"""
Jacobi's elliptic functions and Legendre's integrals, accurate up to the separatrix.

Everything takes the complementary parameter m1 = 1 - m, 0 <= m1 <= 1, which callers know without
cancellation: near m = 1 the digits of a motion are those of m1.  u and m1 broadcast.
"""

import numpy as np
from scipy.special import elliprf, elliprj

# What counts as rounding of a motion's own numbers: it cannot be distinguished from zero.
LAST_DIGITS = 4.0 * np.finfo(float).eps


def K(m1: float | np.ndarray) -> np.ndarray:
    """
    Return the quarter period K, inf for m1 = 0 (DLMF 19.25.1).

    >>> K(1.0)
    np.float64(1.5707963267948966)
    """
    return elliprf(0.0, m1, 1.0)


def fold(u: float | np.ndarray, m1: float | np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return ur in [-K, K] and the number j of half turns of am, with u = ur + 2 K j."""
    two_K = 2.0 * K(m1)
    j = np.rint(u / two_K)
    return u - _times(j, two_K), j


def _times(j, period):
    """Return j periods, none where j is 0 even if the period is infinite."""
    return j * np.where(j == 0.0, 0.0, period)


def sncndn(
    u: float | np.ndarray, m1: float | np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """
    Return sn, cn and dn of u.

    >>> sn, cn, dn = sncndn(0.5, 0.0)   # tanh 0.5, sech 0.5 twice
    """
    ur, j = fold(u, m1)
    tan_am, dn = _tan_am_dn(ur, m1)
    sign = 1.0 - 2.0 * np.mod(j, 2.0)
    cn = sign / np.hypot(1.0, tan_am)
    return tan_am * cn, cn, dn


def amplitude(u: float | np.ndarray, m1: float | np.ndarray) -> np.ndarray:
    """Return am u [rad], continuous over all periods."""
    ur, j = fold(u, m1)
    return np.arctan(_tan_am_dn(ur, m1)[0]) + j * np.pi


def _tan_am_dn(u, m1):
    """Return tan am u = sn / cn and dn for |u| <= K by Gauss's transformation (DLMF 22.20)."""
    u, m1 = np.asarray(u, float), np.asarray(m1, float)
    hyperbolic = m1 == 0.0
    a, g = np.ones_like(m1), np.sqrt(np.where(hyperbolic, 1.0, m1))
    levels = [(a, g)]
    while np.any(np.abs(a - g) > 1e-8 * a):
        a, g = (a + g) / 2.0, np.sqrt(a * g)
        levels.append((a, g))
    a_above = (a + g) / 2.0
    # K may round to just beyond pi/2, where the tangent would change its sign
    tan_am = np.tan(np.clip(a_above * u, -np.pi / 2, np.pi / 2)) / a_above
    dn: float | np.ndarray = 1.0
    for a, g in reversed(levels):
        square = a_above * tan_am * tan_am
        tan_am, dn = tan_am / dn, (1.0 + g * square) / (1.0 + a * square)
        a_above = a
    if np.any(hyperbolic):
        tan_gd = np.sinh(np.clip(u, -700.0, 700.0))
        tan_am = np.where(hyperbolic, tan_gd, tan_am)
        dn = np.where(hyperbolic, 1.0 / np.hypot(1.0, tan_gd), dn)
    return tan_am, dn


def F(phi: float | np.ndarray, m1: float | np.ndarray) -> np.ndarray:
    """Return Legendre's first integral, the u with am u = phi [rad], any phi."""
    j = np.rint(np.asarray(phi, float) / np.pi)
    f = phi - j * np.pi
    s, c = np.sin(f), np.cos(f)
    return F_sncndn(s, c, np.hypot(c, np.sqrt(m1) * s)) + _times(j, 2.0 * K(m1))


def F_sncndn(sn: float | np.ndarray, cn: float | np.ndarray, dn: float | np.ndarray) -> np.ndarray:
    """Return the u in [-K, K] with these sn, cn >= 0 and dn (DLMF 19.25.31)."""
    return sn * elliprf(np.square(cn), np.square(dn), 1.0)


def L(u: float | np.ndarray, nn: float | np.ndarray, m1: float | np.ndarray) -> np.ndarray:
    """
    Return the integral of sn^2 / (1 - nn sn^2) from 0 to u, nn < 1.

    Legendre's third integral is u + nn L, without cancellation at nn = 0 (DLMF 19.25.14).
    """
    ur, j = fold(u, m1)
    # beyond 40 the hyperbolic sn is 1 to the last bit
    core = np.where(np.equal(m1, 0.0), np.clip(ur, -40.0, 40.0), ur)
    sn, cn, dn = sncndn(core, m1)
    n1 = 1.0 - nn
    first = sn**3 / 3.0 * elliprj(cn * cn, dn * dn, 1.0, cn * cn + n1 * sn * sn)
    complete = elliprj(0.0, m1, 1.0, n1) / 3.0
    return first + (ur - core) / n1 + _times(j, 2.0 * complete)
