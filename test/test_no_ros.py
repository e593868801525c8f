"""Where ROS cannot be imported, what does not need it runs and writes the same bytes."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from flights import GYROSTAT, sequence

ROOT = Path(__file__).parents[1]
EVENTS = """\
- {at_s: 1, torque: [0.0, 0.1, 0.0], until_s: 2}
- {at_s: 3, request: {initial.angular_velocity: [0.0, 0.0, 0.1]}}
- {at_s: 4, topics: [attitude, rotor, markers, tf]}
"""

# Python imports this ahead of all else: every package that a ROS installation brings is refused.
SITECUSTOMIZE = """\
import re
import sys


class NoRos:
    ros = re.compile(r'(rclpy|rosidl|rmw|rpyutils|ament_index|action|builtin|std_srvs|\\w+_msgs)')

    def find_spec(self, name, path=None, target=None):
        top = name.partition('.')[0]
        if self.ros.match(top) or top.endswith(('_interfaces', '_srvs')):
            raise ModuleNotFoundError(f'No module named {top!r}', name=top)


sys.meta_path.insert(0, NoRos())
"""


@pytest.fixture(scope='module')
def without_ros(tmp_path_factory):
    """Return the environment of processes in which ROS cannot be imported."""
    place = tmp_path_factory.mktemp('no_ros')
    (place / 'sitecustomize.py').write_text(SITECUSTOMIZE)
    environment = os.environ | {'PYTHONPATH': f'{place}{os.pathsep}{ROOT}'}
    for package in ('rclpy', 'geometry_msgs.msg', 'rcl_interfaces', 'std_srvs'):
        result = python(environment, '-c', f'import {package}')
        assert 'ModuleNotFoundError' in result.stderr
    return environment


def python(environment, *arguments):
    return subprocess.run(
        [sys.executable, *map(str, arguments)], env=environment, capture_output=True, text=True
    )


def satdyn(environment, *arguments):
    result = python(environment, '-m', 'satdyn_ros.cli.main', *arguments)
    assert result.returncode == 0, result.stderr
    return result.stdout


def test_bags_are_the_same_and_can_be_used(without_ros, tmp_path):
    """A bag of every topic, written without ROS, is byte for byte that of an install with ROS."""
    scenario, happening = tmp_path / 'scenario.yaml', tmp_path / 'events.yaml'
    scenario.write_text(GYROSTAT.to_yaml())
    happening.write_text(EVENTS)
    command = ['simulate', scenario, '--events', happening, '--duration', '5', '-o']
    bags = tmp_path / 'with/bag', tmp_path / 'without/bag'
    satdyn(os.environ | {'PYTHONPATH': str(ROOT)}, *command, bags[0])
    satdyn(without_ros, *command, bags[1])
    for name in ('bag_0.mcap', 'metadata.yaml'):
        assert (bags[0] / name).read_bytes() == (bags[1] / name).read_bytes()

    assert 'the same byte for byte' in satdyn(without_ros, 'verify', bags[1])

    table = tmp_path / 'states.npz'
    satdyn(without_ros, 'export', bags[1], '-o', table)
    states = GYROSTAT.motion().at(np.arange(30) / 30.0)
    exported = np.load(table)
    np.testing.assert_array_equal(exported['q_ib_w'][:30], states.q_ib[:, 3])

    cut = tmp_path / 'cut'
    shutil.copytree(bags[1], cut)
    (cut / 'metadata.yaml').unlink()
    (cut / 'bag_0.mcap').write_bytes((bags[1] / 'bag_0.mcap').read_bytes()[:-1000])
    satdyn(without_ros, 'recover', cut)
    recovered = sequence(cut)
    assert recovered
    assert recovered == sequence(bags[1])[: len(recovered)]


def test_the_check_needs_no_ros(without_ros):
    """`satdyn check` proves an installation without ROS."""
    assert satdyn(without_ros, 'check').endswith('all is well\n')


def test_the_front_door_needs_no_ros(without_ros):
    """The public names of Python are there."""
    program = (
        'import satdyn_ros\n'
        'for name in satdyn_ros.__all__: getattr(satdyn_ros, name)\n'
        'print(satdyn_ros.Simulation(satdyn_ros.Scenario()).step().q_ib.shape)'
    )
    assert python(without_ros, '-c', program).stdout == '(4,)\n'
