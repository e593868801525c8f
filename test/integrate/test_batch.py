"""Propagations side by side: the truths of single ones, whatever the neighbours."""

import numpy as np
import pytest
from cases import bounded, newtonian, rigid

from satdyn_ros.dynamics.motion import States
from satdyn_ros.dynamics.rotor import Rotor
from satdyn_ros.dynamics.system import State, System
from satdyn_ros.integrate.batch import LANES, propagate_all
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import KeplerOrbit

CASES = newtonian() | rigid()
INERTIA = np.diag([900.0, 800.0, 600.0])
FREE = Rotor('free', np.array([0.0, 1.0, 0.0]), inertia=0.05)
SYSTEMS = [
    System(INERTIA, orbit=KeplerOrbit()),
    System(INERTIA, orbit=KeplerOrbit(eccentricity=0.3)),
    System(INERTIA, orbit=KeplerOrbit(), rotors=(FREE,)),
    System(INERTIA, orbit=KeplerOrbit(), rotors=(FREE,), rotor_torque=np.array(1e-4)),
    System(INERTIA, orbit=KeplerOrbit(), torque_b=np.array([0.0, 1e-4, 2e-4])),
]
TIMES_S = np.linspace(0.0, 6000.0, 7)


def motions(count, seed=1):
    """Return motions of all kinds, from attitudes and rates of a seed."""
    rng = np.random.default_rng(seed)
    return [
        Propagation(
            SYSTEMS[i % len(SYSTEMS)],
            State(rotation.normalise(rng.normal(size=4)), rng.normal(size=3) * 1e-2, 30.0, 0.0),
            tolerance=10.0 ** rng.integers(-13, -8),
        )
        for i in range(count)
    ]


def columns(states):
    """Return all that states hold of a motion, (N, 10)."""
    rotors = [states.rotor_speed, states.rotor_angle]
    return np.hstack([states.q_ib, states.omega_bi_b, *rotors, states.work[:, None]])


@pytest.mark.parametrize(
    'name',
    # Code of its own is compiled for the lanes of ellipses.
    [
        pytest.param(name, marks=[pytest.mark.long] * CASES[name].system.orbit.is_eccentric)
        for name in bounded(CASES, 'bound_numeric')
    ],
)
def test_reference_case(name):
    """Every reference case, in a lane among others, stays within its bound at 1e-13."""
    case = CASES[name]
    motion = Propagation(case.system, case.start, tolerance=1e-13)
    # Copies with other tolerances take other steps in the lanes beside.
    beside = [Propagation(case.system, case.start, tolerance=10.0**-n) for n in range(6, 10)]
    states = propagate_all([*beside, motion], case.t_s)[-1]
    assert isinstance(states, States)
    assert rotation.angle_between(states.q_ib, case.q_ib).max() < case.bound_numeric
    rate = np.linalg.norm(case.omega_bi_b, axis=1).max()
    error = np.linalg.norm(states.omega_bi_b - case.omega_bi_b, axis=1).max()
    assert error < 10.0 * case.bound_numeric * rate


@pytest.mark.long
def test_as_one_by_one():
    """Rotors, ellipses and torques come out as from single propagations, to rounding."""
    flown = motions(3 * LANES + 1)
    for motion, states in zip(flown, propagate_all(flown, TIMES_S), strict=True):
        single = columns(motion.at(TIMES_S))
        # Rounding of 1e-16 a step, in some hundred steps whose lengths differ by it.
        scale = np.abs(np.nan_to_num(single)).max(axis=0) + 1e-300
        np.testing.assert_allclose(columns(states) / scale, single / scale, atol=1e-11)


@pytest.mark.long
def test_neighbours_change_nothing():
    """The same bits alone and among others, in whatever lane."""
    flown = motions(3 * LANES + 1)
    for motion, states in zip(flown, propagate_all(flown, TIMES_S), strict=True):
        (alone,) = propagate_all([motion], TIMES_S)
        np.testing.assert_array_equal(columns(states), columns(alone))


@pytest.mark.long
def test_one_that_halts_ends_alone():
    """A motion that no step length suits gives its error, the others go on."""
    flown = motions(LANES)
    stuck = Propagation(flown[0].system, State(flown[0].state.q_ib, np.full(3, 1e160)))
    found = propagate_all([stuck] * LANES + flown, TIMES_S)
    for motion, states in zip(flown, found[LANES:], strict=True):
        (alone,) = propagate_all([motion], TIMES_S)
        np.testing.assert_array_equal(columns(states), columns(alone))
    with pytest.raises(RuntimeError, match='no step meets the tolerance') as single:
        stuck.at(TIMES_S)
    assert [str(halted) for halted in found[:LANES]] == [str(single.value)] * LANES


@pytest.mark.long
def test_no_motions_and_the_begin():
    """No motions give no states; at time zero every motion is where it starts, bit for bit."""
    assert propagate_all([], TIMES_S) == []
    flown = motions(5)
    for motion, states in zip(flown, propagate_all(flown, [0.0]), strict=True):
        assert isinstance(states, States)
        np.testing.assert_array_equal(states.q_ib[0], motion.state.q_ib)
        np.testing.assert_array_equal(states.omega_bi_b[0], motion.state.omega_bi_b)


def test_times_may_be_every_other_of_an_array():
    """As of the same times side by side."""
    motion = Propagation(System(np.eye(3)), State(rotation.IDENTITY, np.array([0.1, 0.2, 0.3])))
    t_s = np.linspace(0.0, 10.0, 11)[::2]
    (states,) = propagate_all([motion], t_s)
    assert isinstance(states, States)
    np.testing.assert_array_equal(states.q_ib, motion.at(t_s).q_ib)
