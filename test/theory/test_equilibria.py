from functools import partial

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from satdyn_ros.dynamics.rotor import Rotor
from satdyn_ros.dynamics.system import State, System
from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import FixedDirection, KeplerOrbit
from satdyn_ros.theory import equilibria

close = partial(assert_allclose, rtol=0.0)

SIDE = Rotation.from_rotvec([0.4, -0.3, 0.8]).as_matrix()
TRIAXIAL = np.diag([900.0, 800.0, 600.0])
SKEW = SIDE @ TRIAXIAL @ SIDE.T
ORBIT = KeplerOrbit(inclination=0.9, raan=2.1, argument_of_periapsis=0.3, true_anomaly=1.2)
vectors = arrays(float, 3, elements=st.floats(-1.0, 1.0))


def gyrostat(inertia, h, orbit):
    """Return a system whose rotor has the constant relative momentum h (3,)."""
    size = float(np.linalg.norm(h))
    axis = h / size if size > 0.0 else np.array([0.0, 1.0, 0.0])
    return System(inertia, (Rotor('constant_momentum', axis, size),), orbit)


def attitude_for(inertia, k, orbit_s):
    """Return q_ib with body axis k along ORBIT's normal and no gravity torque about it."""
    basis = np.linalg.svd(k[None])[2][1:].T
    c = basis @ np.linalg.eigh(basis.T @ inertia @ basis)[1][:, 0]
    R_bl = np.stack([np.cross(k, c), -k, -c], axis=-1)
    return rotation.multiply(ORBIT.lvlh(orbit_s), rotation.from_matrix(R_bl.T))


@given(
    moments=st.tuples(*[st.floats(0.5, 1.0)] * 3),
    h=vectors,
    rate=st.floats(0.05, 3.0),
    turn=vectors,
)
def test_all_permanent_rotations_are_found(moments, h, rate, turn):
    """
    Each has the asked size and keeps omega parallel to H, and none is missing.

    They are the critical points of omega . I omega / 2 + h . omega on the sphere |omega| = rate:
    those where its Hessian is definite less the saddles make 2, the Euler number of the sphere.
    """
    R = Rotation.from_rotvec(turn).as_matrix()
    inertia = R @ np.diag(moments) @ R.T
    found = equilibria.permanent_rotations(inertia, rate, h)
    count = 0
    for omega in found:
        H = inertia @ omega + h
        scale = rate * (np.linalg.norm(h) + rate * np.max(moments))
        assert np.linalg.norm(omega) == pytest.approx(rate, rel=1e-13)
        # Components of h up to 1e-12 of the whole count as none, each of two across omega.
        assert np.linalg.norm(np.cross(omega, H)) <= 2e-12 * scale
        x = omega @ H / rate**2
        basis = np.linalg.svd(omega[None])[2][1:].T
        hessian = np.linalg.det(basis.T @ inertia @ basis - x * np.eye(2))
        # Where two of them meet, or a whole circle is critical, the count says nothing.
        assume(abs(hessian) > 1e-6)
        count += np.sign(hessian)
    assert count == 2


@pytest.mark.parametrize('h', [[0.0, 0.0, 0.0], [0.0, 0.0, 0.4], [1e-9, 0.2, 0.0], [1e-7] * 3])
def test_a_fast_gyrostat_has_six_permanent_rotations(h):
    """Near each principal axis there are two, also where the rotor is weak or along an axis."""
    found = equilibria.permanent_rotations(np.diag([1.0, 2.0, 3.0]), 2.0, h)
    near = np.sort([np.argmax(np.abs(omega)) for omega in found])
    assert list(near) == [0, 0, 1, 1, 2, 2]
    assert len(np.unique(np.round(found, 6), axis=0)) == 6


@pytest.mark.parametrize('inertia', [np.diag([1.0, 1.0, 1.5]), np.eye(3)])
def test_equal_moments_leave_no_spurious_rotations(inertia):
    """With momentum along no principal axis of a symmetric body omega x H = 0 still holds."""
    h = np.array([0.1, 0.2, 0.3])
    found = equilibria.permanent_rotations(inertia, 0.3, h)
    assert len(found) == 2
    close(np.cross(found, found @ inertia + h), 0.0, atol=1e-15)


def test_the_vertical_rates_of_an_oblique_body_are_agostinellis():
    """Any attitude turns uniformly at sqrt(3 mu / r^3) about the vertical (nu = 0)."""
    c = SIDE @ [0.6, 0.0, 0.8]
    rates = equilibria.vertical_rotation_rates(TRIAXIAL, c, gradient=3.63e-6)
    close(rates, [-np.sqrt(3.63e-6), np.sqrt(3.63e-6)], atol=1e-15)


def test_a_principal_axis_stands_vertical_at_any_rate():
    """Spin about a vertical principal axis with weight and rotor along it needs no torque."""
    c = SIDE[:, 1]
    assert equilibria.vertical_rotation_rates(SKEW, c, 1e-6, 2.0 * c, -3.0 * c) is None
    rates = equilibria.vertical_rotation_rates(SKEW, c, 1e-6, SIDE[:, 0])
    assert rates is not None
    assert len(rates) == 0


def test_the_conical_pendulum():
    """A bob of mass m on a rod l at the angle theta circles at W^2 = g / (l cos theta)."""
    m, l, g, theta = 2.0, 0.7, 9.81, 0.5
    c = np.array([np.sin(theta), 0.0, np.cos(theta)])
    rates = equilibria.vertical_rotation_rates(
        m * l * l * np.diag([1.0, 1.0, 0.0]), c, weight_moment=[0.0, 0.0, -m * g * l]
    )
    expected = np.sqrt(g / (l * np.cos(theta)))
    close(rates, [-expected, expected], atol=1e-13)


@given(c=vectors, h=vectors, m=vectors)
def test_vertical_rotations_with_rotor_and_weight_balance(c, h, m):
    """For a rotor and weight in the plane of c and I c there are rates, and they balance."""
    assume(np.linalg.norm(c) > 0.1)
    c = c / np.linalg.norm(c)
    I = np.diag([1.0, 1.4, 2.0])
    across = np.cross(c, I @ c)
    assume(np.linalg.norm(across) > 0.05)
    plane = np.eye(3) - np.outer(across, across) / (across @ across)
    h, m = plane @ h, plane @ m
    rates = equilibria.vertical_rotation_rates(I, c, 0.5, m, h)
    assert rates is not None
    if 0.5 * across @ across + np.cross(c, m) @ across > 1e-6:
        assert len(rates) == 2
    for W in rates:
        torque = 0.5 * np.cross(c, I @ c) - np.cross(m, c)
        turn = np.cross(W * c, I @ (W * c) + h)
        close(turn, torque, atol=1e-11 * (1.0 + W * W))


def test_the_balance_is_the_euler_equation():
    """K omega' = imbalance, on the components written out by hand (Balli and Grioli 1979, 1)."""
    A, B, C = 900.0, 800.0, 600.0
    p, q, r = omega = np.array([2e-3, -1e-3, 1.5e-3])
    h1, h2, h3 = h = np.array([3.0, -2.0, 5.0])
    state = State(rotation.normalise([0.3, 0.2, -0.3, 0.8]), omega)
    system = gyrostat(TRIAXIAL, h, ORBIT)
    c1, c2, c3 = equilibria.direction(system, state, 700.0)
    k = 3.0 * ORBIT.mean_motion**2
    expected = [
        (B - C) * q * r - q * h3 + r * h2 + k * (C - B) * c2 * c3,
        (C - A) * r * p - r * h1 + p * h3 + k * (A - C) * c3 * c1,
        (A - B) * p * q - p * h2 + q * h1 + k * (B - A) * c1 * c2,
    ]
    close(equilibria.imbalance(system, state, 700.0), expected, atol=1e-16)
    assert not equilibria.is_balanced(system, state, 700.0)


@pytest.mark.parametrize('inertia', [TRIAXIAL, SKEW], ids=['principal', 'skew'])
@pytest.mark.parametrize('orbit_s', [0.0, 1.0e6])
def test_a_triaxial_body_rests_in_24_attitudes(inertia, orbit_s):
    """There are 24 different ones and each balances on the orbit, in any body axes."""
    attitudes = equilibria.relative_equilibria(inertia)
    angles = [rotation.angle_between(attitudes, q) for q in attitudes]
    assert np.sum(np.array(angles) < 0.1) == 24
    system = System(inertia, orbit=ORBIT)
    for q_lb in attitudes:
        state = equilibria.at_rest_in_lvlh(ORBIT, q_lb, orbit_s)
        assert equilibria.is_balanced(system, state, orbit_s)


def test_the_first_attitude_is_aligned():
    """A diagonal inertia's first attitude is the identity: x ahead, z down."""
    close(equilibria.relative_equilibria(TRIAXIAL)[0], rotation.IDENTITY, atol=0.0)


@given(k=vectors, along_normal=st.floats(-5.0, 5.0))
def test_a_rotor_holds_any_attitude_without_pitch_torque(k, along_normal):
    """The momentum found balances the attitude, whatever its part along the orbit normal."""
    assume(np.linalg.norm(k) > 0.1)
    k = k / np.linalg.norm(k)
    q_ib = attitude_for(TRIAXIAL, k, 0.0)
    q_lb = rotation.multiply(rotation.conjugate(ORBIT.lvlh(0.0)), q_ib)
    n = ORBIT.mean_motion
    h = equilibria.equilibrium_momentum(TRIAXIAL, q_lb, n, along_normal)
    assert h @ k == pytest.approx(along_normal, abs=1e-12)
    state = equilibria.at_rest_in_lvlh(ORBIT, q_lb)
    assert equilibria.is_balanced(gyrostat(TRIAXIAL, h, ORBIT), state)


def test_no_rotor_holds_a_pitch_torque():
    """A body turned about the normal between its principal axes is refused with the reason."""
    q_lb = rotation.about([0, 1, 0], 0.3)
    with pytest.raises(ValueError, match='cannot balance a pitch torque: it must be 0'):
        equilibria.equilibrium_momentum(TRIAXIAL, q_lb, 1e-3)


def test_balance_is_relative_to_the_torques():
    """Rest without torque balances, a rate 1e-11 off a permanent axis does not."""
    system = System(TRIAXIAL, orbit=FixedDirection())
    assert equilibria.is_balanced(system, State(rotation.IDENTITY, np.zeros(3)))
    assert equilibria.is_balanced(system, State(rotation.IDENTITY, np.array([0.0, 1e-9, 0.0])))
    tilted = State(rotation.IDENTITY, np.array([1e-19, 1e-9, 0.0]))
    assert not equilibria.is_balanced(system, tilted)
