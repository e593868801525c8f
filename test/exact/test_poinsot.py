"""Poinsot's constants against the references, quadrature of the textbook's integrals, curves."""

import numpy as np
import pytest
from cases import rigid
from scipy.integrate import quad

from satdyn_ros.dynamics.system import State, System
from satdyn_ros.exact.free import Free
from satdyn_ros.exact.geometry import herpolhode
from satdyn_ros.exact.poinsot import Poinsot, commensurability, separatrix_planes
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.kernel import rotation

REFERENCES = [name for name, case in rigid().items() if 'k2' in case.raw['derived']]
ANY = rotation.normalise([0.1, 0.5, 0.7, 0.5])
SKEW = rotation.matrix(rotation.normalise([0.3, -0.2, 0.4, 1.0]))
# About the largest, the smallest, and a permuted smallest axis; L^2 on either side of 2 E I2.
TRIAXIAL = [
    ([1.0, 2.0, 2.5], [0.2, 0.3, 1.0]),
    ([1.0, 2.0, 2.5], [1.1, 0.2, -0.3]),
    ([2.5, 1.0, 2.0], [0.3, -0.9, 0.2]),
]


@pytest.mark.parametrize('name', REFERENCES)
def test_reference_constants(name):
    """E, L, lam, k^2, a1 and a3 are those of the 28-digit references."""
    case = rigid()[name]
    known = Poinsot(case.system.inertia, case.start.omega_bi_b)
    for ours, theirs in (('E', 'E'), ('L', 'L'), ('lam', 'lam'), ('k2', 'k2')):
        expected = float(case.raw['derived'][theirs])
        assert getattr(known, ours) == pytest.approx(expected, rel=1e-13)
    for key in ('a1', 'a3'):
        assert getattr(known, key) == pytest.approx(float(case.raw['derived'][key]), rel=1e-12)


@pytest.mark.parametrize('name', REFERENCES)
def test_reference_mean_spin(name):
    """The mean spin of the axis of the largest moment (46.35) is the references'."""
    case = rigid()[name]
    expected = float(case.raw['derived']['mean_spin_psi'])
    assert Free(case.system, case.start).Psi == pytest.approx(expected, rel=2e-12)


@pytest.mark.parametrize(('moments', 'omega'), TRIAXIAL)
def test_periods_by_the_textbook_s_integrals(moments, omega):
    """
    T1 and T2 by (46.11), integrated by SciPy with x = a sin, about either axis.

    T2 = 2 pi / chi0 is that of the axis of the largest moment in both families.
    """
    system, state = System(np.diag(moments)), State(ANY, np.array(omega))
    known, motion = Poinsot(system.inertia, omega), Free(system, state)
    I1, I2, I3 = known.moments
    excess_3 = 2.0 * known.E * I3 - known.L**2
    bound = min(known.a1, known.a3)

    def over_the_way(weight):
        def integrand(angle):
            x = bound * np.sin(angle)
            root = np.sqrt(-known.V(x) / (bound * np.cos(angle)) ** 2)
            return weight(x) / root

        return quad(integrand, -np.pi / 2.0, np.pi / 2.0, epsabs=0.0, epsrel=1e-13, limit=400)[0]

    def phi_dot(x):
        first = (excess_3 - (I3 - I2) * I2 * x * x) / (I1 * (I3 - I1))
        return (I1 * first + I2 * x * x) / (I1**2 * first + I2**2 * x * x)

    half = over_the_way(lambda x: 1.0)
    assert motion.T1 == pytest.approx(2.0 * half, rel=1e-11)
    T2 = 2.0 * np.pi / known.L * half / over_the_way(phi_dot)
    assert motion.T2 == pytest.approx(T2, rel=1e-11)


@pytest.mark.parametrize(('moments', 'omega'), TRIAXIAL)
def test_largest_rates(moments, omega):
    """Propagated rates reach B (46.12) about every axis and go no farther."""
    inertia = SKEW @ np.diag(moments) @ SKEW.T
    known = Poinsot(inertia, SKEW @ omega)
    states = Propagation(System(inertia), State(ANY, SKEW @ omega)).at(
        np.linspace(0.0, known.T1, 4001)
    )
    largest = np.max(np.abs(states.omega_bi_b @ SKEW), axis=0)[np.argsort(moments)]
    # 4001 points: the peak is missed by up to (2 pi / 8000)^2 / 2
    np.testing.assert_allclose(largest, known.B, rtol=1e-6)


@pytest.mark.parametrize(('moments', 'omega'), TRIAXIAL)
def test_the_precession_by_its_fourier_series(moments, omega):
    """
    chi_0 is chi0, and (46.24) with forty terms is the precession of the propagated axis.

    The coefficients fall like the nome's powers: by the fortieth they are rounding.
    """
    system, state = System(np.diag(moments)), State(ANY, np.array(omega))
    motion, known = Free(system, state), Poinsot(system.inertia, omega)
    chi = known.precession_coefficients(40)
    assert chi[0] == pytest.approx(motion.chi0, rel=1e-13)
    assert np.max(np.abs(chi[1::2])) < 1e-15
    largest = int(np.argmax(moments))
    t_s = np.linspace(0.0, known.T1, 401)
    states = Propagation(system, state, 0.0, 1e-14).at(t_s)
    momentum = rotation.rotate(state.q_ib, system.inertia @ state.omega_bi_b)
    to_momentum = rotation.conjugate(rotation.from_z_to(momentum / known.L))
    x, y, _ = rotation.rotate(rotation.multiply(to_momentum, states.q_ib), np.eye(3)[largest]).T
    phi = np.unwrap(np.arctan2(y, x))
    n = 2.0 * np.pi * np.arange(1, 40) / known.T1

    def S(t):
        return 2.0 * np.sin(np.multiply.outer(t, n)) @ (chi[1:] / n)

    # t0: the time since O_2 was least, found where the middle rate of the start is
    middle = np.argsort(moments)[1]
    rate, slope = states.omega_bi_b[:, middle], np.gradient(states.omega_bi_b[:, middle])
    least = int(np.argmin(rate))
    assert abs(slope[least]) < 1e-2
    fine = np.linspace(t_s[max(least - 2, 0)], t_s[min(least + 2, 400)], 20001)
    at_least = fine[
        np.argmin(Propagation(system, state, 0.0, 1e-14).at(fine).omega_bi_b[:, middle])
    ]
    t0 = known.T1 - at_least
    series = phi[0] + chi[0] * t_s + S(t_s + t0) - S(t0)
    # the minimum is found to the root of rounding
    np.testing.assert_allclose(phi, series, atol=1e-5)


@pytest.mark.parametrize(('moments', 'omega'), TRIAXIAL)
def test_the_annulus_of_the_herpolhode(moments, omega):
    """A propagated herpolhode touches both radii (45.17) and leaves them at no time."""
    inertia, omega = np.diag(moments), np.array(omega)
    low, high = Poinsot(inertia, omega).herpolhode_radii
    T1 = Poinsot(inertia, omega).T1
    states = Propagation(System(inertia), State(ANY, omega)).at(np.linspace(0.0, T1, 20001))
    radius = np.linalg.norm(herpolhode(inertia, states.q_ib, states.omega_bi_b), axis=-1)
    assert np.min(radius) == pytest.approx(low, abs=1e-7)
    assert np.max(radius) == pytest.approx(high, abs=1e-7)


@pytest.mark.parametrize('moments', [[1.0, 1.0, 1.6], [2.0, 2.0, 0.7], [1.6, 1.0, 1.0]])
def test_a_symmetric_body_draws_circles(moments):
    """Polhode and herpolhode (45.11) have one radius each; so has the propagated herpolhode."""
    inertia, omega = np.diag(moments), np.array([0.3, 0.4, 1.1])
    known = Poinsot(inertia, omega)
    assert known.polhode_radii[0] == pytest.approx(known.polhode_radii[1], rel=1e-15)
    low, high = known.herpolhode_radii
    assert low == pytest.approx(high, rel=1e-14)
    states = Propagation(System(inertia), State(ANY, omega)).at(np.linspace(0.0, 20.0, 101))
    radius = np.linalg.norm(herpolhode(inertia, states.q_ib, states.omega_bi_b), axis=-1)
    np.testing.assert_allclose(radius, low, rtol=1e-10)
    axis = int(np.argmax(np.abs(np.array(moments) - np.median(moments))))
    across = np.linalg.norm(np.delete(omega, axis)) / np.sqrt(2.0 * known.E)
    assert known.polhode_radii[0] == pytest.approx(across, rel=1e-14)


def test_the_separatrix_s_planes():
    """Momenta of the 28-digit separatrix case lie on one of the planes (44.9), others do not."""
    case = rigid()['free_tri_exact_separatrix']
    normals = separatrix_planes(case.system.inertia)
    for omega in case.omega_bi_b:
        H = case.system.inertia @ omega
        assert np.min(np.abs(normals @ H)) < 1e-13 * np.linalg.norm(H)
    turned = separatrix_planes(SKEW @ case.system.inertia @ SKEW.T)
    np.testing.assert_allclose(np.abs(np.sum(turned * (normals @ SKEW.T), axis=-1)), 1.0)
    with pytest.raises(ValueError, match='two principal moments are equal'):
        separatrix_planes(np.diag([1.0, 1.0, 1.5]))


def test_when_the_attitude_returns():
    """
    A body whose T1 / T2 is 5 / 2 is where it was after two T1, and one turned by chi after one.

    Symmetric: T1 / T2 = L / |C - A| r0 by choice of C.
    """
    omega = np.array([0.3, 0.4, 1.0])
    A = 1.0
    # L^2 = (A w)^2 + (C r0)^2 = (5/2)^2 (C - A)^2 r0^2
    roots = np.roots([1.0 - 6.25, 12.5 * A, (0.25 - 6.25) * A * A])
    C = float(roots[(roots > A) & (roots < 2.0 * A)][0])
    system = System(np.diag([A, A, C]))
    motion = Free(system, State(ANY, omega))
    assert commensurability(motion.T1, motion.T2) == pytest.approx(2.5)
    back = motion.at([2.0 * motion.T1]).q_ib
    assert rotation.angle_between(back, ANY)[0] < 1e-12
    other = Free(System(np.diag([1.0, 2.0, 2.5])), State(ANY, omega))
    assert commensurability(other.T1, other.T2) is None
    H = other.system.inertia @ omega
    turn = rotation.about(rotation.rotate(ANY, H / np.linalg.norm(H)), other.chi)
    after = other.at([other.T1]).q_ib
    assert rotation.angle_between(after, rotation.multiply(turn, ANY))[0] < 1e-12


@pytest.mark.parametrize('omega', [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
def test_periods_of_permanent_rotations_are_those_beside_them(omega):
    """About the largest and smallest axis T1 is that of nutations of 1e-4 of the rate."""
    system = System(np.diag([1.0, 2.0, 2.5]))
    steady = Free(system, State(ANY, np.array(omega)))
    beside = Free(system, State(ANY, np.array(omega) + 1e-4 * np.array([0.5, 1.0, -0.5])))
    assert steady.T1 == pytest.approx(beside.T1, rel=2e-4)
    assert steady.period_s is None


def test_without_period():
    """A sphere's rates have no series, and on the separatrix T1 is infinite."""
    assert Poinsot(np.eye(3), [0.1, 0.2, 0.3]).T1 == np.inf
    with pytest.raises(ValueError, match='no period'):
        Poinsot(np.eye(3), [0.1, 0.2, 0.3]).precession_coefficients(3)
    case = rigid()['free_tri_exact_separatrix']
    assert Poinsot(case.system.inertia, case.start.omega_bi_b).k2 == pytest.approx(1.0, abs=1e-15)


@pytest.mark.parametrize(('moments', 'omega'), TRIAXIAL)
def test_the_cones_of_the_rate_in_space(moments, omega):
    """The propagated rate keeps to these angles from the momentum, and reaches both (45.8)."""
    system, state = System(np.diag(moments)), State(ANY, np.array(omega))
    known = Poinsot(system.inertia, omega)
    states = Propagation(system, state).at(np.linspace(0.0, known.T1, 4001))
    rate = rotation.rotate(states.q_ib, states.omega_bi_b)
    momentum = rotation.rotate(ANY, system.inertia @ np.array(omega))
    angle = np.arctan2(np.linalg.norm(np.cross(rate, momentum), axis=-1), rate @ momentum)
    np.testing.assert_allclose([np.min(angle), np.max(angle)], known.space_cones, rtol=1e-5)


def test_a_rate_near_an_outer_axis_stays_near_in_space():
    """
    Corollary 45.8: about the largest and the smallest moment the cones shrink with the departure.

    About the middle moment they do not.
    """
    body = np.diag([1.0, 2.0, 2.5])
    for axis in range(3):
        aside = np.array([1e-6, 1e-6, 1e-6])
        aside[axis] = 1.0
        assert (Poinsot(body, aside).space_cones[1] < 1e-5) == (axis != 1)
