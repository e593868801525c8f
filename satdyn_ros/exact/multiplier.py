"""
The multiplier nu of Agostinelli's stationary motions and the alphas that belong to it.

omega_i = omega_0 alpha_i gamma_i with omega_0^2 = |gradient|, alpha_i = s sqrt|N1 N2 N3| / N_i,
N_i = 1 - 2 nu I_i and s = +-1.  nu is admissible where N1 N2 N3 has the sign of the gradient: for
a positive one below the least of the poles 1 / (2 I_i) and between the two others, for a negative
one (De Brun's problem) between the two least and above the greatest.
"""

import numpy as np

from ..dynamics.inertia import ROUNDING
from .elliptic import LAST_DIGITS


def alphas(moments: np.ndarray, nu: float, sign: int, field: int = 1) -> np.ndarray:
    """
    Return the alphas (3,); field: the sign of the gradient.

    ValueError: nu is not admissible.
    """
    N = 1.0 - 2.0 * nu * moments
    with np.errstate(over='ignore'):
        product = field * np.prod(N)
    if not 0.0 < product < np.inf:
        poles = ', '.join(f'{pole:g}' for pole in np.sort(0.5 / moments))
        if field > 0:
            where = 'below the least or between the others'
        else:
            where = 'between the two least or above the greatest'
        raise ValueError(f'nu is {nu:g}; it must be {where} of the poles 1 / (2 I): {poles}')
    return sign * np.sqrt(product) / N


def differences(moments: np.ndarray, nu: float, sign: int) -> np.ndarray:
    """Return the matrix alpha_i - alpha_j without cancellation."""
    N = 1.0 - 2.0 * nu * moments
    scale = 2.0 * nu * sign * np.sqrt(np.abs(np.prod(N)))
    return scale * np.subtract.outer(moments, moments) / np.multiply.outer(N, N)


def c0_of_energy(
    moments: np.ndarray, nu: float, sign: int, field: int, h: float
) -> tuple[float, float]:
    """
    Return c0 = e - alpha_3 of h [kg m^2], the energy over omega_0^2 (27, corrected).

    c0 = nu (2 h - C (alpha_3^2 + f)) f s sqrt|N1 N2 N3| / D3, f the sign of the gradient and

        D3 = 1 - (A + B + C) nu + 4 A B C nu^3 = (N1 N2 + N2 N3 + N3 N1 - N1 N2 N3) / 2,

    which keeps its digits near the poles; beside it, how much of c0 rounding of h is worth.
    ValueError: nu is not admissible, or a root of D3, where all motions have the same energy, or
    zero, where c0 is zero whatever the energy.
    """
    alpha = alphas(moments, nu, sign, field)
    N = 1.0 - 2.0 * nu * moments
    terms = np.append(N * np.roll(N, 1), -np.prod(N)) / 2.0
    D3 = np.sum(terms)
    if nu == 0.0:
        raise ValueError('nu is 0, for which c0 is 0 whatever the energy; give c0 instead')
    if abs(D3) <= ROUNDING * np.sum(np.abs(terms)):
        raise ValueError(
            f'nu is {nu:g}, for which all motions have the same energy; give c0 instead'
        )
    root = np.sqrt(np.abs(np.prod(N)))
    left = 2.0 * h - moments[2] * (alpha[2] ** 2 + field)
    slope = nu * field * sign * root / D3
    size = np.max(moments * (alpha**2 + 1.0))
    return float(slope * left), float(ROUNDING * abs(slope) * size)


def find(
    moments: np.ndarray, omega_0: float, gamma: np.ndarray, omega_p: np.ndarray, field: int = 1
) -> tuple[float, int] | None:
    """
    Return nu and the sign of mu of a state, None where it has none.

    field: the sign of the gradient.  The axis k of the largest |gamma_k| gives alpha_k, and
    N_i N_j = field alpha_k^2 N_k is quadratic in nu; least squares over all axes then settle what
    alpha_k alone may leave open.  The rates must agree as if the attitude were off by no more than
    the rounding of its input.
    """
    I, k = moments, np.argmax(np.abs(gamma))
    square = field * (omega_p[k] / (omega_0 * gamma[k])) ** 2
    found = []
    for root in _real_roots(
        4.0 * I[k - 1] * I[k - 2], 2.0 * (square * I[k] - I[k - 1] - I[k - 2]), 1.0 - square
    ):
        nu = root
        for _ in range(3):
            N = 1.0 - 2.0 * nu * I
            if not field * np.prod(N) > 0.0:
                break
            sign = int(np.copysign(1.0, omega_p[k] * gamma[k] * N[k]))
            rates = omega_0 * alphas(I, nu, sign, field)
            off = omega_p - rates * gamma
            slope = rates * gamma * (2.0 * I / N - np.sum(I / N))
            step = float(off @ slope / (slope @ slope)) if np.any(slope) else 0.0
            found.append((np.max(np.abs(off)) / np.max(np.abs(rates)), nu, sign))
            nu += step
    if not found or min(found)[0] > ROUNDING:
        return None
    _, nu, sign = min(found)
    # Alphas of a smaller nu are equal to the last digit, and its elliptic functions overflow.
    return (0.0 if abs(nu) * np.max(I) <= LAST_DIGITS else nu), sign


def _real_roots(a, b, c):
    """Return the roots of a x^2 + b x + c, a > 0; a double one where they are just complex."""
    q = -(b + np.copysign(np.sqrt(max(b * b - 4.0 * a * c, 0.0)), b)) / 2.0
    return (float(q / a), float(c / q)) if q else (0.0,)
