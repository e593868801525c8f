"""Balli and Grioli's relations where they must hold, and where, as printed, they do not."""

import numpy as np
import pytest

from satdyn_ros.dynamics.rotor import Rotor
from satdyn_ros.dynamics.system import State, System
from satdyn_ros.exact.body_fixed import BodyFixed
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import KeplerOrbit

E2 = np.array([0.0, 1.0, 0.0])


def common_points():
    """
    Yield bodies, omega, nu and c on (1)_1, (7), (8) and (10), about axis 2.

    With I_3 = eta (C - A) c_2 c_3 / omega of (1)_1, (10) is quadratic in omega.
    """
    rng = np.random.default_rng(7)
    for _ in range(40):
        A, C, eta, I2 = 1.3, *rng.uniform(0.3, 2.0, 3)
        c = rng.normal(size=3)
        c1, c2, c3 = c = c / np.linalg.norm(c)
        n1, n2, n3 = nu = np.cross(c, rng.normal(size=3))
        turn = A * (c3 * (c1 * n3 - c3 * n1) + c2 * (c2 * n1 - c1 * n2))
        pull = eta * (C - A) * c2 * c3
        for omega in np.roots([A * c2 * c1, turn, pull * c1 * c3]):
            if omega.imag == 0.0 and 0.1 < abs(omega) < 10.0:
                yield BodyFixed(A, C, [0.0, I2, pull / omega.real], eta), omega.real, nu, c


def test_the_eliminants_vanish_where_the_relations_hold():
    """
    By (11) to (13), corrected: they have no c left and vanish with (1)_1, (4), (7), (8), (10).

    H is -eta (C - A) c_3^2 there.  As printed, nu_1^2 + nu_3^2, (11) does not vanish.
    """
    count = 0
    for body, omega, nu, c in common_points():
        E = body.E0(omega, E2, nu, c) + 2.0 * body.rotor_momentum[1] * nu[1]
        assert body.transverse(omega, E2, c) == pytest.approx(0.0, abs=1e-13)
        assert body.changing(omega, nu, c) == pytest.approx(0.0, abs=1e-12)
        H, I3 = body.H(omega, nu, E), body.rotor_momentum[2]
        assert H == pytest.approx(-body.eta * (body.C - body.A) * c[2] ** 2, abs=1e-12)
        size = (1.0 + omega**2) ** 2 * (1.0 + nu @ nu) ** 2 * (1.0 + I3**2)
        eliminants = body.eliminants(omega, nu, E)
        np.testing.assert_allclose(eliminants, 0.0, atol=1e-11 * size)
        printed = eliminants[0] + I3**2 * (nu[2] ** 2 - nu[1] ** 2) * omega**2
        count += abs(printed) > 1e-6
    assert count > 20


def test_the_integrals_of_a_rotation_that_is_not_uniform():
    """Planar libration with a rotor along the normal: l = n (6) and E0 (5) are constant."""
    A, C, orbit = 900.0, 500.0, KeplerOrbit()
    rotor = Rotor('constant_momentum', E2, 3.0)
    system = System(np.diag([A, A, C]), (rotor,), orbit)
    q_lb = rotation.multiply(rotation.from_z_to(np.array([0.0, 0.0, -1.0])), rotation.IDENTITY)
    # axis 2 along the orbit normal, whatever axes LVLH has
    normal_l = rotation.rotate(rotation.conjugate(orbit.lvlh(0.0)), orbit.normal)
    turn = np.append(np.cross(rotation.rotate(q_lb, E2), normal_l), 0.0)
    turn[3] = 1.0 + rotation.rotate(q_lb, E2) @ normal_l
    if np.linalg.norm(turn) < 1e-9:
        turn = np.array([1.0, 0.0, 0.0, 0.0])
    q_lb = rotation.multiply(rotation.normalise(turn), q_lb)
    q_ib = rotation.multiply(orbit.lvlh(0.0), rotation.multiply(q_lb, rotation.about(E2, 0.4)))
    n = orbit.mean_motion
    states = Propagation(system, State(q_ib, 1.3 * n * E2), 0.0, 1e-14).at(
        np.linspace(0.0, 6000.0, 50)
    )
    body = BodyFixed(A, C, [0.0, 3.0, 0.0], 3.0 * n**2)
    nu_b = rotation.rotate(rotation.conjugate(states.q_ib), n * orbit.normal)
    rates = states.omega_bi_b @ E2
    assert np.ptp(rates) > 0.1 * n
    along = [body.along_axis(E2, nu) for nu in nu_b]
    np.testing.assert_allclose(along, n, rtol=1e-12)
    E0 = [body.E0(rate, E2, nu, c) for rate, nu, c in zip(rates, nu_b, states.c_b, strict=True)]
    np.testing.assert_allclose(E0, E0[0], rtol=1e-10)


def test_off_the_equator_the_rotor_s_first_component_vanishes():
    """(9) is (1)_2 and (1)_3 without omega': their difference for any omega' that both give."""
    body = BodyFixed(1.3, 0.7, [0.4, 0.1, -0.2], 1.5)
    omega, gamma, c = 0.8, np.array([0.0, 0.6, 0.8]), np.array([0.48, 0.6, 0.64])
    rise = omega * 0.4 * gamma[1] / (body.C * gamma[2])  # (1)_3
    second = body.A * rise * gamma[1] + omega * 0.4 * gamma[2]
    second -= body.eta * (body.A - body.C) * c[0] * c[2]  # (1)_2
    found = body.off_the_equator(omega, gamma, c)
    assert found == pytest.approx(body.C * gamma[2] * second, rel=1e-13)
