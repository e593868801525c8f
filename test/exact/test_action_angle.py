"""The phase, the actions and the angles of a free body against quadrature and propagation."""

import numpy as np
import pytest
from draws import attitudes, body_axes, inertia_in_body_axes, moments
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.integrate import quad

from satdyn_ros.dynamics.rotor import Rotor
from satdyn_ros.dynamics.system import State, System
from satdyn_ros.exact import ActionAngle, Free
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.kernel import rotation

ANY = rotation.normalise([0.1, 0.5, 0.7, 0.5])
SKEW = rotation.normalise([0.3, -0.2, 0.4, 1.0])
# About the largest moment and about the smallest, in either sense, in permuted axes, symmetric
BODIES = [
    ([1.0, 2.0, 2.5], [0.2, 0.3, 1.0]),
    ([1.0, 2.0, 2.5], [0.2, -0.3, -1.0]),
    ([1.0, 2.0, 2.5], [1.1, 0.2, -0.3]),
    ([2.0, 2.5, 1.0], [0.2, -0.3, -1.1]),
    ([2.5, 1.0, 2.0], [1.0, 0.1, -0.3]),
    ([1.0, 1.0, 1.6], [0.3, -0.4, 0.9]),
    ([1.0, 1.6, 1.6], [0.8, 0.3, 0.4]),
]


def free(body, omega, q_ib=ANY):
    return Free(System(np.diag(body)), State(q_ib, np.array(omega)))


@pytest.mark.parametrize(('body', 'omega'), BODIES[:5])
def test_t0_is_the_textbook_s_integral(body, omega):
    """(46.17), x = -a cos s from O_2 at its least: the way to O_2, on either half of the way."""
    motion = free(body, omega)
    known = motion.poinsot
    assert known is not None
    middle = int(np.argsort(body)[1])
    reach = min(known.a1, known.a3)
    rate = omega[middle]

    def slowness(s):
        x = -reach * np.cos(s)
        return reach * np.sin(s) / np.sqrt(-known.V(x))

    way = quad(slowness, 0.0, np.arccos(-rate / reach), epsrel=1e-12)[0]
    I = np.array(body)
    rising = (I[middle - 2] - I[middle - 1]) * omega[middle - 2] * omega[middle - 1] > 0.0
    assert motion.t0 == pytest.approx(way if rising else motion.T1 - way, rel=1e-10)


@pytest.mark.parametrize(('body', 'omega'), BODIES)
def test_the_angles_of_propagated_states_grow_linearly(body, omega):
    """(46.27 to 46.30): each state of a propagation has the angles of the start, grown on."""
    system, state = System(np.diag(body)), State(ANY, np.array(omega))
    start = ActionAngle.of(Free(system, state))
    t_s = np.linspace(0.0, 30.0, 16)
    states = Propagation(system, state, 0.0, 1e-14).at(t_s)
    for i, expected in enumerate(start.at(t_s)):
        found = ActionAngle.of(Free(system, states[i]))
        np.testing.assert_allclose(found.actions, start.actions, rtol=1e-10)
        np.testing.assert_allclose(rotation.wrap(found.angles - expected), 0.0, atol=1e-9)


@pytest.mark.parametrize(('body', 'omega'), BODIES[:5])
def test_the_swing_of_the_precession_is_its_quadrature_and_its_series(body, omega):
    """S of (46.24) in closed form: the integral of Phi - chi_0, and forty terms of Fourier's."""
    known = free(body, omega).poinsot
    chi = known.precession_coefficients(40)
    t_s = np.array([0.1, 0.4, 0.9, 1.7, -0.3]) * known.T1
    n = np.arange(1, 40)
    frequencies = 2.0 * np.pi * n / known.T1
    series = 2.0 * np.sin(np.multiply.outer(t_s, frequencies)) @ (chi[1:] / frequencies)
    np.testing.assert_allclose(known.precession_swing(t_s), series, atol=1e-12)
    for end, swing in zip(t_s, known.precession_swing(t_s), strict=True):
        swept, _ = quad(lambda t: known.precession_rate(t) - chi[0], 0.0, end, epsabs=1e-12)
        assert swing == pytest.approx(swept, abs=1e-10)


@pytest.mark.parametrize(('body', 'omega'), BODIES)
def test_the_action_is_the_area_that_the_momentum_sweeps(body, omega):
    """J = (1 / 2 pi) of the integral of L_3 dpsi over T1, from rates of a propagation."""
    motion = free(body, omega)
    known = motion.poinsot
    axis = motion.axis_b if known.is_symmetric else np.eye(3)[int(np.argmax(body))]
    k = int(np.argmax(np.abs(axis)))
    t_s = np.arange(400) * motion.T1 / 400.0
    H = Propagation(motion.system, motion.state, 0.0, 1e-13).at(t_s).omega_bi_b * np.array(body)
    # psi = arctan (L_1 / L_2), so psi' = Omega_k - phi' cos theta
    omega_t = H / np.array(body)
    across = motion.L**2 - H[:, k] ** 2
    phi_dot = motion.L * (2.0 * motion.E - H[:, k] * omega_t[:, k]) / across
    psi_dot = omega_t[:, k] - phi_dot * H[:, k] / motion.L
    area = np.mean(H[:, k] * psi_dot) * motion.T1
    assert ActionAngle.of(motion).actions[0] == pytest.approx(area / (2.0 * np.pi), rel=1e-9)


@pytest.mark.parametrize(('body', 'omega'), BODIES[:5])
def test_the_rates_are_the_derivatives_of_the_energy(body, omega):
    """The differential dE = (2 pi / T1) dJ + chi_0 dL, by central differences along each axis."""
    rates = ActionAngle.of(free(body, omega)).rates
    for k in range(3):
        step = np.eye(3)[k] * 1e-5
        later, before = (free(body, np.array(omega) + side * step) for side in (1.0, -1.0))
        change = ActionAngle.of(later).actions - ActionAngle.of(before).actions
        assert later.E - before.E == pytest.approx(rates @ change, abs=1e-13)


@given(st.data())
def test_the_phase_of_any_start(data):
    """Any body in any axes: a state that is dt later has a t0 that is dt larger."""
    I, q_bp = data.draw(moments()), data.draw(body_axes())
    omega = np.array([data.draw(st.floats(-1.0, 1.0)) for _ in range(3)])
    assume(np.min(np.abs(omega)) > 0.01)
    inertia = inertia_in_body_axes(I, q_bp)
    motion = Free(System(inertia), State(data.draw(attitudes()), rotation.rotate(q_bp, omega)))
    assert motion.poinsot is not None
    assume(motion.poinsot.lam > 0.0 and motion.poinsot.k2 < 0.999)
    for share in (0.1, 0.35, 0.77):
        later = Free(motion.system, motion.at([share * motion.T1])[0])
        apart = (later.t0 - motion.t0) / motion.T1 - share
        assert apart - np.rint(apart) == pytest.approx(0.0, abs=1e-7)


def test_where_there_is_no_phase():
    """A permanent rotation has none to speak of, a separatrix an infinite one, a gyrostat none."""
    assert free([1.0, 2.0, 2.5], [0.0, 0.0, 1.0]).t0 == 0.0
    separatrix = free([2.0, 4.0, 4.5], [0.75, 0.3, 1.0])
    assert separatrix.t0 == np.inf
    with pytest.raises(ValueError, match='no period'):
        ActionAngle.of(separatrix)
    rotor = Rotor('constant_momentum', np.array([0.0, 0.0, 1.0]), 0.4)
    gyrostat = Free(System(np.diag([1.0, 2.0, 2.5]), (rotor,)), State(ANY, np.ones(3)))
    with pytest.raises(ValueError, match='rotor'):
        ActionAngle.of(gyrostat)
