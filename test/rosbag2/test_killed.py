"""Writers that are killed at any moment: no message older than a second is lost."""

import multiprocessing
import random
import shutil
import signal
import subprocess
import sys
import time

import flights
import pytest

from satdyn_ros.bag.verify import verify
from satdyn_ros.rosbag2.reader import Bag
from satdyn_ros.rosbag2.recover import recover


def kill(directory, after_s):
    """Kill a recording a while after its file is begun; return the ticks that it had flushed."""
    context = multiprocessing.get_context('forkserver')
    context.set_forkserver_preload(['satdyn_ros.bag.write_run'])
    receiver, sender = context.Pipe(duplex=False)
    process = context.Process(target=flights.fly, args=(directory, sender), daemon=True)
    process.start()
    while not any(path.stat().st_size for path in directory.glob('*.mcap')):
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


@pytest.mark.parametrize(
    'number', [0, 1, *(pytest.param(number, marks=pytest.mark.long) for number in range(2, 10))]
)
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


PROGRAM = """
import sys
from satdyn_ros.rosbag2.recover import recover
print('begins', flush=True)
recover(sys.argv[1])
"""


@pytest.mark.long
@pytest.mark.parametrize('count', [6, pytest.param(200, marks=pytest.mark.torture)])
def test_a_killed_recovery_is_begun_again(tmp_path, capsys, count):
    """Killed at any moment, recover leaves a bag that recover mends as if nothing had been."""
    template = tmp_path / 'template'
    kill(template, 1.5)
    expected = tmp_path / 'expected'
    shutil.copytree(template, expected)
    begin_s = time.perf_counter()
    recover(expected)
    whole_s = time.perf_counter() - begin_s
    chance, killed = random.Random(count), 0
    for number in range(count):
        bag = tmp_path / str(number)
        shutil.copytree(template, bag)
        process = subprocess.Popen(
            [sys.executable, '-c', PROGRAM, str(bag)], stdout=subprocess.PIPE, text=True
        )
        assert process.stdout is not None
        process.stdout.readline()
        time.sleep(chance.uniform(0.0, 1.2 * whole_s))
        process.kill()
        killed += process.wait() == -signal.SIGKILL
        recover(bag)
        assert flights.sequence(bag) == flights.sequence(expected)
        assert verify(bag).same_bytes
        assert {path.name for path in bag.iterdir()} == {path.name for path in expected.iterdir()}
        shutil.rmtree(bag)
    with capsys.disabled():
        print(f'\n{killed} of {count} recoveries killed before their end')
