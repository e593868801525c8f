"""What the page hears of a satellite."""

import subprocess
import sys
import time

import pytest

pytest.importorskip('aiohttp')

import rclpy
from sensor_msgs.msg import Imu
from trajectory_msgs.msg import JointTrajectory

from satdyn_ros.watch.listener import Listener


def test_of_two_nodes_that_publish_at_one_instant_both_are_heard(ros):
    """Otherwise the newest would be that of the same node whenever a frame is due."""
    namespace = '/at_one_instant'
    nodes = [rclpy.create_node('satdyn', namespace=namespace) for _ in range(2)]
    publishers = [node.create_publisher(Imu, 'imu', 10) for node in nodes]
    poller = rclpy.create_node('poller')
    listener = Listener(poller)
    end_s = time.monotonic() + 60.0
    heard: list[int] = []
    while heard != [1, 2]:
        assert time.monotonic() < end_s, heard
        listener.look(f'{namespace}/satdyn')
        for stamp_ns, publisher in enumerate(publishers, 1):
            message = Imu()
            message.header.stamp.nanosec = stamp_ns
            publisher.publish(message)
        heard = [sample.stamp_ns for sample in listener.samples()]
    for node in (*nodes, poller):
        node.destroy_node()


# Publish on a new publisher for each line that comes in, as soon as both subscriptions are found.
PUBLISH = """
import sys, rclpy
from trajectory_msgs.msg import JointTrajectory
rclpy.init()
node = rclpy.create_node('commander')
kept = []
for line in sys.stdin:
    kept.append(node.create_publisher(JointTrajectory, '/commanded/thruster_command', 10))
    while kept[-1].get_subscription_count() < 2:
        pass
    kept[-1].publish(JointTrajectory(joint_names=[line.strip()]))
"""


def test_a_command_that_is_published_once_is_heard(ros):
    """As by `ros2 topic pub --once`: as soon as its publisher has found the page."""
    poller = rclpy.create_node('poller')
    node = rclpy.create_node('satdyn', namespace='/commanded')
    node.create_subscription(JointTrajectory, 'thruster_command', lambda _: None, 10)
    listener = Listener(poller)
    command = [sys.executable, '-c', PUBLISH]
    with subprocess.Popen(command, stdin=subprocess.PIPE, text=True) as commander:
        end_s = time.monotonic() + 60.0
        while not listener.look('/commanded/satdyn'):
            assert time.monotonic() < end_s
        for number in '0123456789':
            print(number, file=commander.stdin, flush=True)
            heard: list = []
            while not heard:
                assert time.monotonic() < end_s, number
                heard = listener.commands()
            assert [(topic, m.joint_names) for topic, m in heard] == [
                ('thruster_command', [number])
            ]
    for each in (node, poller):
        each.destroy_node()
