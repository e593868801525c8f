from functools import partial

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.linalg import logm
from scipy.spatial.transform import Rotation

from satdyn_ros.dynamics.rotor import Rotor
from satdyn_ros.dynamics.system import State, System
from satdyn_ros.exact.free import Free
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import FixedDirection, KeplerOrbit
from satdyn_ros.theory import equilibria, stability

close = partial(assert_allclose, rtol=0.0)

N = 1.1e-3
ORBIT = KeplerOrbit(semi_major_axis=(3.986004418e14 / N**2) ** (1 / 3))
NORMAL = np.array([0.0, -1.0, 0.0])
moments = st.tuples(*[st.floats(0.5, 1.0)] * 3)


def aligned(I_r, I_t, I_n, h=0.0):
    """Return the system and state with body axes along LVLH and the rotor along the normal."""
    rotor = Rotor('constant_momentum', NORMAL, h)
    system = System(np.diag([I_t, I_n, I_r]), (rotor,), ORBIT)
    return system, equilibria.at_rest_in_lvlh(ORBIT, rotation.IDENTITY)


@pytest.mark.parametrize('j', range(3))
@pytest.mark.parametrize('h', [0.0, 0.4, -1.2])
@pytest.mark.parametrize('side', [[0.0, 0.0, 0.0], [0.4, -0.3, 0.8]])
def test_rotation_about_a_principal_axis(j, h, side):
    """lambda^2 = -((Ij - Ik) W + h) ((Ij - Il) W + h) / (Ik Il), in any body axes (44.10)."""
    I, W, R = np.array([1.0, 1.7, 2.2]), 0.6, Rotation.from_rotvec(side).as_matrix()
    k, l = (j + 1) % 3, (j + 2) % 3
    expected = -((I[j] - I[k]) * W + h) * ((I[j] - I[l]) * W + h) / (I[k] * I[l])
    found = stability.eigenvalue_squared(R @ np.diag(I) @ R.T, R[:, j] * W, R[:, j] * h)
    assert found == pytest.approx(expected, abs=1e-15)


def test_the_middle_axis_has_the_textbook_rate():
    """The rate is sqrt(2E (I3 - I2)(I2 - I1) / (I1 I2 I3)), with I2 and not I2^2 below (44.10)."""
    I, W = np.array([1.0, 1.7, 2.2]), 0.6
    E = I[1] * W**2 / 2.0
    expected = 2.0 * E * (I[2] - I[1]) * (I[1] - I[0]) / np.prod(I)
    found = stability.eigenvalue_squared(np.diag(I), [0.0, W, 0.0])
    assert found == pytest.approx(expected, rel=1e-14)


def test_the_departure_from_the_middle_axis_grows_at_that_rate():
    """A propagated start 1e-6 off the middle axis departs as cosh(lambda t)."""
    I, W = np.diag([1.0, 1.7, 2.2]), 0.6
    rate = np.sqrt(stability.eigenvalue_squared(I, [0.0, W, 0.0]))
    motion = Propagation(System(I), State(rotation.IDENTITY, np.array([1e-6, W, 0.0])))
    t_s = np.linspace(0.0, 4.0 / rate, 20)
    # Second order in the departure, which ends at 3e-5 of W.
    close(motion.at(t_s).omega_bi_b[:, 0], 1e-6 * np.cosh(rate * t_s), atol=1e-12)


@given(I=moments, h=st.floats(-2.0, 2.0))
def test_a_free_rotation_has_the_same_eigenvalues_in_both_functions(I, h):
    """Beside +-lambda the six have those of the turned attitude: 0, 0 and +-i W."""
    W = 0.7
    rotor = Rotor('constant_momentum', np.array([0.0, 0.0, 1.0]), h)
    system = System(np.diag(I), (rotor,), FixedDirection())
    state = State(rotation.normalise([0.1, 0.5, 0.7, 0.5]), np.array([0.0, 0.0, W]))
    square = stability.eigenvalue_squared(np.diag(I), state.omega_bi_b, [0.0, 0.0, h])
    # Compare the polynomials in s^2: two of its six roots stand for four of the six in s.
    squares = stability.eigenvalues(system, state) ** 2
    found = np.poly(squares)
    expected = np.poly([0.0, 0.0, -(W**2), -(W**2), square, square])
    # Rounding is relative to the largest power of the largest root.
    close(found, expected, atol=1e-12 * (1.0 + abs(square)) ** 6)


@pytest.mark.parametrize(
    ('h', 'frequencies'),
    [(0.0, [0.816497, 1.437541, 0.347816]), (1.5, [0.816497, 2.421772, 1.154492])],
)
def test_published_frequencies(h, frequencies):
    """
    Moments 900, 800, 600 about normal, track and radius, with and without a rotor.

    In units of n, to the six digits given; the general eigenvalues give the same.
    """
    motion = stability.small_motion(600.0, 800.0, 900.0, N, h)
    close(motion.frequencies / N, frequencies, atol=6e-7)
    assert motion.is_stable
    system, state = aligned(600.0, 800.0, 900.0, h)
    found = np.sort(np.abs(stability.eigenvalues(system, state).imag)) / N
    close(found[::2], np.sort(frequencies), atol=6e-7)


def test_periods_of_the_nasa_cylinder():
    """
    A cylinder of 500, 12250, 12250 kg m^2 along the radius, period 5526.56 s.

    NASA's JEOD verification quotes 3257.94 s in the plane and 2821.46 s across it from Hughes; the
    second is that of roll alone, 2 n sqrt(k_R), without its coupling to yaw.
    """
    period = 5526.56
    in_plane = stability.small_motion(500.0, 12250.0, 12250.0, 2.0 * np.pi / period).frequencies[0]
    assert 2.0 * np.pi / in_plane == pytest.approx(3257.94, abs=0.01)
    k_R, _ = stability.smelt_parameters(500.0, 12250.0, 12250.0)
    assert period / (2.0 * np.sqrt(k_R)) == pytest.approx(2821.46, abs=0.01)


@given(I=moments, h=st.floats(-3.0, 3.0))
def test_the_closed_form_is_the_general_one(I, h):
    """Pitch and roll-yaw have the eigenvalues of the six linear equations."""
    I_r, I_t, I_n = I
    motion = stability.small_motion(I_r, I_t, I_n, 1.0, h)
    system, state = aligned(I_r, I_t, I_n, h * N)
    squares = (stability.eigenvalues(system, state) / N) ** 2
    expected = np.poly(np.repeat([motion.pitch, *motion.roll_yaw], 2))
    size = (1.0 + np.max(np.abs(motion.roll_yaw))) ** 6
    close(np.poly(squares), expected, atol=1e-12 * size)


@given(I=moments, h=st.floats(-3.0, 3.0))
def test_a_minimum_of_the_potential_suffices(I, h):
    """Where the amended potential has a minimum the linear motion is stable too."""
    I_r, I_t, I_n = I
    if stability.is_surely_stable(I_r, I_t, I_n, 1.0, h):
        motion = stability.small_motion(I_r, I_t, I_n, 1.0, h)
        # Two roots that meet are parted by the root of rounding, to either side.
        edge = abs(motion.roll_yaw[0] - motion.roll_yaw[1]) < 1e-7
        assert motion.is_stable or edge


@given(I=moments)
def test_the_regions_are_where_a_body_without_rotor_is_stable(I):
    """Lagrange and DeBra-Delp are all of the stable moments, and Lagrange's is the sure part."""
    I_r, I_t, I_n = I
    k_R, k_Y = stability.smelt_parameters(*I)
    margin = 1.0 + 3.0 * k_R + k_R * k_Y - 4.0 * np.sqrt(max(k_R * k_Y, 0.0))
    assume(min(abs(k_R), abs(k_Y), abs(k_R - k_Y), abs(margin)) > 1e-9)
    region = stability.stability_region(*I)
    assert (region is not None) == stability.small_motion(I_r, I_t, I_n, 1.0).is_stable
    assert (region == 'Lagrange') == (I_n > I_t > I_r)
    assert (region == 'Lagrange') == stability.is_surely_stable(I_r, I_t, I_n, 1.0)


@pytest.mark.parametrize(
    ('I', 'region'),
    [
        ((600.0, 800.0, 900.0), 'Lagrange'),
        ((1.0, 1.5238, 0.9238), 'DeBra-Delp'),
        ((800.0, 900.0, 600.0), None),
        ((900.0, 800.0, 600.0), None),
        ((800.0, 800.0, 900.0), None),
        ((600.0, 800.0, 800.0), None),
    ],
)
def test_examples_of_the_regions(I, region):
    """The region's name by (I_r, I_t, I_n); two equal moments, a boundary, belong to neither."""
    assert stability.stability_region(*I) == region


def transition(system, state, t_s):
    """
    Return the 6 x 6 matrix of small turns and rates after t_s, by central differences.

    A perturbed rate leaves the rotor its axial momentum.
    """
    rotor, columns = system.rotors[0], []
    p = rotor.axial_momentum(state.rotor_speed[0], state.omega_bi_b)
    for i in range(6):
        ends = []
        for step in (1e-5, -1e-5):
            turn = step * np.eye(3)[i] if i < 3 else np.zeros(3)
            q = rotation.multiply(state.q_ib, rotation.normalise([*(turn / 2.0), 1.0]))
            omega = state.omega_bi_b + (step * N * np.eye(3)[i - 3] if i >= 3 else 0.0)
            start = State(q, omega, rotor.speed(p, omega), 0.0)
            ends.append(Propagation(system, start, tolerance=1e-13).at(t_s)[0])
        turn = rotation.multiply(rotation.conjugate(ends[1].q_ib), ends[0].q_ib)
        angle = 2.0 * turn[:3] * np.sign(turn[3])
        columns.append(np.append(angle, (ends[0].omega_bi_b - ends[1].omega_bi_b) / N) / 2e-5)
    return np.stack(columns, axis=-1)


@pytest.mark.parametrize('case', ['skew gyrostat', 'vertical spin', 'free wheel'])
def test_eigenvalues_are_those_of_propagated_departures(case):
    """
    The logarithm of the propagated transition over an arc has the eigenvalues of the matrix.

    Tolerance: differences of 1e-5 leave 1e-10 of curvature, rounding 1e-13 / 1e-5 = 1e-8; pairs of
    zeros take the root of that.
    """
    t_s, I = 600.0, np.diag([900.0, 800.0, 600.0])
    if case == 'skew gyrostat':
        q_lb = rotation.about([0.0, 0.0, 1.0], 0.4)
        h = equilibria.equilibrium_momentum(I, q_lb, N, -2.0)
        size = float(np.linalg.norm(h))
        system = System(I, (Rotor('constant_momentum', h / size, size),), ORBIT)
        state = equilibria.at_rest_in_lvlh(ORBIT, q_lb)
    elif case == 'vertical spin':
        system = System(I, orbit=FixedDirection(N**2))
        q = rotation.normalise([0.1, 0.5, 0.7, 0.5])
        state = State(q, N * rotation.rotate(rotation.conjugate(q), [0.0, 0.0, 1.0]))
    else:
        system = System(I, (Rotor('free', NORMAL, inertia=30.0),), ORBIT)
        rest = equilibria.at_rest_in_lvlh(ORBIT, rotation.IDENTITY)
        state = State(rest.q_ib, rest.omega_bi_b, rotor_speed=0.05, rotor_angle=0.0)
    assert equilibria.is_balanced(system, state)
    found = np.linalg.eigvals(logm(transition(system, state, t_s))) / t_s
    expected = stability.eigenvalues(system, state)
    close(np.poly(found / N), np.poly(expected / N), atol=1e-6)


def test_a_rotation_that_is_stable_in_rate_drifts_in_attitude():
    """
    By (44.11): after a day the closed forms of two near rates are as far apart as is said.

    A millionth more about the largest moment; a millionth across it changes next to nothing.
    """
    body, omega = System(np.diag([1.0, 2.0, 2.5])), np.array([0.0, 0.0, 0.5])
    start = Free(body, State(rotation.IDENTITY, omega))
    for change in (1e-6 * omega, np.array([0.5e-6, 0.0, 0.0])):
        near = Free(body, State(rotation.IDENTITY, omega + change))
        apart = rotation.angle_between(near.at([86400.0]).q_ib, start.at([86400.0]).q_ib)[0]
        assert apart == pytest.approx(stability.attitude_drift(omega, change), abs=5e-6)
    assert stability.attitude_drift(omega, 1e-6 * omega) == pytest.approx(0.0432, rel=1e-12)
    assert stability.attitude_drift(np.zeros(3), omega) == 0.0
