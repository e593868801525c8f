from functools import partial

import numpy as np
import pytest
from cases import rigid
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from satdyn_ros.dynamics.system import State, System
from satdyn_ros.exact.geometry import Rolling, herpolhode, herpolhode_rate, polhode
from satdyn_ros.exact.symmetric import Symmetric
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.kernel import rotation

close = partial(assert_allclose, rtol=0.0)

SIDE = Rotation.from_rotvec([0.4, -0.3, 0.8]).as_matrix()
ANY = rotation.normalise([0.1, 0.5, 0.7, 0.5])
RATES = [[0.2, 0.3, 1.0], [1.0, 0.2, -0.3], [0.5, -1.0, 0.2]]
TURN = np.linspace(0.0, 2.0 * np.pi, 20001)


@pytest.mark.parametrize('moments', [[1.0, 2.0, 2.5], [2.5, 1.0, 2.0], [1.0, 1.0, 1.6]])
@pytest.mark.parametrize('omega', RATES)
def test_the_polhode_is_where_the_rate_goes(moments, omega):
    """
    The curve holds both integrals, and every propagated rate is on it.

    Its points are 3e-4 apart, so a point on the curve is within half of that of one of them, and
    within its square of the chord; the distance to the integrals' surfaces is rounding.
    """
    inertia, omega = SIDE @ np.diag(moments) @ SIDE.T, SIDE @ omega
    xi = polhode(inertia, omega, TURN)
    two_E, L = omega @ inertia @ omega, np.linalg.norm(inertia @ omega)
    close(np.sum(xi * (xi @ inertia), axis=-1), 1.0, atol=1e-14)
    close(np.sum((xi @ inertia) ** 2, axis=-1), L**2 / two_E, atol=1e-13)
    motion = Propagation(System(inertia), State(ANY, omega))
    contact = motion.at(np.linspace(0.0, 30.0, 100)).omega_bi_b / np.sqrt(two_E)
    nearest = [np.min(np.linalg.norm(xi - point, axis=-1)) for point in contact]
    assert max(nearest) < 3e-4


@pytest.mark.parametrize('moments', [[1.0, 2.0, 2.5], [1.0, 2.0, 2.0], [2.0, 2.0, 2.0]])
@pytest.mark.parametrize('axis', range(3))
def test_the_polhode_of_a_permanent_rotation_is_a_point(moments, axis):
    """About a principal axis, middle and equal ones among them, the curve is omega's tip."""
    omega = 0.7 * np.eye(3)[axis]
    expected = omega / np.sqrt(moments[axis] * 0.49)
    close(polhode(np.diag(moments), omega, TURN[:5]), [expected] * 5, atol=1e-15)


def test_the_separatrix_runs_into_the_middle_axis():
    """With L^2 = 2 E I2 the curve ends at both ends of the middle axis."""
    I = np.array([1.0, 2.0, 2.5])
    # I1 (I2 - I1) w1^2 = I3 (I3 - I2) w3^2
    omega = np.array([np.sqrt(1.25), 0.3, 1.0])
    xi = polhode(np.diag(I), omega, np.array([np.pi / 2.0, -np.pi / 2.0]))
    tip = 1.0 / np.sqrt(I[1])
    # The root of a rounding: the curve comes in at an angle to the surfaces.
    close(xi, [[0.0, tip, 0.0], [0.0, -tip, 0.0]], atol=1e-7)


@pytest.mark.parametrize('omega', RATES)
def test_the_herpolhode_lies_between_the_polhodes_extremes(omega):
    """
    Radius and angle of the propagated contact point: rho^2 = (O^2 - 4 E^2 / L^2) / 2 E.

    The radius keeps between those of the polhode's nearest and farthest point, and the angle
    never turns back and grows at the rate of the formula (difference over 1e-4 s: 1e-7).
    """
    inertia, omega = np.diag([1.0, 2.0, 2.5]), np.asarray(omega)
    two_E, L = omega @ inertia @ omega, np.linalg.norm(inertia @ omega)
    t_s = np.linspace(0.0, 40.0, 4001)
    motion = Propagation(System(inertia), State(ANY, omega), tolerance=1e-13)
    states, after = motion.at(t_s), motion.at(t_s + 1e-4)
    points = herpolhode(inertia, states.q_ib, states.omega_bi_b)
    radius = np.linalg.norm(points, axis=-1)
    extremes = polhode(inertia, omega, np.array([0.0, np.pi / 2.0]))
    limits = np.sqrt(np.sum(extremes**2, axis=-1) - two_E / L**2)
    assert np.min(radius) == pytest.approx(np.min(limits), abs=1e-4)
    assert np.max(radius) == pytest.approx(np.max(limits), abs=1e-4)
    assert np.all((radius > np.min(limits) - 1e-11) & (radius < np.max(limits) + 1e-11))
    rate = herpolhode_rate(inertia, states.omega_bi_b)
    assert np.all(rate >= 0.0)
    later = herpolhode(inertia, after.q_ib, after.omega_bi_b)
    # Both tables measure from the same axis of the plane, as L does not move.
    turned = np.arctan2(
        points[:, 0] * later[:, 1] - points[:, 1] * later[:, 0], np.sum(points * later, axis=-1)
    )
    middle = herpolhode_rate(inertia, motion.at(t_s + 5e-5).omega_bi_b)
    close(turned / 1e-4, middle, atol=1e-7)


def test_the_herpolhode_of_a_permanent_rotation_does_not_turn():
    """It is a point on L itself, and has no rate."""
    omega = np.array([[0.0, 0.7, 0.0]])
    inertia = np.diag([1.0, 2.0, 2.5])
    close(herpolhode(inertia, ANY[None], omega), [[0.0, 0.0]], atol=1e-15)
    assert np.isnan(herpolhode_rate(inertia, omega)[0])


def constants(A, C, h3, H1, H2, q, omega):
    """Return the rolling by the definitions of its constants."""
    g1, g2, u = rotation.rotate(rotation.conjugate(q), [0.0, 0.0, 1.0])
    p, q_, r0 = omega
    J3 = C * r0 + h3
    g = A * (p * g1 + q_ * g2) + J3 * u
    h_prime = A / 2.0 * (p * p + q_ * q_) - H1 * u * u - H2 * u
    return Rolling(A, J3, r0, g, h_prime, H1, H2)


PALADINI = [name for name in rigid() if name.startswith('pal1_')]


def of_case(case):
    A, C = (float(case.raw['body'][key]) for key in 'AC')
    H1, H2 = (float(case.raw['field'][key]) for key in ('H1', 'H2'))
    return A, C, float(case.raw['rotor_h_body'][2]), H1, H2


@pytest.mark.parametrize('name', PALADINI)
def test_the_pole_stays_on_the_quadric(name):
    """
    Along every reference motion the pole R omega is on Paladini's quadric.

    Tolerance: rounding, relative to the largest term, which for the sphere A = C is a plane.
    """
    case = rigid()[name]
    A, C, h3, H1, H2 = of_case(case)
    rolling = constants(A, C, h3, H1, H2, case.start.q_ib, case.start.omega_bi_b)
    v_i = rotation.rotate(case.q_ib, case.omega_bi_b)
    c2, c1, c0 = rolling.coefficients if rolling.Delta else (1.0, 1.0, 1.0)
    z = np.max(np.abs(v_i[:, 2]))
    size = np.max(np.sum(v_i**2, axis=-1)) + abs(c2) * z * z + abs(c1) * z + abs(c0)
    close(rolling.residual(v_i), 0.0, atol=1e-14 * size)
    assert (rolling.kind == 'plane') == (case.raw['body']['A'] == case.raw['body']['C'])
    assert (rolling.kind == 'sphere') == (rolling.H1 == 0.0 and rolling.Delta != 0.0)


@pytest.mark.parametrize('name', PALADINI)
def test_the_polar_curve_in_the_body(name):
    """The pole's distance from the axis and its turning, on reference rates, by u alone (41)."""
    case = rigid()[name]
    A, C, h3, H1, H2 = of_case(case)
    rolling = constants(A, C, h3, H1, H2, case.start.q_ib, case.start.omega_bi_b)
    gamma = rotation.rotate(rotation.conjugate(case.q_ib), [0.0, 0.0, 1.0])
    p, q, r = case.omega_bi_b.T
    square = p * p + q * q
    close(rolling.polar_radius(gamma[:, 2]) ** 2, square, atol=1e-14 * (1.0 + np.max(square)))
    slope = 2.0 * H1 * gamma[:, 2] + H2
    p_dot = ((A - C) * q * r - h3 * q - slope * gamma[:, 1]) / A
    q_dot = ((C - A) * r * p + h3 * p + slope * gamma[:, 0]) / A
    moving = square > 1e-6
    expected = (p * q_dot - q * p_dot)[moving] / square[moving]
    found = rolling.polar_rate(gamma[moving, 2])
    close(found, expected, atol=1e-8 if 'separatrix' in name else 1e-11)


EXAMPLES = [
    # A, C, h3, H1, H2, omega: what the pole of the attitude ANY is on.
    ('ellipsoid', 1.0, 1.5, 0.0, -0.7, 0.3, [0.3, -0.2, 1.1]),
    ('ellipsoid', 1.0, 3.5, 0.0, 0.7, 0.3, [0.3, -0.2, 1.1]),
    ('sphere', 1.0, 0.5, 0.0, 0.0, -2.0, [0.3, -0.2, 3.0]),
    ('hyperboloid of one sheet', 1.0, 1.5, 0.0, 0.7, 0.3, [0.3, -0.2, 1.1]),
    ('hyperboloid of two sheets', 1.0, 1.5, 0.0, 4.0, 0.4, [0.1, 0.1, 0.9]),
    ('plane', 1.0, 1.5, -0.55, 0.7, 0.3, [0.3, -0.2, 1.1]),
    ('plane', 1.0, 1.5, 0.0, 0.7, 0.3, [0.3, -0.2, 0.0]),
    ('paraboloid', 1.0, 1.5, 0.0, 0.125, 0.3, [0.3, -0.2, 1.0]),
    ('cylinder', 1.0, 1.5, 0.0, 0.125, None, [0.3, -0.2, 1.0]),
]


@pytest.mark.parametrize(('kind', 'A', 'C', 'h3', 'H1', 'H2', 'omega'), EXAMPLES)
def test_the_kind_of_quadric_is_that_of_the_motion(kind, A, C, h3, H1, H2, omega):
    """
    The name, and the coefficients, are those of a fit to the poles of the closed-form motion.

    rho^2 over v_z is fitted by a parabola, which knows nothing of the formula.
    """
    if H2 is None:
        # A cylinder has no slope: 2 H1 g / Delta + H2 = 0, and g = H . Z does not know of H2.
        g = constants(A, C, h3, H1, 0.0, ANY, np.array(omega)).g
        H2 = -2.0 * H1 * g / ((C - A) * omega[2] + h3)
    motion = Symmetric.in_potential(A, C, h3, H1, H2, State(ANY, np.array(omega)))
    rolling = Rolling.of(motion)
    assert rolling.kind == kind
    states = motion.at(np.linspace(0.0, 20.0, 200))
    x, y, z = rotation.rotate(states.q_ib, states.omega_bi_b).T
    if kind == 'plane':
        close(z, rolling.g / A, atol=1e-13)
        return
    fitted = np.polynomial.Polynomial.fit(z, x * x + y * y, 2)
    close((x * x + y * y) - fitted(z), 0.0, atol=1e-11)
    c0, c1, c2 = fitted.convert().coef
    close([c2, c1, c0], rolling.coefficients, atol=1e-9 * (1.0 + np.max(np.abs(fitted.coef))))


def test_a_cone_divides_the_hyperboloids():
    """Between one sheet and two, by the energy, there is a cone: rho^2 has a double zero."""
    rolling = constants(1.0, 1.5, 0.0, 0.7, 0.3, ANY, np.array([0.3, -0.2, 1.1]))
    c2, c1, c0 = rolling.coefficients
    rise = rolling.A / 2.0 * (c1 * c1 / (4.0 * c2) - c0)

    def at(h_prime):
        return Rolling(1.0, rolling.J3, rolling.r0, rolling.g, h_prime, 0.7, 0.3)

    assert at(rolling.h_prime + rise).kind == 'cone'
    assert at(rolling.h_prime + rise + 1e-6).kind == 'hyperboloid of one sheet'
    assert at(rolling.h_prime + rise - 1e-6).kind == 'hyperboloid of two sheets'
    apex = -c1 / (2.0 * c2)
    assert at(rolling.h_prime + rise).residual([[0.0, 0.0, apex]])[0] == pytest.approx(
        0, abs=1e-13
    )


def decimals(low, high):
    """Draw numbers of a size that a scenario has: zero, or not below 1e-6."""
    return st.floats(low, high).map(lambda x: round(x, 6))


@given(
    C=decimals(0.3, 1.9),
    h3=decimals(-1.0, 1.0),
    H1=decimals(-3.0, 3.0),
    H2=decimals(-3.0, 3.0),
    omega=st.tuples(*[decimals(-2.0, 2.0)] * 3),
)
def test_the_limits_of_the_polar_curve(C, h3, H1, H2, omega):
    """
    Over the motion the pole keeps between the two limits.

    Rounding of a radius near zero is the root of that of its square.
    """
    motion = Symmetric.in_potential(1.0, C, h3, H1, H2, State(ANY, np.array(omega)))
    states = motion.at(np.linspace(0.0, 30.0, 300))
    u = rotation.rotate(states.q_ib, [0.0, 0.0, 1.0])[:, 2]
    least, greatest = Rolling.of(motion).polar_limits(np.min(u), np.max(u))
    radius = np.hypot(*states.omega_bi_b[:, :2].T)
    size = 1.0 + greatest**2
    assert np.all(radius**2 >= least**2 - 1e-11 * size)
    assert np.all(radius**2 <= greatest**2 + 1e-11 * size)
    if H1 == 0.0 or abs(-H2 / (2.0 * H1)) > 1.0:
        # Without an extreme between them the limits are those of the turning points.
        assert least == pytest.approx(np.min(radius), abs=1e-5)
        assert greatest == pytest.approx(np.max(radius), abs=1e-5)


def test_the_quadric_holds_along_a_propagated_satellite():
    """The prolate satellite in a fixed field, propagated: its pole is on the quadric, to 1e-11."""
    case = rigid()['pal1_two_real_two_complex_H1pos']
    motion = Symmetric(case.system, case.start)
    states = Propagation(case.system, case.start).at(np.linspace(0.0, 50.0, 200))
    v_i = rotation.rotate(states.q_ib, states.omega_bi_b)
    close(Rolling.of(motion).residual(v_i), 0.0, atol=1e-10)
