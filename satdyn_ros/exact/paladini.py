"""
What Paladini's paper says of a symmetric body's motion besides its attitude (1888, ch. 1).

The three motions that make it up (sec. 5, 11), the curves of the instantaneous pole in the body
and in space (sec. 12), and the motions akin to it: Poinsot's motion behind its nutation (sec. 4),
the heavy top of sec. 13, and for H1 = 0 Poinsot's motion whose herpolhode is the body's curve.
Angles and rates refer to body axis 3, the symmetry axis, and the field's direction Z
(symmetric.py).
"""

import numpy as np

from ..dynamics.system import State
from ..kernel import rotation
from ..theory.euler_angles import zxz_angles
from .cones import AT_POLE, Cones
from .elliptic import LAST_DIGITS
from .geometry import AT_ZERO, Rolling
from .symmetric import Symmetric

_Z = np.array([0.0, 0.0, 1.0])
# A pole that comes this near the centre of its curve, as a share of its size, passes through it.
_AT_CENTRE = 1e-12
# Roots of opposite signs that differ by less, as a share, are equally far.
_A_TIE = 1e-9
# Gauss-Legendre nodes and weights on [0, 1].
_NODES, _WEIGHTS = (np.polynomial.legendre.leggauss(16) + np.array([[1.0], [0.0]])) / 2.0


def oscillation(motion: Symmetric, t_s: float | np.ndarray) -> np.ndarray:
    """
    Return psi', theta, phi' (N, 3) [rad] of the oscillating rotation R' (sec. 5).

    The motion is two uniform rotations and this oscillating one, R = Rz(Om_P t) R' Rz(Om_S t) with
    R' = Rz(psi') Rx(theta) Rz(phi'), whose angles have the period of the nutation.

    Parameters
    ----------
    motion : Symmetric
        the motion
    t_s : (N,), s
        since it began
    """
    t_s = np.atleast_1d(np.asarray(t_s, float))
    q = rotation.multiply(rotation.about(_Z, -motion.Om_P * t_s), _attitude(motion, t_s))
    return zxz_angles(rotation.multiply(q, rotation.about(_Z, -motion.Om_S * t_s)))


def body_curve(motion: Symmetric, t_s: float | np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """
    Return rho [rad/s] and sigma [rad], (N,) each, of the pole in the body, continuous (41).

    p + i q = rho exp(i sigma) in the plane r = r0; sigma is an integral of the third kind.  Where
    the curve passes through its centre, at a cusp of the axis' path, rho changes its sign.

    Parameters
    ----------
    motion : Symmetric
        the motion
    t_s : (N,), s
        since it began
    """
    t_s = np.atleast_1d(np.asarray(t_s, float))
    return _polar(motion, t_s, Rolling.of(motion).turning_in_body, _body_pole, -motion.Om_S)


def space_curve(motion: Symmetric, t_s: float | np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """
    Return rho' [rad/s] and sigma' [rad], (N,) each, of the pole's projection across Z (42).

    v_x + i v_y = rho' exp(i sigma') for the rate v = R omega in space; both are continuous.  Where
    it passes through Z, rho' changes its sign.

    Parameters
    ----------
    motion : Symmetric
        the motion
    t_s : (N,), s
        since it began
    """
    t_s = np.atleast_1d(np.asarray(t_s, float))
    return _polar(motion, t_s, Rolling.of(motion).turning_in_space, _space_pole, motion.Om_P)


def companion_top(motion: Symmetric) -> Symmetric:
    """
    Return the heavy top, H1 = 0, that moves like motion except in nutation (sec. 13).

    tan(theta / 2) of the top is sqrt(ka) times that of the body, ka = (a + 1) / (a - 1) with a the
    root of f that is farthest beyond a pole, of two as far the positive one; precession and spin
    differ by uniform rotations: lp and lm of the half angles (flow.py) are lp / ka and ka lm.
    With a_i the other roots of f, H2 of the top is -H1 (a - a_1)(a - a_2)(a - a_3) / (a^2 - 1).
    It has the body's A, C and r0, and a rotor that gives it its momentum.  ValueError: f has no
    real root beyond the poles; the paper's condition, that all roots are real, is not enough.
    """
    if motion.H1 == 0.0:
        return motion
    roots = Cones.of(motion).roots
    farthest = len(roots) - 1 if roots[-1] >= -roots[0] * (1.0 - _A_TIE) else 0
    a, others = roots[farthest], np.delete(roots, farthest)
    if abs(a) <= 1.0 + AT_POLE:
        raise ValueError('the quartic of this motion has no real root beyond +-1: it has no top')
    root_ka = np.sqrt((a + 1.0) / (a - 1.0))
    A, J3 = motion.A, motion.C * motion.r0 + motion.h3
    lp, lm = (motion.g + J3) / A, (motion.g - J3) / A
    J3_top = A * (lp / root_ka**2 - lm * root_ka**2) / 2.0
    H2_top = -motion.H1 * np.prod(a - others) / (a * a - 1.0)
    x, y, z, w = _attitude(motion, np.zeros(1))[0]
    alpha, beta = complex(w, z), complex(x, y)
    p, q, r0 = motion.pole(np.zeros(1))[0]
    # exp(i S) (p + i q) = theta' + i P' sin theta, and 2 P' sin theta = lp tan + lm cot of theta/2
    node = np.exp(1j * (np.angle(alpha) - np.angle(beta)))
    across = node * complex(p, q)
    nodding = across.real * root_ka / (abs(alpha) ** 2 + root_ka**2 * abs(beta) ** 2)
    if abs(beta) <= abs(alpha):
        gap = (1.0 / root_ka - root_ka) * lp * abs(beta / alpha) / 2.0
        turning = root_ka * across.imag + gap
    else:
        gap = (root_ka - 1.0 / root_ka) * lm * abs(alpha / beta) / 2.0
        turning = across.imag / root_ka + gap
    pq = complex(nodding, turning) / node
    state = State(
        rotation.normalise([root_ka * x, root_ka * y, z, w]), np.array([pq.real, pq.imag, r0])
    )
    return Symmetric.in_potential(A, motion.C, J3_top - motion.C * r0, 0.0, float(H2_top), state)


def poinsot_rates(motion: Symmetric) -> np.ndarray:
    """
    Return L / I_j (3,) [rad/s] of Poinsot's motion whose herpolhode is the body's curve (sec. 12).

    For H1 = 0.  The herpolhode, omega across L, is half as large as the curve at the same times,
    its plane at 2 E / L = J3 / 2A - r0.  With the curve's rate of turn 2 E / L + 4 F / rho^2 and
    rho_j at the three roots of f, L / I_j = 2 E / L + 4 F / rho_j^2: a general quadric, whose
    moments need not be those of a body.

    With x_j = L / I_j - 2 E / L, rho_j^2 = -4 x_k x_l and F = -x_1 x_2 x_3.  A top with cusps, F =
    rho_j = 0 at one root, is the limit of one moment zero, inf here, and the two others L^2 / 2E;
    for a top that rises to the vertical for ever, rho_j = 0 at two roots, their x_j are +-rho /
    2 of the third: of all separatrices with this herpolhode the even one.  ValueError: H1 is not
    zero, or H2 is.
    """
    if motion.H1 != 0.0 or motion.H2 == 0.0:
        raise ValueError('this curve is a herpolhode for H1 = 0 and H2 not 0')
    A, J3 = motion.A, motion.C * motion.r0 + motion.h3
    roots = Cones.of(motion).roots
    energies = motion.h_prime + motion.H2 * roots
    at_centre = np.abs(energies) <= AT_ZERO * (abs(motion.h_prime) + abs(motion.H2))
    x = np.zeros(3)
    if not np.any(at_centre):
        x = (motion.H2 * motion.g + J3 * motion.h_prime) / (2.0 * A * energies)
    elif np.sum(at_centre) == 1:
        x[at_centre] = np.inf
    else:
        square = 2.0 / A * np.sum(energies[~at_centre])
        x[np.flatnonzero(at_centre)[:2]] = (
            np.sqrt(abs(square)) / 2.0 * np.array([1.0, -np.copysign(1.0, square)])
        )
    return J3 / (2.0 * A) - motion.r0 + x


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


def _polar(motion, t_s, turning, pole, steady_rate):
    """
    Return the polar coordinates of a pole (N, 2) whose angle has a rate that u determines.

    steady_rate [rad/s]: that of the angle where u is constant or the curve is its centre.
    """

    def z(t_s):
        x, y = pole(motion, np.asarray(t_s, float)).T
        return x + 1j * y

    nutation = motion.flow.nutation
    period, imaginary, _ = nutation.lattice
    # The pole where u is at e, at the other end (or long after, at its limit), and between: it
    # may pass through the centre at the ends.
    quarter = min(period, imaginary) / 4.0
    at_s = np.array([0.0, min(period / 2.0, 40.0 * quarter), quarter]) - nutation.since
    sizes = np.abs(z(at_s))
    largest = np.max(sizes)
    is_point = largest <= LAST_DIGITS * np.linalg.norm(motion.state.omega_bi_b)
    if nutation.turning.steady or is_point:
        return np.abs(z(t_s)), np.angle(z([0.0]))[0] + steady_rate * t_s
    passes = sizes[:2] <= _AT_CENTRE * largest
    known = np.zeros(1) if abs(z([0.0])[0]) > 0.1 * largest else at_s[2:]

    def signed(t_s):
        return _sign(nutation, t_s, passes) * z(t_s)

    swept = _Swept(motion, turning, z, passes)
    if period < np.inf:
        turn = np.angle(signed(known + period) / signed(known))[0]
        swept.whole = turn + _whole_turns(swept.whole - turn)
    offset = np.angle(signed(known))[0] - swept.until(known)[0]
    offset -= _whole_turns(swept.until(np.zeros(1))[0] + offset)
    turned = swept.until(t_s) + offset
    angle = np.angle(signed(t_s))
    angle = angle + _whole_turns(turned - angle)
    # Near the centre the angle of the pole is rounding.
    near = np.any(passes) & (np.abs(z(t_s)) <= 1e-6 * largest)
    return _sign(nutation, t_s, passes) * np.abs(z(t_s)), np.where(near, turned, angle)


def _sign(nutation, t_s, passes):
    """Return the sign (N,) that a pole has at t_s (N,) after it passed its centre at the ends."""
    period, since = nutation.lattice.period, nutation.since

    def count(tau_s):
        if period == np.inf:
            return passes[0] * np.heaviside(tau_s, 1.0)
        return passes[0] * np.floor(tau_s / period) + passes[1] * np.floor(tau_s / period + 0.5)

    return 1.0 - 2.0 * np.mod(count(since + t_s) - count(since), 2.0)


def _whole_turns(angle):
    """Return the angle [rad] rounded to whole turns."""
    return 2.0 * np.pi * np.rint(angle / (2.0 * np.pi))


class _Swept:
    """
    The angle of a pole [rad], the integral of its rate over the time since the motion began.

    whole [rad]: over a period.  By quadrature from the end e of the nutation to the other, in
    panels that shrink towards both: where the pole comes near its centre, it turns fast.
    """

    def __init__(self, motion, turning, z, passes):
        self._motion, self._turning, self._z = motion, turning, z
        nutation = motion.flow.nutation
        self._period, imaginary, share = nutation.lattice
        self._since = nutation.since
        ends = (nutation.turning.b, nutation.turning.a)[:: 1 if nutation.from_b else -1]
        half = self._period / 2.0
        if self._period == np.inf:
            # After this long u is at its limit to the last bit.
            half = 40.0 / (2.0 * np.pi) * imaginary
            ends = ends[0], nutation.at_limit(nutation.turning.a, nutation.turning.b)
        self._through = [end for end, is_passed in zip(ends, passes, strict=True) if is_passed]
        count = int(np.ceil(5.0 * half / min(self._period, share * imaginary)))
        even = half / count * np.arange(count + 1)
        nearer = half / count * 0.5 ** np.arange(1, 45)
        self._edges = np.unique([*even, *nearer, *(half - nearer)])
        panels = self._panel(self._edges[:-1], self._edges[1:])
        self._sums = np.append(0.0, np.cumsum(panels))
        self.whole = 2.0 * self._sums[-1]

    def until(self, t_s):
        """Return the integral from the start to t_s (N,)."""
        return self._since_e(self._since + t_s) - self._since_e(np.array([self._since]))

    def _since_e(self, tau_s):
        """Return the integral over tau_s (N,) since u was at e."""
        n, r = np.zeros_like(tau_s), tau_s
        if self._period < np.inf:
            n = np.rint(tau_s / self._period)
            r = tau_s - n * self._period
        end = self._edges[-1]
        within = np.minimum(np.abs(r), end)
        k = np.minimum(np.searchsorted(self._edges, within, 'right'), len(self._edges) - 1) - 1
        swept = self._sums[k] + self._panel(self._edges[k], within)
        if self._period == np.inf:
            swept += self._rate(np.array([end]))[0] * (np.abs(r) - within)
        return np.copysign(1.0, r) * swept + n * self.whole

    def _panel(self, start_s, stop_s):
        """Return the integral from start_s to stop_s (N,) by Gauss-Legendre quadrature."""
        length = (stop_s - start_s)[:, None]
        rates = self._rate((start_s[:, None] + length * _NODES).ravel())
        return length[:, 0] * (rates.reshape(-1, len(_NODES)) @ _WEIGHTS)

    def _rate(self, tau_s):
        """Return the rate (N,) [rad/s] at tau_s (N,) since u was at e."""
        x, y, z, w = _attitude(self._motion, tau_s - self._since).T
        u = z * z + w * w - x * x - y * y
        if self._through:
            return self._turning.rate(u, self._through)
        return self._turning.rate_at(u, np.abs(self._z(tau_s - self._since)))
