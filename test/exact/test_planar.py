"""The planar motions against 30-digit integrations, published formulas and propagation."""

from typing import NamedTuple

import mpmath as mp
import numpy as np
import pytest
from agreement import assert_agrees
from cases import bounded, newtonian
from draws import angles, body_axes, inertia_in_body_axes, moments, powers_of_ten, signs
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from satdyn_ros.dynamics.rotor import Rotor
from satdyn_ros.dynamics.system import State, System
from satdyn_ros.exact.offset_pendulum import Field, OffsetPendulum
from satdyn_ros.exact.pendulum import Pendulum
from satdyn_ros.exact.planar import Planar
from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import FixedDirection, KeplerOrbit

PLANAR = ['B1', 'B2', 'B4', 'B6', 'B8', 'G1', 'G3', 'G5']
CASES = {
    name: newtonian()[name]
    for name in bounded(newtonian(), 'bound_exact')
    if name.split('_')[0] in PLANAR
}
ORBIT = KeplerOrbit(
    semi_major_axis=7.1e6, inclination=0.9, raan=2.0, argument_of_periapsis=0.4, true_anomaly=1.1
)
X, Y, Z = np.eye(3)


class Plane(NamedTuple):
    """How a body lies in its plane: principal axis along the normal, angle from c to the next."""

    axis: int
    side: int
    theta: float
    rate: float


def start_in(plane, moments, q_bp, orbit, start_s=0.0, azimuth=0.0):
    """Return q_ib, the rate omega_bi_b and the normal (3,) in body axes of a planar start."""
    R_bp = rotation.matrix(q_bp)
    n_b, e_1 = R_bp[:, plane.axis], R_bp[:, plane.axis - 2]
    c = orbit.direction(start_s)
    normal = orbit.normal if orbit.has_lvlh else rotation.rotate(rotation.about(Z, azimuth), X)
    line_rate = plane.side * orbit.mean_motion if orbit.has_lvlh else 0.0
    n_i = plane.side * normal
    ahead = np.cos(plane.theta) * c + np.sin(plane.theta) * np.cross(n_i, c)
    R_ib = np.stack([ahead, np.cross(n_i, ahead), n_i], axis=-1) @ np.stack(
        [e_1, np.cross(n_b, e_1), n_b]
    )
    return rotation.from_matrix(R_ib), (plane.rate + line_rate) * n_b, n_b


@pytest.mark.parametrize('name', CASES)
def test_reference_cases(name):
    """Proves attitude, rate and period of the planar cases at every listed time."""
    case = CASES[name]
    motion = Planar(case.system, case.start)
    states = motion.at(case.t_s)
    assert np.max(rotation.angle_between(states.q_ib, case.q_ib)) <= case.bound_exact
    off = np.linalg.norm(states.omega_bi_b - case.omega_bi_b, axis=-1)
    assert np.all(off <= 10.0 * case.bound_exact * np.linalg.norm(case.omega_bi_b, axis=-1))
    given = case.raw['closed_form_params']
    if 'period' in given:
        assert motion.period_s == pytest.approx(float(given['period']), rel=1e-13)
    if 'k2' in given:
        assert motion.k**2 == pytest.approx(float(given['k2']), rel=1e-13)
    kind = given.get('kind', 'rotation')
    assert motion.regime == {'rotation': 'tumbling'}.get(kind.split(',')[0], kind.split(',')[0])


def test_period_of_small_swings():
    """Proves Beletsky's series T = (2 pi / N)(1 + k^2 / 4 + 9 k^4 / 64 + ...), k = sin theta0."""
    k, N = np.sin(0.02), 1.3
    series = 2.0 * np.pi / N * (1.0 + k**2 / 4.0 + 9.0 * k**4 / 64.0)
    assert Pendulum(N, 0.02, 0.0).period_s == pytest.approx(series, rel=0.1 * k**6 + 1e-15)


@pytest.mark.parametrize(
    'pendulum', [Pendulum(2.0, 3e-9, 0.0), OffsetPendulum(Field(2.0, 0.0, 1.5, 3e-9, 0.0))]
)
def test_the_smallest_swings_keep_all_digits(pendulum):
    """Proves relative, not absolute, accuracy of an amplitude of 3e-9 rad: harmonic to 1e-17."""
    N = 2.0 * np.pi / pendulum.period_s
    assert pytest.approx(2.0, rel=1e-14) == N
    t_s = np.linspace(0.0, 20.0, 50)
    theta, rate = pendulum.at(t_s)
    np.testing.assert_allclose(theta, 3e-9 * np.cos(2.0 * t_s), rtol=0, atol=3e-9 * 1e-13)
    np.testing.assert_allclose(rate, -6e-9 * np.sin(2.0 * t_s), rtol=0, atol=6e-9 * 1e-13)


FIELDS = {
    'libration, other roots complex': Field(1.0, 0.5, 0.3, 0.4, 0.3),
    'libration, other roots real': Field(0.3, 0.5, 1.0, 0.4, 0.3),
    'libration in the other well': Field(0.3, 0.5, 1.0, 3.0, -0.2),
    'libration over both wells': Field(0.3, 0.0, 1.0, 0.0, 1.5),
    'libration of nearly a turn': Field(1.0, 0.0, 0.1, 3.1, 0.0),
    'libration from a turning point': Field(1.0, 0.3, -0.8, 1.0, 0.0),
    'libration about the side': Field(0.2, 0.3, -0.8, 1.2, 0.4),
    'tumbling forward': Field(1.0, 0.5, 0.3, 0.4, 3.0),
    'tumbling backward': Field(1.0, 2.5, -0.7, -1.4, -2.0),
    'tumbling, no gradient': Field(1.0, 0.5, 0.0, 0.4, 2.3),
    'tumbling, no offset': Field(0.0, 0.0, 0.7, 0.4, 2.3),
    'libration, no gradient': Field(1.0, 0.5, 0.0, 0.4, 0.3),
}


def integrated(field, t_s):
    """Return theta and its rate at t_s by SciPy's integration, good to 1e-12 here."""
    G1, delta, G2, theta0, rate0 = field

    def equation(_, y):
        return y[1], -G1 / 2.0 * np.sin(y[0] + delta) - G2 * np.sin(2.0 * y[0])

    options = {'method': 'DOP853', 'rtol': 3e-14, 'atol': 1e-15}
    return solve_ivp(equation, (0.0, t_s[-1]), (theta0, rate0), t_eval=t_s, **options).y


@pytest.mark.parametrize('name', FIELDS)
def test_offset_pendulum_in_all_patterns_of_roots(name):
    """Proves Beletsky's offset pendulum against integration."""
    field = FIELDS[name]
    pendulum = OffsetPendulum(field)
    assert name.startswith(pendulum.regime)
    t_s = np.array([0.0, 0.7, 3.0, 11.0])
    theta, rate = integrated(field, t_s)
    np.testing.assert_allclose(pendulum.at(t_s), [theta, rate], rtol=0, atol=1e-11)
    turn = 2.0 * np.pi * np.sign(field.rate0) if pendulum.regime == 'tumbling' else 0.0
    later = pendulum.at(t_s + pendulum.period_s)
    np.testing.assert_allclose(later[0], theta + turn, rtol=0, atol=1e-11)


def on_separatrix(G1, delta, G2, saddle, theta0, sense):
    """Return the field whose energy is that of the saddle; f there is zero to rounding."""

    def height(angle):
        return G1 * np.cos(angle + delta) + G2 * np.cos(2.0 * angle)

    rate0 = sense * np.sqrt(height(theta0) - height(saddle))
    return Field(G1, delta, G2, theta0, rate0)


SEPARATRICES = {
    'all the way round': (on_separatrix(1.0, 0.0, 0.1, np.pi, 0.3, 1), np.pi),
    'all the way round, backward': (on_separatrix(1.0, 0.0, 0.1, np.pi, 0.3, -1), -np.pi),
    'away, round a turning point and back': (on_separatrix(0.5, 0.0, -1.0, 0.0, 0.4, 1), 0.0),
    'straight back to where it came from': (on_separatrix(0.5, 0.0, -1.0, 0.0, 0.4, -1), 0.0),
    'between two tops of one height': (on_separatrix(0.0, 0.0, 0.6, np.pi / 2, 0.2, 1), np.pi / 2),
    'between two tops, backward': (on_separatrix(0.0, 0.0, 0.6, np.pi / 2, 0.2, -1), -np.pi / 2),
}


@pytest.mark.parametrize('name', SEPARATRICES)
def test_separatrices_of_the_offset_pendulum(name):
    """
    Proves double roots: the way to the equilibrium, against integration, and its end.

    Rounding of the start, 1e-16, grows like exp(lambda t) < 1e6 by the last time.
    """
    field, end = SEPARATRICES[name]
    pendulum = OffsetPendulum(field)
    assert pendulum.regime == 'separatrix'
    assert pendulum.k == 1.0
    assert pendulum.period_s is None
    t_s = np.array([0.0, 0.5, 2.0, 6.0])
    np.testing.assert_allclose(pendulum.at(t_s), integrated(field, t_s), rtol=0, atol=1e-9)
    theta, rate = pendulum.at(np.array([1e3, 1e9]))
    np.testing.assert_allclose(theta, end, atol=1e-12)
    np.testing.assert_allclose(rate, 0.0, atol=1e-12)


@pytest.mark.parametrize(
    'field',
    [Field(1.0, 0.5, 0.0, -0.5, 0.0), Field(0.4, 0.0, 0.3, np.pi, 0.0), Field(1, 0, -2, 0, 0)],
)
def test_equilibria_of_the_offset_pendulum_rest(field):
    """Proves that the motion stays in stable and unstable equilibria."""
    pendulum = OffsetPendulum(field)
    theta, rate = pendulum.at(np.array([0.0, 1e6]))
    assert pendulum.regime == 'rest'
    assert np.all(theta == field.theta0)
    assert np.all(rate == 0.0)


@pytest.mark.parametrize('theta0', [0.4, -2.0, 3.1])
@pytest.mark.parametrize('rate0', [0.0, 0.3, -0.3, 2.0, -2.0])
def test_without_offset_both_pendulums_are_one(theta0, rate0):
    """Proves that the offset pendulum with a = 0 is the pendulum of the gradient alone."""
    t_s = np.linspace(0.0, 30.0, 40)
    plain, offset = (
        Pendulum(1.1, theta0, rate0),
        OffsetPendulum(Field(0.0, 0.0, 0.605, theta0, rate0)),
    )
    assert plain.regime == offset.regime
    assert plain.period_s == pytest.approx(offset.period_s, rel=1e-13)
    np.testing.assert_allclose(plain.at(t_s), offset.at(t_s), rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize('theta0', [0.0, np.pi / 2, -np.pi, 0.3])
def test_separatrix_of_the_gradient(theta0):
    """Proves theta = gd(N t + ...) from any start: it ends at the equilibrium, within 1e-12."""
    N = 0.7
    rate0 = N * np.cos(theta0)
    pendulum = Pendulum(N, theta0, rate0)
    assert pendulum.regime == ('rest' if abs(rate0) < 1e-15 else 'separatrix')
    theta, rate = pendulum.at(np.array([0.0, 1e5]))
    assert theta[0] == pytest.approx(theta0, abs=1e-15)
    assert np.cos(theta[1]) == pytest.approx(0.0, abs=1e-12)
    assert rate[1] == pytest.approx(0.0, abs=1e-12)


def test_the_rotor_has_no_part_in_the_motion():
    """Proves Balli and Grioli's theorem: any momentum along the normal, bit for bit."""
    body = np.array([600.0, 900.0, 800.0])
    q_ib, omega, n_b = start_in(Plane(1, 1, 0.4, 2e-4), body, rotation.IDENTITY, ORBIT)
    t_s = np.linspace(0.0, 2e4, 50)
    bare = Planar(System(np.diag(body), orbit=ORBIT), State(q_ib, omega)).at(t_s)
    for momentum in (4.0, -300.0):
        rotor = Rotor('constant_momentum', n_b, momentum)
        states = Planar(System(np.diag(body), (rotor,), ORBIT), State(q_ib, omega)).at(t_s)
        assert np.array_equal(states.q_ib, bare.q_ib)


def test_a_free_rotor_takes_its_inertia_out_of_the_swing():
    """Proves I_n = I - J for a rotor that turns freely: the period is that of the lighter body."""
    body, J = np.array([600.0, 900.0, 800.0]), 250.0
    q_ib, omega, n_b = start_in(Plane(1, 1, 0.4, 2e-4), body, rotation.IDENTITY, ORBIT)
    free = System(np.diag(body), (Rotor('free', n_b, inertia=J),), ORBIT)
    N = np.sqrt(3.0 * (800.0 - 600.0) / (900.0 - J)) * ORBIT.mean_motion
    k = np.hypot(2e-4 / N, np.sin(0.4 - np.pi / 2.0))
    period = 4.0 / N * float(mp.ellipk(k**2))
    motion = Planar(free, State(q_ib, omega, 5.0, 0.1))
    assert motion.k == pytest.approx(k, rel=1e-12)
    assert motion.period_s == pytest.approx(period, rel=1e-12)


@pytest.mark.long
@settings(max_examples=200)
@given(st.data())
def test_beletsky_agrees_with_propagation(data):
    """Proves the plane of a fixed field, all regimes, signs of A - C and of the gradient."""
    orbit = FixedDirection(data.draw(signs) * data.draw(powers_of_ten(-6.0, 1.0)))
    _agrees(data, orbit, data.draw(moments()), np.sqrt(abs(orbit.gradient)), _no_weight)


@pytest.mark.long
@settings(max_examples=200)
@given(st.data())
def test_balli_and_grioli_agree_with_propagation(data):
    """Proves the plane of a circular orbit, either sense of the normal, at any time of a run."""
    _agrees(data, ORBIT, data.draw(moments()), np.sqrt(3.0) * ORBIT.mean_motion, _no_weight)


@pytest.mark.long
@settings(max_examples=200)
@given(st.data())
def test_the_offset_pendulum_agrees_with_propagation(data):
    """Proves the offset pendulum as a motion of a body, weight and gradient of any proportion."""
    gradient = data.draw(st.one_of(st.just(0.0), powers_of_ten(-2.0, 1.0)))
    I = data.draw(moments())
    weight = np.max(I) * data.draw(powers_of_ten(-2.0, 2.0))
    direction = data.draw(angles)

    def weight_moment(e_1, e_2):
        return weight * (np.cos(direction) * e_1 + np.sin(direction) * e_2)

    scale = np.sqrt(gradient + weight / np.min(I))
    _agrees(data, FixedDirection(gradient), I, scale, weight_moment)


def _no_weight(e_1, e_2):
    return np.zeros(3)


def _agrees(data, orbit, I, scale, weight_moment):
    """Draw the rest of a planar scenario and compare it with its propagation."""
    q_bp = data.draw(body_axes())
    start_s = data.draw(st.floats(0.0, 1e4)) if orbit.has_lvlh else 0.0
    slow = data.draw(st.one_of(st.just(0.0), powers_of_ten(-3.0, 1.0)))
    plane = Plane(
        data.draw(st.integers(0, 2)),
        data.draw(signs),
        data.draw(angles),
        data.draw(signs) * slow * scale,
    )
    q_ib, omega, n_b = start_in(plane, I, q_bp, orbit, start_s, data.draw(angles))
    rotor, speed = Rotor(), np.nan
    mode = data.draw(st.sampled_from(['none', 'constant_momentum', 'free', 'motor']))
    fraction = data.draw(st.floats(0.01, 0.6))
    if mode == 'constant_momentum':
        rotor = Rotor(mode, n_b, momentum=float(10.0 * fraction * I[plane.axis] * scale))
    elif mode != 'none':
        rotor, speed = Rotor(mode, -n_b, inertia=fraction * I[plane.axis]), 3.0 * scale
    R_bp = rotation.matrix(q_bp)
    weight = weight_moment(R_bp[:, plane.axis - 2], R_bp[:, plane.axis - 1])
    system = System(inertia_in_body_axes(I, q_bp), (rotor,), orbit, weight)
    start = State(q_ib, omega, speed, 0.2 if rotor.turns_freely else np.nan)
    # At rest a hair beside an equilibrium, the torque alone gives the plane, with few digits.
    assume(slow > 0.0 or Planar.why_not(system, start) is None)
    motion = Planar(system, start, start_s)
    total = scale + np.linalg.norm(omega)
    duration = min(10.0 * (motion.period_s or 1.0 / scale), 300.0 / total)
    assert_agrees(motion, np.linspace(0.0, duration, 40), total)


@pytest.mark.parametrize(
    'name', ['B1_planar_libration', 'B2_planar_rotation', 'B8_offset_rotation']
)
def test_rows_do_not_depend_on_each_other(name):
    """Proves random access: a million times give the same bits as each time alone."""
    motion = Planar(CASES[name].system, CASES[name].start)
    t_s = np.random.default_rng(0).uniform(0.0, 1e5, 10**6)
    states = motion.at(t_s)
    for i in (0, 1, 77_777, 999_999):
        assert np.array_equal(motion.at(t_s[i]).q_ib[0], states.q_ib[i])
        assert np.array_equal(motion.at(t_s[i]).omega_bi_b[0], states.omega_bi_b[i])


def test_it_says_why_not():
    """Proves the refusals, each by its own reason."""
    body = np.array([600.0, 900.0, 800.0])
    q_ib, omega, _ = start_in(Plane(1, 1, 0.4, 2e-4), body, rotation.IDENTITY, ORBIT)
    inertia, start = np.diag(body), State(q_ib, omega)
    skew = Rotor('constant_momentum', np.array([0.0, 0.6, 0.8]), 1.0)
    product = inertia + 1e-6 * np.array([[0, 1, 0], [1, 0, 0], [0, 0, 0]])
    tilted = State(q_ib, omega + 1e-9 * X)
    torque = np.array([0.0, 0.0, 1e-6])
    fixed = FixedDirection(1e-6)
    eccentric = KeplerOrbit(eccentricity=0.1)
    along = State(rotation.IDENTITY, np.array([0.0, 0.0, 0.1]))
    across = State(rotation.IDENTITY, np.array([0.0, 0.1, 0.0]))
    reasons = {
        'the rotor is not along the orbit normal': (System(inertia, (skew,), ORBIT), start),
        'the orbit normal is not a principal axis': (System(product, orbit=ORBIT), start),
        'does not rotate about the orbit normal': (System(inertia, orbit=ORBIT), tilted),
        'eccentricity is 0.1': (System(inertia, orbit=eccentric), start),
        'a torque is applied': (System(inertia, orbit=ORBIT, torque_b=torque), start),
        'not perpendicular to the direction': (System(inertia, orbit=fixed), along),
        'weight_moment is not perpendicular to': (
            System(inertia, orbit=fixed, weight_moment=Y),
            across,
        ),
    }
    for words, (refused, state) in reasons.items():
        assert words in (Planar.why_not(refused, state) or '')
        with pytest.raises(ValueError, match=words):
            Planar(refused, state)


def test_at_rest_in_an_equilibrium_of_a_fixed_field():
    """Proves the rest that has neither rate nor torque to give its plane."""
    system = System(np.diag([1.0, 1.5, 2.0]), orbit=FixedDirection(1.0))
    motion = Planar(system, State(rotation.IDENTITY, np.zeros(3)))
    assert motion.regime == 'rest'
    np.testing.assert_array_equal(motion.at(1e6).q_ib[0], rotation.IDENTITY)
