"""
The multiplier nu of Agostinelli's stationary motions and the alphas that belong to it.

alpha_i = s sqrt(N1 N2 N3) / N_i with N_i = 1 - 2 nu I_i and s = +-1; nu is admissible where
N1 N2 N3 > 0: below the least of the poles 1 / (2 I_i), and between the two others.
"""

import numpy as np

from .axes import ROUNDING


def alphas(moments, nu, sign):
    """Return the alphas (3,); ValueError: nu is not admissible."""
    N = 1.0 - 2.0 * nu * moments
    if not np.prod(N) > 0.0:
        poles = ', '.join(f'{pole:g}' for pole in np.sort(0.5 / moments))
        raise ValueError(
            f'nu is {nu:g}; of the poles 1 / (2 I), {poles}, it must be below the least or '
            'between the others'
        )
    return sign * np.sqrt(np.prod(N)) / N


def differences(moments, nu, sign):
    """Return the matrix alpha_i - alpha_j without cancellation."""
    N = 1.0 - 2.0 * nu * moments
    scale = 2.0 * nu * sign * np.sqrt(np.prod(N))
    return scale * np.subtract.outer(moments, moments) / np.multiply.outer(N, N)


def find(moments, omega_0, gamma, omega_p):
    """
    Return nu and the sign of mu of a state, None where there is none.

    The axis k of the largest |gamma_k| gives alpha_k, and N_i N_j = alpha_k^2 N_k is quadratic in
    nu; least squares over all axes then settle what alpha_k alone may leave open.  The rates must
    agree as if the attitude were off by no more than the rounding of its input.
    """
    I, k = moments, np.argmax(np.abs(gamma))
    square = (omega_p[k] / (omega_0 * gamma[k])) ** 2
    found = []
    for root in _real_roots(
        4.0 * I[k - 1] * I[k - 2], 2.0 * (square * I[k] - I[k - 1] - I[k - 2]), 1.0 - square
    ):
        nu = root
        for _ in range(3):
            N = 1.0 - 2.0 * nu * I
            if not np.prod(N) > 0.0:
                break
            sign = int(np.copysign(1.0, omega_p[k] * gamma[k] * N[k]))
            rates = omega_0 * alphas(I, nu, sign)
            off = omega_p - rates * gamma
            found.append((np.max(np.abs(off)) / np.max(np.abs(rates)), nu, sign))
            slope = rates * gamma * (2.0 * I / N - np.sum(I / N))
            nu += float(off @ slope / (slope @ slope)) if np.any(slope) else 0.0
    if not found or min(found)[0] > ROUNDING:
        return None
    return min(found)[1:]


def _real_roots(a, b, c):
    """Return the roots of a x^2 + b x + c, a > 0; a double one where they are just complex."""
    q = -(b + np.copysign(np.sqrt(max(b * b - 4.0 * a * c, 0.0)), b)) / 2.0
    return (float(q / a), float(c / q)) if q else (0.0,)
