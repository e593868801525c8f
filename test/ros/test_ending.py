"""A node that is told to end, by someone impatient."""

import signal
import time

import pytest
from ros.live import LiveNode

from satdyn_ros.bag.verify import verify


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_a_bag_is_complete_however_often_its_node_is_told_to_end(tmp_path, number):
    """With a signal each millisecond until the process has ended."""
    node = LiveNode(
        tmp_path,
        {'record.enabled': True, 'record.directory': str(tmp_path), 'time.factor': 0.0},
    )
    while not any(file.stat().st_size > 1_000_000 for file in tmp_path.glob('*/*.mcap')):
        assert node.process.poll() is None
        time.sleep(0.01)
    while node.process.poll() is None:
        node.process.send_signal(number)
        time.sleep(0.001)
    _, errors = node.end()
    (path,) = (each for each in tmp_path.iterdir() if each.is_dir())
    assert (path / 'metadata.yaml').exists()
    assert verify(path).is_true
    assert 'Traceback' not in errors
