"""A loop closed in lockstep by the services, twice: the same messages in the same order."""

import subprocess
import sys
from collections import Counter

import pytest
from mcap.records import Channel, Message
from mcap.stream_reader import StreamReader
from ros.live import PATIENCE_S, ROOT

from satdyn_ros.bag.verify import verify
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
    """Return topics, log times and data of all messages of a flight in lockstep, in order."""
    values = ParameterFile.of_texts([(CUBESAT, 'cubesat')]).parameters('/satdyn')
    values |= {'time.factor': 1e-6, 'record.enabled': True, 'record.directory': str(directory)}
    # The frames have the namespace before them, and are to be the same.
    node, _ = live(values, namespace='/lockstep')
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
    with (path / f'{path.name}_0.mcap').open('rb') as file:
        records = list(StreamReader(file).records)
    topics = {
        x.id: x.topic.removeprefix(node.namespace) for x in records if isinstance(x, Channel)
    }
    return [(topics[x.channel_id], x.log_time, x.data) for x in records if isinstance(x, Message)]


@pytest.mark.long
def test_lockstep_gives_the_same_bytes_twice(live, busy, tmp_path):
    """Each torque acts at its tick, the first one too, whatever else the machine does."""
    first = flown(live, tmp_path / 'first')
    counts = Counter(topic for topic, _, _ in first)
    # The first step has no torque yet, each of the others has one.
    assert counts['/torque'] == TICKS - 1
    assert counts['/attitude'] == TICKS + 1
    assert first == flown(live, tmp_path / 'second')
