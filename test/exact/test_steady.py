from functools import partial

import numpy as np
import pytest
from cases import newtonian
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from satdyn_ros.dynamics.rotor import Rotor
from satdyn_ros.dynamics.system import State, System
from satdyn_ros.exact.steady import Steady
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import FixedDirection, KeplerOrbit
from satdyn_ros.theory import equilibria, stability

close = partial(assert_allclose, rtol=0.0)

SIDE = Rotation.from_rotvec([0.4, -0.3, 0.8]).as_matrix()
TRIAXIAL = SIDE @ np.diag([900.0, 800.0, 600.0]) @ SIDE.T
ORBIT = KeplerOrbit(inclination=0.9, raan=2.1, argument_of_periapsis=0.3, true_anomaly=1.2)
N = ORBIT.mean_motion
ANY = rotation.normalise([0.1, 0.5, 0.7, 0.5])
X, Y, Z = np.eye(3)
vectors = arrays(float, 3, elements=st.floats(-1.0, 1.0))


def gyrostat(inertia, h, orbit):
    size = float(np.linalg.norm(h))
    return System(inertia, (Rotor('constant_momentum', h / size, size),), orbit)


def vertical(q_ib):
    return rotation.rotate(rotation.conjugate(q_ib), Z)


def assert_agrees_with_propagation(system, state, start_s=0.0, growth=1.0, turns=2.0):
    """
    Compare with a propagation at 1e-13 over some turns.

    1e-10 for its own error, and rounding of the start, 1e-14, times the growth of departures.
    """
    motion = Steady(system, state, start_s)
    slowest = max(motion.rate, N if system.orbit.has_lvlh else 0.0, 1e-9)
    t_s = np.linspace(0.0, turns * 2.0 * np.pi / slowest, 30)
    exact = motion.at(t_s)
    numeric = Propagation(system, state, start_s, tolerance=1e-13).at(t_s)
    allowed = 1e-10 + 1e-14 * growth
    assert np.max(rotation.angle_between(exact.q_ib, numeric.q_ib)) < allowed
    close(exact.omega_bi_b, numeric.omega_bi_b, atol=allowed * slowest)
    close(exact.rotor_speed, numeric.rotor_speed, atol=allowed * slowest)
    close(exact.rotor_angle, numeric.rotor_angle, atol=1e-9 + allowed)


def growth(system, state, start_s, turns):
    """Return by how much a departure grows over some orbits, by the linear equations."""
    rate = np.max(stability.eigenvalues(system, state, start_s).real)
    return np.exp(rate * turns * 2.0 * np.pi / N)


def test_the_reference_of_the_uniform_spin():
    """Balli and Grioli's spin along the orbit normal with its rotor, to the bound of the case."""
    case = newtonian()['G5_BG_uniform_spin_on_normal']
    states = Steady(case.system, case.start).at(case.t_s)
    assert np.max(rotation.angle_between(states.q_ib, case.q_ib)) < case.bound_exact
    close(states.omega_bi_b, case.omega_bi_b, atol=10.0 * case.bound_exact * 0.45)


@pytest.mark.parametrize('start_s', [0.0, 1234.5])
def test_the_24_relative_equilibria_of_a_triaxial_body(start_s):
    """Each of the 24 is flown with the orbit, wherever on it the motion begins."""
    system = System(TRIAXIAL, orbit=ORBIT)
    for q_lb in equilibria.relative_equilibria(TRIAXIAL):
        state = equilibria.at_rest_in_lvlh(ORBIT, q_lb, start_s)
        turns = 1.0
        factor = growth(system, state, start_s, turns)
        assert_agrees_with_propagation(system, state, start_s, factor, turns)
        close(
            rotation.angle_between(Steady(system, state, start_s).at([1e4]).q_lb, q_lb),
            0.0,
            atol=1e-13,
        )


@given(k=vectors, along_normal=st.floats(-5.0, 5.0))
def test_skew_gyrostats_rest_on_the_orbit(k, along_normal):
    """Any attitude without pitch torque, held by its rotor, is flown and agrees."""
    assume(np.linalg.norm(k) > 0.1)
    k = k / np.linalg.norm(k)
    basis = np.linalg.svd(k[None])[2][1:].T
    c = basis @ np.linalg.eigh(basis.T @ TRIAXIAL @ basis)[1][:, 0]
    q_lb = rotation.from_matrix(np.stack([np.cross(k, c), -k, -c]))
    h = equilibria.equilibrium_momentum(TRIAXIAL, q_lb, N, along_normal)
    assume(np.linalg.norm(h) > 1e-6)
    system, state = gyrostat(TRIAXIAL, h, ORBIT), equilibria.at_rest_in_lvlh(ORBIT, q_lb, 50.0)
    factor = growth(system, state, 50.0, 1.0)
    assume(factor < 1e8)
    assert_agrees_with_propagation(system, state, 50.0, factor, turns=1.0)


def test_a_free_wheel_keeps_its_speed_and_turns_on():
    """With a free-spinning rotor the rotor's angle and speed come with the motion."""
    wheel = Rotor('free', -Y, inertia=30.0)
    system = System(np.diag([800.0, 900.0, 600.0]), (wheel,), ORBIT)
    rest = equilibria.at_rest_in_lvlh(ORBIT, rotation.IDENTITY)
    state = State(rest.q_ib, rest.omega_bi_b, rotor_speed=0.05, rotor_angle=0.3)
    assert_agrees_with_propagation(system, state)


@given(h=vectors, rate=st.floats(0.2, 2.0))
def test_permanent_rotations_of_a_free_gyrostat(h, rate):
    """Every permanent rotation that is found for a free gyrostat is flown."""
    assume(np.linalg.norm(h) > 0.1)
    inertia = TRIAXIAL / 600.0
    system = gyrostat(inertia, h, FixedDirection())
    for omega in equilibria.permanent_rotations(inertia, rate, h):
        square = stability.eigenvalue_squared(inertia, omega, h)
        factor = np.exp(np.sqrt(max(square, 0.0)) * 4.0 * np.pi / rate)
        if factor < 1e8:
            assert_agrees_with_propagation(system, State(ANY, omega), growth=factor)


def test_a_gyrostat_of_next_to_no_momentum():
    """Proves that the balance is relative to what cancels in H, body and rotor, not to H."""
    inertia, omega = TRIAXIAL / 600.0, np.array([-0.26, -0.33, -0.84])
    h = 1e-8 * omega - inertia @ omega
    assert Steady.why_not(gyrostat(inertia, h, FixedDirection()), State(ANY, omega)) is None
    changed = gyrostat(inertia, h + 1e-9 * X, FixedDirection())
    assert 'omega x H' in (Steady.why_not(changed, State(ANY, omega)) or '')


@pytest.mark.parametrize('sign', [1.0, -1.0])
def test_agostinellis_uniform_spin_of_an_oblique_body(sign):
    """In a field of fixed direction any attitude turns at sqrt(3 mu / r^3) about the vertical."""
    system = System(TRIAXIAL, orbit=FixedDirection(3.63e-6))
    state = State(ANY, sign * np.sqrt(3.63e-6) * vertical(ANY))
    assert_agrees_with_propagation(system, state)


def test_a_heavy_gyrostat_about_the_vertical():
    """Weight, gradient and rotor together, at the rates that balance them."""
    c, inertia = vertical(ANY), TRIAXIAL / 600.0
    across = np.cross(c, inertia @ c)
    plane = np.eye(3) - np.outer(across, across) / (across @ across)
    m, h = plane @ [0.1, -0.3, 0.2], plane @ [0.2, 0.1, 0.4]
    rates = equilibria.vertical_rotation_rates(inertia, c, 0.4, m, h)
    size = float(np.linalg.norm(h))
    rotor = Rotor('constant_momentum', h / size, size)
    system = System(inertia, (rotor,), FixedDirection(0.4), weight_moment=m)
    assert rates is not None
    assert len(rates) == 2
    for W in rates:
        assert_agrees_with_propagation(system, State(ANY, W * c))


def test_spin_where_weight_and_gradient_cancel():
    """A symmetric body spins about its inclined axis where U'(u) = 0, without precession."""
    gradient, u = 0.8, vertical(ANY)[2]
    # -m x c + k c x I c = 0 along the axis: m = -k (C - A) u.
    m = -gradient * (1.5 - 1.0) * u
    system = System(
        np.diag([1.0, 1.0, 1.5]), orbit=FixedDirection(gradient), weight_moment=np.array([0, 0, m])
    )
    assert_agrees_with_propagation(system, State(ANY, np.array([0.0, 0.0, 0.7])))


@pytest.mark.parametrize('e', [0.0, 0.2])
@pytest.mark.parametrize('rate', [0.0, 0.01])
def test_spin_along_the_normal_of_any_orbit(e, rate):
    """A symmetric body with its axis along the normal feels no torque, also on an ellipse."""
    orbit = KeplerOrbit(semi_major_axis=9.0e6, eccentricity=e, inclination=0.9, raan=2.1)
    q_ib = rotation.multiply(rotation.from_matrix(orbit.perifocal), rotation.about(Z, 0.4))
    system = System(np.diag([2.0, 2.0, 3.0]), orbit=orbit)
    # The wheel shape is stable; at rest the axis leaves slowly at most with 2 n.
    assert_agrees_with_propagation(system, State(q_ib, rate * Z), turns=1.0)


def test_a_sphere_turns_anyhow():
    """Without any torque a spherical body keeps every rate, with a rotor those along it."""
    sphere = System(2.0 * np.eye(3), orbit=KeplerOrbit(eccentricity=0.3))
    assert_agrees_with_propagation(sphere, State(ANY, np.array([0.01, -0.02, 0.005])))
    h = np.array([0.1, 0.2, -0.1])
    with_rotor = gyrostat(2.0 * np.eye(3), h, ORBIT)
    assert_agrees_with_propagation(with_rotor, State(ANY, -0.1 * h))
    assert 'does not balance' in (Steady.why_not(with_rotor, State(ANY, 0.01 * X)) or '')


def test_a_constant_torque_in_the_body_can_hold_an_oblique_rotation():
    """An applied torque that equals omega x H keeps omega."""
    omega, inertia = np.array([0.2, -0.1, 0.3]), np.diag([1.0, 2.0, 2.5])
    system = System(inertia, torque_b=np.cross(omega, inertia @ omega))
    assert_agrees_with_propagation(system, State(ANY, omega))


def test_rest():
    """A body at rest without field stays, and one whose principal axis is vertical."""
    at_rest = State(ANY, np.zeros(3))
    assert np.array_equal(Steady(System(TRIAXIAL), at_rest).at(1e6).q_ib, [ANY])
    upright = State(rotation.IDENTITY, np.zeros(3))
    system = System(np.diag([900.0, 800.0, 600.0]), orbit=FixedDirection(3.63e-6))
    assert Steady.why_not(system, upright) is None
    assert 'does not balance' in (Steady.why_not(system, at_rest) or '')


@pytest.mark.parametrize(
    ('system', 'state', 'why'),
    [
        (
            System(np.eye(3), (Rotor('motor', X, inertia=0.1),), rotor_torque=np.array(0.1)),
            State(ANY, np.zeros(3), 0.0, 0.0),
            'a torque is applied to the body or to a rotor',
        ),
        (
            System(TRIAXIAL),
            State(ANY, SIDE[:, 1] + 1e-9 * SIDE[:, 0]),
            'the torque does not balance omega x H: the rate of rotation changes',
        ),
        (
            # The long axis is radial now and leaves it: the rate is not the orbit's.
            System(np.diag([800.0, 900.0, 600.0]), orbit=ORBIT),
            State(ORBIT.lvlh(0.0), np.array([0.0, -1.01 * N, 0.0])),
            'the direction to the attracting centre, and the torque, turn in the body',
        ),
        (
            # Momentarily right on an ellipse, where the rate is that of the pericentre only.
            System(
                np.diag([800.0, 900.0, 600.0]),
                orbit=KeplerOrbit(semi_major_axis=9.0e6, eccentricity=0.1),
            ),
            State(
                KeplerOrbit(semi_major_axis=9.0e6, eccentricity=0.1).lvlh(0.0),
                np.array([0.0, -1.0, 0.0])
                * KeplerOrbit(semi_major_axis=9.0e6, eccentricity=0.1).rate(0.0),
            ),
            'the direction to the attracting centre, and the torque, turn in the body',
        ),
        (
            # A principal axis across the vertical with a spin about it: balanced for an instant.
            System(np.diag([900.0, 800.0, 600.0]), orbit=FixedDirection(3.63e-6)),
            State(rotation.IDENTITY, np.array([0.01, 0.0, 0.0])),
            'the direction to the attracting centre, and the torque, turn in the body',
        ),
    ],
)
def test_the_reason_when_a_motion_is_not_steady(system, state, why):
    """One sentence says why not, and the constructor refuses with it."""
    assert Steady.why_not(system, state) == why
    with pytest.raises(ValueError, match=why[:20]):
        Steady(system, state)


def test_the_start_counts_from_where_the_orbit_is():
    """A state that rests at one time of the orbit does not at another."""
    system = System(TRIAXIAL, orbit=ORBIT)
    state = equilibria.at_rest_in_lvlh(ORBIT, equilibria.relative_equilibria(TRIAXIAL)[0], 500.0)
    assert Steady.why_not(system, state, 500.0) is None
    assert Steady.why_not(system, state) is not None


def test_random_access_gives_the_same_bits():
    """A row does not depend on the others, and the start is given back exactly."""
    system = System(TRIAXIAL, orbit=FixedDirection(3.63e-6))
    state = State(ANY, np.sqrt(3.63e-6) * vertical(ANY))
    motion, t_s = Steady(system, state), np.array([0.0, 1e6, 3.3, 17.0])
    table = motion.at(t_s)
    for i, t in enumerate(t_s):
        assert np.array_equal(table.q_ib[i], motion.at(t).q_ib[0])
    assert np.array_equal(table.q_ib[0], state.q_ib)
    assert np.array_equal(table.omega_bi_b, np.tile(state.omega_bi_b, (4, 1)))
