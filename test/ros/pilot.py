"""Fly a node from a process of its own: torques, requests, a line for each last stamp heard."""

import random
import sys

import rclpy
from geometry_msgs.msg import WrenchStamped
from ros.live import Participant, raw_stamp_ns


def fly(namespace, seed):
    """Command the node in a namespace without an end."""
    chance = random.Random(seed)
    rclpy.init()
    participant = Participant(namespace)
    heard = participant.listen('attitude', raw=True)
    publisher = participant.node.create_publisher(WrenchStamped, 'torque', 10)
    participant.wait_until(lambda: heard and publisher.get_subscription_count())
    message = WrenchStamped()
    while True:
        for _ in range(chance.randrange(1, 8)):
            message.wrench.torque.z = chance.uniform(-0.05, 0.05)
            publisher.publish(message)
            participant.spin(chance.uniform(0.0, 0.1))
            print(raw_stamp_ns(heard[-1]), flush=True)
        participant.request({'initial.angular_velocity': [0.0, 0.0, chance.uniform(0.0, 0.1)]})


if __name__ == '__main__':
    fly(sys.argv[1], int(sys.argv[2]))
