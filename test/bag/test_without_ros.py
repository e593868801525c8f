"""Bags where there is no ROS: in an environment that holds what setup.py asks for alone."""

import os
import re
import subprocess
import sys
from importlib.metadata import distribution
from pathlib import Path

import flights
import pytest

from satdyn_ros.bag.simulate import simulate
from satdyn_ros.run.scenario import Scenario

PROJECT = Path(__file__).parents[2]
SCENARIO = """\
/**:
  ros__parameters:
    body: {inertia: [800.0, 900.0, 600.0]}
    rotor: {mode: constant_momentum, momentum: -5.0}
    publish: {rate: 30.0, topics: [attitude, imu, odometry, markers, tf]}
    time: {epoch_ns: 1700000000000000000}
"""
EVENTS = """\
- {at_s: 1.0, torque: [0.0, 0.0, 0.05], until_s: 2.0}
- {at_s: 3.0, request: {initial.angular_velocity: [0.0, 0.01, 0.0]}}
"""


def with_needs(names):
    """Return the distributions and all that they need, extras left out."""
    found = {}
    for name in names:
        found[name] = distribution(name)
        required = [need for need in found[name].requires or [] if 'extra ==' not in need]
        further = [re.match(r'[\w.-]+', need).group() for need in required if ';' not in need]
        found |= with_needs(further)
    return found


@pytest.fixture(scope='module')
def bare(tmp_path_factory):
    """Return the variables of an environment with the runtime needs and nothing else."""
    declared = re.search(r'install_requires=\[(.*?)\]', (PROJECT / 'setup.py').read_text(), re.S)
    names = [re.match(r'[\w-]+', need).group() for need in re.findall(r"'(.*?)'", declared[1])]
    site = tmp_path_factory.mktemp('site')
    for found in with_needs(names).values():
        tops = {Path(file).parts[0] for file in found.files} - {'..', '__pycache__'}
        for top in tops:
            if not (site / top).exists():
                (site / top).symlink_to(found.locate_file(top))
    return {'PYTHONPATH': f'{site}:{PROJECT}', 'PATH': os.environ['PATH'], 'HOME': str(site)}


def python(bare, directory, *arguments):
    """Run Python without its own site-packages; return what it said."""
    return subprocess.run(
        [sys.executable, '-S', *map(str, arguments)],
        env=bare,
        cwd=directory,
        capture_output=True,
        text=True,
    )


def satdyn(bare, directory, *arguments):
    """Run the command there and return its output; it has to succeed."""
    program = 'import sys; from satdyn_ros.cli.main import main; sys.exit(main())'
    result = python(bare, directory, '-c', program, *arguments)
    assert result.returncode == 0, result.stderr
    return result.stdout


@pytest.mark.parametrize('name', ['rclpy', 'geometry_msgs', 'rosbags'])
def test_the_environment_has_no_ros(bare, tmp_path, name):
    """What the other tests here show would be worth nothing otherwise."""
    result = python(bare, tmp_path, '-c', f'import {name}')
    assert f"No module named '{name}'" in result.stderr


def test_bags_are_the_same_without_ros(bare, tmp_path):
    """Simulated, verified, recovered and exported there; byte for byte the bag from here."""
    (tmp_path / 'scenario.yaml').write_text(SCENARIO)
    (tmp_path / 'events.yaml').write_text(EVENTS)
    given = ('scenario.yaml', '--duration', '5', '--events', 'events.yaml')
    satdyn(bare, tmp_path, 'simulate', *given, '-o', 'there')

    from satdyn_ros.run import events

    scenario = Scenario.from_yaml(tmp_path / 'scenario.yaml')
    happening = events.from_yaml(tmp_path / 'events.yaml', scenario)
    for _ in simulate(scenario, 5.0, tmp_path / 'here', happening):
        pass
    here = flights.sequence(tmp_path / 'here')
    assert len(here) == 5 * 150 + 1
    assert flights.sequence(tmp_path / 'there') == here

    file = tmp_path / 'there/there_0.mcap'
    whole = file.read_bytes()
    (tmp_path / 'there/metadata.yaml').unlink()
    file.write_bytes(whole[:-40])
    satdyn(bare, tmp_path, 'recover', 'there')
    assert file.read_bytes() == whole
    assert 'the same byte for byte' in satdyn(bare, tmp_path, 'verify', 'there')
    satdyn(bare, tmp_path, 'export', 'there', '-o', 'states.csv')
    assert len((tmp_path / 'states.csv').read_text().splitlines()) == 151
