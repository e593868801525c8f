"""Where there is no ROS: in an environment that holds what setup.py asks for, and nothing else."""

import os
import re
import subprocess
import sys
from collections.abc import Iterable
from importlib.metadata import Distribution, distribution
from pathlib import Path

import numpy as np
import pytest
from flights import GYROSTAT

from satdyn_ros.bag.simulate import simulate
from satdyn_ros.run import events

ROOT = Path(__file__).parents[1]
EVENTS = """\
- {at_s: 1, torque: [0.0, 0.1, 0.0], until_s: 2}
- {at_s: 3, request: {initial.angular_velocity: [0.0, 0.0, 0.1]}}
- {at_s: 4, topics: [attitude, rotor, markers, tf]}
"""


def with_needs(names: Iterable[str]) -> dict[str, Distribution]:
    """Return the distributions and all that they need, extras left out."""
    found = {}
    for name in names:
        found[name] = distribution(name)
        required = [need for need in found[name].requires or [] if 'extra ==' not in need]
        further = [re.split(r'[^\w.-]', need)[0] for need in required if ';' not in need]
        found |= with_needs(further)
    return found


@pytest.fixture(scope='module')
def bare(tmp_path_factory):
    """Return the variables of an environment with the runtime needs and nothing else."""
    setup = (ROOT / 'setup.py').read_text()
    (declared,) = re.findall(r'install_requires=\[(.*?)\]', setup, re.DOTALL)
    names = [re.split(r'[^\w-]', need)[0] for need in re.findall(r"'(.*?)'", declared)]
    site = tmp_path_factory.mktemp('site')
    for found in with_needs(names).values():
        tops = {Path(file).parts[0] for file in found.files or []} - {'..', '__pycache__'}
        for top in tops:
            if not (site / top).exists():
                (site / top).symlink_to(found.locate_file(top))
    return {'PYTHONPATH': f'{site}:{ROOT}', 'PATH': os.environ['PATH'], 'HOME': str(site)}


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
    result = python(bare, directory, '-m', 'satdyn_ros.cli.main', *arguments)
    assert result.returncode == 0, result.stderr
    return result.stdout


@pytest.mark.parametrize('name', ['rclpy', 'geometry_msgs', 'rosbags'])
def test_the_environment_has_no_ros(bare, tmp_path, name):
    """What the other tests here show would be worth nothing otherwise."""
    result = python(bare, tmp_path, '-c', f'import {name}')
    assert f"No module named '{name}'" in result.stderr


def test_what_needs_the_extra_environment_says_so(bare, tmp_path):
    """Without its libraries each function of the Earth is refused in one sentence that helps."""
    program = """
from satdyn_ros import environment
position = [7e6, 0.0, 0.0]
for call in (
    lambda: environment.gcrs_to_itrs(0),
    lambda: environment.teme_to_gcrs(0),
    lambda: environment.geodetic(position),
    lambda: environment.sun_position(0),
    lambda: environment.igrf_field(0, position),
    lambda: environment.dipole_vector(0),
    lambda: environment.Msis().log_density(0, 0.0, 0.0, 4e5),
):
    try:
        call()
    except ValueError as error:
        print(error)
"""
    erfa, igrf, msis = (
        f'this needs {library}, which the extra `environment` brings: pip install {library}'
        for library in ('pyerfa', 'ppigrf', 'pymsis')
    )
    said = python(bare, tmp_path, '-c', program).stdout.splitlines()
    assert said == [erfa] * 4 + [igrf] * 2 + [msis]


def test_bags_are_the_same_and_can_be_used(bare, tmp_path):
    """A bag of every topic, simulated there, is that from here; verified, exported, recovered."""
    (tmp_path / 'scenario.yaml').write_text(GYROSTAT.to_yaml())
    (tmp_path / 'events.yaml').write_text(EVENTS)
    here, there = tmp_path / 'here/bag', tmp_path / 'there/bag'
    given = ('scenario.yaml', '--duration', '5', '--events', 'events.yaml')
    satdyn(bare, tmp_path, 'simulate', *given, '-o', there)
    for _ in simulate(GYROSTAT, 5.0, here, events.from_yaml_text(EVENTS, GYROSTAT)):
        pass
    for name in ('bag_0.mcap', 'metadata.yaml'):
        assert (there / name).read_bytes() == (here / name).read_bytes()

    assert 'the same byte for byte' in satdyn(bare, tmp_path, 'verify', there)
    satdyn(bare, tmp_path, 'export', there, '-o', 'states.npz')
    states = GYROSTAT.motion().at(np.arange(30) / 30.0)
    exported = np.load(tmp_path / 'states.npz')
    np.testing.assert_array_equal(exported['q_ib_w'][:30], states.q_ib[:, 3])

    file = there / 'bag_0.mcap'
    os.truncate(file, file.stat().st_size - 40)
    (there / 'metadata.yaml').unlink()
    satdyn(bare, tmp_path, 'recover', there)
    assert file.read_bytes() == (here / 'bag_0.mcap').read_bytes()


@pytest.mark.long
def test_the_check_needs_no_ros(bare, tmp_path):
    """`satdyn check` proves an installation without ROS."""
    assert satdyn(bare, tmp_path, 'check').endswith('all is well\n')


def test_the_front_door_needs_no_ros(bare, tmp_path):
    """The public names of Python are there."""
    program = (
        'import satdyn_ros\n'
        'for name in satdyn_ros.__all__: getattr(satdyn_ros, name)\n'
        'print(satdyn_ros.Simulation(satdyn_ros.Scenario()).step().q_ib.shape)'
    )
    assert python(bare, tmp_path, '-c', program).stdout == '(4,)\n'


@pytest.mark.parametrize(
    'name',
    ['mcap', *(pytest.param(each, marks=pytest.mark.long) for each in ('zstandard', 'lz4'))],
)
def test_what_a_distribution_of_ros_does_not_have_is_named(bare, tmp_path, name):
    """Only what reads or writes a bag needs it; that says so in one sentence, without a bag."""
    program = (
        f'import sys; sys.modules[{name!r}] = None; '
        'from satdyn_ros.cli.main import main; sys.exit(main(sys.argv[1:]))'
    )
    assert python(bare, tmp_path, '-c', program, 'describe', 'default').returncode == 0
    argv = ('simulate', 'default', '--duration', '1', '-o', 'bag')
    refused = python(bare, tmp_path, '-c', program, *argv)
    sentence = f'satdyn simulate: this needs {name}: pip install {name}\n'
    assert (refused.returncode, refused.stderr) == (2, sentence)
    assert list(tmp_path.iterdir()) == []
