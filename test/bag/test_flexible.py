"""Flexible modes in a bag: verified, gone on with, in tables and pictures by their names."""

import numpy as np
import pytest
from actuated import cases

from satdyn_ros import Scenario
from satdyn_ros.bag.columns import StateTable
from satdyn_ros.bag.continuation import begun_in_bag
from satdyn_ros.bag.read_run import RecordedRun
from satdyn_ros.bag.simulate import simulate
from satdyn_ros.bag.verify import verify
from satdyn_ros.messages import cdr
from satdyn_ros.report.plot import plot
from satdyn_ros.rosbag2.reader import Bag

SCENARIO = Scenario.from_dict(
    cases('flexible.json')['flex_damped_torques']['scenario']
).with_values({'publish.topics': ['attitude', 'angular_velocity', 'flexible']})


@pytest.fixture(scope='module')
def bag(tmp_path_factory):
    directory = tmp_path_factory.mktemp('flexible') / 'bag'
    for _ in simulate(SCENARIO, 20.0, directory):
        pass
    return directory


def test_it_verifies(bag):
    """Byte for byte."""
    verdict = verify(bag)
    assert verdict.is_true
    assert verdict.same_bytes


def test_a_few_ticks_of_a_long_boom_verify(tmp_path):
    """The swing of a mode within its first step is off by more than a rigid body's rate is."""
    scenario = Scenario.from_yaml('config/flexible.yaml').with_values(
        {
            'initial.frame': 'inertial',
            'initial.angular_velocity': [0.0, 0.0, 0.0],
            'motion.tolerance': 1e-11,
            'publish.rate': 29.97,
            'time.epoch_ns': 10**18,
            'flexible.torsion.frequency': 0.03,
            'flexible.torsion.damping': 0.5,
            'flexible.fuel.frequency': 0.16,
        }
    )
    for _ in simulate(scenario, 0.12, tmp_path / 'bag'):
        pass
    verdict = verify(tmp_path / 'bag')
    assert verdict.is_true, verdict
    assert verdict.drift['energy_balance'] > 0.3 * verdict.allowed_drift


def test_its_messages_name_the_modes(bag):
    """As sensor_msgs/JointState: the displacement as position, the rate as velocity."""
    data = bytes(Bag(bag).messages('/flexible').data[0])
    message = cdr.read('sensor_msgs/msg/JointState', data)
    assert message.name == ['array', 'boom']
    assert (message.position, message.velocity, message.effort) == ([0.0, 0.02], [0.0, 0.0], [])


def test_its_table_has_the_modes(bag):
    """By their names, as the motion has them."""
    (block,) = StateTable(RecordedRun(bag), ['t_s', 'boom_displacement_sqrt_kg_m']).blocks()
    eta = SCENARIO.motion().at(block['t_s']).inner['flexible.boom.displacement']
    np.testing.assert_array_equal(block['boom_displacement_sqrt_kg_m'], eta)


def test_it_goes_on_where_it_is(bag, tmp_path):
    """The motion goes on, or begins anew with the swing of then where another key changes."""
    stiffer = SCENARIO.with_values({'flexible.boom.damping': 0.03})
    found = []
    for n, scenario in enumerate((SCENARIO, stiffer)):
        scenario, begin = begun_in_bag(scenario, bag, 10.0)
        for _ in simulate(scenario, 5.0, tmp_path / str(n), begin=begin):
            pass
        assert verify(tmp_path / str(n)).is_true
        found.append(Bag(tmp_path / str(n)).messages('/flexible').data)
    before = Bag(bag).messages('/flexible').data
    np.testing.assert_array_equal(found[0], before[100:150])
    np.testing.assert_array_equal(found[1][0], before[100])
    assert not np.array_equal(found[1][10], before[110])


def test_it_is_drawn(bag, tmp_path):
    """The panel is that of the topic."""
    plot(bag, tmp_path / 'modes.png', ['flexible', 'drift'])
    assert (tmp_path / 'modes.png').stat().st_size > 10_000
