"""Writers that are killed at any moment: no message older than a second is lost."""

import multiprocessing
import random
import time

import flights
import pytest

from satdyn_ros.bag.verify import verify
from satdyn_ros.rosbag2.reader import Bag
from satdyn_ros.rosbag2.recover import recover


def kill(directory, after_s):
    """Kill a recording a while after its file is there; return the ticks that it had flushed."""
    context = multiprocessing.get_context('forkserver')
    context.set_forkserver_preload(['satdyn_ros.bag.recording'])
    receiver, sender = context.Pipe(duplex=False)
    process = context.Process(target=flights.fly, args=(directory, sender), daemon=True)
    process.start()
    while not any(directory.glob('*.mcap')):
        assert process.is_alive()
        time.sleep(0.001)
    time.sleep(after_s)
    process.kill()
    process.join()
    sender.close()
    flushed = 0
    try:
        while receiver.poll():
            flushed = receiver.recv()
    except EOFError:
        pass
    return flushed


def assert_nothing_lost(directory, seconds):
    """Kill a recording, recover its bag, and compare every message with the run."""
    flushed = kill(directory, seconds)
    assert not (directory / 'metadata.yaml').exists()
    recovered = recover(directory)
    verdict = verify(directory)
    assert verdict.is_true, str(verdict)
    assert verdict.same_bytes
    assert verdict.message_count == recovered.message_count
    stamps_ns = Bag(directory).messages('/attitude').log_times_ns
    assert len(stamps_ns) >= flushed
    assert Bag(directory).problem is None


@pytest.mark.parametrize('number', range(10))
def test_a_killed_recording_loses_nothing_that_was_flushed(tmp_path, number):
    """At a random moment within the first second, the same moments in every run of the test."""
    seconds = random.Random(number).uniform(0.0, 0.8)
    assert_nothing_lost(tmp_path / 'bag', seconds)


@pytest.mark.torture
@pytest.mark.parametrize('number', range(100))
def test_a_hundred_killed_recordings(tmp_path, number):
    """The same at a hundred moments within three seconds."""
    seconds = random.Random(1000 + number).uniform(0.0, 3.0)
    assert_nothing_lost(tmp_path / 'bag', seconds)
