"""
The motion of u between its turning points b and a, u'^2 = f(u) = (a - u)(u - b) Q(u).

Let e be the end with the larger Q, o the other and w^2 = (u - e) / (o - u).  Then

    dt = 2 dw / sqrt(Qo w^4 + M w^2 + Qe) = 2 dw / sqrt((Qe + Y1 w^2)(Qe + Y2 w^2) / Qe)

with M twice the polar form of Q at a and b: one formula for every pattern of roots, in Carlson's
integrals (DLMF 19.16).
"""

from collections.abc import Sequence

import numpy as np
from scipy.special import elliprf, elliprj

from .half_angles import Lattice, Zero, evaluate
from .turning import steady, turning_points

EPS = np.finfo(float).eps
# A turning point this near a pole counts as at it; a number this small replaces a zero divisor.
NO_DISTANCE = 1e-100
# Q at the end that u left long ago, relative: so far back that u is at that end to the last bit.
_LONG_AGO = 1e-200
# This near a turning point, as a share of the squared width, f(u0) has no digits left for Q.
_AT_THE_END = 1e-10


class Nutation:
    """
    The periods of u, the time since u was last at e, and the integral of u.

    f, f_up, f_down, above and below as in turning_points; u_dot0 [1/s]; is_even: the
    other two roots of f are -a and -b.
    """

    def __init__(
        self,
        f: Sequence[float] | np.ndarray,
        f_up: Sequence[float] | np.ndarray,
        f_down: Sequence[float] | np.ndarray,
        above: float,
        below: float,
        u_dot0: float,
        is_even: bool = False,
    ):
        self.lattice: Lattice
        self.turning = turning_points(f, f_up, f_down, above, below)
        if self.turning.steady:
            self._rest(above, below)
            return
        da, db, _, _, Qa, Qb = self.turning
        width, c2 = da - db, -f[4]
        sizes, M = min(_ways_to_M(self.turning, c2, -f_up[0], -f_down[0]))
        if Qa == Qb == 0.0:
            # From one double root to another: u left b long ago.
            sizes, M = 0.0, -c2 * width**2
            Qb = _LONG_AGO * -c2 * width**2
            self.turning = self.turning._replace(Qb=Qb)
        self.from_b = Qb >= Qa
        G = 2.0 * np.sqrt(Qa * Qb)
        # M^2 - G^2 in ways that keep its digits: where the other roots are near both ends, where
        # the ends are near each other, and where u0 is near a double root.
        total, difference, c_2 = Qa + Qb, Qa - Qb, c2 * width**2
        ways = [
            (_square_error(M, sizes), (M - G) * (M + G)),
            (
                _square_error(difference, total) + EPS * (2.0 * total * abs(c_2) + c_2**2),
                difference**2 - (2.0 * total - c_2) * c_2,
            ),
        ]
        if -da * db > _AT_THE_END * width**2:
            c0 = f[0] / (-da * db)
            c1 = (f[1] - (da + db) * c0) / (-da * db)
            sizes = (abs(f[1]) + abs(da + db) * c0) / (-da * db)
            error = _square_error(c1, sizes) + EPS * 4.0 * abs(c0 * c2)
            ways.append((width**2 * error, width**2 * (c1 * c1 - 4.0 * c0 * c2)))
        if is_even:
            ways = [(0.0, c_2**2)]
        self._set_lattice(M, G, min(ways)[1])
        if self.lattice.period == np.inf and self.lattice.share < 1.0:
            # A double root between the ends: u left the end on its own side of it.
            self.from_b = bool(db**2 * Qa <= da**2 * Qb)
        S2, C2 = (-db / width, da / width) if self.from_b else (da / width, -db / width)
        Qe, (Y1, Y2) = Qb if self.from_b else Qa, self.Y
        since = 2.0 * np.sqrt(S2) * elliprf(Qe * C2, Qe * C2 + Y1 * S2, Qe * C2 + Y2 * S2).real
        if not since < np.inf:
            # From an end u takes for ever to the double root, which is where it starts.
            self._rest(above, below)
            return
        leaving = u_dot0 >= 0.0 if self.from_b else u_dot0 <= 0.0
        self.since = since if leaving else -since

    def _rest(self, above, below):
        """Set what says that u is constant."""
        self.turning = steady(above, below)
        self.from_b, self.since, self.lattice = True, 0.0, Lattice(1.0, np.inf, 1.0)

    def _set_lattice(self, M, G, discriminant):
        """Set Y1, Y2, their split where real, and the periods; discriminant = M^2 - 4 Qa Qb."""
        if discriminant >= 0.0 and M > 0.0:
            self.split = np.sqrt(discriminant)
            Y1 = (M + self.split) / 2.0
            Y2 = G * G / (4.0 * Y1)
            T, imaginary = elliprf(0.0, Y1, Y2), elliprf(0.0, self.split, Y1)
            self.Y, self.lattice = (Y1, Y2), Lattice(4.0 * T, 4.0 * imaginary, 1.0)
        else:
            discriminant = min(discriminant, 0.0)
            Y = complex(M, np.sqrt(-discriminant)) / 2.0
            larger = G + abs(M)
            smaller = -discriminant / larger
            G_plus_M, G_minus_M = (larger, smaller) if M > 0.0 else (smaller, larger)
            self._m1 = G_plus_M / (2.0 * G)
            T = elliprf(0.0, G_plus_M / 4.0, G / 2.0)
            imaginary = elliprf(0.0, G_minus_M / 4.0, G / 2.0)
            self.Y, self.lattice = (Y, Y.conjugate()), Lattice(4.0 * T, 4.0 * imaginary, 0.5)

    @property
    def k2(self) -> float:
        """Return the squared modulus of the elliptic functions, 0 where u is constant."""
        if self.turning.steady:
            return 0.0
        if self.lattice.share == 1.0:
            return float(self.split / self.Y[0]) if self.lattice.period < np.inf else 1.0
        return float(1.0 - self._m1)

    @property
    def period(self) -> float:
        """Return the period of u [s]: inf where u is constant or the motion asymptotic."""
        return np.inf if self.turning.steady else self.lattice.period

    def at_limit(self, at_a: float, at_b: float) -> float:
        """
        Return what is at_a and at_b at the ends, and linear in u, at the double root.

        There w^4 = Qe / Qo: the limit of an asymptotic motion.
        """
        root_a, root_b = np.sqrt(self.turning.Qa), np.sqrt(self.turning.Qb)
        return float((at_a * root_b + at_b * root_a) / (root_a + root_b))

    def integral(self, t_s: float | np.ndarray) -> np.ndarray:
        """Return the integral of u from 0 to t_s [s], shape (N,)."""
        t_s = np.asarray(t_s, float)
        if self.turning.steady:
            return self.turning.b * t_s
        return self._from_e(self.since + t_s) - self._from_e(np.array([self.since]))

    def _from_e(self, tau_s):
        """Return the integral of u over tau_s (N,) since u was at e."""
        T, imaginary, _ = self.lattice
        if np.isinf(T):
            # After this long u is at its limit, to the last bit.
            whole = 40.0 / (2.0 * np.pi) * imaginary
            within = np.minimum(np.abs(tau_s), whole)
            limit = self.at_limit(self.turning.a, self.turning.b)
            swept = self._over_half_a_period(within) + limit * (np.abs(tau_s) - within)
            return np.copysign(1.0, tau_s) * swept
        n = np.rint(tau_s / T)
        r = tau_s - n * T
        a_half = self._over_half_a_period(np.array([T / 2.0]))
        return np.copysign(1.0, r) * self._over_half_a_period(np.abs(r)) + 2.0 * n * a_half

    def _over_half_a_period(self, tau_s):
        """
        Return the integral of u over tau_s (N,), 0 to T / 2, since u was at e.

        It is e tau + (o - e)(2/3) Qe S^3 RJ(Qe C^2, Qe C^2 + Y1 S^2, Qe C^2 + Y2 S^2, Qe), where
        w = S / C and S^2 + C^2 = 1.  For conjugate Y1, Y2 the same in real terms, with the
        amplitude phi, tan(phi/2) = (Qo/Qe)^(1/4) w.
        """
        a, b, Qa, Qb = self.turning.a, self.turning.b, self.turning.Qa, self.turning.Qb
        e, o, Qe, Qo = (b, a, Qb, Qa) if self.from_b else (a, b, Qa, Qb)
        S, C = self._half_angle(tau_s, Qe)
        Y1, Y2 = self.Y
        if self.lattice.share == 1.0:
            third = elliprj(Qe * C**2, Qe * C**2 + Y1 * S**2, Qe * C**2 + Y2 * S**2, Qe)
            return e * tau_s + (o - e) * 2.0 / 3.0 * Qe * S**3 * third
        p, q, m1 = np.sqrt(Qe), np.sqrt(Qo), self._m1
        cn, sn = p * C**2 - q * S**2, 2.0 * np.sqrt(p * q) * S * C
        cn, sn = cn / np.hypot(cn, sn), sn / np.hypot(cn, sn)
        dn = np.hypot(cn, np.sqrt(m1) * sn)
        eta, h = (q - p) / (q + p), 4.0 * p * q / (q + p) ** 2
        third = sn**3 / 3.0 * elliprj(cn**2, dn**2, 1.0, cn**2 + sn**2 / h) / h
        whole = elliprj(0.0, m1, 1.0, 1.0 / h) / 3.0 / h
        third = np.where(cn < 0.0, 2.0 * whole - third, third)
        k = np.sqrt(max(eta**2 / h + 1.0 - m1, 0.0))
        turn = np.arctan(k * sn / dn) / max(k, NO_DISTANCE)
        x = np.sqrt(p * q) * tau_s
        swept = (e * q + o * p) / (q + p) * x + (e - o) / 2.0 * (turn - eta * (x - third))
        return swept / np.sqrt(p * q)

    def _half_angle(self, tau_s, Qe):
        """Return S and C of tau_s (N,) since u was at e: square roots of two theta functions."""
        zero = Zero(1.0, 0.0, self.lattice.share * self.lattice.imaginary, False, 0.0)
        times = np.append(tau_s, 0.0)
        at_e, slope, at_o, _ = evaluate(times, 0.0, self.lattice, zero, zero._replace(at_end=True))
        # w = (sqrt(Qe) / 2) tau at first
        S = np.sqrt(Qe) / 2.0 * np.abs(at_e / slope[-1])[:-1]
        C = np.abs(at_o / at_o[-1])[:-1]
        return S / np.hypot(S, C), C / np.hypot(S, C)


def _ways_to_M(turning, c2, *squares):
    """
    Return pairs of the size of the terms of M, which bounds its rounding, and M.

    From Q's leading coefficient c2, and from f = -square at each pole, whose digits count where
    more than one root is near it.
    """
    width, Qa, Qb = turning.da - turning.db, turning.Qa, turning.Qb
    ways = [(Qa + Qb + abs(c2) * width**2, Qa + Qb - c2 * width**2)]
    poles = [(*turning.from_above, Qa, Qb), (*turning.from_below, Qb, Qa)]
    for (near, far, Q_near, Q_far), square in zip(poles, squares, strict=True):
        if near > NO_DISTANCE:
            sum_ = Q_near * far / near + Q_far * near / far
            other = square * (width / near / far) ** 2
            ways.append((sum_ + other, sum_ - other))
    return ways


def _square_error(x, sizes):
    """Return a bound of the rounding of x^2, sizes the sum of the sizes of the terms of x."""
    return EPS * sizes * (2.0 * abs(x) + EPS * sizes)
