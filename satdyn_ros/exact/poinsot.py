"""
Euler's and Poinsot's constants of a free rigid body (textbook, sections 44 to 46).

Axes 1, 2, 3 here are the principal ones in the order of their moments, I1 <= I2 <= I3.  With o, p
the axes of I1, I3, p the one that the polhode encircles, and x = lam t + x0,

    O_o = B_o cn x,    O_2 = B_2 sn x,    O_p = B_p dn x.
"""

from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from ..dynamics.inertia import ROUNDING, principal_axes
from . import elliptic


class Poinsot:
    """
    The constants of the free motion of a rigid body.

    Parameters
    ----------
    inertia : (3, 3), kg m^2, body axes
        of the body
    omega : (3,), rad/s, body axes
        a rate that it passes through

    Attributes
    ----------
    moments : (3,), kg m^2
        I1 <= I2 <= I3
    E, L : J, N m s
        energy and angular momentum
    B : (3,), rad/s
        largest rates about axes 1, 2, 3 (46.12)
    lam : rad/s
        rate of the argument of the elliptic functions
    k2, k2_complement : float
        their squared modulus, and 1 - k2
    t0 : s
        time since O_2 was at its least, from 0 to T1 (46.16 to 46.18), 0 where O_2 is constant and
        inf on a separatrix
    about_largest : bool
        whether the polhode encircles axis 3, else axis 1; for a symmetric body it encircles the
        axis of symmetry

    Examples
    --------
    >>> round(Poinsot(np.diag([1.0, 2.0, 2.5]), [0.2, 0.3, 1.0]).T1, 12)
    10.222621676194
    """

    def __init__(self, inertia: np.ndarray, omega: Sequence[float] | np.ndarray):
        moments, R_bp = principal_axes(inertia)
        order = np.argsort(moments, kind='stable')
        I, w = moments[order], (R_bp.T @ np.asarray(omega, float))[order]
        # The axes in the order of their moments may be left-handed.
        self._rise = float(np.linalg.det(R_bp[:, order])) * w[0] * w[2]
        low, high = np.diff(I) <= ROUNDING * I[2]
        I = np.where([low, low and high, high], I[[1, 1, 1]], I)
        self.moments, self.is_symmetric = I, bool(low or high)
        self.E, self.L = float(I @ w**2) / 2.0, float(np.linalg.norm(I * w))
        # L^2 - 2 E I_j without cancellation
        self._excess = np.array([(I - moment) @ (I * w**2) for moment in I])
        self.about_largest = bool(low or (not high and self._excess[1] >= 0.0))
        self._o, self._p = (0, 2) if self.about_largest else (2, 0)
        self._solve(w)
        self.t0 = self._time_since_least(w)

    def _time_since_least(self, w):
        """Return t0 in closed form: I2 O_2' = (I3 - I1) O_3 O_1 has the sign of cn."""
        if self.lam == 0.0 or self.B[1] == 0.0:
            return 0.0
        if not np.isfinite(self.T1):
            return np.inf
        K, o, p = elliptic.K(self.k2_complement), self._o, self._p
        sn, cn = w[1] / self.B[1], abs(w[o]) / self.B[o]
        sn, cn = sn / np.hypot(sn, cn), cn / np.hypot(sn, cn)
        u = elliptic.F_sncndn(sn, cn, abs(w[p]) / self.B[p])
        return float((K + u if self._rise >= 0.0 else 3.0 * K - u) / self.lam)

    def _solve(self, w):
        o, p, I = self._o, self._p, self.moments
        self.lam, self.k2, self.k2_complement = 0.0, 0.0, 1.0
        self.B = np.abs(w)
        product = (I[p] - I[1]) * self._excess[o]
        if product == 0.0:
            return
        self.B = np.zeros(3)
        for j in (o, 1):
            if I[p] != I[j]:
                self.B[j] = np.sqrt(max(-self._excess[p] / (I[j] * (I[p] - I[j])), 0.0))
        self.B[p] = np.sqrt(self._excess[o] / (I[p] * (I[p] - I[o])))
        self.lam = float(np.sqrt(product / np.prod(I)))
        self.k2 = float((I[1] - I[o]) * -self._excess[p] / product)
        self.k2_complement = float((I[p] - I[o]) * self._excess[1] / product)

    @property
    def a1(self) -> float:
        """Return the root of V that bounds O_2 of a polhode about axis 3 [rad/s] (46.15)."""
        return self._root_of_V(2)

    @property
    def a3(self) -> float:
        """Return the root of V that bounds O_2 of a polhode about axis 1 [rad/s] (46.15)."""
        return self._root_of_V(0)

    def _root_of_V(self, j):
        gap = self.moments[1] * (self.moments[1] - self.moments[j])
        return float(np.sqrt(self._excess[j] / gap)) if gap != 0.0 else np.inf

    def V(self, x: float | np.ndarray) -> np.ndarray:
        """Return the V [rad^2/s^4] of O_2'^2 = -V(O_2) (46.10) at x [rad/s] of any shape."""
        I1, I2, I3 = self.moments
        square = I2 * np.square(x)
        first = -self._excess[2] - (I3 - I2) * square
        return -first * (self._excess[0] - (I2 - I1) * square) / (I1 * I2**2 * I3)

    @property
    def T1(self) -> float:
        """Return the period of the rates [s] (46.11); inf where it does not exist."""
        if self.lam == 0.0 or self.k2_complement <= 0.0:
            return np.inf
        return float(4.0 * elliptic.K(self.k2_complement) / self.lam)

    @property
    def polhode_radii(self) -> tuple[float, float]:
        """
        Return the least and greatest distance of the polhode from the axis it encircles.

        In the units of xi = omega / sqrt(2 E); equal for a symmetric body, whose polhode is a
        circle (45.11).
        """
        if self.lam == 0.0:
            return 0.0, 0.0
        across = sorted(self.B[[self._o, 1]] / np.sqrt(2.0 * self.E))
        return float(across[0]), float(across[1])

    @property
    def herpolhode_radii(self) -> tuple[float, float]:
        """
        Return the radii of the annulus that the herpolhode keeps to, touches and may fill (45.17).

        In the units of xi = omega / sqrt(2 E); equal for a symmetric body, whose herpolhode is a
        circle (45.11).
        """
        o, p, I, B = self._o, self._p, self.moments, self.B
        if self.lam == 0.0:
            return 0.0, 0.0
        # |omega x I omega| where O_2 = 0, and where O_o = 0
        first = abs(I[p] - I[o]) * B[o] * B[p]
        least = B[p] * np.sqrt(max(self.k2_complement, 0.0))
        second = abs(I[p] - I[1]) * B[1] * least
        radii = np.array(sorted([first, second])) / (self.L * np.sqrt(2.0 * self.E))
        return float(radii[0]), float(radii[1])

    @property
    def space_cones(self) -> tuple[float, float]:
        """
        Return the least and greatest angle [rad] of omega from the fixed momentum (45.8).

        Of a start near a permanent rotation about the largest or the smallest moment both are
        small: the rate stays near in space, as it does in the body.  Their tangents are the radii
        of the herpolhode over sqrt(2 E) / L, the distance of its plane.
        """
        least, greatest = np.array(self.herpolhode_radii) * self.L / np.sqrt(2.0 * self.E)
        return float(np.arctan(least)), float(np.arctan(greatest))

    def precession_rate(self, t_s: float | np.ndarray) -> np.ndarray:
        """
        Return the precession rate [rad/s] of axis 3 about the momentum (46.21), shape of t_s.

        t_s [s]: time since O_2 was at its least.  For a symmetric body that of its axis, L / I2.
        """
        t_s = np.asarray(t_s, float)
        I, B = self.moments, self.B
        if self.is_symmetric:
            return np.full(t_s.shape, self.L / I[1])
        x = self.lam * t_s
        if np.isfinite(self.T1):
            x = x - elliptic.K(self.k2_complement)
        sn, cn, dn = elliptic.sncndn(x, self.k2_complement)
        first = (B[0] * (cn if self.about_largest else dn)) ** 2
        second = (B[1] * sn) ** 2
        return self.L * (I[0] * first + I[1] * second) / (I[0] ** 2 * first + I[1] ** 2 * second)

    def precession_swing(self, t_s: float | np.ndarray) -> np.ndarray:
        """
        Return S(t) [rad] (46.24), what the precession is ahead of its mean, shape of t_s.

        The integral of Phi - chi_0 over t_s [s] since O_2 was at its least, of the third kind: Phi
        = L (a + b sn^2) / (c + d sn^2) by (46.21).  ValueError: the rates have no period.
        """
        t_s = np.asarray(t_s, float)
        I, B, m1 = self.moments, self.B, self.k2_complement
        kappa = 1.0 if self.about_largest else self.k2
        (a, second), (c, last) = (((I * B**2)[:2]), ((I * B) ** 2)[:2])
        if self.is_symmetric or c == 0.0:
            return np.zeros(t_s.shape)
        if not np.isfinite(self.T1):
            raise ValueError('the rates of this motion have no period')
        b, d, K = second - kappa * a, last - kappa * c, elliptic.K(m1)

        def swept(x):
            return self.L * (b * c - a * d) / c**2 * elliptic.L(x, -d / c, m1) / self.lam

        # over a half period of the rates, 2 K, the swing is none
        mean = swept(2.0 * K) / (2.0 * K)
        x = self.lam * t_s
        return swept(x - K) + swept(K) - mean * x

    def precession_coefficients(self, count: int) -> np.ndarray:
        """
        Return chi_0 ... chi_(count - 1) [rad/s] of the precession rate's Fourier series (46.23).

        Phi(t) = chi_0 + 2 sum chi_n cos(2 pi n t / T1), t since O_2 was at its least: the rate is
        even there, so that chi_-n = chi_n is real, and odd n are zero.  The precession is phi_0 +
        chi_0 t + S(t + t0) - S(t0), S(t) = 2 sum chi_n sin(2 pi n t / T1) / (2 pi n / T1) (46.24).
        ValueError: the rates have no period.
        """
        if not np.isfinite(self.T1):
            raise ValueError(
                'the rates of this motion have no period and therefore no Fourier series'
            )
        # The trapezoidal rule doubles its digits with the points until rounding is left.
        points, coefficients = max(64, 4 * count), np.zeros(count)
        while True:
            rates = self.precession_rate(np.arange(points) * self.T1 / points)
            finer = np.fft.rfft(rates).real[:count] / points
            if np.max(np.abs(finer - coefficients)) <= 1e-15 * self.L / self.moments[0]:
                return finer
            points, coefficients = 2 * points, finer


def separatrix_planes(inertia: np.ndarray) -> np.ndarray:
    """
    Return the unit normals (2, 3), body axes, of the planes that hold the separatrix (44.9).

    The angular momenta L with L^2 = 2 E I2 are on the planes L1 = +-sqrt(I1 (I3 - I2) / (I3 (I2 -
    I1))) L3 through the middle axis, which cut the sphere |L| = const in great circles (44.8).

    Parameters
    ----------
    inertia : (3, 3), kg m^2, body axes
        of the body

    Raises
    ------
    ValueError
        two moments are equal
    """
    moments, R_bp = principal_axes(inertia)
    order = np.argsort(moments, kind='stable')
    I1, I2, I3 = moments[order]
    if min(I2 - I1, I3 - I2) <= ROUNDING * I3:
        raise ValueError('two principal moments are equal; a symmetric body has no separatrix')
    along_1, along_3 = np.sqrt((I2 - I1) / I1), np.sqrt((I3 - I2) / I3)
    normals_p = np.array([[along_1, 0.0, -along_3], [along_1, 0.0, along_3]])
    return normals_p @ R_bp[:, order].T / np.hypot(along_1, along_3)


def commensurability(
    T1: float, T2: float, tolerance: float = 1e-9, largest: int = 1000
) -> Fraction | None:
    """
    Return T1 / T2 as the fraction of turns to nutations after which the attitude is back, or None.

    The body is where it was after denominator * T1, in which it turned numerator times (45.17).

    Parameters
    ----------
    T1, T2 : s
        the periods
    tolerance : float
        relative
    largest : int
        the largest denominator
    """
    ratio = T1 / T2
    if not np.isfinite(ratio):
        return None
    nearest = Fraction(ratio).limit_denominator(largest)
    return nearest if abs(float(nearest) - ratio) <= tolerance * abs(ratio) else None
