"""Wheels with dry friction, drives that follow speeds, imbalance, as others integrated them."""

import numpy as np
import pytest
import yaml
from environment import truth

from satdyn_ros.actuators import Command
from satdyn_ros.bag.read_run import RecordedRun
from satdyn_ros.bag.simulate import simulate
from satdyn_ros.bag.verify import verify
from satdyn_ros.dynamics.drives import law_of
from satdyn_ros.dynamics.integrals import relative_drift
from satdyn_ros.dynamics.rotor import Rotor
from satdyn_ros.kernel import rotation
from satdyn_ros.run.events import from_yaml_text, to_yaml
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.run.simulation import Simulation

CASES = {case['name']: case for case in truth.cases('gravity_gradient')}
FOLLOWS = Scenario.from_dict(
    CASES['wheel_speed_loop']['scenario'] | {'publish': {'rate': 1.0, 'topics': ['rotor']}}
)


@pytest.mark.parametrize(
    'name',
    [
        'wheel_speed_loop',
        # The equations of these have to be compiled anew.
        pytest.param('coulomb_wheel', marks=pytest.mark.long),
        pytest.param('jitter_300', marks=pytest.mark.long),
    ],
)
def test_states_are_those_of_the_reference(name):
    """Attitude, rate, speed and angle within the bound of the case."""
    case = CASES[name]
    rates = {'publish': {'rate': 2.0}, 'torque': {'timeout': 0.0}}
    scenario = Scenario.from_dict(case['scenario'] | rates)
    events = from_yaml_text(yaml.safe_dump(case['events']), scenario) if case['events'] else []
    simulation, rows = Simulation(scenario, events), []
    t_s = truth.column(case['states'], 't')
    while simulation.next_tick <= 2 * t_s[-1]:
        states = simulation.advance(int(2 * t_s[-1]) + 1 - simulation.next_tick)[1].states
        columns = states.q_ib, states.omega_bi_b, states.rotor_speed, states.rotor_angle
        rows.append(np.hstack(columns))
    found = np.concatenate(rows)[(2 * t_s).astype(int)]
    q_ib, omega, speed, angle = (
        truth.column(case['states'], each)
        for each in ('q_xyzw', 'omega', 'rotor_speed', 'rotor_angle')
    )
    bound, drift = case['bound'], relative_drift(scenario.system, states)
    # An event begins another motion, with a balance of its own.
    assert case['events'] or np.max(np.abs(drift['energy_balance'])) < 1e-11
    assert np.max(rotation.angle_between(found[:, :4], q_ib)) < bound
    np.testing.assert_allclose(found[:, 4:7], omega, rtol=0.0, atol=bound)
    np.testing.assert_allclose(found[:, 7:8], speed, rtol=0.0, atol=bound * np.max(np.abs(speed)))
    np.testing.assert_allclose(found[:, 8:], angle, rtol=0.0, atol=bound * np.max(np.abs(angle)))


def test_a_bag_with_commanded_speeds_verifies(tmp_path):
    """A speed is recorded as a velocity, goes on through a reset, and ends after its time."""
    text = """
        - {at_s: 1, rotor_speed: 100.0, until_s: 40}
        - {at_s: 20, reset: true}
        - {at_s: 50, rotor_speed: -20.0, until_s: null}
        - {at_s: 60, rotor_torque: 1.0e-5}
    """
    events = from_yaml_text(text, FOLLOWS)
    assert from_yaml_text(to_yaml(events), FOLLOWS) == events
    split = FOLLOWS.with_values({'record.max_duration_s': 11.0})
    for _ in simulate(split, 70.0, tmp_path / 'bag', events):
        pass
    recorded = RecordedRun(tmp_path / 'bag')
    commands = [event for event in recorded.events if isinstance(event, Command)]
    assert [(c.tick, c.value.torques, c.value.speeds) for c in commands] == [
        (1, {}, {'rotor': 100.0}),
        (50, {}, {'rotor': -20.0}),
        (60, {'rotor': 1e-5}, {}),
    ]
    verdict = verify(tmp_path / 'bag')
    assert verdict.same_bytes, str(verdict)
    for file in sorted((tmp_path / 'bag').glob('*.mcap')):
        assert verify(file).same_bytes


def test_a_speed_of_a_step_holds_during_it():
    """At first the loop gives the largest torque, then J k (100 - s); after the step nothing."""
    simulation = Simulation(FOLLOWS)
    state = simulation.step(rotor_speed={'rotor': 100.0})
    rotor = FOLLOWS.system.rotors[0]
    assert simulation.rotor_torque[0] == rotor.max_torque
    simulation.step(rotor_speed={'rotor': float(state.rotor_speed[0]) + 0.1})
    error = simulation.system.rotor_target[0] - simulation.state.rotor_speed[0]
    expected = rotor.inertia * rotor.speed_gain * error
    np.testing.assert_allclose(simulation.rotor_torque[0], expected, rtol=1e-9)
    simulation.step()
    assert simulation.rotor_torque[0] == 0.0
    with pytest.raises(ValueError, match=r'rotor_command\.rotor is commanded twice; give one'):
        simulation.step(rotor_torque={'rotor': 0.0}, rotor_speed={'rotor': 0.0})


def test_a_law_is_cut_by_both_limits():
    """Level at max_torque, falling between, zero where it would make the rotor faster than 50."""
    rotor = Rotor('motor', inertia=0.1, speed_gain=1.0, max_torque=2.0, max_speed=50.0)
    law = law_of(rotor, 0.0, 60.0)
    assert [(line.low, line.high) for line in law] == [
        (-np.inf, 40.0),
        (40.0, 50.0),
        (50.0, np.inf),
    ]
    assert [line.at(45.0) for line in law] == [2.0, pytest.approx(1.5), 0.0]
    assert law_of(rotor, 0.0, 30.0)[-1].torque == -2.0


def test_a_loop_whose_torque_is_no_number_commands_nothing():
    """The product of inertia and gain may be too small for a float: it is zero, as its limit."""
    rotor = Rotor('motor', inertia=0.01, speed_gain=5e-324, max_torque=0.1, max_speed=50.0)
    assert law_of(rotor, 0.0, 60.0) == law_of(rotor, 0.0, np.nan)


@pytest.mark.parametrize(
    ('changes', 'event', 'sentence'),
    [
        ({'rotor.speed_gain': 0.0}, 'rotor_speed: 1.0', r'and rotor\.speed_gain is 0; .*above 0'),
        ({}, 'rotor_speed: .inf', r'speed of the rotor rotor'),
        (
            {'rotor.max_torque': 0.0},
            'rotor_torque: 1.0e300',
            r'1e\+300; without rotor\.max_torque',
        ),
    ],
)
def test_commands_that_no_motor_takes_are_refused(changes, event, sentence):
    """In one sentence that names the rotor and the key."""
    with pytest.raises(ValueError, match=sentence):
        from_yaml_text(f'- {{at_s: 1, {event}}}', FOLLOWS.with_values(changes))
