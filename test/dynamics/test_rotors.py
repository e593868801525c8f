"""Gyrostats with several rotors against quadruple precision, alone and in lanes."""

import json

import numpy as np
import pytest
from cases import REFERENCE

from satdyn_ros.dynamics import rotation
from satdyn_ros.dynamics.batch import propagate_all
from satdyn_ros.dynamics.orbit import FixedDirection, KeplerOrbit
from satdyn_ros.dynamics.propagator import Propagation
from satdyn_ros.dynamics.rotor import Rotor
from satdyn_ros.dynamics.system import State, System

CASES = {
    case['name']: case for case in json.loads((REFERENCE / 'rotors.json').read_text())['cases']
}


def motion_of(case):
    """Return the propagation of a case at tolerance 1e-13."""
    orbit = {name: value for name, value in case['orbit'].items() if name != 'type'}
    fixed = case['orbit']['type'] == 'fixed'
    rotors, torques, speeds = [], [], []
    for given in case['rotors']:
        keys = {k: v for k, v in given.items() if k in ('mode', 'momentum', 'inertia', 'friction')}
        rotors.append(Rotor(axis=np.array(given['axis']), name=given['name'], **keys))
        torques.append(given.get('torque', 0.0))
        speeds.append(given.get('speed', np.nan))
    system = System(
        np.array(case['inertia']),
        tuple(rotors),
        FixedDirection(**orbit) if fixed else KeplerOrbit(**orbit),
        weight_moment=np.array(case.get('weight_moment', np.zeros(3))),
        torque_b=np.array(case.get('torque_b', np.zeros(3))),
        rotor_torque=np.array(torques),
    )
    initial = case['initial']
    state = State(
        np.array(initial['q_xyzw']),
        np.array(initial['omega']),
        np.array(speeds),
        0.0 * np.array(speeds),
    )
    return Propagation(system, state, tolerance=1e-13)


@pytest.mark.parametrize('name', CASES)
@pytest.mark.parametrize('fly', ['alone', 'in a lane'])
def test_reference_case(name, fly):
    """Attitude within 1e-9 rad, speeds and angles within 1e-9 relative of the quadruple ones."""
    case = CASES[name]
    motion, t_s = motion_of(case), np.array([float(row['t']) for row in case['states']])
    (states,) = propagate_all([motion], t_s) if fly == 'in a lane' else [motion.at(t_s)]
    q_ib = np.array([[float(x) for x in row['q_xyzw']] for row in case['states']])
    assert rotation.angle_between(states.q_ib, q_ib).max() < 1e-9
    turning = [i for i, rotor in enumerate(motion.system.rotors) if rotor.turns_freely]
    for column, key in ((states.rotor_speed, 'speeds'), (states.rotor_angle, 'angles')):
        truth = np.array([[float(x) for x in row[key]] for row in case['states']])
        for n, i in enumerate(turning):
            size = np.max(np.abs(truth[:, n]))
            np.testing.assert_allclose(column[:, i], truth[:, n], atol=1e-9 * size, rtol=0.0)
