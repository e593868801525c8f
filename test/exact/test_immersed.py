from functools import partial

import numpy as np
import pytest
from cases import rigid
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from satdyn_ros.dynamics.system import State, System
from satdyn_ros.exact.fluid import FluidBody
from satdyn_ros.exact.immersed import Immersed
from satdyn_ros.exact.symmetric import Symmetric
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import FixedDirection

close = partial(assert_allclose, rtol=0.0)

COUPLED = {'a11': 2.0, 'a33': 3.0, 'a44': 1.0, 'a66': 0.8, 'a14': 0.3, 'a36': -0.4}
ANY, RATE = np.array([0.1, 0.5, 0.7, 0.5]), np.array([0.3, -0.2, 1.1])
UP = np.array([0.0, 0.0, 0.0, 1.0])
PERTURBATION = 1e-9

# Thousandths: exact zeros and equal coefficients come up, and none smaller than a body has.
ratios = st.integers(300, 3000).map(lambda k: k / 1000.0)
signed = st.integers(-1000, 1000).map(lambda k: k / 1000.0)
vectors = arrays(float, 3, elements=signed)


def matrices(body):
    """Return the mass, coupling and inertia matrices of the kinetic energy, diagonals (3,)."""
    return (
        np.array([body.a11, body.a11, body.a33]),
        np.array([body.a14, body.a14, body.a36]),
        np.array([body.a44, body.a44, body.a66]),
    )


def momenta(body, v, omega):
    """Return the impulse P = dT/dv and the impulsive moment G = dT/domega, body axes."""
    mass, coupling, inertia = matrices(body)
    return mass * v + coupling * omega, inertia * omega + coupling * v


def kirchhoff(body, q, omega, P0, t_s):
    """
    Return q_ib, omega_bi_b, v_b and x_i at t_s by the equations of Kirchhoff, all six degrees.

    P' = P x omega, G' = G x omega + P x v + N, x' = R v, by DOP853 at its finest.
    """
    mass, coupling, inertia = matrices(body)
    energy = np.block([[np.diag(mass), np.diag(coupling)], [np.diag(coupling), np.diag(inertia)]])
    velocities = np.linalg.inv(energy)

    def rates(_, y):
        qx, qy, qz, qw = y[:4]
        P, G = y[4:7], y[7:10]
        v, omega = np.split(velocities @ y[4:10], 2)
        p, q, r = omega
        R = np.array(
            [
                [1 - 2 * (qy * qy + qz * qz), 2 * (qx * qy - qw * qz), 2 * (qx * qz + qw * qy)],
                [2 * (qx * qy + qw * qz), 1 - 2 * (qx * qx + qz * qz), 2 * (qy * qz - qw * qx)],
                [2 * (qx * qz - qw * qy), 2 * (qy * qz + qw * qx), 1 - 2 * (qx * qx + qy * qy)],
            ]
        )
        U_prime = 2.0 * body.H1 * R[2, 2] + body.H2
        return [
            (qw * p + qy * r - qz * q) / 2.0,
            (qw * q + qz * p - qx * r) / 2.0,
            (qw * r + qx * q - qy * p) / 2.0,
            -(qx * p + qy * q + qz * r) / 2.0,
            *cross(P, omega),
            *(cross(G, omega) + cross(P, v) + U_prime * np.array([-R[2, 1], R[2, 0], 0.0])),
            *(R @ v),
        ]

    P = P0 * rotation.matrix(q)[2]
    v = (P - coupling * omega) / mass
    start = np.concatenate([q, *momenta(body, v, omega), np.zeros(3)])
    y = solve_ivp(rates, (0.0, np.max(t_s)), start, 'DOP853', t_s, rtol=1e-13, atol=1e-14).y.T
    v, omega = np.split(y[:, 4:10] @ velocities.T, 2, axis=1)
    return rotation.normalise(y[:, :4]), omega, v, y[:, 10:]


def cross(a, b):
    return np.array(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


def assert_kirchhoff(body, q, omega, P0, t_s):
    """
    Assert that a motion is the one of the equations, within 1e-10 + 1e-13 G.

    G: how much an integration that starts 1e-9 away has grown apart; what DOP853 rounds away,
    some 1e-13 of a time unit, grows alike.
    """
    q_ib, omega_bi_b, v_b, x_i = truth = kirchhoff(body, q, omega, P0, t_s)
    aside = PERTURBATION * np.array([0.36, -0.48, 0.8])
    turned = rotation.multiply(q, rotation.normalise([*aside / 2.0, 1.0]))
    twin = kirchhoff(body, turned, omega + aside, P0, t_s)
    growth = max(np.max(np.abs(a - b)) for a, b in zip(twin, truth, strict=True)) / PERTURBATION
    bound = 1e-10 + 1e-13 * growth
    states = Immersed(body, q, omega, P0).at(t_s)
    assert np.max(rotation.angle_between(states.q_ib, q_ib)) < bound
    # quaternions of one sign: neither jumps where the other does not
    assert np.all(np.sum(states.q_ib * q_ib, axis=-1) > 0.0)
    speed = 1.0 + np.max(np.abs(omega_bi_b)) + np.max(np.abs(v_b))
    close(states.omega_bi_b, omega_bi_b, atol=bound * speed)
    close(states.v_b, v_b, atol=bound * speed)
    close(states.x_i, x_i, atol=bound * speed * (1.0 + t_s[-1]))


@pytest.mark.parametrize('name', ['pal2_revolution_no_coupling', 'pal2_helicoidal_coupled'])
def test_the_reference_cases(name):
    """Paladini's body of revolution and his helicoidal one, to the bound of the cases."""
    case = rigid()[name]
    coefficients = {
        **case.raw['body'],
        'H1': case.raw['field']['H1'],
        'H2': case.raw['field']['H2'],
    }
    body = FluidBody(**{key: float(value) for key, value in coefficients.items()})
    motion = Immersed(body, case.start.q_ib, case.start.omega_bi_b, float(case.raw['P0']))
    states = motion.at(case.t_s)
    assert np.max(rotation.angle_between(states.q_ib, case.q_ib)) < case.bound_exact
    for column, key in (('omega_bi_b', 'omega'), ('v_b', 'v_body'), ('x_i', 'position')):
        expected = np.array([[float(x) for x in state[key]] for state in case.raw['states']])
        size = np.max(np.abs(expected))
        close(getattr(states, column), expected, atol=10.0 * case.bound_exact * size)
    derived = {key: case.raw['derived'][key] for key in ('A_star', 'C_star', 'H1_star', 'H2_star')}
    derived |= {'Oz': case.raw['derived']['Omega_z'], 'kappa': case.raw['derived']['kappa']}
    for key, value in derived.items():
        close(getattr(motion, key), float(value), atol=1e-14)


@pytest.mark.long
@settings(max_examples=25)
@given(
    st.tuples(ratios, ratios, ratios, ratios),
    st.tuples(signed, signed),
    st.tuples(signed, signed),
    arrays(float, 4, elements=signed),
    vectors,
    signed,
)
def test_any_body_moves_by_kirchhoffs_equations(energy, coupling, potential, q, omega, P0):
    """Attitude, rates, velocity and position of drawn bodies, also coupled, in any potential."""
    assume(np.linalg.norm(q) > 0.1)
    (a11, a33, a44, a66), (H1, H2) = energy, potential
    a14, a36 = 0.9 * np.array(coupling) * np.sqrt([a11 * a44, a33 * a66])
    body = FluidBody(a11, a33, a44, a66, a14, a36, H1, H2)
    assert_kirchhoff(body, rotation.normalise(q), 2.0 * omega, 2.0 * P0, np.linspace(0.0, 6.0, 13))


@pytest.mark.parametrize(
    ('q', 'omega', 'P0', 'potential'),
    [
        pytest.param(ANY, RATE, 1.5, (0.4, -0.3), id='many periods'),
        pytest.param(ANY, RATE, -1.5, (0.4, -0.3), id='impulse downward'),
        pytest.param(ANY, RATE, 0.0, (0.4, -0.3), id='no impulse'),
        pytest.param(ANY, RATE, 0.0, (0.0, 0.0), id='no impulse, no potential'),
        pytest.param(ANY, RATE, 1.5, (0.0, 0.0), id='no potential'),
        pytest.param(UP, RATE, 1.5, (0.4, -0.3), id='through the upper pole'),
        pytest.param([1.0, 0.0, 0.0, 0.0], RATE, 1.5, (0.4, -0.3), id='through the lower pole'),
        pytest.param(UP, [0.0, 0.0, 1.1], 1.5, (0.4, 0.3), id='axis along the impulse'),
    ],
)
def test_many_periods_of_the_coupled_body(q, omega, P0, potential):
    """The closed form repeats its velocity, turned about z, through 5 periods and more."""
    body = FluidBody(**COUPLED, H1=potential[0], H2=potential[1])
    assert_kirchhoff(body, np.array(q), np.array(omega), P0, np.linspace(0.0, 80.0, 33))


def integrated(body, q, omega, v, t_s):
    """Return q_ib, omega_bi_b, v_b and x_i at t_s by the package's equations and SciPy."""

    def rates(_, y):
        return np.concatenate(body.kirchhoff(y[:4], y[4:7], y[7:10]))

    start = np.concatenate([q, *body.momenta(v, omega), np.zeros(3)])
    y = solve_ivp(rates, (0.0, np.max(t_s)), start, 'DOP853', t_s, rtol=1e-13, atol=1e-14).y.T
    v_b, omega_bi_b = body.velocities(y[:, 4:7], y[:, 7:10])
    return rotation.normalise(y[:, :4]), omega_bi_b, v_b, y[:, 10:]


@pytest.mark.parametrize('P0', [1.5, -0.7])
def test_the_package_s_equations_are_kirchhoff_s(P0):
    """They integrate to what the equations written out here give, in any potential."""
    body = FluidBody(**COUPLED, H1=0.4, H2=-0.3)
    q, t_s = rotation.normalise(ANY), np.linspace(0.0, 20.0, 21)
    v = body.velocity(P0 * rotation.matrix(q)[2], RATE)
    truth = kirchhoff(body, q, RATE, P0, t_s)
    for ours, theirs in zip(integrated(body, q, RATE, v, t_s), truth, strict=True):
        close(ours, theirs, atol=1e-10)


def test_a_start_from_velocity_and_rates():
    """
    Without a potential any velocity is a start; attitude and position stay in the given axes.

    Against the integrated equations over ten time units, the impulse in a general direction.
    """
    body, t_s, x0 = FluidBody(**COUPLED), np.linspace(0.0, 10.0, 21), np.array([1.0, 2.0, -1.0])
    q, v = rotation.normalise(ANY), np.array([0.4, -0.2, 0.7])
    q_ib, omega_bi_b, v_b, x_i = integrated(body, q, RATE, v, t_s)
    motion = Immersed.from_velocity(body, q, RATE, v, x0)
    states = motion.at(t_s)
    assert np.max(rotation.angle_between(states.q_ib, q_ib)) < 1e-10
    for ours, theirs in (
        (states.omega_bi_b, omega_bi_b),
        (states.v_b, v_b),
        (states.x_i, x0 + x_i),
    ):
        close(ours, theirs, atol=1e-10)


def test_the_constants_stay_what_they_are():
    """G3, g and the energy of the start are those of every integrated state (28-digit P0 too)."""
    case = rigid()['pal2_helicoidal_coupled']
    coefficients = {**case.raw['body'], **{k: case.raw['field'][k] for k in ('H1', 'H2')}}
    body = FluidBody(**{key: float(value) for key, value in coefficients.items()})
    P0, q = float(case.raw['P0']), case.start.q_ib
    motion = Immersed(body, q, case.start.omega_bi_b, P0)
    v = np.array([float(x) for x in case.raw['initial_v_body']])
    assert Immersed.from_velocity(body, q, case.start.omega_bi_b, v).P0 == pytest.approx(P0)
    q_ib, omega_bi_b, v_b, _ = integrated(body, q, case.start.omega_bi_b, v, case.t_s)
    P, G = body.momenta(v_b, omega_bi_b)
    close(G[:, 2], motion.G3, atol=1e-10)
    close(
        np.sum(rotation.rotate(rotation.conjugate(q_ib), [0, 0, 1.0]) * G, -1),
        motion.g,
        atol=1e-10,
    )
    close(body.energy(q_ib, v_b, omega_bi_b), motion.energy, atol=1e-10)
    close(np.linalg.norm(P, axis=-1), abs(P0), atol=1e-10)


def test_an_impulse_beside_the_potential_s_axis_is_refused():
    """The hidden hypothesis of ch. 2: the fixed direction of U is that of the impulse."""
    with pytest.raises(ValueError, match=r'the impulse is \[.*along the inertial z axis'):
        Immersed.from_velocity(
            FluidBody(**COUPLED, H1=0.4), rotation.normalise(ANY), RATE, [0.4, -0.2, 0.7]
        )


def test_the_impulse_gives_the_position_across_it():
    """
    Without potential R G + x cross P is constant, which gives x and y without a quadrature.

    Over 10 000 s: the phases round by 1e-16 of what they turn, some 1e4 rad.
    """
    body = FluidBody(**COUPLED)
    x0 = np.array([1.0, -2.0, 3.0])
    motion = Immersed(body, ANY, RATE, 1.5, x0)
    states = motion.at(np.linspace(0.0, 1e4, 500))
    P_b, G_b = momenta(body, states.v_b, states.omega_bi_b)
    P, G = rotation.rotate(states.q_ib, P_b), rotation.rotate(states.q_ib, G_b)
    close(P, np.tile([0.0, 0.0, 1.5], (500, 1)), atol=1e-12)
    close(G[:, 2], G[0, 2], atol=1e-12)
    close(states.x_i[:, 0], x0[0] + (G[:, 1] - G[0, 1]) / 1.5, atol=1e-11)
    close(states.x_i[:, 1], x0[1] - (G[:, 0] - G[0, 0]) / 1.5, atol=1e-11)
    close(states.x_i[0], x0, atol=0.0)


def test_without_impulse_and_coupling_it_is_the_symmetric_body():
    """P0 = a14 = a36 = 0: the equivalent body is the body itself, and O rests."""
    body = FluidBody(2.0, 3.0, 1.0, 0.8, H1=0.4, H2=-0.3)
    motion = Immersed(body, ANY, RATE, 0.0)
    assert (motion.Oz, motion.kappa) == (0.0, 0.0)
    close([motion.A_star, motion.C_star], [1.0, 0.8], atol=1e-15)
    t_s = np.linspace(0.0, 50.0, 20)
    states = motion.at(t_s)
    alone = Symmetric.in_potential(1.0, 0.8, 0.0, 0.4, -0.3, State(ANY, RATE)).at(t_s)
    # C_star rounds, and 50 rad of turn with it
    close(states.q_ib, alone.q_ib, atol=1e-13)
    close(states.omega_bi_b, alone.omega_bi_b, atol=1e-13)
    close(states.v_b, 0.0, atol=0.0)
    close(states.x_i, 0.0, atol=0.0)


def test_the_screw_along_the_impulse():
    """A body that spins about its axis along the impulse: w = (P0 - a36 r) / a33, steadily."""
    states = Immersed(FluidBody(**COUPLED), UP, [0.0, 0.0, 1.1], 1.5).at([0.0, 7.0, 1e3])
    w = (1.5 + 0.4 * 1.1) / 3.0
    close(states.v_b, np.tile([0.0, 0.0, w], (3, 1)), atol=1e-15)
    close(states.x_i, np.outer([0.0, 7.0, 1e3], [0.0, 0.0, w]), atol=1e-12)
    angle = rotation.angle_between(states.q_ib, rotation.about([0, 0, 1], 1.1 * states.t_s))
    # 1100 rad of turn, rounded
    close(angle, 0.0, atol=1e-12)


def test_a_slender_body_turns_over_once():
    """
    The separatrix of the quadrantal pendulum: axis against the impulse long ago, along it at last.

    In a plane A theta'' = (P0^2 / 2)(1 / a33 - 1 / a11) sin 2 theta (Kirchhoff); at rest at
    theta = 0 and pi, cos theta = tanh(k t) with k^2 = P0^2 (1 / a33 - 1 / a11) / A.
    """
    body, P0 = FluidBody(2.0, 1.0, 1.0, 0.8), 1.5
    k = P0 * np.sqrt((1.0 / body.a33 - 1.0 / body.a11) / body.a44)
    q = rotation.about([1, 0, 0], np.pi / 2.0)
    motion = Immersed(body, q, [-k, 0.0, 0.0], P0)
    t_s = np.array([0.0, 0.5, 1.0, 3.0, 8.0])
    states = motion.at(t_s)
    cos_theta = rotation.matrix(states.q_ib)[:, 2, 2]
    # rounding of the start grows as exp(k t), to 1e-16 exp(8.5)
    close(cos_theta, np.tanh(k * t_s), atol=1e-12)
    # z' = P0 (sin^2 / a11 + cos^2 / a33)
    z = P0 * (t_s / body.a33 - (1 / body.a33 - 1 / body.a11) * np.tanh(k * t_s) / k)
    close(states.x_i[:, 2], z, atol=1e-11)


def test_the_table_does_not_depend_on_what_else_is_asked():
    """Any order, one time or many: row i depends on t_s[i] alone, to the last bit."""
    motion = Immersed(FluidBody(**COUPLED, H1=0.4, H2=-0.3), ANY, RATE, 1.5)
    t_s = np.array([30.0, 0.0, 4.5, 4.5, 1e3])
    states = motion.at(t_s)
    for i, t in enumerate(t_s):
        alone = motion.at(t)
        for column in ('t_s', 'q_ib', 'omega_bi_b', 'v_b', 'x_i'):
            assert np.array_equal(getattr(alone, column)[0], getattr(states, column)[i])
    assert len(motion.at([]).x_i) == 0


def test_what_is_no_body_is_refused():
    """The kinetic energy must be positive; the sentence names the coefficient and its bound."""
    with pytest.raises(ValueError, match=r'^a33 is -3; it must be positive$'):
        FluidBody(2.0, -3.0, 1.0, 0.8)
    with pytest.raises(ValueError, match=r'^a66 is 0; it must be positive$'):
        FluidBody(2.0, 3.0, 1.0, 0.0)
    with pytest.raises(ValueError, match=r'^a14 is -2; its square must be less than a11 a44 = 2$'):
        FluidBody(2.0, 3.0, 1.0, 0.8, a14=-2.0)
    with pytest.raises(ValueError, match=r'^a36 is 1\.6; its square must be less than a33 a66'):
        FluidBody(2.0, 3.0, 1.0, 0.8, a36=1.6)
    with pytest.raises(ValueError, match=r'^H1 is nan; it must be finite$'):
        FluidBody(2.0, 3.0, 1.0, 0.8, H1=np.nan)
    with pytest.raises(ValueError, match='t_s is -1'):
        Immersed(FluidBody(2.0, 3.0, 1.0, 0.8), ANY, RATE, 1.5).at([0.0, -1.0])


@pytest.mark.parametrize(('gradient', 'P0', 's'), [(2.5, 1.7, 1.0), (-2.5, -0.8, 9.0)])
def test_a_solid_in_a_fluid_turns_as_a_satellite(gradient, P0, s):
    """
    Clebsch's solid by Kirchhoff's equations, the satellite by its own: the same attitudes.

    Three different axes, either sign of the gradient (De Brun's problem is the negative one); the
    map back gives the satellite again.
    """
    moments = np.array([1.0, 1.5, 2.2])
    body = FluidBody.of_satellite(moments, gradient, P0, s)
    assert not body.is_symmetric
    again, same = body.satellite(P0)
    np.testing.assert_allclose(again, moments, rtol=1e-15)
    assert same == pytest.approx(gradient, rel=1e-12)
    q_ib, omega = rotation.normalise([0.3, -0.2, 0.4, 1.0]), np.array([0.4, -0.3, 0.6])
    impulse = P0 * rotation.rotate(rotation.conjugate(q_ib), [0.0, 0.0, 1.0])
    start = np.concatenate([q_ib, impulse, body.momenta(body.velocity(impulse, omega), omega)[1]])

    def rates(_, y):
        q_dot, P_dot, G_dot, _ = body.kirchhoff(y[:4], y[4:7], y[7:])
        return np.concatenate([q_dot, P_dot, G_dot])

    t_s = np.linspace(0.0, 12.0, 25)
    flown = solve_ivp(rates, (0.0, 12.0), start, 'DOP853', t_s, rtol=1e-12, atol=1e-13).y.T
    system = System(np.diag(moments), orbit=FixedDirection(gradient))
    states = Propagation(system, State(q_ib, omega)).at(t_s)
    assert np.max(rotation.angle_between(flown[:, :4], states.q_ib)) < 1e-9
    _, omega_flown = body.velocities(flown[:, 4:7], flown[:, 7:])
    np.testing.assert_allclose(omega_flown, states.omega_bi_b, atol=1e-9)


def test_solids_that_no_satellite_is_like():
    """Couplings, a potential, and masses that are not linear in the moments are refused."""
    with pytest.raises(ValueError, match='not linear'):
        FluidBody(1.0, 2.0, 1.0, 2.2, a22=1.1, a55=1.5).satellite(1.0)
    with pytest.raises(ValueError, match='not zero'):
        FluidBody(1.0, 2.0, 1.0, 2.2, a14=0.1).satellite(1.0)
    with pytest.raises(ValueError, match='must be above'):
        FluidBody.of_satellite(np.array([1.0, 1.5, 2.2]), -2.5, 1.0, 1.0)
    with pytest.raises(ValueError, match='a25 is 2'):
        FluidBody(1.0, 2.0, 1.0, 2.2, a25=2.0)


def test_a_solid_of_three_axes_has_no_closed_form():
    """Its equations are there, its closed form is refused by a sentence."""
    with pytest.raises(ValueError, match='no closed form'):
        Immersed(FluidBody(1.0, 2.0, 1.0, 2.2, a22=1.1), [0, 0, 0, 1.0], [0.1, 0.2, 0.3], 1.0)
