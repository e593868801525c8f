"""The verdicts of stability against the textbook's theorems, known regions and propagation."""

import numpy as np
import pytest
from cases import rigid
from scipy.optimize import brentq

from satdyn_ros.dynamics.rotor import Rotor
from satdyn_ros.dynamics.system import State, System
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import FixedDirection, KeplerOrbit
from satdyn_ros.theory.equilibria import (
    at_rest_in_lvlh,
    direction,
    permanent_rotations,
    relative_equilibria,
)
from satdyn_ros.theory.stability import is_surely_stable, small_motion
from satdyn_ros.theory.steady_motions import steady_motions
from satdyn_ros.theory.verdicts import free_verdict, small_motion_roots, verdict

ANY = rotation.normalise([0.1, 0.5, 0.7, 0.5])
SKEW = rotation.matrix(rotation.normalise([0.3, -0.2, 0.4, 1.0]))
ORBIT = KeplerOrbit(inclination=0.9, true_anomaly=1.2)
ASIDE = 1e-4
# Small compared with the way that an unstable motion goes, large compared with ASIDE.
NEAR = 0.1


def wander(system, state, span_s):
    """
    Return how far rate and direction of the field go in body axes from a start a little aside.

    Relative to the rate; the worst of several starts, each ASIDE off in rate and attitude.
    """
    rate = np.linalg.norm(state.omega_bi_b)
    c = direction(system, state)
    worst = 0.0
    for aside in np.vstack([np.eye(3), -np.eye(3), [[0.6, -0.5, 0.6]]]):
        turn = rotation.normalise([*(ASIDE / 2.0 * aside[[1, 2, 0]]), 1.0])
        start = State(rotation.multiply(state.q_ib, turn), state.omega_bi_b + ASIDE * rate * aside)
        states = Propagation(system, start, 0.0, 1e-11).at(np.linspace(0.0, span_s, 4001))
        gone = np.linalg.norm(states.omega_bi_b - state.omega_bi_b, axis=-1) / rate
        if system.orbit.gradient_at(0.0) != 0.0 or np.any(system.weight_moment):
            gone = np.maximum(gone, np.linalg.norm(states.c_b - c, axis=-1))
        worst = max(worst, float(np.max(gone)))
    return worst


FREE = {
    'smallest': ([1.0, 2.0, 2.5], 0, 0.0, 'stable'),
    'middle': ([1.0, 2.0, 2.5], 1, 0.0, 'unstable'),
    'largest': ([1.0, 2.0, 2.5], 2, 0.0, 'stable'),
    'axis of an oblate body': ([1.0, 1.0, 1.6], 2, 0.0, 'stable'),
    'axis of a prolate body': ([2.0, 2.0, 1.6], 2, 0.0, 'stable'),
    'equator of an oblate body': ([1.0, 1.0, 1.6], 0, 0.0, 'unstable'),
    'equator of a prolate body': ([2.0, 2.0, 1.6], 1, 0.0, 'unstable'),
    'sphere': ([2.0, 2.0, 2.0], 1, 0.0, 'stable'),
    'middle axis held by a rotor': ([1.0, 2.0, 2.5], 1, 1.4, 'stable'),
    'largest axis upset by a rotor': ([1.0, 2.0, 2.5], 2, -1.0, 'unstable'),
    # (I_j - I_k) W + h is zero for one k: terms of fourth order decide
    'fourth order, minimum': ([1.0, 2.0, 2.5], 1, 0.5, 'stable'),
    'fourth order, maximum': ([1.0, 2.0, 2.5], 1, -1.0, 'stable'),
    'fourth order, saddle': ([1.0, 2.0, 2.5], 2, -0.5, 'unstable'),
    'fourth order, both': ([1.0, 1.0, 1.6], 2, -0.6, 'stable'),
}


@pytest.mark.parametrize('name', FREE)
def test_permanent_rotations(name):
    """
    The textbook's 44.11 to 44.13, rotors and the degenerate cases, each as the propagation goes.

    Over 4000 rad of rotation what is unstable by drift alone, at 1e-4 of the rate, goes far too.
    """
    moments, axis, h, stability = FREE[name]
    rotor = Rotor('constant_momentum', SKEW[:, axis], h) if h else Rotor()
    system = System(SKEW @ np.diag(moments) @ SKEW.T, (rotor,))
    state = State(ANY, SKEW[:, axis])
    found = verdict(system, state)
    assert found.stability == stability, found
    assert (wander(system, state, 4e4 if stability == 'unstable' else 4e3) > NEAR) == (
        stability == 'unstable'
    )


def test_a_rotor_along_no_principal_axis():
    """Each rotation that permanent_rotations finds with a skew rotor goes as its verdict says."""
    inertia, h = np.diag([1.0, 2.0, 2.5]), np.array([0.3, 0.2, 0.4])
    size = float(np.linalg.norm(h))
    system = System(inertia, (Rotor('constant_momentum', h / size, size),))
    verdicts = []
    for omega in permanent_rotations(inertia, 1.0, h):
        found = verdict(system, State(ANY, omega))
        verdicts.append(found.stability)
        assert (wander(system, State(ANY, omega), 600.0) > NEAR) == (
            found.stability == 'unstable'
        ), (omega, found)
    assert {'stable', 'unstable'} == set(verdicts)


def test_a_fold_is_unstable():
    """
    Where two permanent rotations have just met, the energy has a saddle of third order.

    Of the family omega_j = h_j / (x - I_j) that is where |H| = |x omega| has its minimum over x.
    """
    I, h = np.array([1.0, 2.0, 2.5]), np.array([0.3, 0.2, 0.0])

    def slope(x):
        return -np.sum(x * I[:2] * h[:2] ** 2 / (x - I[:2]) ** 3)

    x = brentq(slope, 1.001, 1.999, xtol=1e-15)
    omega = np.array([h[0] / (x - I[0]), h[1] / (x - I[1]), 0.0])
    found = free_verdict(np.diag(I), omega, I * omega + h, h)
    assert found == ('unstable', 'the energy has a saddle of third order')


@pytest.mark.parametrize('h', [0.0, -1.5, 1.5])
def test_aligned_equilibria_agree_with_the_linear_equations(h):
    """
    For every aligned attitude: stable where (4.a) holds, unstable where a root of (4.3) grows.

    The remaining cases are undecided: gyroscopic stability, such as the DeBra-Delp region's.
    """
    moments, n = np.array([600.0, 800.0, 900.0]), ORBIT.mean_motion
    for q_lb in relative_equilibria(np.diag(moments)):
        R_lp = rotation.matrix(q_lb)
        I_t, I_n, I_r = np.abs(R_lp) @ moments
        rotor = Rotor('constant_momentum', -R_lp[1], h) if h else Rotor()
        system = System(np.diag(moments), (rotor,), ORBIT)
        found = verdict(system, at_rest_in_lvlh(ORBIT, q_lb)).stability
        if is_surely_stable(I_r, I_t, I_n, n, h):
            assert found == 'stable'
        elif small_motion(I_r, I_t, I_n, n, h).is_stable:
            assert found == 'undecided'
        else:
            assert found == 'unstable'


def test_debra_and_delp_are_not_decided():
    """Gyroscopic stability is not called stable: damping ends it."""
    system = System(np.diag([1.5238, 0.9238, 1.0]), orbit=ORBIT)
    found = verdict(system, at_rest_in_lvlh(ORBIT, rotation.IDENTITY))
    assert found.stability == 'undecided'
    assert 'gyroscopic' in found.argument


@pytest.mark.parametrize(
    ('inertia', 'h'),
    [
        (np.diag([800.0, 900.0, 600.0]), [0.0, 0.0, 0.0]),
        (np.diag([800.0, 900.0, 600.0]), [0.1, 0.2, 0.05]),
        (SKEW @ np.diag([800.0, 900.0, 600.0]) @ SKEW.T, [0.3, -0.2, 0.1]),
    ],
)
def test_relative_equilibria_go_as_the_verdict_says(inertia, h):
    """Near each equilibrium of a gyrostat on a circle, over twenty orbits."""
    size = float(np.linalg.norm(h))
    rotor = Rotor('constant_momentum', np.array(h) / size, size) if size else Rotor()
    system = System(inertia, (rotor,), ORBIT)
    spans = 20.0 * 2.0 * np.pi / ORBIT.mean_motion
    for steady in steady_motions(system, State(rotation.IDENTITY, np.zeros(3)))[::3]:
        if steady.verdict.stability == 'undecided':
            continue
        gone = Propagation(system, _aside(steady.state), 0.0, 1e-11).at(
            np.linspace(0.0, spans, 2001)
        )
        turned = rotation.angle_between(
            gone.q_lb, rotation.multiply(rotation.conjugate(ORBIT.lvlh(0.0)), steady.state.q_ib)
        )
        assert (np.max(turned) > NEAR) == (steady.verdict.stability == 'unstable')


def _aside(state):
    turn = rotation.normalise([*(ASIDE / 2.0 * np.array([0.36, 0.48, 0.8])), 1.0])
    return State(rotation.multiply(state.q_ib, turn), state.omega_bi_b)


@pytest.mark.parametrize(('spin', 'stability'), [(3.2, 'stable'), (2.4, 'unstable')])
def test_the_sleeping_top(spin, stability):
    """An upright top stays up where J3^2 > 4 A M g z0 (here at spin 2.83), and falls below."""
    A, C, weight = 1.0, 1.0 / 1.4142135623730951, 1.0
    system = System(np.diag([A, A, C]), weight_moment=np.array([0.0, 0.0, weight]))
    state = State(rotation.IDENTITY, np.array([0.0, 0.0, spin]))
    assert verdict(system, state).stability == stability
    turn = rotation.normalise([ASIDE, 0.0, 0.0, 1.0])
    states = Propagation(system, State(turn, state.omega_bi_b), 0.0, 1e-11).at(
        np.linspace(0.0, 100.0, 2001)
    )
    assert (np.min(states.c_b[:, 2]) < 1.0 - NEAR) == (stability == 'unstable')


def test_rotations_about_the_vertical():
    """A triaxial body in a fixed field, about its principal axes, as the propagation goes."""
    system = System(np.diag([1.0, 1.5, 2.0]), orbit=FixedDirection(1.0))
    found = steady_motions(system, State(rotation.IDENTITY, np.array([0.0, 0.0, 1.5])))
    assert len(found) == 6
    for steady in found:
        if steady.verdict.stability != 'undecided':
            unstable = steady.verdict.stability == 'unstable'
            assert (wander(system, steady.state, 400.0) > NEAR) == unstable


def test_an_elliptic_orbit_has_no_steady_motions():
    """The verdict is refused there, and none is listed."""
    system = System(np.diag([1.0, 1.5, 2.0]), orbit=KeplerOrbit(eccentricity=0.1))
    state = State(rotation.IDENTITY, np.array([0.0, 0.0, 1e-3]))
    assert steady_motions(system, state) == []
    with pytest.raises(ValueError, match='elliptic'):
        verdict(system, state)


def test_a_steady_precession():
    """
    Paladini's steady precession, its body spinning: stable, with the nutation of f (2.1).

    u'^2 = f(u) has a double root there, and small nutations the frequency sqrt(-f'' / 2).
    """
    case = rigid()['pal1_steady_precession_double_root']
    assert verdict(case.system, case.start).stability == 'stable'
    A, C = (float(case.raw['body'][key]) for key in 'AC')
    H1, H2 = (float(case.raw['field'][key]) for key in ('H1', 'H2'))
    u = rotation.rotate(rotation.conjugate(case.start.q_ib), [0.0, 0.0, 1.0])[2]
    p, q, r0 = case.start.omega_bi_b
    h_prime = A / 2.0 * (p * p + q * q) - H1 * u * u - H2 * u
    second = 12.0 * -2.0 * H1 / A * u * u - 6.0 * 2.0 * H2 / A * u
    second += 2.0 * (2.0 * (H1 - h_prime) / A - (C * r0 / A) ** 2)
    roots = small_motion_roots(case.system, case.start)
    nutation = np.sqrt(-second / 2.0)
    assert np.min(np.abs(roots - 1j * nutation)) < 1e-7 * nutation
