"""Gyrostats with several rotors against quadruple precision, alone and in lanes."""

import json

import numpy as np
import pytest
from cases import REFERENCE
from scipy.integrate import cumulative_simpson

from satdyn_ros.dynamics.integrals import relative_drift
from satdyn_ros.dynamics.motion import States
from satdyn_ros.dynamics.rotor import Rotor
from satdyn_ros.dynamics.system import State, System
from satdyn_ros.integrate.batch import propagate_all
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import FixedDirection, KeplerOrbit

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


# Others need code of their own, for their number of rotors and orbit, alone and in a lane.
QUICK = 'R1_circular_1_rotors', 'S_fast_wheel', 'S_stiff_damper', 'S_coaxial_pair'


@pytest.mark.parametrize(
    ('fly', 'name'),
    [
        pytest.param(fly, name, marks=[pytest.mark.long] * (fly != 'alone' or name not in QUICK))
        for fly in ('alone', 'in a lane')
        for name in CASES
    ],
)
def test_reference_case(name, fly):
    """Attitude within 1e-9 rad, speeds and angles within 1e-9 relative of the quadruple ones."""
    case = CASES[name]
    motion, t_s = motion_of(case), np.array([float(row['t']) for row in case['states']])
    (states,) = propagate_all([motion], t_s) if fly == 'in a lane' else [motion.at(t_s)]
    assert isinstance(states, States)
    q_ib = np.array([[float(x) for x in row['q_xyzw']] for row in case['states']])
    assert rotation.angle_between(states.q_ib, q_ib).max() < 1e-9
    turning = [i for i, rotor in enumerate(motion.system.rotors) if rotor.turns_freely]
    for column, key in ((states.rotor_speed, 'speeds'), (states.rotor_angle, 'angles')):
        truth = np.array([[float(x) for x in row[key]] for row in case['states']])
        for n, i in enumerate(turning):
            size = np.max(np.abs(truth[:, n]))
            np.testing.assert_allclose(column[:, i], truth[:, n], atol=1e-9 * size, rtol=0.0)


X, Y, Z = np.eye(3)
BODY = np.array([[0.05, 0.002, 0.0], [0.002, 0.06, -0.001], [0.0, -0.001, 0.04]])
TURNED = np.array([0.1, 0.2, 0.3, np.sqrt(0.86)])


def wheel(axis, friction=0.0):
    """Return a wheel of a CubeSat."""
    return Rotor('motor', axis, inertia=1e-3, friction=friction)


def driven(rotors, torques, speeds, omega, orbit=None):
    """Return the propagation of wheels under constant motor torques."""
    system = System(BODY, rotors, orbit or FixedDirection(0.0), rotor_torque=np.array(torques))
    return Propagation(
        system, State(TURNED, np.array(omega), np.array(speeds), np.zeros(len(rotors)))
    )


@pytest.mark.long
def test_coaxial_wheels_driven_against_each_other_do_not_move_the_body():
    """Torques that cancel leave the attitude within 1e-12 rad of that without motors."""
    wheels, orbit = (wheel(Y), wheel(Y)), FixedDirection(1e-4)
    t_s = np.linspace(0.0, 300.0, 31)
    pair, still = (
        driven(wheels, torques, [20.0, -20.0], [0.02, -0.01, 0.03], orbit).at(t_s)
        for torques in ([1e-4, -1e-4], [0.0, 0.0])
    )
    assert np.abs(pair.rotor_speed - still.rotor_speed).max() > 29.0
    assert rotation.angle_between(pair.q_ib, still.q_ib).max() < 1e-12


@pytest.mark.long
def test_motors_and_friction_leave_the_whole_momentum():
    """Without a field H is constant in inertial axes to 1e-12 whatever motors and friction do."""
    axes = (X, Y, np.array([0.0, 0.6, 0.8]))
    rotors = tuple(
        wheel(axis, friction) for axis, friction in zip(axes, (0.0, 1e-5, 1e-4), strict=True)
    )
    state = State(TURNED, np.array([0.3, -0.2, 0.1]), np.array([50.0, -80.0, 10.0]), np.zeros(3))
    found = []
    for torques in ([1e-3, 0.0, -2e-3], [-3e-3, 1e-3, 5e-4], [0.0, 0.0, 0.0]):
        system = System(BODY, rotors, FixedDirection(0.0), rotor_torque=np.array(torques))
        states = Propagation(system, state).at(np.linspace(0.0, 20.0, 41))
        H_b = states.omega_bi_b @ BODY + 1e-3 * states.rotor_speed @ np.array(axes)
        found.append(rotation.rotate(states.q_ib, H_b))
        state = states[-1]
    H_i = np.concatenate(found)
    size = np.linalg.norm(H_i[0])
    assert np.linalg.norm(H_i - H_i[0], axis=1).max() < 1e-12 * size


@pytest.mark.long
def test_friction_takes_the_energy_that_the_motors_do_not_give():
    """Without a field the kinetic energy of body and wheels rises by sum tau s - b s^2."""
    axes, friction, torques = (X, Z), np.array([1e-4, 3e-4]), np.array([2e-3, -1e-3])
    rotors = tuple(wheel(axis, b) for axis, b in zip(axes, friction, strict=True))
    motion = driven(rotors, torques, [60.0, -40.0], [0.2, -0.1, 0.05])
    states = motion.at(np.linspace(0.0, 30.0, 3001))
    omega, speed = states.omega_bi_b, states.rotor_speed
    along = omega @ np.array(axes).T
    kinetic = np.sum(omega * (omega @ BODY), 1) / 2 + 1e-3 * np.sum(
        speed * along + speed**2 / 2, 1
    )
    work = (states.rotor_angle - states.rotor_angle[0]) @ torques
    heat = cumulative_simpson(speed**2 @ friction, x=states.t_s, initial=0.0)
    assert heat[-1] > 0.1 * kinetic[0]
    # Simpson's rule at 0.01 s.
    np.testing.assert_allclose(kinetic - kinetic[0], work - heat, atol=1e-9 * kinetic[0], rtol=0.0)
    assert np.abs(relative_drift(motion.system, states)['energy_balance']).max() < 1e-12


@pytest.mark.parametrize('friction', [3e-4, 1.8e-3, 1e-2])
def test_a_ring_damper_damps_the_pitch_as_its_cubic_says(friction):
    """A small libration decays and swings within 1e-4 of the roots in docs/theory/on_board.md."""
    I, J, orbit = np.array([12.0, 12.5, 1.0]), 1.0, KeplerOrbit(semi_major_axis=7178137.0)
    stiffness = 3.0 * orbit.mean_motion**2 * (I[0] - I[2])
    cubic = [(I[1] - J) * J, friction * I[1], stiffness * J, stiffness * friction]
    root = max(np.roots(cubic), key=np.imag)
    # The start of the mode of this root: Re(exp(root t)), its rate, and the ring's speed.
    pitch, rate, speed = 0.005 * np.real([1.0, root, -J * root**2 / (J * root + friction)])
    q_li = orbit.lvlh(0.0)
    q_ib = rotation.multiply(q_li, np.array([0.0, np.sin(pitch / 2), 0.0, np.cos(pitch / 2)]))
    omega = rotation.rotate(rotation.conjugate(q_ib), orbit.lvlh_rate(0.0)) + rate * Y
    ring = Rotor('free', Y, inertia=J, friction=friction)
    system = System(np.diag(I), (ring,), orbit)
    start = State(q_ib, omega, np.array([speed]), np.zeros(1))
    step_s = 0.25 / abs(root)
    q_lb = Propagation(system, start).at(step_s * np.arange(100)).q_lb
    theta = 2.0 * np.arctan2(q_lb[:, 1], q_lb[:, 3])
    # Each sample of a damped swing is the same combination of the two before it.
    before = np.stack([theta[1:-1], theta[:-2]], axis=1)
    (a, b), *_ = np.linalg.lstsq(before, theta[2:], rcond=None)
    found = np.log(max(np.roots([1.0, -a, -b]).astype(complex), key=np.imag)) / step_s
    assert found.real == pytest.approx(root.real, rel=1e-4)
    assert found.imag == pytest.approx(root.imag, rel=1e-4)
