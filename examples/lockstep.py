"""
Close a loop without losing a message: pause, then command and step, tick by tick.

Run it beside a node:
    satdyn node --params-file config/cubesat.yaml --ros-args -p time.factor:=1e-6
    python examples/lockstep.py --ticks 500
With so small a factor the node is still at tick 0 when it is paused.  A loop over topics has the
machine's delay in it.  Here the node waits: each turn hears the sample of the last tick, sends the
torque for the next, and asks for one step, whose reply comes when the tick has passed.  The same
start gives the same bytes, however busy the machine is.
"""

import argparse
import sys
import time

import numpy as np
import rclpy
import rclpy.utilities
from geometry_msgs.msg import QuaternionStamped, VelocityStamped, WrenchStamped
from rclpy.node import Node
from std_srvs.srv import SetBool, Trigger

from satdyn_ros.dynamics import rotation

INERTIA, BANDWIDTH = 0.03, 0.3  # kg m^2, rad/s


class Lockstep(Node):
    """A controller that lets time pass when it is ready."""

    def __init__(self):
        super().__init__('lockstep')
        self.attitude = self.rate = None
        self.torque = self.create_publisher(WrenchStamped, 'torque', 10)
        self._heard = [
            self.create_subscription(QuaternionStamped, 'attitude', self._take_attitude, 10),
            self.create_subscription(VelocityStamped, 'angular_velocity', self._take_rate, 10),
        ]
        self._pause = self.create_client(SetBool, 'satdyn/pause')
        self._reset = self.create_client(Trigger, 'satdyn/reset')
        self._step = self.create_client(Trigger, 'satdyn/step')

    def begin(self):
        """Pause the node, start its motion anew and hear the first tick of it."""
        for client in (self._pause, self._reset, self._step):
            client.wait_for_service()
        while not (
            self.torque.get_subscription_count()
            and all(subscription.get_publisher_count() for subscription in self._heard)
        ):
            rclpy.spin_once(self, timeout_sec=0.1)
        self._call(self._pause, SetBool.Request(data=True))
        self._call(self._reset, Trigger.Request())
        self.pass_tick()

    def pass_tick(self):
        """Let one tick pass and hear its attitude and rate."""
        self.attitude = self.rate = None
        self._call(self._step, Trigger.Request())
        deadline_s = time.monotonic() + 10.0
        while self.attitude is None or self.rate is None:
            rclpy.spin_once(self, timeout_sec=0.1)
            if time.monotonic() > deadline_s:
                raise SystemExit('the sample of a tick did not come; start again')

    def command(self):
        """Send the torque for the next tick: it is there before the step that follows."""
        error = 2.0 * np.copysign(1.0, self.attitude[3]) * self.attitude[:3]
        torque_b = -INERTIA * BANDWIDTH * (BANDWIDTH * error + 2.0 * self.rate)
        message = WrenchStamped()
        message.header.frame_id = 'base_link'
        vector = message.wrench.torque
        vector.x, vector.y, vector.z = torque_b.tolist()
        self.torque.publish(message)

    def _call(self, client, request):
        future = client.call_async(request)
        rclpy.spin_until_future_complete(self, future)
        if not future.result().success:
            raise SystemExit(future.result().message)

    def _take_attitude(self, message):
        q = message.quaternion
        self.attitude = np.array([q.x, q.y, q.z, q.w])

    def _take_rate(self, message):
        angular = message.velocity.angular
        self.rate = np.array([angular.x, angular.y, angular.z])


def main():
    """Fly some ticks in lockstep, and say where the satellite points."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--ticks', type=int, default=500)
    arguments = parser.parse_args(rclpy.utilities.remove_ros_args(sys.argv)[1:])
    rclpy.init()
    node = Lockstep()
    node.begin()
    for _ in range(arguments.ticks):
        node.command()
        node.pass_tick()
    error_deg = np.degrees(rotation.angle_between(rotation.IDENTITY, node.attitude))
    print(f'error {error_deg:.6f} deg after {arguments.ticks} ticks')
    node.destroy_node()
    rclpy.try_shutdown()


if __name__ == '__main__':
    main()
