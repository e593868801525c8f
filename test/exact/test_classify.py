import numpy as np
import pytest
from cases import newtonian
from scipy.spatial.transform import Rotation

from satdyn_ros.dynamics.rotor import Rotor
from satdyn_ros.dynamics.system import State, System
from satdyn_ros.exact.classify import axis_wander, rotation_class
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import FixedDirection, KeplerOrbit
from satdyn_ros.theory import equilibria

PRINCIPAL, SKEW = np.eye(3), Rotation.from_rotvec([0.4, -0.3, 0.8]).as_matrix()
ORBIT = KeplerOrbit(inclination=0.9, raan=2.1, argument_of_periapsis=0.3, true_anomaly=1.2)
N = ORBIT.mean_motion
X, Y, Z = np.eye(3)


def gyrostat(moments, h, axes=PRINCIPAL):
    """Return a gyrostat on the orbit with principal axes the columns of axes, h along them."""
    inertia, h = axes @ np.diag(moments) @ axes.T, axes @ np.asarray(h, float)
    size = float(np.linalg.norm(h))
    rotor = Rotor('constant_momentum', h / size, size) if size else Rotor()
    return System(inertia, (rotor,), ORBIT)


def state(pitch, rate, axes=PRINCIPAL, lean=0.0):
    """Return the second principal axis along the orbit normal, turned and turning about it."""
    R_lp = Rotation.from_euler('zyx', [lean, -pitch, np.pi]).as_matrix()
    q_ib = rotation.multiply(ORBIT.lvlh(0.0), rotation.from_matrix(R_lp @ axes.T))
    return State(q_ib, rate * axes[:, 1])


@pytest.mark.parametrize(
    ('name', 'is_rotation', 'is_uniform', 'why'),
    [
        ('G1_BG_libration_rotor_along_axis', True, False, 'swings or tumbles'),
        ('G3_BG_oblate_libration_spacecraft', True, False, 'swings or tumbles'),
        ('G5_BG_uniform_spin_on_normal', True, True, 'balances'),
        ('G8_BG_nonparallel_rotor', False, False, 'rotor is not along the orbit normal'),
    ],
)
def test_the_reference_cases(name, is_rotation, is_uniform, why):
    """The class of each reference motion, and its axis wanders in the reference table or not."""
    case = newtonian()[name]
    found = rotation_class(case.system, case.start)
    assert (found.is_rotation, found.is_uniform) == (is_rotation, is_uniform)
    assert why in found.why
    across = np.cross(case.omega_bi_b, case.omega_bi_b[0] / np.linalg.norm(case.omega_bi_b[0]))
    wander = np.max(np.linalg.norm(across, axis=-1)) / np.max(np.abs(case.omega_bi_b))
    assert (wander < 1e-12) if is_rotation else (wander > 0.1)


SYMMETRIC, TRIAXIAL = [800.0, 800.0, 600.0], [800.0, 900.0, 600.0]


@pytest.mark.parametrize('axes', [PRINCIPAL, SKEW], ids=['principal', 'skew'])
@pytest.mark.parametrize(
    ('moments', 'h', 'start', 'is_rotation', 'is_uniform'),
    [
        # Pitch motion, the rotor along the normal.
        (SYMMETRIC, [0.0, 3.0, 0.0], {'pitch': 0.4, 'rate': 1.3 * N}, True, False),
        (SYMMETRIC, [0.0, 0.0, 0.0], {'pitch': 0.4, 'rate': -5.0 * N}, True, False),
        (TRIAXIAL, [0.0, -3.0, 0.0], {'pitch': 0.4, 'rate': 1.3 * N}, True, False),
        # At rest now but about to swing.
        (TRIAXIAL, [0.0, 0.0, 0.0], {'pitch': 0.4, 'rate': 0.0}, True, False),
        # The rotor is not along the normal, or leans from it.
        (SYMMETRIC, [0.5, 3.0, 0.0], {'pitch': 0.4, 'rate': 1.3 * N}, False, False),
        (SYMMETRIC, [0.0, 0.0, 0.5], {'pitch': 0.4, 'rate': 1.3 * N}, False, False),
        (TRIAXIAL, [0.0, 3.0, 0.5], {'pitch': 0.4, 'rate': 1.3 * N}, False, False),
        # The body leans from the normal.
        (SYMMETRIC, [0.0, 3.0, 0.0], {'pitch': 0.4, 'rate': 1.3 * N, 'lean': 0.1}, False, False),
        (TRIAXIAL, [0.0, 0.0, 0.0], {'pitch': 0.0, 'rate': 1.3 * N, 'lean': 0.1}, False, False),
        # A sphere turns uniformly with its rotor along the axis, else the axis moves.
        ([700.0] * 3, [0.0, 3.0, 0.0], {'pitch': 0.4, 'rate': 1.3 * N, 'lean': 0.1}, True, True),
        ([700.0] * 3, [1.0, 3.0, 0.0], {'pitch': 0.4, 'rate': 1.3 * N}, False, False),
    ],
)
def test_the_class_is_what_propagation_shows(axes, moments, h, start, is_rotation, is_uniform):
    """
    The axis of a propagated motion stays in the body exactly where the theorem says so.

    A rotation wanders less than 1e-9 by the propagation's error; the others more than 1e-3.
    """
    system, initial = gyrostat(moments, h, axes), state(axes=axes, **start)
    found = rotation_class(system, initial)
    assert (found.is_rotation, found.is_uniform) == (is_rotation, is_uniform), found.why
    motion, t_s = Propagation(system, initial), np.linspace(0.0, 2.0 * np.pi / N, 300)
    wander = axis_wander(motion, t_s)
    assert (wander < 1e-9) if is_rotation else (wander > 1e-3)
    rates = np.linalg.norm(motion.at(t_s).omega_bi_b, axis=-1)
    if is_rotation:
        assert (np.ptp(rates) < 1e-9 * N) == is_uniform


def test_relative_equilibria_are_uniform_rotations_with_any_rotor():
    """A skew gyrostat at rest in LVLH rotates uniformly though its rotor is not along the axis."""
    inertia = np.diag(TRIAXIAL)
    q_lb = rotation.about(X, 0.3)
    h = equilibria.equilibrium_momentum(inertia, q_lb, N, 1.0)
    found = rotation_class(gyrostat(TRIAXIAL, h), equilibria.at_rest_in_lvlh(ORBIT, q_lb))
    assert (found.is_rotation, found.is_uniform) == (True, True)


def test_a_free_wheel_along_the_normal_leaves_a_pitch_motion():
    """The theorem's planar class holds for a free wheel, whose body swings with less inertia."""
    system = System(np.diag(TRIAXIAL), (Rotor('free', Y, inertia=20.0),), ORBIT)
    start = state(0.4, 1.3 * N)
    start = State(start.q_ib, start.omega_bi_b, rotor_speed=3.0, rotor_angle=0.0)
    assert rotation_class(system, start)[:2] == (True, False)
    tilted = System(
        np.diag(TRIAXIAL), (Rotor('free', (Y + Z) / np.sqrt(2.0), inertia=20.0),), ORBIT
    )
    assert rotation_class(tilted, start)[:2] == (False, False)


def test_a_triaxial_body_that_starts_from_rest_is_watched():
    """Its rate has no direction yet, so only the orbit that follows shows that the axis moves."""
    start = state(0.4, 0.0, lean=0.1)
    assert rotation_class(gyrostat(TRIAXIAL, [0.0, 0.0, 0.0]), start)[:2] == (False, False)


def test_wander_of_a_known_motion():
    """For a free symmetric body the wander is the sine of the body cone's widest opening, 2 g."""
    omega = np.array([0.3, 0.0, 1.0])
    motion = Propagation(System(np.diag([1.0, 1.0, 1.5])), State(rotation.IDENTITY, omega))
    t_s = np.linspace(0.0, 4.0 * np.pi, 2001)
    expected = np.sin(2.0 * np.arctan2(0.3, 1.0))
    assert axis_wander(motion, t_s) == pytest.approx(expected, abs=1e-5)
    resting = Propagation(System(np.eye(3)), State(rotation.IDENTITY, np.zeros(3)))
    assert axis_wander(resting, t_s) == 0.0


@pytest.mark.parametrize(
    ('system', 'why'),
    [
        (System(np.eye(3), orbit=FixedDirection(1e-6)), 'orbit.type must be circular'),
        (System(np.eye(3), orbit=KeplerOrbit(eccentricity=0.1)), 'orbit.type must be circular'),
        (System(np.eye(3), orbit=ORBIT, torque_b=X), 'without an applied torque'),
    ],
)
def test_what_the_theorem_is_not_about_is_refused(system, why):
    """Without a circular orbit, or under an applied torque, there is no class."""
    with pytest.raises(ValueError, match=why):
        rotation_class(system, State(rotation.IDENTITY, N * Y))
