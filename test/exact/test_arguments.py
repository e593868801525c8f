"""Paladini's sigma, tau, N1 and N2, and the poles of cos theta, by what defines them."""

import mpmath
import numpy as np
import pytest
from cases import rigid
from numpy.polynomial import Polynomial
from scipy.integrate import solve_ivp

from satdyn_ros.dynamics.system import State
from satdyn_ros.exact.arguments import Arguments, poles
from satdyn_ros.exact.cones import Cones
from satdyn_ros.exact.symmetric import Symmetric
from satdyn_ros.kernel import rotation

NAMES = [
    'pal1_two_real_two_complex_H1pos',
    'pal1_four_real_H1neg_mid_interval',
    'pal1_four_real_H1pos_upper_interval',
    'pal1_lagrange_limit_H1_zero',
    'pal1_H2_zero',
    'upside down',
]


def motion_of(name):
    if name == 'upside down':
        # With Z turned over, u and H2 change their signs, and the well is the lower one.
        motion = motion_of('pal1_four_real_H1pos_upper_interval')
        over = rotation.multiply(rotation.about([1.0, 0.0, 0.0], np.pi), motion.state.q_ib)
        start = State(over, motion.state.omega_bi_b)
        return Symmetric.in_potential(motion.A, motion.C, motion.h3, motion.H1, -motion.H2, start)
    case = rigid()[name]
    return Symmetric(case.system, case.start)


def end(motion):
    """Return u where x is 0."""
    nutation = motion.flow.nutation
    return nutation.turning.b if nutation.from_b else nutation.turning.a


def jacobi(name, x, k2):
    return complex(mpmath.ellipfun(name, x, m=k2))


@pytest.mark.parametrize('name', NAMES)
def test_sigma_is_where_cos_theta_is_at_a_pole(name):
    """
    1 + n_i sn^2 is zero at i sigma_i, by mpmath, and 1 +- u has that zero along the motion.

    The divisor of the integrals is 2 i: with l_i = (g +- J3) / A their factor in the precession
    plus or less the spin is 2 sqrt(N_i) / n_i (sec. 1, 3), which ties N_i to the constants.
    """
    motion = motion_of(name)
    found = Arguments.of(motion)
    assert np.all(motion.sigma == found.sigma)
    assert (motion.N1, motion.N2) == tuple(found.N)
    assert np.min(found.N) > 0.0
    is_complex = Cones.of(motion).case == 'complex'
    K = mpmath.ellipk(found.k2)
    for sigma, far, n in zip(found.sigma, found.at_far_end, found.n, strict=True):
        assert 0.0 < sigma < mpmath.ellipk(1.0 - found.k2)
        x = mpmath.mpc(far * K * (2 if is_complex else 1), sigma)
        sn = jacobi('sn', x, found.k2)
        # n is a difference of numbers near 1
        assert abs(1.0 + n * sn**2) < 1e-13 + 4e-15 * abs(sn**2)
    t_s = np.linspace(0.0, motion.period_s, 12)
    x = found.x_rate * (t_s + motion.flow.nutation.since)
    u, e = motion.at(t_s).c_b[:, 2], end(motion)
    pole = 1j * motion.tau
    for sign, sigma, far, n in zip(
        (1.0, -1.0), found.sigma, found.at_far_end, found.n, strict=True
    ):
        if is_complex:
            # (1 + m_i cn x) / (1 + m cn x), m = -1 / cn at the zero and at the pole
            cn = np.array([jacobi('cn', each, found.k2) for each in x])
            at_zero = jacobi('cn', mpmath.mpc(2 * far * K, sigma), found.k2)
            at_pole = jacobi('cn', pole, found.k2)
            shape = (1.0 - cn / at_zero) / (1.0 - cn / at_pole)
            shape *= (1.0 - 1.0 / at_pole) / (1.0 - 1.0 / at_zero)
        else:
            sn2 = np.array([jacobi('sn', each, found.k2) for each in x]) ** 2
            # For H1 = 0 the pole is that of sn.
            at_pole = 0.0 if motion.H1 == 0.0 else 1.0 / jacobi('sn', pole, found.k2) ** 2
            shape = (1.0 + n * sn2) / (1.0 - at_pole * sn2)
            l = (motion.g + sign * (motion.C * motion.r0 + motion.h3)) / motion.A
            factor = l / (1.0 + sign * e) / found.x_rate * (1.0 + at_pole / n)
            N = n * (n + 1.0) * (n + found.k2)
            assert abs(factor) == pytest.approx(2.0 * np.sqrt(N) / abs(n), rel=1e-11)
        np.testing.assert_allclose(1.0 + sign * u, ((1.0 + sign * e) * shape).real, rtol=1e-11)
        np.testing.assert_allclose(shape.imag, 0.0, atol=1e-11)


@pytest.mark.parametrize('name', [*NAMES, 'pal1_asymptotic_to_sleeping_top'])
def test_cos_theta_beside_its_poles(name):
    """
    u'^2 = f(u) integrated through complex time to beside a pole gives it and its residue.

    Beside a simple pole u = residue / (t - pole) - H2 / (4 H1) + O(t - pole); beside the double
    one of H1 = 0 it is -2 A / H2 / (t - pole)^2.
    """
    motion = motion_of(name)
    A, J3, g = motion.A, motion.C * motion.r0 + motion.h3, motion.g
    square = Polynomial([1.0, 0.0, -1.0]) * (2.0 / A)
    f = square * Polynomial([motion.h_prime, motion.H2, motion.H1])
    slope = (f - Polynomial([g / A, -J3 / A]) ** 2).deriv()
    at_s, residues = poles(motion)
    assert len(at_s) == (2 if motion.H1 else 1)
    since = motion.flow.nutation.since
    for pole, residue in zip(at_s, residues, strict=True):
        way, short = pole + since, 1e-4

        def rates(_, y, way=way):
            return [way * y[1], way * slope(y[0]) / 2.0]

        start = [complex(end(motion)), 0j]
        found = solve_ivp(rates, (0.0, 1.0 - short), start, 'DOP853', rtol=1e-12, atol=1e-12)
        u, away = found.y[0, -1], -short * way
        if motion.H1:
            assert abs(residue) == pytest.approx(np.sqrt(A / 2.0 / abs(motion.H1)), rel=1e-14)
            assert u == pytest.approx(residue / away - motion.H2 / (4.0 * motion.H1), abs=1e-3)
        else:
            assert residue == 0.0
            assert u * away**2 == pytest.approx(-2.0 * A / motion.H2, rel=1e-6)


def test_balanced_forces():
    """For a_1 = -a_4, a_2 = -a_3 tau = K' / 2 and sigma_1 + sigma_2 = K' (sec. 13, footnote)."""
    start = State(rotation.about([1.0, 0.0, 0.0], 0.6), np.array([0.1, 0.3, 0.0]))
    motion = Symmetric.in_potential(1.0, 1.4, 0.0, 1.0, 0.0, start)
    roots = Cones.of(motion).roots
    np.testing.assert_allclose(roots, -roots[::-1], atol=1e-14)
    K_prime = float(mpmath.ellipk(1.0 - Arguments.of(motion).k2))
    assert motion.tau == pytest.approx(K_prime / 2.0, rel=1e-13)
    assert np.sum(motion.sigma) == pytest.approx(K_prime, rel=1e-13)


def test_motions_without_poles():
    """The free body's cos theta is a cosine; a constant one has no argument."""
    start = State(rotation.about([1.0, 0.0, 0.0], 0.6), np.array([0.1, 0.3, 0.5]))
    at_s, residues = poles(Symmetric.in_potential(1.0, 1.4, 0.0, 0.0, 0.0, start))
    assert len(at_s) == len(residues) == 0
    with pytest.raises(ValueError, match='cos theta is constant'):
        poles(
            Symmetric.in_potential(1.0, 1.4, 0.0, 1.0, 0.0, State(rotation.IDENTITY, np.zeros(3)))
        )


@pytest.mark.parametrize('H1', [-2.0, 1.0])
def test_a_body_that_passes_through_a_pole(H1):
    """Where cos theta reaches 1 at a real time sigma_2 is 0 and N_2 is at its limit, 0 or inf."""
    start = State(rotation.IDENTITY, np.array([0.3, 0.4, 2.0]))
    motion = Symmetric.in_potential(1.0, 1.5, 0.0, H1, 0.7, start)
    assert motion.sigma[1] == 0.0
    assert motion.N2 in (0.0, np.inf)
    assert 0.0 < motion.N1 < np.inf
