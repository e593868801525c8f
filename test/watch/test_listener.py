"""What the page hears of a satellite."""

import time

import pytest

pytest.importorskip('aiohttp')

import rclpy
from sensor_msgs.msg import Imu

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
