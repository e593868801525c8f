"""A loop closed in lockstep by the services, twice: the same bytes."""

import subprocess
import sys

import pytest
from ros.live import PATIENCE_S, ROOT

from satdyn_ros.bag.verify import verify
from satdyn_ros.rosbag2.reader import Bag
from satdyn_ros.run.parameter_file import ParameterFile

TICKS = 60
CUBESAT = (ROOT / 'config' / 'cubesat.yaml').read_text()
BUSY = [sys.executable, '-c', 'while True: pass']


@pytest.fixture
def busy():
    """Let four processes compete for the machine's two cores."""
    processes = [subprocess.Popen(BUSY) for _ in range(4)]
    yield
    for process in processes:
        process.kill()
        process.wait()


def flown(live, directory):
    """Return log times and data of all that a flight in lockstep recorded, by topic."""
    values = ParameterFile.of_texts([(CUBESAT, 'cubesat')]).parameters('/satdyn')
    values |= {'time.factor': 1e-6, 'record.enabled': True, 'record.directory': str(directory)}
    node, _ = live(values)
    command = [sys.executable, 'examples/lockstep.py', '--ticks', str(TICKS)]
    done = subprocess.run(
        [*command, '--ros-args', '-r', f'__ns:={node.namespace}'],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=10 * PATIENCE_S,
    )
    assert done.returncode == 0, done.stderr
    assert f'after {TICKS} ticks, 0 missed' in done.stdout
    assert node.end()[0] == 0
    (path,) = directory.glob('satdyn_*')
    assert verify(path).same_bytes
    bag = Bag(path)
    messages = {name.removeprefix(node.namespace): bag.messages(name) for name in bag.topics}
    return {
        name: [(int(t), bytes(data)) for t, data in zip(*some, strict=True)]
        for name, some in messages.items()
    }


@pytest.mark.long
def test_lockstep_gives_the_same_bytes_twice(live, busy, tmp_path):
    """Each torque acts at its tick, the first one too, whatever else the machine does."""
    first = flown(live, tmp_path / 'first')
    # The first step has no torque yet, each of the others has one.
    assert len(first['/torque']) == TICKS - 1
    assert len(first['/attitude']) == TICKS + 1
    assert first == flown(live, tmp_path / 'second')
