"""What Paladini says besides the attitude, against roots, propagation and integrated equations."""

import numpy as np
import pytest
from cases import rigid
from scipy.integrate import solve_ivp

from satdyn_ros.dynamics import rotation
from satdyn_ros.dynamics.euler import from_zxz
from satdyn_ros.dynamics.propagator import Propagation
from satdyn_ros.dynamics.system import State, System
from satdyn_ros.exact.cones import Cones
from satdyn_ros.exact.paladini import (
    body_curve,
    companion_top,
    nutation_as_precession,
    oscillation,
    poinsot_rates,
    space_curve,
)
from satdyn_ros.exact.symmetric import Symmetric

Z = np.array([0.0, 0.0, 1.0])
FLOWN = [
    'pal1_two_real_two_complex_H1pos',
    'pal1_four_real_H1neg_mid_interval',
    'pal1_four_real_H1pos_upper_interval',
    'pal1_lagrange_limit_H1_zero',
    'pal1_H2_zero',
]


def motion_of(name):
    case = rigid()[name]
    return Symmetric(case.system, case.start)


@pytest.mark.parametrize(
    ('name', 'case', 'interval', 'count'),
    [
        ('pal1_two_real_two_complex_H1pos', 'complex', (1, 2), 2),
        ('pal1_four_real_H1neg_mid_interval', 'gamma', (2, 3), 4),
        ('pal1_four_real_H1pos_upper_interval', 'beta', (3, 4), 4),
        ('pal1_lagrange_limit_H1_zero', 'alpha', (1, 2), 3),
        ('pal1_asymptotic_to_sleeping_top', 'alpha', (1, 2), 3),
    ],
)
def test_limiting_cones(name, case, interval, count):
    """Roots, case and interval of sec. 1: the axis stays between these two and reaches both."""
    motion = motion_of(name)
    cones = Cones.of(motion)
    assert (cones.case, cones.interval, len(cones.roots)) == (case, interval, count)
    real = np.sort([z.real for z in motion.roots if abs(z.imag) < 1e-6])
    # np.roots has the double root of the separatrix to the root of rounding
    np.testing.assert_allclose(cones.roots, real, atol=2e-8)
    period = motion.period_s or 60.0
    u = motion.at(np.linspace(0.0, period, 4001)).c_b[:, 2]
    bounds = cones.roots[[interval[0] - 1, interval[1] - 1]]
    assert np.min(u) >= bounds[0] - 1e-12
    assert np.max(u) <= bounds[1] + 1e-12
    if motion.period_s:
        np.testing.assert_allclose([np.min(u), np.max(u)], bounds, atol=1e-6)
    inside = cones.thetas[~np.isnan(cones.thetas)]
    np.testing.assert_allclose(np.cos(inside), cones.roots[np.abs(cones.roots) <= 1.0])


def test_modulus_of_four_real_roots():
    """k^2 of sec. 2 from the roots: beta by the indices 3 4 1 2 of alpha, gamma by 2 3 4 1."""
    for name in ('pal1_four_real_H1pos_upper_interval', 'pal1_four_real_H1neg_mid_interval'):
        cones = Cones.of(motion_of(name))
        a1, a2, a3, a4 = cones.roots
        if cones.case == 'gamma':
            expected = (a3 - a2) * (a4 - a1) / ((a4 - a2) * (a3 - a1))
        else:
            expected = (a2 - a1) * (a4 - a3) / ((a4 - a2) * (a3 - a1))
        assert cones.k**2 == pytest.approx(expected, rel=1e-12)


def test_modulus_of_two_complex_roots():
    """k^2 of sec. 7 from the real roots and the complex pair."""
    motion = motion_of('pal1_two_real_two_complex_H1pos')
    a1, a2 = Cones.of(motion).roots
    z = next(z for z in motion.roots if z.imag > 0.1)
    product = abs(a1 - z) * abs(a2 - z)
    expected = (1.0 - ((a1 - z.real) * (a2 - z.real) + z.imag**2) / product) / 2.0
    assert Cones.of(motion).k ** 2 == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize('name', FLOWN)
def test_two_uniform_rotations_and_an_oscillation(name):
    """The oscillation has the period of the nutation and makes up the propagated attitude."""
    motion = motion_of(name)
    t_s = np.linspace(0.0, 2.0 * motion.period_s, 41)
    angles = oscillation(motion, t_s)
    later = oscillation(motion, t_s + motion.period_s)
    np.testing.assert_allclose(rotation.wrap(later - angles), 0.0, atol=1e-11)
    q = rotation.multiply(rotation.about(Z, motion.Om_P * t_s), from_zxz(*angles.T))
    q = rotation.multiply(q, rotation.about(Z, motion.Om_S * t_s))
    truth = Propagation(motion.system, motion.state, 0.0, 1e-14).at(t_s)
    assert np.max(rotation.angle_between(q, truth.q_ib)) < 1e-10


@pytest.mark.parametrize('name', FLOWN)
@pytest.mark.parametrize('curve', [body_curve, space_curve])
def test_the_curves_of_the_pole(name, curve):
    """Radius and continuous angle of the propagated pole in the body and across Z (41, 42)."""
    motion = motion_of(name)
    t_s = np.linspace(0.0, 3.0 * motion.period_s, 3001)
    states = Propagation(motion.system, motion.state, 0.0, 1e-14).at(t_s)
    pole = states.omega_bi_b
    if curve is space_curve:
        pole = rotation.rotate(states.q_ib, pole)
    radius, angle = curve(motion, t_s[::100])
    expected = np.unwrap(np.arctan2(pole[:, 1], pole[:, 0]))[::100]
    np.testing.assert_allclose(radius, np.hypot(pole[:, 0], pole[:, 1])[::100], atol=1e-10)
    np.testing.assert_allclose(angle, expected, atol=1e-9)


@pytest.mark.parametrize(
    'name', ['pal1_four_real_H1neg_mid_interval', 'pal1_H2_zero', 'pal1_lagrange_limit_H1_zero']
)
def test_the_companion_top(name):
    """
    A propagated heavy top nods with the body, by the fixed ratio of tan(theta / 2) (sec. 13).

    Half sum and difference of precession and spin differ by what grows uniformly.
    """
    motion = motion_of(name)
    top = companion_top(motion)
    assert top.H1 == 0.0
    t_s = np.linspace(0.0, 2.0 * motion.period_s, 61)
    ours = Propagation(motion.system, motion.state, 0.0, 1e-14).at(t_s)
    theirs = top.at(t_s)
    half, half_top = (
        np.hypot(states.q_ib[:, 0], states.q_ib[:, 1])
        / np.hypot(states.q_ib[:, 2], states.q_ib[:, 3])
        for states in (ours, theirs)
    )
    np.testing.assert_allclose(half_top / half, half_top[0] / half[0], rtol=1e-9)
    for x, y in ((3, 2), (0, 1)):
        gone, gone_top = (
            np.unwrap(np.arctan2(states.q_ib[:, y], states.q_ib[:, x]))
            for states in (ours, theirs)
        )
        apart = gone_top - gone
        uniform = apart[0] + (apart[-1] - apart[0]) * t_s / t_s[-1]
        np.testing.assert_allclose(apart, uniform, atol=1e-8)
    # The closed form of the top, in turn, is what its equations give.
    heavy = Propagation(
        System(
            top.system.inertia, top.system.rotors, top.system.orbit, np.array([0.0, 0.0, -top.H2])
        ),
        top.state,
        0.0,
        1e-14,
    ).at(t_s)
    assert np.max(rotation.angle_between(heavy.q_ib, theirs.q_ib)) < 1e-9


@pytest.mark.parametrize('name', ['pal1_four_real_H1pos_upper_interval', 'lower'])
def test_the_poinsot_motion_behind_the_nutation(name):
    """The projection of its axis across L turns at sqrt(H1 / 2A) cos theta (sec. 4)."""
    motion = motion_of('pal1_four_real_H1pos_upper_interval')
    if name == 'lower':
        # With Z turned over, u and H2 change their signs.
        over = rotation.multiply(rotation.about([1.0, 0.0, 0.0], np.pi), motion.state.q_ib)
        start = State(over, motion.state.omega_bi_b)
        motion = Symmetric.in_potential(
            motion.A, motion.C, motion.h3, motion.H1, -motion.H2, start
        )
    assert Cones.of(motion).case == {'lower': 'alpha'}.get(name, 'beta')
    end, rates = nutation_as_precession(motion)
    t_s = np.linspace(0.0, 3.0 * motion.period_s, 200)
    expected = np.sqrt(motion.H1 / (2.0 * motion.A)) * motion.at(t_s).c_b[:, 2]
    # the axis' height over the plane across L, and its share of the other two
    square = (expected[0] - end) / (expected[0] - rates[0])
    others = np.linalg.solve(
        np.array([[1.0, 1.0], rates[1:]]), [1.0 - square, end - rates[0] * square]
    )
    gamma_0 = np.sqrt([square, *others])
    rising = (expected[1] - expected[0]) * (rates[2] - rates[1]) * (end - rates[0]) > 0.0
    gamma_0[1] *= 1.0 if rising else -1.0
    flown = solve_ivp(
        lambda _, gamma: np.cross(gamma, rates * gamma),
        (0.0, t_s[-1]),
        gamma_0,
        'DOP853',
        t_s,
        rtol=1e-12,
        atol=1e-14,
    ).y
    precession = (rates[1:] @ flown[1:] ** 2) / (1.0 - flown[0] ** 2)
    np.testing.assert_allclose(precession, expected, atol=1e-8 * np.max(np.abs(rates)))


@pytest.mark.parametrize(
    'name', ['pal1_four_real_H1neg_mid_interval', 'pal1_two_real_two_complex_H1pos']
)
def test_no_real_poinsot_motion_is_behind_other_nutations(name):
    """The constants would be complex."""
    with pytest.raises(ValueError, match='real for H1 > 0 and four real roots'):
        nutation_as_precession(motion_of(name))


def test_no_companion_where_all_roots_are_between_the_poles():
    """Four real roots in (-1, 1) have no companion: the paper's condition is not enough."""
    with pytest.raises(ValueError, match='no real root beyond'):
        companion_top(motion_of('pal1_four_real_H1pos_upper_interval'))


def test_the_herpolhode_of_a_heavy_top():
    """
    For H1 = 0 the body's curve is the herpolhode, twice as large, of integrated Euler equations.

    Euler's equations and the angle of the contact point, by SciPy to 1e-11, for the moments that
    the rates L / I_j name with L = 1.
    """
    motion = motion_of('pal1_lagrange_limit_H1_zero')
    D = poinsot_rates(motion)
    t_s = np.linspace(0.0, 2.0 * motion.period_s, 81)
    rho, sigma = body_curve(motion, t_s)
    d = motion.C * motion.r0 / (2.0 * motion.A) - motion.r0
    # direction cosines m_j of L in the body: sum m^2 = 1, sum D m^2 = d, sum D^2 m^2 = omega^2
    omega_square = (rho[0] / 2.0) ** 2 + d**2
    squares = np.linalg.solve(np.array([D**0, D, D**2]), [1.0, d, omega_square])
    assert np.min(squares) > 0.0
    m0 = np.sqrt(squares)

    def rates(t, y):
        m = y[:3]
        m_dot = np.cross(m, D * m)
        omega, omega_dot = D * m, D * m_dot
        across = omega @ omega - d**2
        return [*m_dot, omega_dot @ m_dot / across]

    growing, compared = rho[1] > rho[0], 0
    for sign in (1.0, -1.0):
        start = [sign * m0[0], m0[1], m0[2], sigma[0]]
        found = solve_ivp(rates, (0.0, t_s[-1]), start, 'DOP853', t_s, rtol=1e-11, atol=1e-13)
        omega = found.y[:3].T * D
        radius = np.sqrt(np.maximum(np.sum(omega**2, axis=-1) - d**2, 0.0))
        if (radius[1] > radius[0]) == growing:
            np.testing.assert_allclose(2.0 * radius, rho, rtol=1e-7)
            np.testing.assert_allclose(found.y[3], sigma, atol=1e-6)
            compared += 1
    assert compared == 1


def test_a_herpolhode_needs_a_heavy_top():
    with pytest.raises(ValueError, match='for H1 = 0'):
        poinsot_rates(motion_of('pal1_H2_zero'))
