"""Where ROS keeps its log."""

import subprocess
import sys
from pathlib import Path

import pytest
from ros.live import ENVIRONMENT


def run(environment, *arguments):
    return subprocess.run(
        [sys.executable, '-m', 'satdyn_ros.cli.main', *arguments],
        env=environment,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=60.0,
    )


def test_without_a_home_directory_in_the_environment():
    """A service of the system, which has no HOME, takes part in ROS."""
    home = ('HOME', 'ROS_HOME', 'ROS_LOG_DIR')
    environment = {name: value for name, value in ENVIRONMENT.items() if name not in home}
    done = run(environment, 'request', '--reset', '--node', '/nowhere/satdyn', '--timeout', '0.5')
    assert done.stdout.startswith('no: no node /nowhere/satdyn found within 0.5 s')
    assert (done.returncode, done.stderr) == (1, '')


@pytest.mark.parametrize(
    'arguments',
    [('request', '--reset'), ('watch', '--port', '0'), ('node',), ('replay',)],
    ids=lambda arguments: arguments[0],
)
def test_without_a_folder_for_the_log(arguments, tmp_path):
    """What cannot write the log of ROS ends in a sentence that says what to set."""
    (tmp_path / 'file').touch()
    if arguments == ('replay',):
        bag = Path(__file__).parents[1] / 'reference/bags_0.2/closed_form'
        arguments = ('replay', str(bag))
    done = run(ENVIRONMENT | {'ROS_LOG_DIR': str(tmp_path / 'file/log')}, *arguments)
    (line,) = done.stderr.splitlines()
    assert line.startswith(f'satdyn {arguments[0]}: ROS has no folder for its log; ROS_LOG_DIR')
    assert (done.returncode, done.stdout) == (2, '')
