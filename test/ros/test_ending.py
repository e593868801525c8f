"""A node that is asked to end, by someone impatient."""

import os
import signal
import subprocess
import sys
import time

import pytest
from ros.live import PATIENCE_S, LiveNode

from satdyn_ros.bag.verify import verify


@pytest.mark.long
@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_a_bag_is_complete_however_often_its_node_is_asked_to_end(tmp_path, number):
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


# A node that is asked to end before its first line, when it has published.
EARLY = """
import os, signal, sys, time, warnings
from satdyn_ros.ros import node, start

say = node.SatdynNode._what_begins

def late(self, scenario):
    while not len(self.lateness):
        time.sleep(0.001)
    warnings.warn('a client has left', RuntimeWarning)
    os.kill(os.getpid(), signal.SIGINT)
    return say(self, scenario)

node.SatdynNode._what_begins = late
sys.exit(start.main([]))
"""


def test_a_node_that_has_published_says_what_it_did_however_early_it_ends():
    """Its first line and its last, though the signal comes before the first, and a warning."""
    done = subprocess.run(
        [sys.executable, '-c', EARLY],
        env=os.environ,
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
    )
    assert done.returncode == 0
    warning, line, last = done.stderr.splitlines()
    assert warning.startswith('[WARN]')
    assert warning.endswith('a client has left')
    assert 'publishing' in line
    assert 'lateness' in last
