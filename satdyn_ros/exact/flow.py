"""
The one kernel of the symmetric body and of free rotation: u'^2 = f(u) and two half-angle phases.

With s+ = P + S and s- = P - S of the ZXZ angles P (precession), theta, S (spin), u = cos theta,
f of degree 4 at most with f(1) = -lm^2 and f(-1) = -lp^2,

    u'^2 = f(u),    s+' = kp + lp / (1 + u),    s-' = km + lm / (1 - u).

The half-angle numbers alpha = w + i z = cos(theta/2) exp(i s+/2) and beta = x + i y =
sin(theta/2) exp(i s-/2) are the quaternion.  As functions of complex time each has one zero in a
cell of the periods of u, so up to a common real factor each is one theta function times
exp(i rate t / 2), rate the mean of s+' or s-' (Klein and Sommerfeld, Theorie des Kreisels, 1898,
VI).  The form has no singular attitude, passes both poles, and stays accurate on separatrices,
where the real period is infinite, and for small oscillations, where the imaginary one is.
"""

import numpy as np
from scipy.special import elliprf, elliprj

from ..kernel.compile import compiled, inlined
from .half_angles import Zero, evaluate
from .nutation import NO_DISTANCE, Nutation


class Flow:
    """
    The attitude of an axis u = cos theta whose nutation and phases are given.

    Parameters
    ----------
    nutation : Nutation
        of u
    plus : two of float, rad/s
        kp, lp
    minus : two of float, rad/s
        km, lm
    alpha0, beta0 : complex
        at the start
    pq0 : complex, rad/s
        the transverse rate p + i q at the start

    Attributes
    ----------
    zero_plus, zero_minus : Zero
        of alpha and beta in complex time
    mean_plus, mean_minus : rad/s
        the mean rates of s+ and s-, without the jump of an angle at a passage exactly through a
        pole
    """

    def __init__(
        self,
        nutation: Nutation,
        plus: tuple[float, float],
        minus: tuple[float, float],
        alpha0: complex,
        beta0: complex,
        pq0: complex,
    ):
        self.nutation = nutation
        self.zero_plus, self.mean_plus = _zero(nutation, -1, *plus)
        self.zero_minus, self.mean_minus = _zero(nutation, 1, *minus)
        self._factors = self._fit(alpha0, beta0, pq0)

    @property
    def mean_precession(self) -> float:
        """Return the mean rate of P [rad/s]."""
        return (self.mean_plus + self.mean_minus) / 2.0

    @property
    def mean_spin(self) -> float:
        """Return the mean rate of S [rad/s]."""
        return (self.mean_plus - self.mean_minus) / 2.0

    def at(self, t_s: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return alpha, beta and p + i q [rad/s] at t_s (N,), complex (N,) each."""
        return _normalised(self._numbers(np.asarray(t_s, float)), *self._factors)

    def _numbers(self, t_s):
        nutation = self.nutation
        return evaluate(t_s, nutation.since, nutation.lattice, self.zero_plus, self.zero_minus)

    def _fit(self, alpha0, beta0, pq0):
        """
        Return the constant factors of alpha, alpha', beta and beta' that give the start.

        That of the larger number is direct; that of the smaller, which may start at its zero, is
        a least-squares fit to the number and to p + i q = 2 (alpha* beta' - beta alpha'*).
        """
        A, A_dot, B, B_dot = self._numbers(np.zeros(1))[:, 0]
        lattice = self.nutation.lattice
        unit = min(lattice.period, lattice.imaginary) / (2.0 * np.pi)
        if abs(alpha0) >= abs(beta0):
            factor_a = alpha0 / A
            rate = np.conj(alpha0) * (B_dot - B * np.conj(A_dot / A))
            factor_b = _least_squares(beta0, B, unit * pq0 / 2.0, unit * rate)
        else:
            factor_b = beta0 / B
            rate = np.conj(beta0) * (A * np.conj(B_dot / B) - A_dot)
            factor_a = _least_squares(alpha0, A, unit * np.conj(pq0) / 2.0, unit * rate)
        return factor_a, factor_b


@compiled
def _normalised(numbers, factor_a, factor_b):
    """Return alpha, beta and p + i q = 2 (alpha* beta' - beta alpha'*) (3, N) of the numbers."""
    found = np.empty((3, numbers.shape[1]), np.complex128)
    for i in range(numbers.shape[1]):
        alpha, alpha_dot = factor_a * numbers[0, i], factor_a * numbers[1, i]
        beta, beta_dot = factor_b * numbers[2, i], factor_b * numbers[3, i]
        a, b = _size(alpha), _size(beta)
        square = a * a + b * b
        pq = 2.0 * (np.conj(alpha) * beta_dot - np.conj(alpha_dot * np.conj(beta)))
        found[0, i] = 1.0 / np.sqrt(square) * alpha
        found[1, i] = 1.0 / np.sqrt(square) * beta
        found[2, i] = 1.0 / square * pq
    return found


@inlined
def _size(z):
    """Return |z|, whatever its order of magnitude."""
    x, y = abs(z.real), abs(z.imag)
    if x == y == 0.0:
        return 0.0
    ratio = min(x, y) / max(x, y)
    return max(x, y) * np.sqrt(ratio * ratio + 1.0)


def _zero(nutation, c, k, l):
    """Return the zero of sqrt(1 - c u) exp(i s/2), s' = k + l / (1 - c u), and the mean of s'."""
    turning, (T, imaginary, share) = nutation.turning, nutation.lattice
    depth = share * imaginary
    # The pole u = c from the end of the range beside it and from the other end.
    near, far = turning.from_above if c > 0 else turning.from_below
    if turning.steady:
        rate = k + (l / near if near > NO_DISTANCE else 0.0)
        return Zero(1.0, np.inf, np.inf, False, rate), rate
    if near <= NO_DISTANCE:
        return Zero(1.0, 0.0, depth, nutation.from_b == (c > 0), k + 2.0 * np.pi / T), k
    Q_near, Q_far = (turning.Qa, turning.Qb) if c > 0 else (turning.Qb, turning.Qa)
    width, (Y1, Y2) = turning.da - turning.db, nutation.Y
    # Imaginary time leads from the near end straight to the pole or, where the other two roots
    # lie between, from the far end through infinity.
    direct = near**2 * Q_far <= far**2 * Q_near
    start, end, Q = (near, far, Q_near) if direct else (far, near, Q_far)
    if share == 1.0:
        # z = Q end - Y start by product and difference, for f = -l^2 at the pole
        product, half = Q * (l * width) ** 2 / (start * end), nutation.split * start / 2.0
        z2 = half + np.hypot(half, np.sqrt(product))
        z1 = product / z2 if z2 > 0.0 else 0.0
    else:
        z1, z2 = Q * end - Y1 * start, Q * end - Y2 * start
    height = min(2.0 * np.sqrt(start) * elliprf(Q * end, z1, z2).real, depth)
    depth = depth - height if np.isfinite(height) else np.inf
    sign = 1.0 if (l >= 0.0) == direct else -1.0
    at_end = nutation.from_b == (direct == (c > 0))
    if T < np.inf:
        third = elliprj(0.0, Y1, Y2, Q_far * near / far).real
        mean = 1.0 / far + 4.0 / (3.0 * T) * width / far**2 * Q_far * third
    else:
        mean = 1.0 / (nutation.at_limit(near, far) if c > 0 else nutation.at_limit(far, near))
    rate = k + l * mean
    return Zero(sign, height, depth, at_end, rate), rate


def _least_squares(y1, x1, y2, x2):
    """Return the k that fits y1 = k x1 and y2 = k x2 best."""
    return (np.conj(x1) * y1 + np.conj(x2) * y2) / (abs(x1) ** 2 + abs(x2) ** 2)
