"""A killed node: its bag lacks no message older than a second."""

import random
import signal
import subprocess
import sys
import time

import pytest
from geometry_msgs.msg import WrenchStamped
from ros.live import ENVIRONMENT, LiveNode
from ros.test_diagnostics import health, values

from satdyn_ros.actuators import Command
from satdyn_ros.bag.read_run import RecordedRun
from satdyn_ros.bag.verify import verify
from satdyn_ros.rosbag2.reader import Bag
from satdyn_ros.rosbag2.recover import recover
from satdyn_ros.run.events import Request

VALUES = {
    'publish.rate': 1000.0,
    'publish.topics': ['attitude', 'imu'],
    'record.enabled': True,
    'record.max_size_bytes': 500_000,
    'torque.timeout': 0.05,
}
# The recorder flushes each second; on a loaded machine it comes to that a little later.
LOST_NS = 1_300_000_000


def assert_a_killed_node_loses_nothing(tmp_path, seed):
    """Kill a node that takes torques and requests; its bag is recovered and runs again."""
    node = LiveNode(tmp_path, VALUES | {'record.directory': str(tmp_path)})
    # Both end by SIGKILL: a participant of this process would have to part from a dead peer.
    pilot = subprocess.Popen(
        [sys.executable, '-m', 'ros.pilot', node.namespace, str(seed)],
        env=ENVIRONMENT,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert pilot.stdout is not None
    first = pilot.stdout.readline()
    time.sleep(random.Random(seed).uniform(0.0, 2.5))
    node.end(signal.SIGKILL)
    pilot.kill()
    heard = [first, *pilot.communicate()[0].splitlines(keepends=True)]
    # Among the stamps, on stdout, Fast DDS says what it makes of ports that others hold.
    stamps_heard = [line for line in heard if line.endswith('\n') and line.strip().isdigit()]
    last_heard_ns = max(map(int, stamps_heard))

    (path,) = (file for file in tmp_path.iterdir() if file.is_dir())
    assert not (path / 'metadata.yaml').exists()
    recovered = recover(path)
    stamps = Bag(path).messages(f'{node.namespace}/attitude').log_times_ns.tolist()
    last_kept_ns = stamps[-1] if stamps else node.scenario.epoch_ns
    assert last_kept_ns >= last_heard_ns - LOST_NS
    assert stamps == [node.scenario.epoch_ns + k * 1_000_000 for k in range(len(stamps))]
    verdict = verify(path)
    assert verdict.is_true, str(verdict)
    assert verdict.same_bytes
    assert verdict.message_count == recovered.message_count


@pytest.mark.long
@pytest.mark.parametrize('seed', range(3))
def test_a_killed_node_loses_nothing_older_than_a_second(tmp_path, seed):
    """At 1000 Hz, with torques, timeouts, requests and files that follow each other."""
    assert_a_killed_node_loses_nothing(tmp_path, seed)


@pytest.mark.torture
@pytest.mark.parametrize('seed', range(100, 200))
def test_a_hundred_killed_nodes(tmp_path, seed):
    """The same at a hundred moments."""
    assert_a_killed_node_loses_nothing(tmp_path, seed)


def test_a_live_bag_with_torques_and_requests_verifies(live, tmp_path):
    """What happened at 1000 Hz happens again, byte for byte, on the ticks where it happened."""
    node, participant = live(VALUES | {'record.directory': str(tmp_path)})
    until = health(participant)
    heard = participant.listen('attitude', raw=True)
    publisher = participant.node.create_publisher(WrenchStamped, 'torque', 10)
    participant.wait_until(lambda: heard and publisher.get_subscription_count())
    message = WrenchStamped()
    for k in range(20):
        message.wrench.torque.x = 0.01 * (k + 1)
        publisher.publish(message)
        participant.spin(0.02)
        if k % 5 == 0:
            assert participant.request({'initial.angular_velocity': [0.0, 0.001 * k, 0.0]})[0]
    until(node.namespace, lambda r: values(r['inputs'])['accepted'] == '20')
    assert node.end()[0] == 0
    (path,) = (file for file in tmp_path.iterdir() if file.is_dir())
    verdict = verify(path)
    assert verdict.is_true, str(verdict)
    assert verdict.same_bytes
    events = RecordedRun(path).events
    assert len([event for event in events if isinstance(event, Command)]) == 20
    assert len([event for event in events if isinstance(event, Request)]) == 4
