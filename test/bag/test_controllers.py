"""Runs with controllers by command: their bags verify where their files are not."""

import shutil
import subprocess
import sys

import pytest

from satdyn_ros import Scenario, Simulation
from satdyn_ros.actuators import Command
from satdyn_ros.bag import run_metadata
from satdyn_ros.bag.read_run import RecordedRun
from satdyn_ros.bag.verify import verify
from satdyn_ros.rosbag2.reader import Bag, TopicBlock

SHEET = """
/**:
  ros__parameters:
    publish: {rate: 20.0}
    torque: {timeout: 0.5}
    sensors: {names: [gyro], gyro: {noise_density: 1.0e-4, divisor: 10}}
    initial: {angular_velocity: [0.01, 0.02, 0.03]}
"""
DAMPER = """
class Damper:
    period_s, needs_truth = 2.0, {truth}

    def __init__(self, gain=1.0):
        self.gain = gain

    def reset(self, scenario, seed):
        self.asked = 0

    def command(self, sample):
        self.asked += 1
        if self.asked == 4:
            raise KeyError('the fourth')
        return {{'torque_b': [-self.gain * x for x in sample.measured['gyro'].tolist()]}}
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / 'sheet.yaml').write_text(SHEET)
    (tmp_path / 'damper.py').write_text(DAMPER.format(truth=False))
    return tmp_path


def satdyn(folder, *arguments):
    command = [sys.executable, '-m', 'satdyn_ros.cli.main', *arguments]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True)


def controller_of(path):
    """Return what a bag says of the controller."""
    items = (item for item in Bag(path).items() if not isinstance(item, TopicBlock))
    record = next(item.metadata for item in items if item.name == run_metadata.SCENARIO)
    return run_metadata.from_record({'controller': record['controller']})['controller']


def test_its_bag_verifies_without_it(folder):
    """Its commands are those that the bag has; what it is stands in the bag, too."""
    made = ['--controller', 'damper:Damper', '--controller-parameter', 'gain=100.0']
    done = satdyn(folder, 'simulate', 'sheet.yaml', '--duration', '5', *made, '-o', 'bag')
    assert done.returncode == 0, done.stderr
    (folder / 'damper.py').unlink()
    shutil.rmtree(folder / '__pycache__', ignore_errors=True)
    assert 'the same byte for byte' in satdyn(folder, 'verify', 'bag').stdout
    commands = [e for e in RecordedRun(folder / 'bag').events if isinstance(e, Command)]
    # Beyond torque.timeout, until the next one.
    assert [(e.tick, e.until_tick) for e in commands] == [(0, None), (40, None), (80, None)]
    assert controller_of(folder / 'bag') == {'name': 'damper:Damper', 'needs_truth': False}


def test_one_that_fails_leaves_a_complete_bag(folder):
    """Up to there; the sentence names file and line."""
    made = ['--controller', 'damper.py:Damper']
    done = satdyn(folder, 'simulate', 'sheet.yaml', '--duration', '50', *made, '-o', 'bag')
    assert done.returncode != 0
    (sentence,) = done.stderr.splitlines()
    where = f"in {folder / 'damper.py'}, line 14: KeyError: 'the fourth'"
    assert sentence == f'satdyn simulate: the controller damper:Damper failed at 6 s {where}'
    verdict = verify(folder / 'bag')
    assert verdict.same_bytes
    assert RecordedRun(folder / 'bag').last_tick() == 119


@pytest.mark.parametrize(
    ('name', 'why'),
    [
        ('damper', 'it must be MODULE:CLASS, or FILE.py:CLASS'),
        ('damper:None', "module 'damper' has no attribute 'None'"),
        ('nothing.py:Damper', 'FileNotFoundError'),
    ],
)
def test_what_is_no_controller_is_refused(folder, name, why):
    """In one sentence, before a bag is begun."""
    made = ['--controller', name]
    done = satdyn(folder, 'simulate', 'sheet.yaml', '--duration', '5', *made, '-o', 'bag')
    (sentence,) = done.stderr.splitlines()
    assert sentence.startswith(f'satdyn simulate: the controller {name} cannot be made: {why}')
    assert not (folder / 'bag').exists()


def test_from_python_with_the_truth(folder):
    """The bag says that it was seen."""

    class Sees:
        period_s, needs_truth = None, True

        def command(self, sample):
            return {'torque_b': (-10.0 * sample.omega_bi_b).tolist()}

    scenario = Scenario.from_yaml(folder / 'sheet.yaml')
    with Simulation(scenario, controller=Sees(), record=folder / 'bag') as simulation:
        for _ in range(50):
            sample = simulation.step()
    assert sample.tick == 50
    assert controller_of(folder / 'bag')['needs_truth'] is True
    assert verify(folder / 'bag').same_bytes
