"""
Point a tumbling satellite by proportional and derivative feedback, through its topics alone.

Run it beside a node:  satdyn node --params-file config/cubesat.yaml
                       python examples/controller.py
It ends with exit code 0 once the satellite rests at the target, with 1 if that takes too long.
"""

import argparse
import sys
import time

import numpy as np
import rclpy
import rclpy.utilities
from geometry_msgs.msg import QuaternionStamped, VelocityStamped, WrenchStamped
from rclpy.node import Node

from satdyn_ros.dynamics import rotation


class Controller(Node):
    """
    Torque = -Kp e - Kd omega with e the rotation vector from the target to the body.

    For moments near I [kg m^2], Kp = I wn^2 and Kd = 2 I wn damp the error critically at the
    bandwidth wn [rad/s].  source: what stands before the names of the topics it steers by.
    """

    def __init__(self, inertia, bandwidth, source=''):
        super().__init__('controller')
        self.target_q_ib = rotation.IDENTITY
        self.error_rad, self.rate_rad_s = np.inf, np.inf
        self._gains = inertia * bandwidth**2, 2.0 * inertia * bandwidth
        self._q_ib = None
        self._torque = self.create_publisher(WrenchStamped, 'torque', 10)
        self.create_subscription(QuaternionStamped, f'{source}attitude', self._attitude, 10)
        self.create_subscription(VelocityStamped, f'{source}angular_velocity', self._rate, 10)

    def _attitude(self, message):
        q = message.quaternion
        self._q_ib = np.array([q.x, q.y, q.z, q.w])

    def _rate(self, message):
        if self._q_ib is None:
            return
        angular = message.velocity.angular
        omega_bi_b = np.array([angular.x, angular.y, angular.z])
        q_tb = rotation.multiply(rotation.conjugate(self.target_q_ib), self._q_ib)
        error = 2.0 * np.copysign(1.0, q_tb[3]) * q_tb[:3]
        kp, kd = self._gains
        torque = WrenchStamped()
        torque.header.stamp, torque.header.frame_id = message.header.stamp, 'base_link'
        vector = torque.wrench.torque
        vector.x, vector.y, vector.z = (float(x) for x in -kp * error - kd * omega_bi_b)
        self._torque.publish(torque)
        self.error_rad = float(rotation.angle_between(self.target_q_ib, self._q_ib))
        self.rate_rad_s = float(np.linalg.norm(omega_bi_b))

    @property
    def has_settled(self) -> bool:
        """Whether the satellite rests at the target, to a tenth of a degree."""
        return self.error_rad < np.radians(0.1) and self.rate_rad_s < np.radians(0.01)


def main():
    """Point the satellite and say how it goes."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--inertia', type=float, default=0.03, help='kg m^2')
    parser.add_argument('--bandwidth', type=float, default=0.3, help='rad/s')
    parser.add_argument('--timeout', type=float, default=120.0, help='s')
    parser.add_argument(
        '--estimate', action='store_true', help='steer by the topics of examples/estimator.py'
    )
    arguments = parser.parse_args(rclpy.utilities.remove_ros_args(sys.argv)[1:])
    rclpy.init()
    source = 'estimate/' if arguments.estimate else ''
    controller = Controller(arguments.inertia, arguments.bandwidth, source)
    end, next_line = time.monotonic() + arguments.timeout, 0.0
    while not controller.has_settled and time.monotonic() < end:
        rclpy.spin_once(controller, timeout_sec=0.2)
        if time.monotonic() >= next_line:
            next_line = time.monotonic() + 2.0
            error, rate = np.degrees([controller.error_rad, controller.rate_rad_s])
            print(f'error {error:7.2f} deg, rate {rate:6.3f} deg/s', flush=True)
    print('settled' if controller.has_settled else 'not settled')
    settled = controller.has_settled
    controller.destroy_node()
    rclpy.try_shutdown()
    return 0 if settled else 1


if __name__ == '__main__':
    raise SystemExit(main())
