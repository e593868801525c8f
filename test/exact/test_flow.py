"""The kernel of the symmetric body and of free rotation against 30-digit quadrature."""

from functools import cache

import mpmath as mp
import numpy as np
import pytest
from numba import njit

from satdyn_ros.dynamics.system import State
from satdyn_ros.exact.half_angles import (
    ROWS,
    Lattice,
    Zero,
    _decay,
    _decaying,
    _left_rate,
    _oscillating,
)
from satdyn_ros.exact.symmetric import Symmetric

ANY, RATE, SLOW = [0.1, 0.5, 0.7, 0.5], [0.3, -0.2, 1.1], [-0.2, 0.4, -0.2]
# A, C, h3, H1, H2, q_ib, omega: one of every pattern of the roots of f
PATTERNS = {
    'two real, two complex': (1.0, 1.5, 0.0, 0.7, 0.3, ANY, RATE),
    'two complex, with a rotor': (1.3, 0.6, -0.8, 0.9, -0.4, ANY, RATE),
    'one root on each side': (1.0, 1.5, 0.0, -0.7, 0.3, ANY, RATE),
    'four inside, the upper two': (
        1.0,
        1.6,
        0.0,
        8.0,
        0.4,
        [0.1, 0.3, 0.3, 0.9],
        [-0.2, 0.4, -0.2],
    ),
    'four inside, the lower two': (
        1.0,
        1.6,
        0.0,
        8.0,
        0.4,
        [0.3, 0.9, 0.1, 0.3],
        [-0.2, 0.4, -0.2],
    ),
    'two above 1': (1.0, 0.9, 0.0, 0.05, -2.0, ANY, [0.3, -0.2, 4.0]),
    'two below -1': (1.0, 0.9, 0.0, 0.05, 2.0, ANY, [0.3, -0.2, 4.0]),
    'cubic': (1.0, 0.5, 0.0, 0.0, -2.0, [0.1, 0.1, 0.7, 0.7], [0.3, -0.2, 3.0]),
    'quadratic': (1.0, 1.5, 0.0, 0.0, 0.0, ANY, RATE),
    'long period': (1.0, 1.6, 0.0, 1.0, 0.0, [0.5, 0.5, 0.5, 0.5], [-1e-5, 0.0, 0.1]),
    'small nutation': (1.0, 1.6, 0.0, 0.9, -1.463, [0.6, 0.0, 0.0, 0.8], [0.01, 0.52, 1.2]),
    'beside a pole': (1.0, 1.6, 0.0, 0.9, -1.46, [0.0, 1e-7, 0.6, 0.8], [1.0, 0.3, 1.2]),
}


def motion_of(pattern):
    A, C, h3, H1, H2, q, omega = PATTERNS[pattern]
    q = np.array(q) / np.linalg.norm(q)
    return Symmetric.in_potential(A, C, h3, H1, H2, State(q, np.array(omega)))


def roots_of(f):
    """Return the roots of the polynomial f, highest first: eigenvalues of its companion."""
    companion = mp.zeros(len(f) - 1)
    for i in range(len(f) - 1):
        companion[0, i] = -f[i + 1] / f[0]
        if i > 0:
            companion[i, i - 1] = 1
    with mp.workdps(60):
        return list(mp.eig(companion, left=False, right=False))


@cache
def truth(pattern):
    """
    Return the turning points b, a, the period and the means of u, s+' and s-', with 30 digits.

    From the integrals of the motion alone (Paladini 1888, ch. 1): with u = (a + b)/2
    - (a - b)/2 cos(phi), the integrals du / sqrt(f) are those of 1 / sqrt(Q) over phi, f =
    (a - u)(u - b) Q.
    """
    with mp.workdps(30):
        A, C, h3, H1, H2 = (mp.mpf(x) for x in PATTERNS[pattern][:5])
        state = motion_of(pattern).state
        x, y, z, w = (mp.mpf(v) for v in state.q_ib)
        norm = mp.sqrt(x * x + y * y + z * z + w * w)
        x, y, z, w = x / norm, y / norm, z / norm, w / norm
        p, q, r = (mp.mpf(v) for v in state.omega_bi_b)
        gamma = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)
        u0, J3 = gamma[2], C * r + h3
        g = A * (p * gamma[0] + q * gamma[1]) + J3 * u0
        h = A / 2 * (p * p + q * q) - H1 * u0**2 - H2 * u0
        f = [-2 * H1 / A, -2 * H2 / A, 2 * (H1 - h) / A - (J3 / A) ** 2]
        f += [2 * H2 / A + 2 * g * J3 / A**2, 2 * h / A - (g / A) ** 2]
        f = f[next(i for i in range(5) if f[i] != 0) :]
        others = roots_of(f)
        real = [mp.re(root) for root in others if abs(mp.im(root)) < mp.mpf(10) ** -25]
        a = min(root for root in real if root > u0 - mp.mpf(10) ** -25)
        b = max(root for root in real if root < u0 + mp.mpf(10) ** -25)
        for end in (a, b):
            others.remove(min(others, key=lambda root: abs(root - end)))

        def over_a_period(value):
            def integrand(phi):
                u = (a + b) / 2 - (a - b) / 2 * mp.cos(phi)
                Q = abs(f[0] * mp.fprod(u - root for root in others))
                return 2 * value(u) / mp.sqrt(Q)

            return mp.quad(integrand, [0, mp.pi / 2, mp.pi])

        period = over_a_period(lambda u: 1)
        mean_u = over_a_period(lambda u: u) / period
        plus = r - J3 / A + (g + J3) / A * over_a_period(lambda u: 1 / (1 + u)) / period
        minus = J3 / A - r + (g - J3) / A * over_a_period(lambda u: 1 / (1 - u)) / period
        return 1 + b, 1 - a, period, mean_u, plus, minus


@pytest.mark.parametrize('pattern', PATTERNS)
def test_period_and_means(pattern):
    """Proves turning points, period and mean rates for every pattern of roots, by quadrature."""
    motion = motion_of(pattern)
    above_minus_1, below_1, period, mean_u, plus, minus = truth(pattern)
    flow, nutation = motion.flow, motion.flow.nutation
    # a double root's distance halves the digits: 'long period' has m1 = 5e-11
    rel = 1e-9 if pattern == 'long period' else 1e-13
    assert nutation.turning.from_below[0] == pytest.approx(float(above_minus_1), rel=1e-12)
    assert nutation.turning.from_above[0] == pytest.approx(float(below_1), rel=1e-12)
    assert motion.period_s == pytest.approx(float(period), rel=rel)
    assert nutation.integral([motion.period_s])[0] / motion.period_s == pytest.approx(
        float(mean_u), rel=rel, abs=1e-13
    )
    assert flow.mean_plus == pytest.approx(float(plus), rel=rel, abs=1e-13)
    assert flow.mean_minus == pytest.approx(float(minus), rel=rel, abs=1e-13)


@pytest.mark.parametrize('pattern', PATTERNS)
def test_integral_of_u(pattern):
    """Proves the third-kind integral of u at any time, back and forth, by Gauss's rule on u."""
    motion = motion_of(pattern)
    t_s = np.array([11.0, 0.3, 4.0, 1.0, 29.0])
    nodes, weights = np.polynomial.legendre.leggauss(12)
    panels = np.linspace(0.0, 1.0, 400)
    x = (panels[:-1, None] + (nodes + 1.0) / 2.0 * panels[1]).ravel()
    # |u| <= 1: the rule's and the formula's rounding are below 1e-15 of the time
    bound = 1e-12 if pattern == 'long period' else 3e-14
    for t in t_s:
        alpha, beta, _ = motion.flow.at(t * x)
        u = np.abs(alpha) ** 2 - np.abs(beta) ** 2
        rule = t * panels[1] / 2.0 * np.sum(np.tile(weights, len(panels) - 1) * u)
        assert motion.flow.nutation.integral([t])[0] == pytest.approx(rule, abs=bound * t)
    together = motion.flow.nutation.integral(t_s)
    assert np.array_equal(together, [motion.flow.nutation.integral([t])[0] for t in t_s])


def test_integral_of_an_asymptotic_u():
    """Proves the integral where the period is infinite: a top that falls, rises and sleeps."""
    omega = np.array([1.5223337347638329, 0.75, 1.0])
    start = State(np.array([0.6, 0.0, 0.0, 0.8]), omega)
    top = Symmetric.in_potential(1.0, 1.0, 0.0, 0.0, -2.0, start)
    assert top.period_s is None
    # f = 4 (1 - u)^2 (u + 3/4) gives 1 - u = (7/4) sech^2 k(t - t0), 1 - u0 = 0.72, falling.
    k = np.sqrt(7.0) / 2.0
    t0 = np.arccosh(np.sqrt(1.75 / 0.72)) / k
    t_s = np.array([0.1, 1.0, 5.0, 30.0, 400.0])
    expected = t_s - 1.75 / k * (np.tanh(k * (t_s - t0)) + np.tanh(k * t0))
    assert top.flow.nutation.integral(t_s) == pytest.approx(expected, rel=1e-14, abs=1e-14)


def test_triple_root():
    """Proves the slow, algebraic rise of a top of critical spin; no two roots stay apart there."""
    H1, H2, x = 0.5, -1.125, 0.3
    w, spin = np.sqrt(1.0 - x * x), np.sqrt(-4.0 * (2.0 * H1 + H2))
    u0, q = 1.0 - 2.0 * x * x, spin * x / w
    p = -np.sqrt(2.0 * (H1 * (u0**2 - 1.0) + H2 * (u0 - 1.0)) - q * q)
    start = State(np.array([x, 0.0, 0.0, w]), np.array([p, q, spin]))
    top = Symmetric.in_potential(1.0, 1.0, 0.0, H1, H2, start)
    t_s = np.array([0.0, 1.0, 10.0, 50.0])
    alpha, beta, _ = top.flow.at(t_s)
    u, one_minus_u = np.abs(alpha) ** 2 - np.abs(beta) ** 2, 2.0 * np.abs(beta) ** 2
    # f = (1 - u)^3 (u + 3/4): sqrt((u + 3/4) / (1 - u)) grows by 7/8 a second.
    root = np.sqrt((u + 0.75) / one_minus_u)
    assert root == pytest.approx(root[0] + 0.875 * t_s, rel=1e-11)


@pytest.mark.parametrize('pattern', PATTERNS)
def test_a_row_depends_on_its_time_alone(pattern):
    """Proves that a time has the same bits alone and among thousands, and any order serves."""
    motion = motion_of(pattern)
    t_s = np.random.default_rng(7).uniform(0.0, 1e4, 1001)
    states = motion.at(t_s)
    for i in (0, 500, 1000):
        alone = motion.at(t_s[i])
        assert np.array_equal(alone.q_ib[0], states.q_ib[i])
        assert np.array_equal(alone.omega_bi_b[0], states.omega_bi_b[i])


@njit
def oscillating(at, lattice, zero):
    """Return a number and its slope at some times, by the series that oscillates."""
    return _oscillating(at, lattice, zero)


@njit
def decaying(at, lattice, zero):
    """Return a number and its slope at one time, by the series that decays."""
    decay = np.empty((3, ROWS))
    _decay(at, lattice, decay)
    value, slope = _decaying(at, decay, lattice, zero)[:, 0]
    rate = _left_rate(lattice, zero)
    turn = np.exp(1j * rate * at[0])
    return turn * value, turn * (slope + 1j * rate * value)


@pytest.mark.parametrize('at_end', [False, True])
@pytest.mark.parametrize('share', [1.0, 0.5])
@pytest.mark.parametrize('imaginary', [0.4, 1.0, 2.5])
def test_both_series_are_one_function(share, at_end, imaginary):
    """Proves Jacobi's imaginary transformation: the two series differ by a real factor only."""
    lattice = Lattice(1.0, imaginary, share)
    for height in (0.0, 0.13, 0.5):
        whole = share * imaginary
        zeros = [
            Zero(1.0, height * whole, (1.0 - height) * whole, at_end, 0.0),
            # any other: the real factor is the same for all numbers of a lattice
            Zero(-1.0, 0.3 * whole, 0.7 * whole, False, 0.0),
        ]
        quotients = []
        for r in (-0.41, -0.2, 0.1, 0.33, 0.47):
            at = np.array([r])
            (a, da), (b, db) = (oscillating(at, lattice, zero)[:, 0] for zero in zeros)
            (c, dc), (d, dd) = (decaying(at, lattice, zero) for zero in zeros)
            quotients.append((a / b) / (c / d))
            assert (da * b - a * db) * d**2 / b**2 * quotients[0] ** -1 == pytest.approx(
                dc * d - c * dd, rel=1e-12, abs=1e-12
            )
        assert np.array(quotients) == pytest.approx(np.full(5, quotients[0]), rel=1e-12)


@pytest.mark.parametrize('at_end', [False, True])
@pytest.mark.parametrize('share', [1.0, 0.5])
def test_theta_function_against_mpmath(share, at_end):
    """Proves the series and its slope against mpmath's theta functions of complex time."""
    lattice, height, r = Lattice(1.3, 1.7, share), 0.23, 0.31
    zero = Zero(1.0, height, share * 1.7 - height, at_end, 0.0)
    (value, other), (slope, _) = oscillating(np.array([r, -0.2]), lattice, zero)
    nome = mp.exp(1j * mp.pi * ((0.0 if share == 1.0 else 0.5) + 1j * share * 1.7 / 1.3))

    def theta(t):
        z = mp.pi * (t - 1j * height - (0.65 if at_end else 0.0)) / 1.3
        return mp.exp(-1j * mp.pi * t / 1.3) * mp.jtheta(1, z, nome)

    expected = theta(r)
    assert slope / value == pytest.approx(complex(mp.diff(theta, r) / expected), rel=1e-13)
    assert other / value == pytest.approx(complex(theta(-0.2) / expected), rel=1e-13)
