"""
What the controllers over topics share: they receive a state, and point a satellite by it.

What controllers inside the run share is in controllers/quaternion_feedback.py.
"""

import time

import numpy as np
import rclpy
from geometry_msgs.msg import QuaternionStamped, VelocityStamped
from rclpy.node import Node

from satdyn_ros.kernel import rotation


class Pointing(Node):
    """
    A node that receives attitude and body rate, and acts once it has both of one stamp.

    A controller derives from it and defines act.  source: the prefix of the names of the topics.
    """

    def __init__(self, name, source=''):
        super().__init__(name)
        self.target_q_ib = rotation.IDENTITY
        self.error_rad, self.rate_rad_s = np.inf, np.inf
        # Missing samples, counted by the gaps between the stamps.
        self.missed = 0
        self._attitude = self._rate = None
        self._stamp_ns, self._period_ns = None, None
        self.state_subscriptions = [
            self.create_subscription(kind, f'{source}{topic}', take, 1000)
            for kind, topic, take in (
                (QuaternionStamped, 'attitude', self._take_attitude),
                (VelocityStamped, 'angular_velocity', self._take_rate),
            )
        ]

    def act(self, stamp, error, omega_bi_b):
        """
        Act on the state of a stamp.

        error: the rotation vector (3,) from the target to the body [rad], for small angles;
        omega_bi_b (3,): the body rate [rad/s].
        """
        raise NotImplementedError

    def _take_attitude(self, message):
        self._attitude = message
        self._act_on_both()

    def _take_rate(self, message):
        self._rate = message
        self._act_on_both()

    def _act_on_both(self):
        attitude, rate = self._attitude, self._rate
        if attitude is None or rate is None or attitude.header.stamp != rate.header.stamp:
            return
        self._count_missed(rate.header.stamp)
        q, omega = attitude.quaternion, rate.velocity.angular
        q_ib, omega_bi_b = np.array([q.x, q.y, q.z, q.w]), np.array([omega.x, omega.y, omega.z])
        q_tb = rotation.multiply(rotation.conjugate(self.target_q_ib), q_ib)
        self.error_rad = float(rotation.angle_between(self.target_q_ib, q_ib))
        self.rate_rad_s = float(np.linalg.norm(omega_bi_b))
        self.act(rate.header.stamp, 2.0 * np.copysign(1.0, q_tb[3]) * q_tb[:3], omega_bi_b)

    def _count_missed(self, stamp):
        stamp_ns = stamp.sec * 10**9 + stamp.nanosec
        if self._stamp_ns is not None:
            gap_ns = stamp_ns - self._stamp_ns
            self._period_ns = min(gap_ns, self._period_ns or gap_ns)
            self.missed += round(gap_ns / self._period_ns) - 1
        self._stamp_ns = stamp_ns

    @property
    def has_settled(self) -> bool:
        """Whether the satellite rests at the target, to a tenth of a degree."""
        return self.error_rad < np.radians(0.1) and self.rate_rad_s < np.radians(0.01)


def point(controller, timeout_s):
    """Spin until the satellite rests, report every two seconds; return an exit code."""
    end, next_line = time.monotonic() + timeout_s, 0.0
    while not controller.has_settled and time.monotonic() < end:
        rclpy.spin_once(controller, timeout_sec=0.2)
        if time.monotonic() >= next_line:
            next_line = time.monotonic() + 2.0
            error, rate = np.degrees([controller.error_rad, controller.rate_rad_s])
            print(f'error {error:7.2f} deg, rate {rate:6.3f} deg/s', flush=True)
    settled = controller.has_settled
    print(f'{"settled" if settled else "not settled"}; {controller.missed} samples missed')
    controller.destroy_node()
    rclpy.try_shutdown()
    return 0 if settled else 1
