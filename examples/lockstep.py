"""
Close a loop without losing a message: pause the node, then command and step, tick by tick.

Run it beside a node that stays at tick 0:
    satdyn node --params-file config/cubesat.yaml --ros-args -p time.factor:=1e-6
    python examples/lockstep.py --ticks 500
A loop over topics includes the delays of the machine.  Here the satellite waits: each pass
receives the sample of the last tick, sends the torque for the next one, and requests a step, whose
reply comes when the tick has passed.  The same start gives the same bytes, however busy the
machine is.
"""

import argparse
import sys
import time

import numpy as np
import rclpy
import rclpy.utilities
from controller import Controller
from diagnostic_msgs.msg import DiagnosticArray
from std_srvs.srv import SetBool, Trigger

# Anything that takes longer than this has failed.
PATIENCE_S = 60.0


class Lockstep(Controller):
    """The controller, which lets a tick pass once its torque has been sent."""

    def __init__(self, inertia, bandwidth):
        super().__init__(inertia, bandwidth, name='lockstep')
        self.heard, self._flies = False, False
        self._sent = self._accepted_before = 0
        self._told = {}
        self._pause = self.create_client(SetBool, 'satdyn/pause')
        self._step = self.create_client(Trigger, 'satdyn/step')
        self.create_subscription(DiagnosticArray, '/diagnostics', self._take_diagnostics, 10)

    def begin(self):
        """Wait until node and controller have discovered each other, then stop the ticks."""
        for client in (self._pause, self._step):
            self._wait(client.service_is_ready, 'the services of the node did not appear')
        self._wait(lambda: self._is_connected, 'the topics of the node were not connected')
        self._wait(lambda: self._says('tick') >= 0, 'the node did not begin')
        self._accepted_before = self._says('accepted')
        self._call(self._pause, SetBool.Request(data=True))
        self._flies = True
        self.pass_tick()

    def end(self):
        """Make sure that the node has accepted each torque."""
        sent = self._accepted_before + self._sent
        self._wait(lambda: self._says('accepted') == sent, 'a torque was lost')

    def act(self, stamp, error, omega_bi_b):
        """Publish the torque for the next tick, once ticks pass only on request."""
        if not self._flies:
            return
        super().act(stamp, error, omega_bi_b)
        self._sent += 1
        self.heard = True

    def pass_tick(self):
        """Let one tick pass, with the torque that was published last, and act on its sample."""
        # The request follows the torque on the same path, and the node reads torques first.
        self.heard = False
        self._call(self._step, Trigger.Request())
        self._wait(lambda: self.heard, 'the sample of a tick did not come')

    @property
    def _is_connected(self):
        """
        Whether each side has found the other.

        Discovery goes both ways, and one side may be ready before the other: a torque published
        then would be lost.  The node's diagnostics say how many it has found.
        """
        return (
            self.torque.get_subscription_count() > 0
            and all(heard.get_publisher_count() > 0 for heard in self.state_subscriptions)
            and self._says('publishers of torque') >= self.count_publishers('torque')
            and all(
                self._says(f'subscribers of {topic}') >= self.count_subscribers(topic)
                for topic in ('attitude', 'angular_velocity')
            )
        )

    def _take_diagnostics(self, message):
        own = f'{self.get_namespace()}/satdyn: '.lstrip('/')
        for status in message.status:
            if status.name.startswith(own):
                self._told |= {pair.key: pair.value for pair in status.values}

    def _says(self, name):
        """Return an integer from the node's diagnostics, -1 before it is there."""
        return int(self._told.get(name, -1))

    def _call(self, client, request):
        future = client.call_async(request)
        self._wait(future.done, 'the node did not answer')
        if not future.result().success:
            raise SystemExit(future.result().message)

    def _wait(self, condition, otherwise):
        end = time.monotonic() + PATIENCE_S
        while not condition():
            if time.monotonic() > end:
                raise SystemExit(otherwise)
            rclpy.spin_once(self, timeout_sec=0.1)


def main():
    """Run some ticks in lockstep, and print where the satellite points."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--ticks', type=int, default=500)
    parser.add_argument('--inertia', type=float, default=0.03, help='kg m^2')
    parser.add_argument('--bandwidth', type=float, default=0.3, help='rad/s')
    arguments = parser.parse_args(rclpy.utilities.remove_ros_args(sys.argv)[1:])
    rclpy.init()
    controller = Lockstep(arguments.inertia, arguments.bandwidth)
    controller.begin()
    for _ in range(arguments.ticks - 1):
        controller.pass_tick()
    controller.end()
    error_deg = np.degrees(controller.error_rad)
    print(f'error {error_deg:.6f} deg after {arguments.ticks} ticks, {controller.missed} missed')
    controller.destroy_node()
    rclpy.try_shutdown()


if __name__ == '__main__':
    main()
