from functools import partial

import numpy as np
import pytest
from cases import newtonian, rigid
from numpy.testing import assert_allclose

from satdyn_ros.dynamics.rotor import Rotor
from satdyn_ros.dynamics.system import State, System
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import FixedDirection, KeplerOrbit
from satdyn_ros.theory import euler_angles
from satdyn_ros.theory.precession import RegularPrecession, regular_precession

close = partial(assert_allclose, rtol=0.0)

X, Y, Z = np.eye(3)


def precession(spin, rate, nutation):
    return RegularPrecession(Z, Z, spin, rate, nutation)


def test_the_earth_precesses_retrograde_with_a_cone_of_a_hundredth_arc_second():
    """
    The precession of 50.29 arc seconds a year turns a cone of 0.0087 in the Earth.

    It rolls inside that of 23.44 deg in space.
    """
    mu, year = 2.0 * np.pi / 86164.1, 365.25 * 86400.0
    earth = precession(mu, -np.radians(50.29 / 3600.0) / year, np.radians(23.44))
    assert earth.sense == 'retrograde'
    assert earth.cones == 'body cone inside'
    assert np.degrees(earth.body_cone) * 3600.0 == pytest.approx(0.0087, abs=5e-5)
    assert np.degrees(earth.space_cone) == pytest.approx(23.44, abs=1e-4)


@pytest.mark.parametrize(
    ('spin', 'rate', 'nutation', 'sense', 'cones'),
    [
        (2.0, 1.0, 0.5, 'progressive', 'external'),
        (2.0, -1.0, 0.5, 'retrograde', 'body cone inside'),
        (-0.5, 1.0, 0.5, 'retrograde', 'space cone inside'),
        (1.0, -1.0, 1.3, 'retrograde', 'external'),
        (2.0, 1.0, np.pi - 0.5, 'retrograde', 'body cone inside'),
        (2.0, 0.0, 0.5, None, 'plane'),
    ],
)
def test_senses_and_how_the_cones_lie(spin, rate, nutation, sense, cones):
    """Progressive or retrograde, and external or internal cones; retrograde can be external."""
    motion = precession(spin, rate, nutation)
    assert (motion.sense, motion.cones) == (sense, cones)


@pytest.mark.parametrize(('spin', 'rate'), [(2.0, 1.0), (2.0, -1.0), (-0.5, 1.0), (1.0, -1.0)])
def test_cones_roll_without_slipping(spin, rate):
    """The axis of rotation makes the cones' angles with f and e, and |nu| sin = |mu| sin."""
    theta = 0.7
    f, e = Z, np.array([np.sin(theta), 0.0, np.cos(theta)])
    omega = spin * f + rate * e
    axis = omega / np.linalg.norm(omega)
    motion = precession(spin, rate, theta)
    assert np.sin(motion.body_cone) == pytest.approx(np.linalg.norm(np.cross(axis, f)), rel=1e-14)
    assert np.sin(motion.space_cone) == pytest.approx(np.linalg.norm(np.cross(axis, e)), rel=1e-14)
    slip = abs(rate) * np.sin(motion.space_cone) - abs(spin) * np.sin(motion.body_cone)
    assert slip == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize('name', ['free_axi_oblate', 'gyrostat_axi_rotor_on_axis'])
def test_a_free_symmetric_body_precesses_about_its_momentum(name):
    """P' = L / A and S' = -((C - A) r + h) / A, the textbook's (45.5) with its sign mended."""
    case = rigid()[name]
    A, _, C = np.diagonal(case.system.inertia)
    h = float(case.raw['rotor_h_body'][2])
    H = case.start.omega_bi_b * [A, A, C] + [0.0, 0.0, h]
    found = regular_precession(case.system, case.start)
    assert found is not None
    assert found.precession == pytest.approx(np.linalg.norm(H) / A, rel=1e-14)
    expected = -((C - A) * case.start.omega_bi_b[2] + h) / A
    assert found.spin == pytest.approx(expected, rel=1e-13)
    assert np.cos(found.nutation) == pytest.approx(H[2] / np.linalg.norm(H), rel=1e-14)
    close(found.axis_i, rotation.rotate(case.start.q_ib, H) / np.linalg.norm(H), atol=1e-15)
    if h == 0.0:
        assert found.cones == ('space cone inside' if C > A else 'external')


def test_the_steady_precession_of_the_reference():
    """The double root's motion has the constant angles' rates that the reference tables show."""
    case = rigid()['pal1_steady_precession_double_root']
    found = regular_precession(case.system, case.start)
    assert found is not None
    angles = euler_angles.zxz_angles(case.q_ib)
    close(angles[:, 1], found.nutation, atol=1e-14)
    rates = euler_angles.zxz_rates(case.q_ib, case.omega_bi_b)
    close(rates, [[found.precession, 0.0, found.spin]] * len(rates), atol=1e-14)
    A, _, C = np.diagonal(case.system.inertia)
    u, H1, H2 = np.cos(found.nutation), *(float(case.raw['field'][key]) for key in ('H1', 'H2'))
    balance = A * u * found.precession**2 - C * case.start.omega_bi_b[2] * found.precession
    assert balance - (2.0 * H1 * u + H2) == pytest.approx(0.0, abs=1e-14)


@pytest.mark.parametrize('side', [X, Y], ids=['conical', 'hyperbolic'])
@pytest.mark.parametrize('C', [0.6, 1.5])
def test_oblique_spins_on_a_circular_orbit(side, C):
    """
    A symmetric satellite's axis leans against the normal, ahead or up, at the orbital rate.

    Steady where C r = A n cos ahead (no torque) and C r = (A - 3 (C - A)) n cos up, balanced
    against the gravity gradient; the propagated angles to normal, track and radius stay, at 1e-9.
    """
    A, theta, orbit = 1.0, 0.4, KeplerOrbit()
    n = orbit.mean_motion
    # In LVLH: x ahead, -y normal, z down; body z leans from the normal.
    lean = X if side is X else -Z
    f_l = np.cos(theta) * -Y + np.sin(theta) * lean
    R_lb = np.stack([np.cross(-Y, f_l), np.zeros(3), f_l], axis=-1)
    R_lb[:, 0] /= np.sin(theta)
    R_lb[:, 1] = np.cross(f_l, R_lb[:, 0])
    q_ib = rotation.multiply(orbit.lvlh(0.0), rotation.from_matrix(R_lb))
    k_b = rotation.rotate(rotation.conjugate(q_ib), orbit.normal)
    r = n * np.cos(theta) * (A if side is X else A - 3.0 * (C - A)) / C
    omega = n * (k_b - k_b[2] * Z) + r * Z
    system = System(np.diag([A, A, C]), orbit=orbit)
    found = regular_precession(system, State(q_ib, omega))
    assert found is not None
    assert found.precession == pytest.approx(n, rel=1e-12)
    assert found.nutation == pytest.approx(theta, rel=1e-12)
    assert found.spin == pytest.approx(r - n * np.cos(theta), rel=1e-12)
    states = Propagation(system, State(q_ib, omega)).at(np.linspace(0.0, 3.0e3, 20))
    close(rotation.rotate(states.q_lb, Z), [f_l] * 20, atol=1e-9)


def test_what_is_no_regular_precession():
    """A nutating top, a triaxial body, a body pushed and an elliptic orbit have none."""
    nutating = rigid()['pal1_two_real_two_complex_H1pos']
    assert regular_precession(nutating.system, nutating.start) is None
    triaxial = rigid()['free_tri_e3_family']
    assert regular_precession(triaxial.system, triaxial.start) is None
    tilted = newtonian()['G8_BG_nonparallel_rotor']
    assert regular_precession(tilted.system, tilted.start) is None
    spin = State(rotation.IDENTITY, np.array([0.1, 0.0, 0.5]))
    pushed = System(np.diag([1.0, 1.0, 1.5]), torque_b=np.array([0.0, 0.0, 1e-3]))
    assert regular_precession(pushed, spin) is None
    elliptic = System(np.diag([1.0, 1.0, 1.5]), orbit=KeplerOrbit(eccentricity=0.1))
    assert regular_precession(elliptic, spin) is None


def test_a_sleeping_top_spins_only():
    """With the axis along the field the whole rate counts as spin."""
    top = System(np.diag([1.0, 1.0, 1.5]), orbit=FixedDirection(1.0))
    found = regular_precession(top, State(rotation.IDENTITY, np.array([0.0, 0.0, 0.5])))
    assert found is not None
    assert (found.spin, found.precession, found.nutation) == (0.5, 0.0, 0.0)
    assert regular_precession(top, State(rotation.IDENTITY, np.array([0.1, 0.0, 0.5]))) is None


def test_a_sphere_with_a_rotor_precesses_and_one_without_has_no_axis():
    """The rotor gives the axis f: the momentum stays, and the rotor's axis turns about it."""
    case = rigid()['free_spherical']
    assert regular_precession(case.system, case.start) is None
    system = System(np.eye(3), (Rotor('constant_momentum', X, 0.3),))
    state = State(rotation.IDENTITY, np.array([0.2, 0.4, 0.1]))
    found = regular_precession(system, state)
    assert found is not None
    assert found.precession == pytest.approx(np.linalg.norm([0.5, 0.4, 0.1]), rel=1e-14)
    assert found.spin == pytest.approx(-0.3, rel=1e-13)
