"""A kind of actuators that one file adds, put beside the others in a copy of the package."""

import csv
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from geometry_msgs.msg import Vector3Stamped, WrenchStamped
from ros.live import LiveNode, Participant

ROOT = Path(__file__).parents[2]
BIAS = (1e-4, 0.0, 2e-2)
ACTS = (0.0, 0.0, 2e-2)
# The command acts for two seconds of four.
RATE, BEGIN_S, END_S, DURATION_S = 10, 1, 3, 4
SHEET = {
    'publish.rate': float(RATE),
    'publish.topics': ['angular_velocity', 'bias_torque'],
    'body.inertia': [2.0, 2.0, 2.0],
    'bias.dead_band': 1e-3,
    'torque.timeout': 0.0,
}
EVENTS = f"""
- at_s: {BEGIN_S}
  bias: '[{BIAS[0] * 1e3}, 0, {BIAS[2] * 1e3}] mN m'
  until_s: {END_S}
"""


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """Return a folder with the package and the one file, which processes then import."""
    folder = tmp_path_factory.mktemp('own')
    skipped = shutil.ignore_patterns('__pycache__')
    shutil.copytree(ROOT / 'satdyn_ros', folder / 'satdyn_ros', ignore=skipped)
    shutil.copy(Path(__file__).parent / 'bias.py', folder / 'satdyn_ros' / 'actuators')
    lines = ''.join(f'    {key}: {value}\n' for key, value in SHEET.items())
    (folder / 'sheet.yaml').write_text(f'/**:\n  ros__parameters:\n{lines.replace(chr(39), "")}')
    (folder / 'events.yaml').write_text(EVENTS)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv('PYTHONPATH', f'{folder}{os.pathsep}{os.environ.get("PYTHONPATH", "")}')
        yield folder


def run(folder, *arguments):
    """Return what a program of Python, or the command satdyn, prints."""
    command = [sys.executable, *arguments]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def satdyn(folder, *arguments):
    return run(folder, '-m', 'satdyn_ros.cli.main', *arguments)


def test_from_an_events_file_to_a_bag_and_on(folder):
    """The bag verifies; its tables have the torque that acts, its page a panel of it."""
    satdyn(
        folder, 'simulate', 'sheet.yaml', '--events', 'events.yaml',
        '--duration', f'{DURATION_S}', '-o', 'bag',
    )  # fmt: skip
    assert 'the same byte for byte' in satdyn(folder, 'verify', 'bag')
    satdyn(folder, 'export', 'bag', '-o', 'bag.csv')
    with (folder / 'bag.csv').open() as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith('#')))
    torque = np.array(
        [[float(row[f'bias_torque_b_{axis}_n_m']) for axis in 'xyz'] for row in rows]
    )
    t_s = np.arange(len(rows)) / RATE
    acts = (BEGIN_S <= t_s) & (t_s < END_S)
    np.testing.assert_array_equal(torque, np.outer(acts, ACTS))
    satdyn(folder, 'report', 'bag', '-o', 'page.html')
    assert 'bias torque' in (folder / 'page.html').read_text()


def test_from_python(folder):
    """A step has it as a keyword, for the one tick, and a snapshot goes on with it."""
    program = (
        'from satdyn_ros import Scenario, Simulation\n'
        "mine = Simulation(Scenario.from_yaml('sheet.yaml'))\n"
        f'mine.command(bias_b={BIAS})\n'
        'mine.advance(5)\n'
        'snapshot = mine.snapshot(3)\n'
        'on = Simulation.from_snapshot(mine.scenario, snapshot)\n'
        'on.advance(2)\n'
        'here, there = mine.state, on.state\n'
        "print(*mine.acting['bias_command'], (here.omega_bi_b == there.omega_bi_b).all())\n"
    )
    assert run(folder, '-c', program).split() == [*map(str, ACTS), 'True']


def test_from_a_topic(folder, ros):
    """What a message brings acts, is in the diagnostics' counts, and is in the bag."""
    node = LiveNode(folder, SHEET | {'record.enabled': True})
    participant = Participant(node.namespace)
    publisher = participant.node.create_publisher(Vector3Stamped, 'bias_command', 10)
    participant.wait_until(lambda: publisher.get_subscription_count() == 1, 'the node')
    heard: list[WrenchStamped] = []
    participant.node.create_subscription(WrenchStamped, 'bias_torque', heard.append, 10)
    message = Vector3Stamped()
    message.vector.x, message.vector.y, message.vector.z = BIAS
    publisher.publish(message)
    participant.wait_until(lambda: heard and heard[-1].wrench.torque.z == ACTS[2], 'the torque')
    assert heard[-1].wrench.torque.x == 0.0
    participant.close()
    assert node.end()[0] == 0
    (bag,) = folder.glob('satdyn_*_*')
    assert 'the same byte for byte' in satdyn(folder, 'verify', bag.name)
