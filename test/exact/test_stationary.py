"""The stationary motions against 30-digit integrations, the paper's equations and propagation."""

import numpy as np
import pytest
from agreement import assert_agrees
from cases import bounded, newtonian
from draws import (
    angles,
    attitudes,
    body_axes,
    inertia_in_body_axes,
    moments,
    powers_of_ten,
    signs,
)
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from satdyn_ros.dynamics.inertia import principal_axes
from satdyn_ros.dynamics.integrals import first_integrals
from satdyn_ros.dynamics.rotor import Rotor
from satdyn_ros.dynamics.system import State, System
from satdyn_ros.exact import recognise
from satdyn_ros.exact.multiplier import alphas, differences
from satdyn_ros.exact.stationary import Stationary
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import FixedDirection, KeplerOrbit
from satdyn_ros.theory.euler_angles import from_zxz, zxz_angles

CASES = {
    name: newtonian()[name]
    for name in bounded(newtonian(), 'bound_exact')
    if newtonian()[name].raw['source'] == 'Agostinelli 1977'
}
BODY = np.array([1.0, 1.5, 2.0])
TURNED = rotation.normalise([0.3, -0.5, 0.2, 0.9])
SOME = rotation.normalise([0.4, 0.1, -0.6, 0.7])


def system(moments=BODY, gradient=1.0, q_bp=rotation.IDENTITY):
    return System(inertia_in_body_axes(moments, q_bp), orbit=FixedDirection(gradient))


@pytest.mark.parametrize('name', CASES)
def test_reference_cases(name):
    """Proves attitude and rate at every listed time of Agostinelli's cases."""
    case = CASES[name]
    states = Stationary(case.system, case.start).at(case.t_s)
    assert np.max(rotation.angle_between(states.q_ib, case.q_ib)) <= case.bound_exact
    off = np.linalg.norm(states.omega_bi_b - case.omega_bi_b, axis=-1)
    assert np.all(off <= 10.0 * case.bound_exact * np.linalg.norm(case.omega_bi_b, axis=-1))


@pytest.mark.parametrize('name', CASES)
def test_reference_cases_in_other_body_axes(name):
    """Proves that the principal axes may lie anywhere in the body, in any order."""
    case = CASES[name]
    q_bp = rotation.multiply(rotation.about([0.6, 0.0, 0.8], 2.1), TURNED)
    turned = System(
        inertia_in_body_axes(np.diagonal(case.system.inertia), q_bp), orbit=case.system.orbit
    )
    start = State(
        rotation.multiply(case.start.q_ib, rotation.conjugate(q_bp)),
        rotation.rotate(q_bp, case.start.omega_bi_b),
    )
    states = Stationary(turned, start).at(case.t_s)
    q_ip = rotation.multiply(states.q_ib, q_bp)
    assert np.max(rotation.angle_between(q_ip, case.q_ib)) <= case.bound_exact


@pytest.mark.parametrize('name', [name for name in CASES if 'separatrix' not in name])
def test_constants_have_the_values_of_the_paper(name):
    """Proves nu, alphas, e, c0, m, lam, period and the integrals h, c1, c2 against references."""
    case = CASES[name]
    motion, given = Stationary(case.system, case.start), case.raw['closed_form_params']
    integrals = case.raw['first_integrals']
    # near a pole of nu the alphas lose 1 / N = 100 times the rounding of nu
    pairs = {
        'omega0': motion.omega_0,
        'nu': motion.nu,
        'alpha1': motion.alpha[0],
        'alpha2': motion.alpha[1],
        'alpha3': motion.alpha[2],
        'e': motion.e,
        'c0': motion.c0,
        'lam': motion.lam,
        'm': motion.m,
        'period_gamma': motion.period_s,
        'h_energy': motion.h,
    }
    for key, value in pairs.items():
        assert value == pytest.approx(float(given[key]), rel=1e-13, abs=1e-15), key
    assert np.sign(motion.mu) == given['sign_mu']
    assert motion.m + motion.m1 == pytest.approx(1.0, abs=1e-15)
    assert motion.h == pytest.approx(float(integrals['energy']['value']), rel=1e-13)
    assert motion.c1 == pytest.approx(float(integrals['area_H_dot_gamma']['value']), rel=1e-13)
    assert motion.c2 == pytest.approx(float(integrals['F2']['value']), rel=1e-13)


# nu of both ranges for a positive gradient, then of both for a negative one
MULTIPLIERS = [
    (2.5, 0.1, 1),
    (2.5, -0.7, -1),
    (2.5, 0.4, 1),
    (2.5, 0.4, -1),
    (-2.5, 0.3, 1),
    (-2.5, 0.3, -1),
    (-2.5, 0.7, 1),
    (-2.5, 1.9, -1),
]


@pytest.mark.parametrize(('gradient', 'nu', 'sign'), MULTIPLIERS)
def test_the_energy_is_stationary(gradient, nu, sign):
    """
    Proves what defines the motion: h has no first variation beside the constraints.

    grad h = lambda grad |gamma|^2 + mu grad c1 + nu grad c2, with respect to omega and gamma.
    """
    motion = Stationary.from_attitude(system(gradient=gradient), nu, SOME, sign)
    I, square = BODY, gradient
    omega, gamma = motion.state.omega_bi_b, rotation.rotate(rotation.conjugate(SOME), [0, 0, 1.0])
    of_omega = I * omega - motion.mu * I * gamma - 2.0 * nu * I**2 * omega
    of_gamma = (
        square * I * gamma
        - 2.0 * motion.lambda_ * gamma
        - motion.mu * I * omega
        + 2.0 * nu * square * np.prod(I) / I * gamma
    )
    # the terms are up to 100
    np.testing.assert_allclose(of_omega, 0.0, atol=5e-14)
    np.testing.assert_allclose(of_gamma, 0.0, atol=5e-14)


@pytest.mark.parametrize(('gradient', 'nu', 'sign'), MULTIPLIERS)
def test_the_energy_determines_the_motion(gradient, nu, sign):
    """Proves (19), (20), (27): nu and h give c0, c1 and c2 of the motion that has them."""
    motion = Stationary.from_attitude(system(gradient=gradient), nu, SOME, sign)
    same = Stationary.from_energy(system(gradient=gradient), nu, motion.h, 0.4, 1.0, sign)
    for name in ('h', 'c0', 'c1', 'c2', 'e', 'm', 'lam', 'period_s'):
        assert getattr(same, name) == pytest.approx(getattr(motion, name), rel=1e-11), name
    drifts = first_integrals(motion.system, motion.at([0.0, 3.0, 50.0]))
    for name, value in (('energy', motion.h), ('area', motion.c1), ('fourth', motion.c2)):
        np.testing.assert_allclose(drifts[name], value, rtol=1e-12)


def test_the_energy_that_determines_nothing_is_refused():
    """Proves that nu = 0 and a root of D3, nu = -0.7026 for this body, want c0 in place of h."""
    D3 = [4.0 * np.prod(BODY), 0.0, -np.sum(BODY), 1.0]
    root = float(np.min(np.roots(D3).real))
    assert root == pytest.approx(-0.7026, abs=1e-4)
    for nu in (0.0, root):
        with pytest.raises(ValueError, match='give c0 instead'):
            Stationary.from_energy(system(), nu, 2.0)
    with pytest.raises(ValueError, match='c0 is'):
        Stationary.from_energy(system(), 0.1, 1e3)


@pytest.mark.parametrize('nu', [0.1, 0.4])
def test_nu_of_a_positive_gradient_is_refused_for_a_negative_one(nu):
    """Proves that the ranges change places with the sign of the field."""
    with pytest.raises(ValueError, match='between the two least or above the greatest'):
        Stationary.from_attitude(system(gradient=-1.0), nu, SOME)


def test_the_pull_averaged_over_an_orbit_is_recognised():
    """Proves that a start of De Brun's class in a negative gradient finds its closed form."""
    motion = Stationary.from_attitude(system(gradient=-3e-6), 0.3, SOME)
    found = recognise(motion.system, motion.state)
    assert isinstance(found, Stationary)
    assert found.nu == pytest.approx(0.3, rel=1e-13)


@pytest.mark.parametrize(('nu', 'c0', 'sign'), [(0.1, -0.1, 1), (-2.0, 0.9, 1), (0.4, -0.5, -1)])
def test_from_the_constants_of_the_paper(nu, c0, sign):
    """Proves that a motion made of nu, c0, phase, psi0 has them, and the energy of eq. 16."""
    # a small turn leaves the order of the axes, so that axis 3 has the moment 2
    body = system(q_bp=rotation.about([0.6, 0.0, 0.8], 0.3))
    motion = Stationary.from_constants(body, nu, c0, 0.7, 1.2, sign)
    assert motion.nu == pytest.approx(nu, rel=1e-13)
    assert motion.c0 == pytest.approx(c0, rel=1e-12)
    assert np.sign(motion.mu) == sign
    A, B, C = motion.moments
    N = np.prod(1.0 - 2.0 * nu * motion.moments)
    D3 = 1.0 - (A + B + C) * nu + 4.0 * A * B * C * nu**3
    of_energy = 2.0 * motion.h - C * (motion.alpha[2] ** 2 + 1.0)
    assert motion.c0 == pytest.approx(nu * of_energy * sign * np.sqrt(N) / D3, rel=1e-12)
    # a phase is a time
    later = Stationary.from_constants(body, nu, c0, 0.7 + 0.3 * motion.lam, 1.2, sign)
    gamma_later = later.at(0.0).c_b
    np.testing.assert_allclose(motion.at(0.3).c_b, gamma_later, atol=1e-13)


def test_psi0_is_the_precession_of_axis_3():
    """Proves the datum psi0 in principal body axes."""
    motion = Stationary.from_constants(system(), 0.1, -0.1, 0.7, 1.2)
    assert zxz_angles(motion.state.q_ib)[0] == pytest.approx(1.2, abs=1e-14)


def test_one_nu_many_orders_of_the_moments():
    """Proves that the names of the axes play no part: all six orders give one motion."""
    t_s = np.linspace(0.0, 40.0, 30)
    heights = []
    for order in [(0, 1, 2), (1, 2, 0), (2, 0, 1), (0, 2, 1), (2, 1, 0), (1, 0, 2)]:
        # an odd order is a mirrored body: turn one axis over
        R = np.eye(3)[list(order)]
        R[0] *= np.linalg.det(R)
        q_ib = rotation.multiply(SOME, rotation.conjugate(rotation.from_matrix(R)))
        motion = Stationary.from_attitude(system(BODY[list(order)]), 0.4, q_ib)
        heights.append((motion.at(t_s).c_b @ R) ** 2)
    np.testing.assert_allclose(heights, [heights[0]] * 6, atol=1e-13)


def test_nu_zero_is_uniform_rotation_about_the_field():
    """Proves nu = 0: the rate omega_0 along gamma in any attitude, gamma constant."""
    motion = Stationary.from_attitude(system(gradient=4.0), 0.0, SOME, -1)
    states = motion.at(np.array([0.0, 1.0, 100.0]))
    turned = rotation.multiply(rotation.about([0, 0, 1], -2.0 * states.t_s), SOME)
    np.testing.assert_allclose(states.q_ib, turned, atol=1e-13)
    assert motion.nu == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize('axis', [0, 1, 2])
@pytest.mark.parametrize('body', [BODY, BODY[[2, 0, 1]], [1.5, 1.5, 2.0], [2.0, 2.0, 2.0]])
def test_along_a_principal_axis_it_is_a_permanent_rotation(axis, body):
    """Proves the steady branch, on the middle alpha, a saddle, too: it stays for ever."""
    q_ib = rotation.conjugate(rotation.from_matrix(np.roll(np.eye(3), axis - 2, axis=1).T))
    gamma = rotation.rotate(rotation.conjugate(q_ib), [0, 0, 1.0])
    motion = Stationary.from_attitude(system(np.array(body)), 0.1, q_ib)
    states = motion.at(np.array([1e4]))
    np.testing.assert_allclose(states.c_b[0], gamma, atol=1e-12)
    assert motion.period_s is None


def test_next_to_the_saddle_it_swings_to_the_other_side():
    """Proves that 1e-12 from the axis of the middle alpha is no permanent rotation."""
    gamma = np.array([1e-12, 1.0, 0.0])
    theta, phi = np.arccos(gamma[2]), np.arctan2(gamma[0], gamma[1])
    motion = Stationary.from_attitude(system(), 0.1, from_zxz(0.0, theta, phi))
    assert motion.period_s is not None
    opposite = motion.at(motion.period_s / 2.0).c_b[0]
    np.testing.assert_allclose(opposite, [0.0, -1.0, 0.0], atol=1e-9)


def test_alphas_that_are_equal_but_for_rounding():
    """Proves that a body turning about the vertical in axes aside, alphas -1, just turns."""
    q_bp = np.array([5.617333549722722e-16, 0.0, 0.9486832980505138, 0.31622776601683794])
    motion = Stationary.from_attitude(
        system(np.array([0.625, 0.875, 0.75]), 1.0, q_bp), 0.0, rotation.IDENTITY, -1
    )
    states = motion.at([np.pi, 1e3])
    truth = [[0.0, 0.0, -1.0, 0.0], [0.0, 0.0, -np.sin(500.0), np.cos(500.0)]]
    np.testing.assert_allclose(states.q_ib, truth, atol=1e-12)
    assert motion.period_s is None


@pytest.mark.parametrize('name', ['A1_range1_pos_nu_about_max', 'A3_range2'])
def test_rows_do_not_depend_on_each_other(name):
    """Proves random access: a million times give the same bits as each time alone."""
    case = CASES[name]
    motion = Stationary(case.system, case.start)
    t_s = np.random.default_rng(0).uniform(0.0, 1e5, 10**6)
    states = motion.at(t_s)
    assert np.all(np.abs(np.linalg.norm(states.q_ib, axis=-1) - 1.0) < 1e-14)
    for i in (0, 1, 77_777, 999_999):
        assert np.array_equal(motion.at(t_s[i]).q_ib[0], states.q_ib[i])
        assert np.array_equal(motion.at(t_s[i]).omega_bi_b[0], states.omega_bi_b[i])


@st.composite
def admissible(draw, moments, field=1):
    """
    Draw nu of either range for a gradient of the sign field.

    |N_i| > 0.05: nearer to a pole the alphas amplify rounding of the moments; a case is there.
    """
    low, middle, high = np.sort(moments)
    if field < 0 and draw(st.booleans()):
        nu = 0.5 / low * (1.0 + draw(powers_of_ten(-1.3, 1.5)))
    elif field < 0:
        nu = 0.5 / high + (0.5 / middle - 0.5 / high) * draw(st.floats(0.0, 1.0))
    elif draw(st.booleans()):
        nu = 0.5 / high * (1.0 - draw(powers_of_ten(-1.3, 1.5)))
    else:
        nu = 0.5 / middle + (0.5 / low - 0.5 / middle) * draw(st.floats(0.0, 1.0))
    N = 1.0 - 2.0 * nu * moments
    assume(field * np.prod(N) > 0.0 and np.min(np.abs(N)) > 0.05)
    return nu


@settings(max_examples=200)
@given(st.data())
def test_agrees_with_propagation(data):
    """Proves the closed form in all regimes, recognised from a state in any body axes."""
    I, q_bp = data.draw(moments()), data.draw(body_axes())
    field = data.draw(signs)
    nu, q_ib = data.draw(admissible(I, field)), data.draw(attitudes())
    gradient = field * data.draw(powers_of_ten(-6.0, 1.0))
    motion = Stationary.from_attitude(system(I, gradient, q_bp), nu, q_ib, data.draw(signs))
    scale = motion.omega_0 + np.linalg.norm(motion.state.omega_bi_b)
    duration = min(10.0 * (motion.period_s or 1.0 / scale), 300.0 / scale)
    assert_agrees(motion, np.linspace(0.0, duration, 40), scale)


@settings(max_examples=60)
@given(st.data())
def test_agrees_with_propagation_near_the_special_attitudes(data):
    """Proves the branches: near a principal axis, a principal plane, the separatrix."""
    I = data.draw(moments())
    nu = data.draw(admissible(I))
    first, second = data.draw(st.permutations(range(3)))[:2]
    slope = data.draw(powers_of_ten(-12.0, 0.0))
    gamma = np.zeros(3)
    gamma[first], gamma[second] = np.cos(slope), np.sin(slope)
    theta, phi = np.arctan2(np.hypot(gamma[0], gamma[1]), gamma[2]), np.arctan2(*gamma[:2])
    q_ib = from_zxz(data.draw(angles), theta, phi)
    motion = Stationary.from_attitude(system(I), nu, q_ib, data.draw(signs))
    scale = 1.0 + np.linalg.norm(motion.state.omega_bi_b)
    assert_agrees(motion, np.linspace(0.0, 60.0 / scale, 40), scale)


def test_it_says_why_not():
    """Proves the refusals, each by its own reason."""
    motion = Stationary.from_attitude(system(), 0.1, SOME)
    inertia, start, fixed = motion.system.inertia, motion.state, FixedDirection(1.0)
    off = State(SOME, start.omega_bi_b * (1.0 + 1e-9))
    rotor = Rotor('constant_momentum', np.array([1.0, 0.0, 0.0]), 0.1)
    torque = np.array([0.0, 0.0, 1e-6])
    reasons = {
        'nu': (System(inertia, orbit=fixed), off),
        'orbit.type': (System(inertia, orbit=KeplerOrbit()), start),
        'gradient': (System(inertia, orbit=FixedDirection(0.0)), start),
        'rotor': (System(inertia, (rotor,), fixed), start),
        'weight_moment': (System(inertia, orbit=fixed, weight_moment=torque), start),
        'torque': (System(inertia, orbit=fixed, torque_b=torque), start),
    }
    for word, (refused, state) in reasons.items():
        assert word in (Stationary.why_not(refused, state) or '')
        with pytest.raises(ValueError, match=word):
            Stationary(refused, state)
    assert Stationary.why_not(motion.system, start) is None


@pytest.mark.parametrize('nu', [0.3, 0.51])
def test_nu_between_the_ranges_is_refused(nu):
    """Proves that nu is checked where N1 N2 N3 <= 0."""
    with pytest.raises(ValueError, match='nu is'):
        Stationary.from_attitude(system(), nu, SOME)


def test_c0_beyond_the_alphas_is_refused():
    """Proves that e stays between the alphas."""
    with pytest.raises(ValueError, match='c0 is 1;'):
        Stationary.from_constants(system(), 0.1, 1.0)


def test_the_separatrix_stays_near_its_asymptote_while_rounding_allows():
    """Proves the exact separatrix against propagation until rounding has grown to 1e-8."""
    case = CASES['A10_exact_separatrix']
    motion = Stationary(case.system, case.start)
    t_s = np.linspace(0.0, 60.0, 50)
    truth = Propagation(case.system, case.start, tolerance=1e-14).at(t_s)
    assert np.max(rotation.angle_between(motion.at(t_s).q_ib, truth.q_ib)) < 1e-8


def has_the_constants(motion, nu, c0, sign):
    """
    Assert by the definitions that a motion has the constants that were asked for, now and later.

    In principal axes omega = omega_0 alpha gamma and c0 = alpha . gamma^2 - alpha_3 (14, 25).
    """
    I, R_bp = principal_axes(motion.system.inertia)
    gradient = motion.system.orbit.gradient
    alpha, omega_0 = alphas(I, nu, sign, int(np.sign(gradient))), np.sqrt(abs(gradient))
    largest = np.max(np.abs(alpha))
    states = motion.at(np.array([0.0, 0.7, 2.9]) / omega_0)
    gamma_p = states.c_b @ R_bp
    np.testing.assert_allclose(
        states.omega_bi_b @ R_bp, omega_0 * alpha * gamma_p, atol=1e-13 * omega_0 * largest
    )
    np.testing.assert_allclose(gamma_p**2 @ alpha - alpha[2], c0, atol=2e-12 * largest)
    assert motion.nu == pytest.approx(nu, rel=1e-12)
    assert motion.c0 == pytest.approx(c0, abs=2e-12 * largest)
    assert np.sign(motion.mu) == sign


def test_two_equal_moments_at_the_end_of_the_range():
    """Proves that gamma lies across axis 1 where c0 = 0 says so, at any angle: the phase."""
    body = System(np.diag([1.2, 1.6, 1.6]), orbit=FixedDirection(1.0))
    motion = Stationary.from_constants(body, 0.35, 0.0)
    assert motion.nu == 0.35
    assert motion.c0 == pytest.approx(0.0, abs=1e-15)
    assert np.linalg.norm(motion.state.omega_bi_b) == pytest.approx(0.4, rel=1e-14)
    assert motion.state.omega_bi_b[0] == pytest.approx(0.0, abs=1e-15)
    turned = Stationary.from_constants(body, 0.35, 0.0, phase=0.6)
    cosine = motion.at(0.0).c_b[0] @ turned.at(0.0).c_b[0]
    assert cosine == pytest.approx(np.cos(0.6), rel=1e-14)


def test_the_symmetric_body_about_its_equator():
    """Proves c0 = -0.4339 of diag(1.6, 1.6, 1.2) and nu = -1, asked as c0 and as the energy."""
    body = System(np.diag([1.6, 1.6, 1.2]), orbit=FixedDirection(1.0))
    c0 = differences(np.array([1.6, 1.6, 1.2]), -1.0, 1)[0, 2]
    assert c0 == pytest.approx(-0.433860916, rel=1e-9)
    has_the_constants(Stationary.from_constants(body, -1.0, c0), -1.0, c0, 1)
    lying = Stationary.from_attitude(body, -1.0, rotation.about([1.0, 0.0, 0.0], np.pi / 2.0))
    same = Stationary.from_energy(body, -1.0, lying.h)
    has_the_constants(same, -1.0, c0, 1)
    assert same.h == pytest.approx(lying.h, rel=1e-15)


def test_a_permanent_rotation_keeps_the_multiplier_that_was_asked_for():
    """Proves both ends of c0, where a state alone leaves the choice between two nu."""
    end = -0.24152294576982403
    has_the_constants(Stationary.from_constants(system(), 0.1, end), 0.1, end, 1)
    has_the_constants(Stationary.from_constants(system(), 0.1, 0.0), 0.1, 0.0, 1)


@settings(max_examples=100)
@given(st.data())
def test_from_the_constants_of_any_motion_comes_that_motion(data):
    """
    Proves nu, c0, h and sign at the ends of c0, at the middle alpha and between, for any body.

    As given, and again as the motion itself, its later states and its energy say them.  An energy
    is compared with its largest term, of which rounding is left where the others cancel it.
    """
    I, q_bp, field = data.draw(moments()), data.draw(body_axes()), data.draw(signs)
    nu, sign = data.draw(admissible(I, field)), data.draw(signs)
    body = system(I, field * data.draw(powers_of_ten(-6.0, 1.0)), q_bp)
    I, _ = principal_axes(body.inertia)
    alpha, apart = alphas(I, nu, sign, field), differences(I, nu, sign)[:, 2]
    share = data.draw(st.floats(0.0, 1.0))
    between = np.min(apart) + share * np.ptp(apart)
    c0 = data.draw(st.sampled_from([*apart, min(between, np.max(apart))]))
    angle = data.draw(angles)
    motion = Stationary.from_constants(body, nu, c0, data.draw(angles), angle, sign)
    has_the_constants(motion, nu, c0, sign)
    size = motion.omega_0**2 * np.max(I * (alpha**2 + 1.0))
    later = Stationary(body, motion.at([0.7 / motion.omega_0])[0])
    own = Stationary.from_constants(body, later.nu, later.c0, 0.3, 0.1, int(np.sign(later.mu)))
    for other in (later, own):
        assert other.h == pytest.approx(motion.h, abs=1e-11 * size)
    if nu != 0.0:
        same = Stationary.from_energy(body, nu, motion.h, 0.3, 0.1, sign)
        assert same.h == pytest.approx(motion.h, abs=1e-11 * size)


@pytest.mark.parametrize('field', [-1.0, 1.0])
def test_what_is_just_beyond_the_range_is_refused(field):
    """Proves that only rounding is forgiven at the ends, of c0 and of the energy."""
    body, nu = system(gradient=field), 0.1 if field > 0.0 else 0.3
    apart = differences(BODY, nu, 1)[:, 2]
    for end in (np.min(apart), np.max(apart)):
        beyond = end + np.copysign(1e-9, end - np.mean(apart))
        with pytest.raises(ValueError, match='c0 is'):
            Stationary.from_constants(body, nu, beyond)
        h, inside = (Stationary.from_constants(body, nu, c0).h for c0 in (end, np.mean(apart)))
        with pytest.raises(ValueError, match='c0 is'):
            Stationary.from_energy(body, nu, h + np.copysign(1e-9, h - inside))


@pytest.mark.parametrize('nu', [np.nan, np.inf, -np.inf, -1e200])
def test_a_multiplier_without_alphas_is_refused(nu):
    """Proves that no nan and no overflow comes of a nu that is none."""
    with pytest.raises(ValueError, match='nu is'):
        Stationary.from_constants(system(), nu, 0.0)


def test_constants_without_a_field_are_refused():
    """Proves that the field is asked for before nu is judged."""
    with pytest.raises(ValueError, match='no field'):
        Stationary.from_energy(system(gradient=0.0), 0.1, 1.0)


@pytest.mark.parametrize(
    ('moments', 'omega'), [([1.0, 1.0, 2.0], [0.0, 1.0, 0.0]), ([1.0, 1.0, 1.5], [1.0, 1.0, -1.0])]
)
def test_a_multiplier_at_a_pole_is_none(moments, omega):
    """Proves that a symmetric body in a negative gradient is not taken for nu = 1 / (2 I)."""
    state = State(np.array([0.6, 0.0, 0.0, 0.8]), np.array(omega))
    body = System(np.diag(moments), orbit=FixedDirection(-1.0))
    assert 'no nu gives the rates' in (Stationary.why_not(body, state) or '')
