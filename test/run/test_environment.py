"""A body in the environment of its orbit, against states that others integrated."""

import numpy as np
import pytest
from environment import truth
from numpy.testing import assert_allclose

from satdyn_ros.dynamics.integrals import relative_drift
from satdyn_ros.dynamics.system import State, System
from satdyn_ros.dynamics.torque import own_torque
from satdyn_ros.integrate.batch import propagate_all
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import FixedDirection
from satdyn_ros.orbits.pieces import Pieces, Stretch
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.torques.magnetic import Magnetic

CASES = {case['name']: case for case in truth.cases('gravity_gradient')}
FLOWN = (
    'dipole_sso',
    'igrf_sso',
    'kepler_dipole',
    'j2_ten_orbits',
    'tle_cbers2',
    'state_vector',
)


def flown(case):
    """Return the scenario of a case, its states and ours."""
    scenario = Scenario.from_dict(case['scenario'])
    expected = case['states']
    return scenario, expected, scenario.motion().at(truth.column(expected, 't'))


# The equations of each of these have to be compiled anew.
LONG = 'dipole_sso', 'kepler_dipole', 'state_vector'


@pytest.mark.parametrize(
    'name', [pytest.param(name, marks=[pytest.mark.long] * (name in LONG)) for name in FLOWN]
)
def test_states_are_those_of_the_reference(name):
    """Attitude and rate within the bound of the case, and the balance of energy to rounding."""
    case = CASES[name]
    scenario, expected, states = flown(case)
    q_ib, omega = truth.column(expected, 'q_xyzw'), truth.column(expected, 'omega')
    assert np.max(rotation.angle_between(states.q_ib, q_ib)) < case['bound']
    bound = case['bound'] * np.max(np.linalg.norm(omega, axis=1))
    assert_allclose(states.omega_bi_b, omega, rtol=0.0, atol=bound)
    drift = relative_drift(scenario.system, states)['energy_balance']
    assert np.max(np.abs(drift)) < 1e-11


@pytest.mark.parametrize('name', ['igrf_sso', 'tle_cbers2'])
def test_the_torque_is_that_of_the_reference(name):
    """On its states, to 1e-9 of the largest: the last digits of the attitudes."""
    case = CASES[name]
    scenario, _, states = flown(case)
    expected = truth.column(case['fields'], 'magnetic_torque')
    found = own_torque(scenario.system.torques, states)
    assert_allclose(found, expected, rtol=0.0, atol=2e-9 * np.max(np.abs(expected)))


def test_a_batch_flies_in_the_same_field():
    """Three rates side by side are the three alone."""
    scenario = Scenario.from_dict(CASES['igrf_sso']['scenario'])
    system, state, t_s = scenario.system, scenario.initial_state, np.linspace(0.0, 6000.0, 31)
    motions = [
        Propagation(system, State(state.q_ib, k * state.omega_bi_b)) for k in (0.5, 1.0, 1.5)
    ]
    for motion, states in zip(motions, propagate_all(motions, t_s), strict=True):
        assert np.max(rotation.angle_between(states.q_ib, motion.at(t_s).q_ib)) < 1e-11


def test_a_dipole_in_a_uniform_field_is_a_heavy_top():
    """M x B is the torque of a weight moment -|B| m, whatever the body."""
    dipole, B = np.array([0.2, -0.1, 0.4]), 3e-5
    uniform = np.zeros((3, 16))
    uniform[2, 0] = B
    field = Pieces(lambda piece: uniform, [Stretch(0.0, 500.0)])
    inertia = np.diag([0.9, 1.1, 0.8])
    state = State(rotation.normalise([0.1, 0.2, 0.3, 0.9]), np.array([0.01, 0.02, -0.03]))
    magnetised = System(inertia, torques=(Magnetic(dipole, field),))
    heavy = System(inertia, orbit=FixedDirection(0.0), weight_moment=-B * dipole)
    t_s = np.linspace(0.0, 3000.0, 31)
    found, expected = Propagation(magnetised, state).at(t_s), Propagation(heavy, state).at(t_s)
    assert np.max(rotation.angle_between(found.q_ib, expected.q_ib)) < 1e-11


@pytest.mark.parametrize(
    ('changes', 'sentence'),
    [
        ({'orbit.type': 'fixed'}, 'environment.magnetic_field is igrf; with orbit.type fixed'),
        ({'orbit.mu': 4e14}, 'orbit.mu 4e\\+14; it must be within'),
    ],
)
def test_a_field_of_the_earth_needs_the_earth(changes, sentence):
    """Elsewhere it is refused, with the keys."""
    with pytest.raises(ValueError, match=sentence):
        Scenario({'environment.magnetic_field': 'igrf'} | changes)


def test_without_an_instant_there_is_no_field():
    """The sentence says which key needs it; a dipole without a field is warned about."""
    given = {'environment.magnetic_field': 'igrf', 'body.dipole': [0.0, 0.0, 1.0]}
    with pytest.raises(ValueError, match=r'environment\.magnetic_field igrf needs the instant'):
        Scenario(given).motion()
    late = Scenario(given | {'time.epoch_ns': 2 * 10**18})
    assert 'outside the IGRF' in ' '.join(late.warnings)
    with pytest.raises(ValueError, match='5 years at most'):
        Scenario(given | {'time.epoch_ns': 3 * 10**18}).motion()
    (warning,) = Scenario({'body.dipole': [0.0, 0.0, 1.0]}).warnings
    assert warning.startswith('body.dipole is given')
