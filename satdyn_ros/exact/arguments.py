"""
Where in complex time cos theta of a symmetric body is 1, -1 or infinite (Paladini 1888, ch. 1).

Let x be the argument of the elliptic functions, real at real times and 0 where u = cos theta is at
e, the end of its range with the larger Q of nutation.py.  With four real roots of f (sec. 2)

    1 +- u = (1 +- e) (1 + n_i sn^2 x) / (1 + n sn^2 x),

and with two (sec. 7)

    1 +- u = constant (1 + m_i cn x) / (1 + m cn x),    n_i = m_i^2 / (1 - m_i^2),

i = 1 with the upper sign.  The paper's formulas for sigma, tau and N are lost; these are the
numbers that its text describes.
"""

from typing import Any, NamedTuple

import numpy as np
from scipy.special import elliprf


class Arguments(NamedTuple):
    """
    Paladini's auxiliary constants of a motion (symmetric.Symmetric).

    Attributes
    ----------
    sigma : (2,)
        1 + u is zero at x = i sigma[0] and 1 - u at i sigma[1], or (at_far_end) half a period of u
        later; 0 <= sigma <= K' (sec. 3, 8)
    at_far_end : (2,) bool
        whether it is half a period later
    tau : complex
        u is infinite at x = +-i tau (sec. 4, 10): real for H1 > 0, K' for H1 = 0, and for H1 < 0
        complex with the real part K'
    n : (2,)
        those of the integrals of the third kind, 1 / (1 + n_i sn^2 x)
    k2 : float
        the squared modulus
    x_rate : 1/s
        x'
    """

    sigma: np.ndarray
    at_far_end: np.ndarray
    tau: complex
    n: np.ndarray
    k2: float
    x_rate: float

    @classmethod
    def of(cls, motion: Any) -> 'Arguments':
        """Return those of a motion; ValueError: its cos theta is constant."""
        nutation = motion.flow.nutation
        turning, from_b = nutation.turning, nutation.from_b
        if turning.steady:
            raise ValueError('cos theta is constant: no elliptic function describes it')
        Qe, Qo = (turning.Qb, turning.Qa) if from_b else (turning.Qa, turning.Qb)
        # 1 +- e and 1 +- o, the other end
        ends = np.array([turning.from_below, turning.from_above[::-1]])
        at_e, at_o = ends.T if from_b else ends.T[::-1]
        with np.errstate(divide='ignore'):
            ratios = at_o / at_e
        k2 = nutation.k2
        if nutation.lattice.share == 1.0:
            Y1 = nutation.Y[0]
            x_rate = np.sqrt(Y1) / 2.0
            n = Qe / Y1 * ratios - 1.0
            tau = _pole_of_sn(0.0 if motion.H1 == 0.0 else Qe / Y1 - 1.0, k2)
        else:
            x_rate = (Qe * Qo) ** 0.25
            s = np.sqrt(Qo / Qe)
            with np.errstate(divide='ignore'):
                n = (np.sqrt(s / ratios) - np.sqrt(ratios / s)) ** 2 / 4.0
            tau = _pole_of_cn((1.0 - s) / (1.0 + s), k2)
        zeros = motion.flow.zero_plus, motion.flow.zero_minus
        sigma = x_rate * np.array([zero.height for zero in zeros])
        at_far_end = np.array([zero.at_end for zero in zeros])
        return cls(sigma, at_far_end, tau, n, k2, float(x_rate))

    @property
    def N(self) -> np.ndarray:
        """
        Return N_1 and N_2 (2,), n (n + 1)(n + k^2): the characteristic numbers (sec. 2).

        Both are positive, the integrals of the third kind trigonometric, and zero or inf where
        the axis passes through the pole.
        """
        return self.n * (self.n + 1.0) * (self.n + self.k2)


def poles(motion: Any) -> tuple[np.ndarray, np.ndarray]:
    """
    Return the poles of cos theta in complex time t [s] and its residues there [s] (sec. 4).

    Two simple poles with opposite residues, +-sqrt(-A / 2 H1), in each cell of its periods; for
    H1 = 0 one double pole without residue (sec. 13); for the free body none.  t is 0 at the start.
    """
    arguments, nutation = Arguments.of(motion), motion.flow.nutation
    if motion.H1 == motion.H2 == 0.0:
        return np.array([], complex), np.array([], complex)
    away = 1j * arguments.tau / arguments.x_rate
    if motion.H1 == 0.0:
        return np.array([away - nutation.since]), np.array([0j])
    # From the lower end u falls to minus infinity
    residue = (1.0 if nutation.from_b else -1.0) * np.sqrt(complex(-motion.A / (2.0 * motion.H1)))
    return np.array([away, -away]) - nutation.since, np.array([residue, -residue])


def _pole_of_sn(n, k2):
    """Return the tau with sn^2(i tau) = -1 / n; n >= 0, or -k^2 < n < 0 and i tau = i K' + y."""
    if n >= 0.0:
        return float(elliprf(n, n + k2, 1.0 + n))
    # n + k^2 is positive but for rounding
    y = np.sqrt(-n) * elliprf(max(k2 + n, 0.0), k2 * (1.0 + n), k2)
    return complex(elliprf(0.0, k2, 1.0), -y)


def _pole_of_cn(cn, k2):
    """Return the tau with cn(i tau) = 1 / cn, which is cn(tau) of the modulus k'."""
    sn2 = 1.0 - cn * cn
    tau = float(np.sqrt(sn2) * elliprf(cn * cn, 1.0 - (1.0 - k2) * sn2, 1.0))
    return tau if cn >= 0.0 else 2.0 * float(elliprf(0.0, k2, 1.0)) - tau
