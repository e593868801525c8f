"""What a first-time user sees: the line of the node that starts."""

from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String

from satdyn_ros.messages.robot_description import urdf


def test_a_warm_node_says_in_one_line_what_it_does(live):
    """
    Topics, rate, epoch and bag; nothing else stands on stderr until it ends.

    Whoever comes later gets the body's description, with the frames of the node.
    """
    node, participant = live({'publish.topics': ['attitude', 'odometry'], 'publish.rate': 20.0})
    participant.hear(participant.listen('attitude'), 3)
    described: list = []
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    participant.node.create_subscription(String, 'robot_description', described.append, latched)
    participant.wait_until(lambda: described, 'the URDF')
    assert described[0].data == urdf(node.scenario)
    code, errors = node.end()
    assert code == 0
    line, last = errors.splitlines()
    assert 'attitude, odometry at 20 Hz' in line
    assert '2023-11-14 22:13:20.000000 UTC; not recording' in line
    assert 'lateness' in last


def test_publishing_is_said_when_all_that_ticks_need_is_compiled(live, tmp_path):
    """From no code at all, recording: after that line, ticks add none to the folder for it."""
    code_folder = tmp_path / 'code'
    values = {'record.enabled': True, 'record.directory': str(tmp_path / 'bags')}
    environment = {'NUMBA_CACHE_DIR': str(code_folder)}
    node, participant = live(values, environment=environment)
    heard = participant.listen('attitude')
    assert any('publishing' in line for line in node.process.stderr)
    compiled = set(code_folder.rglob('*'))
    assert len(compiled) > 1
    participant.hear(heard, 50)
    assert participant.trigger('reset')[0]
    participant.hear(heard, 50)
    assert set(code_folder.rglob('*')) == compiled
