"""What Paladini says besides the attitude, against roots, propagation and integrated equations."""

import numpy as np
import pytest
from cases import rigid
from scipy.integrate import solve_ivp

from satdyn_ros.dynamics.system import State, System
from satdyn_ros.exact.cones import Cones
from satdyn_ros.exact.free import Free
from satdyn_ros.exact.geometry import Rolling
from satdyn_ros.exact.paladini import (
    body_curve,
    companion_top,
    nutation_as_precession,
    oscillation,
    poinsot_rates,
    space_curve,
)
from satdyn_ros.exact.symmetric import Symmetric
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.kernel import rotation
from satdyn_ros.theory.euler_angles import from_zxz

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


ON_THE_VERTICAL = [
    # A, C, h3, H1, H2, rate: the axis passes the vertical
    (1.0, 1.5, 0.0, -2.0, 0.7, [0.3, 0.4, 2.0]),
    (1.0, 1.5, 0.2, -2.0, -0.7, [0.3, -0.4, 0.2]),
    (1.0, 0.6, 0.2, 1.0, 5.0, [0.3, -0.4, 1.2]),
    (1.0, 0.6, 0.0, -1.0, 0.0, [0.0, 0.5, 0.0]),
    # H2 of its top is -5.269
    (1.0, 1.4, 0.0, -0.5, 0.5, [0.3, 0.0, 2.0]),
]


@pytest.mark.parametrize('pole', [[0.0, 0.0, 0.6, 0.8], [1.0, 0.0, 0.0, 0.0]])
@pytest.mark.parametrize(('A', 'C', 'h3', 'H1', 'H2', 'rate'), ON_THE_VERTICAL)
def test_the_companion_of_a_body_that_starts_on_the_vertical(A, C, h3, H1, H2, rate, pole):
    """
    Its constants are those of every later instant, and it nods by the fixed ratio with the body.

    Neither may depend on when the motion is asked: there the precession and spin have no values.
    """
    motion = Symmetric.in_potential(A, C, h3, H1, H2, State(np.array(pole), np.array(rate)))
    top = companion_top(motion)
    for later_s in (0.3, 1.0, 2.5):
        state = motion.at([later_s])[0]
        later = companion_top(Symmetric.in_potential(A, C, h3, H1, H2, state))
        for name in ('H2', 'g', 'h3', 'h_prime'):
            assert getattr(later, name) == pytest.approx(getattr(top, name), rel=1e-10, abs=1e-12)
    t_s = np.array([0.2, 0.5, 1.1, 1.7])
    half, half_top = (
        np.hypot(*each.at(t_s).q_ib[:, :2].T) / np.hypot(*each.at(t_s).q_ib[:, 2:].T)
        for each in (motion, top)
    )
    np.testing.assert_allclose(half_top / half, half_top[0] / half[0], rtol=1e-9)


def test_the_companion_s_constants_by_the_roots():
    """The quartic's roots a_i go to the cubic's (a a_i - 1) / (a - a_i), a the one left out."""
    motion = motion_of('pal1_four_real_H1neg_mid_interval')
    roots, top = Cones.of(motion).roots, companion_top(motion)
    farthest = np.argmax(np.abs(roots))
    a, others = roots[farthest], np.delete(roots, farthest)
    expected = np.sort((a * others - 1.0) / (a - others))
    np.testing.assert_allclose(Cones.of(top).roots, expected, rtol=1e-11)


def cuspidal(rate=(0.0, 0.0, 3.0), H1=0.0, H2=-1.0, C=1.5, h3=0.0):
    """Return a top released at rest of its axis, tilted by 1 rad."""
    start = State(rotation.about([1.0, 0.0, 0.0], 1.0), np.array(rate))
    return Symmetric.in_potential(1.0, C, h3, H1, H2, start)


CUSPS = [
    cuspidal(),
    cuspidal(H1=0.6, H2=0.4),
    cuspidal(H1=-3.0, C=0.8, h3=1.0),
    # A pendulum, whose pole turns back through the centre, over a wide swing and beside the pole
    cuspidal(rate=(0.0, 0.0, 0.0)),
    cuspidal(rate=(0.0, 0.0, 0.0), H1=3.0, H2=-2.0),
]


@pytest.mark.parametrize('start_s', [0.0, 0.3, -0.2])
@pytest.mark.parametrize('released', CUSPS)
def test_the_curves_pass_through_a_cusp(released, start_s):
    """
    Radius and angle make up the pole, and the angle neither jumps nor loses its rate, nor is nan.

    At the cusps, which are among the times, and between, from a start at one and off it.
    """
    period = released.period_s
    motion = Symmetric.in_potential(
        released.A,
        released.C,
        released.h3,
        released.H1,
        released.H2,
        released.at([start_s % period])[0],
    )
    t_s = np.linspace(0.0, 4.0 * period, 401) - start_s
    t_s = t_s[t_s >= 0.0]
    for curve, pole in ((body_curve, motion.pole(t_s)), (space_curve, None)):
        if pole is None:
            states = motion.at(t_s)
            pole = rotation.rotate(states.q_ib, states.omega_bi_b)
        radius, angle = curve(motion, t_s)
        size = np.max(np.abs(radius))
        made_up = radius * np.exp(1j * angle)
        np.testing.assert_allclose(made_up, pole[:, 0] + 1j * pole[:, 1], atol=1e-6 * size)
        # a hundredth of a period apart: no jump of pi
        assert np.max(np.abs(np.diff(angle))) < 0.5
    radius, _ = body_curve(motion, t_s)
    assert np.min(radius) < -0.1 * np.max(radius)


def test_the_curve_of_the_cuspidal_top():
    """
    The angle grows at Delta / A - J3 / 2A = -0.75 rad/s through the cusps of a top with H1 = 0.

    There F = 0: 4 F / rho^2 is zero but at the cusp.
    """
    motion = cuspidal()
    t_s = np.linspace(0.0, 5.0 * motion.period_s, 41)
    _, angle = body_curve(motion, t_s)
    np.testing.assert_allclose(angle, -0.75 * t_s, atol=1e-12)
    rolling = Rolling.of(motion)
    np.testing.assert_allclose(rolling.polar_rate([np.cos(1.0), 0.2]), -0.75, rtol=1e-12)


@pytest.mark.parametrize('push', [1e-4, -1e-4, 1e-9, -1e-9, 1e-14])
def test_beside_a_cusp_the_curve_turns_as_far(push):
    """The integral follows a turn by pi within any time, and within no time there is none."""
    motion = cuspidal(rate=(0.0, push, 3.0))
    t_s = np.linspace(0.0, 20.0 * motion.period_s, 20001)
    pole = motion.pole(t_s)
    radius, angle = body_curve(motion, t_s[::500])
    expected = np.unwrap(np.arctan2(pole[:, 1], pole[:, 0]))[::500]
    if abs(push) > 1e-5:
        np.testing.assert_allclose(angle, expected, atol=1e-8)
        return
    # The steps miss the turn, by -pi at each of twenty passages or by as much the other way.
    turn = -np.pi * np.sign(push) if abs(push) > 1e-12 else 0.0
    assert angle[-1] - angle[0] == pytest.approx(-0.75 * t_s[-1] + 20.0 * turn, abs=0.01)
    assert np.all(radius >= 0.0) == (turn != 0.0)


def test_poinsot_s_rates_at_a_cusp_are_limits():
    """
    One moment is zero and the others are L^2 / 2E: what starts beside the cusp tend to.

    L / I of the first grows like 1 over the push, of either sign.
    """
    rates = poinsot_rates(cuspidal())
    at_cusp = int(np.argmax(np.abs(rates)))
    assert rates[at_cusp] == np.inf
    np.testing.assert_array_equal(np.delete(rates, at_cusp), -0.75)
    for push in (1e-4, -1e-4, 1e-6):
        near = poinsot_rates(cuspidal(rate=(0.0, push, 3.0)))
        assert abs(near[at_cusp] * push) == pytest.approx(np.sin(1.0), rel=2.0 * abs(push) * 1e3)
        np.testing.assert_allclose(np.delete(near, at_cusp), -0.75, atol=10.0 * abs(push))


def test_poinsot_s_rates_of_a_top_that_rises_for_ever():
    """rho_j^2 = -4 x_k x_l and F = -x_1 x_2 x_3 of x = L / I - 2 E / L, finite at two roots."""
    C, r0, H2 = 1.5, 0.8, -3.0
    # h' = -H2 and g = J3: u = 1 is a double root, u_3 = -1 - J3^2 / 2 A H2 = -0.76 the other
    u = 0.1
    rate_across = (C * r0 - C * r0 * u) / (1.0 - u * u)
    energy = -H2 + H2 * u
    nodding = np.sqrt(2.0 * energy - rate_across**2 * (1.0 - u * u))
    theta = np.arccos(u)
    omega = np.array([nodding, rate_across * np.sin(theta), r0])
    motion = Symmetric.in_potential(1.0, C, 0.0, 0.0, H2, State(from_zxz(0.0, theta, 0.0), omega))
    x = poinsot_rates(motion) - (C * r0 / 2.0 - r0)
    assert np.all(np.isfinite(x))
    squares = 2.0 * (motion.h_prime + H2 * Cones.of(motion).roots)
    products = np.array([x[1] * x[2], x[2] * x[0], x[0] * x[1]])
    np.testing.assert_allclose(squares, -4.0 * products, atol=1e-12)
    _, angle = body_curve(motion, np.array([0.0, 3.0, 5.0]))
    np.testing.assert_allclose(np.diff(angle), (C * r0 / 2.0 - r0) * np.array([3.0, 2.0]))


def test_balanced_forces_of_the_footnote():
    """
    Roots a_1 = -a_4, a_2 = -a_3 are Poinsot's triaxial motion, not the limit H1 = H2 = 0.

    The square of the rate of the cosine from L is an even polynomial of degree four along a free
    triaxial body, and of degree two along a symmetric one.
    """
    for moments, degree in (([1.0, 2.0, 2.5], 4), ([1.0, 1.0, 2.5], 2)):
        free = Free(System(np.diag(moments)), State(rotation.IDENTITY, np.array([0.2, 0.3, 1.0])))
        states = free.at(np.linspace(0.0, free.T1, 60))
        H = states.omega_bi_b * np.array(moments)
        cosine = H[:, 2] / free.L
        rate = np.cross(H, states.omega_bi_b)[:, 2] / free.L
        if degree == 2:
            # the axis of a symmetric body keeps its angle from L, and nods about any other axis
            direction = np.array([0.48, 0.6, 0.64])
            seen = rotation.rotate(rotation.conjugate(states.q_ib), direction)
            cosine = seen[:, 2]
            rate = np.cross(seen, states.omega_bi_b)[:, 2]
        c = np.polynomial.Polynomial.fit(cosine, rate**2, 4).convert().coef
        if degree == 4:
            assert abs(c[4]) > 1e-3
            np.testing.assert_allclose(c[[1, 3]], 0.0, atol=1e-7 * np.max(np.abs(c)))
        else:
            np.testing.assert_allclose(c[[3, 4]], 0.0, atol=1e-9 * np.max(np.abs(c)))


def test_where_the_body_nods_farther_than_its_top():
    """
    Paladini's inequality, the body's angle below the top's, holds where the root left out is > 1.

    For H1 < 0 the farthest root is below -1 as often, and then the body's angle is the larger.
    """
    rng, count = np.random.default_rng(5), {True: 0, False: 0}
    for _ in range(40):
        start = State(rotation.normalise(rng.normal(size=4)), rng.normal(size=3))
        H1, H2 = -rng.uniform(0.2, 2.0), rng.normal()
        motion = Symmetric.in_potential(1.0, 1.4, 0.0, H1, H2, start)
        roots = Cones.of(motion).roots
        is_above = bool(roots[-1] > -roots[0])
        top = companion_top(motion)
        assert (motion.theta_limits[1] < top.theta_limits[1]) == is_above
        count[is_above] += 1
    assert min(count.values()) > 5
