from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from satdyn_ros.kernel import rotation
from satdyn_ros.theory import euler_angles

close = partial(assert_allclose, rtol=0.0)

angles = st.floats(-3.1, 3.1)
nutations = st.floats(1e-3, np.pi - 1e-3)
rates = arrays(float, 3, elements=st.floats(-2.0, 2.0))


@given(P=angles, theta=nutations, S=angles)
def test_angles_are_scipys_intrinsic_zxz(P, theta, S):
    """from_zxz builds scipy's Rz(P) Rx(theta) Rz(S), and zxz_angles takes it apart again."""
    q = euler_angles.from_zxz(P, theta, S)
    expected = Rotation.from_euler('ZXZ', [P, theta, S]).as_matrix()
    close(rotation.matrix(q), expected, atol=4e-15)
    # Angles lose the factor 1 / sin theta, at most 1e3 here.
    close(euler_angles.zxz_angles(q), [P, theta, S], atol=2e-12)
    close(euler_angles.zxz_angles(-q), [P, theta, S], atol=2e-12)


@given(turn=angles)
def test_the_poles_have_no_spin(turn):
    """At theta = 0 and pi, where only P + S and P - S count, all of the turn is precession."""
    upright = rotation.about([0, 0, 1], turn)
    hanging = rotation.multiply(upright, rotation.about([1, 0, 0], np.pi))
    close(euler_angles.zxz_angles(upright), [turn, 0.0, 0.0], atol=4e-15)
    P, theta, S = euler_angles.zxz_angles(hanging)
    assert (theta, S) == (np.pi, 0.0)
    assert np.sin((P - turn) / 2.0) == pytest.approx(0.0, abs=4e-15)


@given(P=angles, theta=nutations, S=angles, rate=rates)
def test_rates_are_the_derivatives_of_the_angles(P, theta, S, rate):
    """
    The rate made of P', theta', S' is that of the turning matrix, R^T R', and gives them back.

    R' by a central difference of 1e-6 s: error 1e-12 by truncation, 1e-10 by rounding.
    """
    angle, h = np.array([P, theta, S]), 1e-6
    omega = euler_angles.rate_from_zxz(angle, rate)
    before, after = (
        rotation.matrix(euler_angles.from_zxz(*(angle + s * h * rate))) for s in (-1, 1)
    )
    turning = rotation.matrix(euler_angles.from_zxz(*angle)).T @ (after - before) / (2.0 * h)
    close([turning[2, 1], turning[0, 2], turning[1, 0]], omega, atol=1e-8)
    close(euler_angles.zxz_rates(euler_angles.from_zxz(*angle), omega), rate, atol=1e-11)


@pytest.mark.parametrize(('theta', 'sign'), [(0.0, 1.0), (np.pi, -1.0)])
def test_rates_at_the_pole_are_the_rates_of_leaving_it(theta, sign):
    """A body that swings through the pole leaves it at |omega perpendicular|."""
    q = euler_angles.from_zxz(0.4, theta, 0.0)
    close(euler_angles.zxz_rates(q, [0.3, -0.4, 0.7]), [sign * 0.7, 0.5, 0.0], atol=1e-12)


def test_tables_are_as_single_rows():
    """Every function works on the last axis, regular rows beside singular ones."""
    q = np.stack([rotation.IDENTITY, euler_angles.from_zxz(0.3, 1.1, -0.7)])
    omega = np.array([[0.1, 0.2, 0.3], [0.3, -0.2, 0.1]])
    for i in range(2):
        assert np.array_equal(euler_angles.zxz_angles(q)[i], euler_angles.zxz_angles(q[i]))
        assert np.array_equal(
            euler_angles.zxz_rates(q, omega)[i], euler_angles.zxz_rates(q[i], omega[i])
        )


@given(P=angles, theta=nutations, S=angles)
def test_the_node_is_across_both_axes(P, theta, S):
    """It is z_a x z_b in both frames, and the same line in space."""
    q = euler_angles.from_zxz(P, theta, S)
    in_a, in_b = euler_angles.node(q)
    z_a, z_b = np.array([0.0, 0.0, 1.0]), rotation.rotate(q, [0.0, 0.0, 1.0])
    close(in_a * np.sin(theta), np.cross(z_a, z_b), atol=1e-14)
    # angles lose the factor 1 / sin theta, at most 1e3 here
    close(rotation.rotate(q, in_b), in_a, atol=2e-12)


def test_kinetic_energy_in_euler_angles():
    """T of (43.14) is the sum over the masses of a body, from positions a moment apart."""
    masses, positions = (
        np.array([1.0, 2.0, 0.5, 1.5]),
        np.random.default_rng(1).normal(size=(4, 3)),
    )
    whole = np.sum(masses[:, None, None] * positions[:, :, None] * positions[:, None, :], axis=0)
    moments, R = np.linalg.eigh(np.trace(whole) * np.eye(3) - whole)
    R[:, 2] *= np.linalg.det(R)
    angle, rate, h = np.array([0.3, 1.1, -0.7]), np.array([0.5, -0.4, 1.2]), 1e-6
    before, after = (
        positions @ R @ rotation.matrix(euler_angles.from_zxz(*(angle + s * h * rate))).T
        for s in (-1, 1)
    )
    speeds = np.linalg.norm(after - before, axis=-1) / (2.0 * h)
    expected = np.sum(masses * speeds**2) / 2.0
    assert euler_angles.kinetic_energy(moments, angle, rate) == pytest.approx(expected, rel=1e-8)
    # (43.15)
    A, C, (_, theta, _) = 2.0, 3.0, angle
    symmetric = A * (rate[1] ** 2 + (rate[0] * np.sin(theta)) ** 2) / 2.0
    symmetric += C * (rate[2] + rate[0] * np.cos(theta)) ** 2 / 2.0
    assert euler_angles.kinetic_energy([A, A, C], angle, rate) == pytest.approx(
        symmetric, rel=1e-14
    )
