"""
What Paladini's paper says of a symmetric body's motion besides its attitude (1888, ch. 1).

The three motions that make it up (sec. 5, 11), the curves of the instantaneous pole in the body
and in space (sec. 12), and the motions akin to it: Poinsot's motion behind its nutation (sec. 4),
the heavy top of sec. 13, and for H1 = 0 Poinsot's motion whose herpolhode is the body's curve.
Angles and rates refer to body axis 3, the symmetry axis, and the field's direction Z
(symmetric.py).
"""

import numpy as np

from ..dynamics import rotation
from ..dynamics.euler import from_zxz, rate_from_zxz, zxz_angles
from ..dynamics.system import State
from .cones import Cones
from .geometry import Rolling
from .symmetric import Symmetric

_Z = np.array([0.0, 0.0, 1.0])
# Gauss-Legendre nodes and weights on [0, 1].
_NODES, _WEIGHTS = (np.polynomial.legendre.leggauss(16) + np.array([[1.0], [0.0]])) / 2.0


def oscillation(motion: Symmetric, t_s: float | np.ndarray) -> np.ndarray:
    """
    Return psi', theta, phi' (N, 3) [rad] of the oscillating rotation R' at t_s (N,) (sec. 5).

    The motion is two uniform rotations and this oscillating one, R = Rz(Om_P t) R' Rz(Om_S t) with
    R' = Rz(psi') Rx(theta) Rz(phi'), whose angles have the period of the nutation.
    """
    t_s = np.atleast_1d(np.asarray(t_s, float))
    q = rotation.multiply(rotation.about(_Z, -motion.Om_P * t_s), _attitude(motion, t_s))
    return zxz_angles(rotation.multiply(q, rotation.about(_Z, -motion.Om_S * t_s)))


def body_curve(motion: Symmetric, t_s: float | np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """
    Return rho [rad/s] and sigma [rad], continuous, of the pole in the body at t_s (N,) (41).

    p + i q = rho exp(i sigma) in the plane r = r0; sigma is an integral of the third kind.
    """
    t_s = np.atleast_1d(np.asarray(t_s, float))
    return _polar(motion, t_s, Rolling.of(motion).polar_rate, _body_pole)


def space_curve(motion: Symmetric, t_s: float | np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """
    Return rho' [rad/s] and sigma' [rad], continuous, of the pole's projection across Z (42).

    v_x + i v_y = rho' exp(i sigma') of the rate v = R omega in space, at t_s (N,).
    """
    t_s = np.atleast_1d(np.asarray(t_s, float))
    return _polar(motion, t_s, Rolling.of(motion).space_rate, _space_pole)


def companion_top(motion: Symmetric) -> Symmetric:
    """
    Return the heavy top, H1 = 0, that moves like motion except in nutation (sec. 13).

    tan(theta / 2) of the top is sqrt(ka) times that of the body, ka = (a + 1) / (a - 1) with a the
    root of f that is farthest beyond a pole; precession and spin differ by uniform rotations.  The
    top has the body's A, C and r0, and a rotor that gives it its momentum.  ValueError: f has no
    real root beyond the poles; the paper's condition, that all roots are real, is not enough.
    """
    if motion.H1 == 0.0:
        return motion
    outside = [a for a in Cones.of(motion).roots if abs(a) > 1.0]
    if not outside:
        raise ValueError('the quartic of this motion has no real root beyond +-1: it has no top')
    a = max(outside, key=abs)
    ka = (a + 1.0) / (a - 1.0)
    A, J3 = motion.A, motion.C * motion.r0 + motion.h3
    lp, lm = (motion.g + J3) / (A * ka), (motion.g - J3) / A * ka
    g, J3 = A * (lp + lm) / 2.0, A * (lp - lm) / 2.0
    # h' and H2 from the turning points, both roots of 2 A (1 - u^2)(h' + H2 u) - (g - J3 u)^2
    theta = 2.0 * np.arctan(np.sqrt(ka) * np.tan(np.array(motion.theta_limits) / 2.0))
    u = np.cos(theta)
    energy = ((g - J3 * u) / np.sin(theta)) ** 2 / (2.0 * A)
    H2 = (energy[0] - energy[1]) / (u[0] - u[1])
    P, nutation, S = zxz_angles(_attitude(motion, np.zeros(1)))[0]
    half = np.tan(nutation / 2.0)
    p, q = motion.pole(np.zeros(1))[0, :2]
    nutation_rate = p * np.cos(S) - q * np.sin(S)
    nutation_rate *= np.sqrt(ka) * (1.0 + half**2) / (1.0 + ka * half**2)
    nutation = 2.0 * np.arctan(np.sqrt(ka) * half)
    precession_rate = (g - J3 * np.cos(nutation)) / (A * np.sin(nutation) ** 2)
    spin_rate = motion.r0 - precession_rate * np.cos(nutation)
    angles, rates = (P, nutation, S), (precession_rate, nutation_rate, spin_rate)
    state = State(from_zxz(*angles), rate_from_zxz(angles, rates))
    return Symmetric.in_potential(A, motion.C, J3 - motion.C * motion.r0, 0.0, float(H2), state)


def poinsot_rates(motion: Symmetric) -> np.ndarray:
    """
    Return L / I_j (3,) [rad/s] of Poinsot's motion whose herpolhode is the body's curve (sec. 12).

    For H1 = 0.  The herpolhode, omega across L, is half as large as the curve at the same times,
    its plane at 2 E / L = J3 / 2A - r0.  With the curve's rate of turn 2 E / L + 4 F / rho^2 and
    rho_j at the three roots of f, L / I_j = 2 E / L + 4 F / rho_j^2: a general quadric, whose
    moments need not be those of a body.  ValueError: H1 is not zero, or H2 is.
    """
    if motion.H1 != 0.0 or motion.H2 == 0.0:
        raise ValueError('this curve is a herpolhode for H1 = 0 and H2 not 0')
    A, J3 = motion.A, motion.C * motion.r0 + motion.h3
    rho_squares = 2.0 / A * (motion.h_prime + motion.H2 * Cones.of(motion).roots)
    four_F = (motion.H2 * motion.g + J3 * motion.h_prime) / A**2
    return J3 / (2.0 * A) - motion.r0 + four_F / rho_squares


def nutation_as_precession(motion: Symmetric) -> tuple[float, np.ndarray]:
    """
    Return 2 E / L and L / I_j (3,) [rad/s] of the Poinsot motion behind cos theta (sec. 4).

    In a Poinsot motion let U be the rate at which the projection of a principal axis across L
    turns; of each axis U'^2 = -4 (U - 2 E / L)(U - L / I_1)(U - L / I_2)(U - L / I_3).  With the
    roots a_i of f and U = sqrt(H1 / 2A) cos theta that is cos theta'^2 = f: the four constants are
    sqrt(H1 / 2A) a_i.  2 E / L is the middle root at which the nutation ends, and the axis, the
    first of the three, is that of the other middle root.  A uniform rotation about L adds the same
    number to all; the moments need not be those of a body.  ValueError: H1 is not positive or two
    roots are complex; no such motion is real.
    """
    cones = Cones.of(motion)
    if cones.case not in ('alpha', 'beta') or motion.H1 <= 0.0:
        raise ValueError('the Poinsot motion is real for H1 > 0 and four real roots of f')
    least, low, high, most = np.sqrt(motion.H1 / (2.0 * motion.A)) * cones.roots
    end, axis = (low, high) if cones.case == 'alpha' else (high, low)
    return float(end), np.array([axis, least, most])


def _attitude(motion, t_s):
    """Return the quaternions of axes 1, 2, 3 in space (N, 4)."""
    return rotation.multiply(motion.attitude(t_s)[0], motion.q_bp)


def _body_pole(motion, t_s):
    return motion.pole(t_s)[:, :2]


def _space_pole(motion, t_s):
    q_ib, omega_bi_b = motion.attitude(t_s)
    return rotation.rotate(q_ib, omega_bi_b)[:, :2]


def _polar(motion, t_s, rate, pole):
    """Return the polar coordinates of a pole (N, 2) whose angle has a rate that u determines."""
    x, y = pole(motion, t_s).T
    x0, y0 = pole(motion, np.zeros(1))[0]
    turned = np.arctan2(y0, x0) + _integral(motion, rate, t_s)
    angle = np.arctan2(y, x)
    return np.hypot(x, y), angle + 2.0 * np.pi * np.rint((turned - angle) / (2.0 * np.pi))


def _integral(motion, rate, t_s):
    """Return the integral (N,) of rate(u) from 0 to t_s (N,): periods, panels and the rest."""
    nutation = motion.flow.nutation
    period, imaginary, share = nutation.lattice
    if nutation.turning.steady:
        return rate(np.array([nutation.turning.b]))[0] * t_s
    panel = min(period, share * imaginary) / 5.0
    n, rest = np.zeros_like(t_s), t_s
    if period < np.inf:
        panel = period / np.ceil(period / panel)
        n, rest = np.divmod(t_s, period)
    k = np.floor(rest / panel)
    count = int(np.rint(period / panel)) if period < np.inf else int(np.max(k, initial=0.0))
    starts = panel * np.arange(count)
    sums = np.append(0.0, np.cumsum(_panel(motion, rate, starts, starts + panel)))
    whole = sums[-1] if period < np.inf else 0.0
    return n * whole + sums[k.astype(int)] + _panel(motion, rate, k * panel, rest)


def _panel(motion, rate, start_s, stop_s):
    """Return the integral of rate(u) from start_s to stop_s (N,) by Gauss-Legendre quadrature."""
    length = (stop_s - start_s)[:, None]
    x, y, z, w = _attitude(motion, (start_s[:, None] + length * _NODES).ravel()).T
    u = z * z + w * w - x * x - y * y
    return length[:, 0] * (rate(u).reshape(-1, len(_NODES)) @ _WEIGHTS)
