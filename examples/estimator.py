"""
Estimate attitude and gyro bias from `gyro` and `star_tracker`, by a multiplicative Kalman filter.

Run it beside a node:  satdyn node --params-file config/cubesat_sensors.yaml
                       python examples/estimator.py config/cubesat_sensors.yaml
                       python examples/controller.py --estimate
The scenario file serves as the data sheet of the sensors.  The estimates are published on
`estimate/attitude` and `estimate/angular_velocity`; where the node publishes `attitude`, a line
every two seconds says how far off they are.

The filter is that of Lefferts, Markley and Shuster, Kalman filtering for spacecraft attitude
estimation, 1982: the state is a quaternion and a bias, the error a small rotation and a bias.
"""

import argparse
import copy
import sys
from contextlib import suppress

import numpy as np
import rclpy
import rclpy.utilities
from geometry_msgs.msg import QuaternionStamped, VelocityStamped
from rclpy.node import Node
from sensor_msgs.msg import Imu

from satdyn_ros import Scenario
from satdyn_ros.kernel import rotation

# Before the first sample the bias is known to this standard deviation [rad/s].
BIAS_SIGMA = 0.01
_NS = 10**9


class Estimator:
    """
    Attitude q_ib (4,), gyro bias (3,) [rad/s] and the covariance P (6, 6) of their errors.

    The errors are the rotation vector of q_ib* q_true, in body axes, and the bias.
    noise_density, bias_random_walk: N and K of the gyro, in rad/s/sqrt(Hz) and rad/s^2/sqrt(Hz).
    """

    def __init__(self, q_ib, covariance, noise_density, bias_random_walk):
        self.q_ib, self.bias = np.array(q_ib), np.zeros(3)
        self.P = np.zeros((6, 6))
        self.P[:3, :3], self.P[3:, 3:] = covariance, BIAS_SIGMA**2 * np.eye(3)
        self._N, self._K = noise_density, bias_random_walk

    def predict(self, rate_b, dt):
        """Advance by dt [s] with a rate of the gyro, in body axes."""
        turned = rotation.from_vector((rate_b - self.bias) * dt)
        self.q_ib = rotation.normalise(rotation.multiply(self.q_ib, turned))
        F = np.eye(6)
        F[:3, :3], F[:3, 3:] = rotation.matrix(turned).T, -dt * np.eye(3)
        self.P = F @ self.P @ F.T + self._noise(dt)

    def update(self, q_ib, R):
        """Process a measured attitude whose error has the covariance R (3, 3) in body axes."""
        error = rotation.to_vector(rotation.multiply(rotation.conjugate(self.q_ib), q_ib))
        gain = np.linalg.solve(self.P[:3, :3] + R, self.P[:3]).T
        correction = gain @ error
        q_ib = rotation.multiply(self.q_ib, rotation.from_vector(correction[:3]))
        self.q_ib, self.bias = rotation.normalise(q_ib), self.bias + correction[3:]
        # Joseph's form keeps P symmetric and positive.
        rest = np.eye(6)
        rest[:, :3] -= gain
        self.P = rest @ self.P @ rest.T + gain @ R @ gain.T

    def _noise(self, dt):
        """Return what dt adds to the covariance (Farrenkopf 1978)."""
        angle = self._N**2 * dt + self._K**2 * dt**3 / 3.0
        cross, bias = -(self._K**2) * dt**2 / 2.0, self._K**2 * dt
        return np.kron([[angle, cross], [cross, bias]], np.eye(3))


class DelayedEstimator:
    """
    An estimator with late attitudes: past is at the last attitude, now at the last rate.

    sensors: those of a Scenario.  Stamps are integer nanoseconds; where a rate was lost, the next
    one covers its interval too.
    """

    def __init__(self, sensors):
        self.gyro, self.tracker = sensors['gyro'], sensors['star_tracker']
        self.now: Estimator | None = None
        self.past: Estimator | None = None
        self.rate_b: np.ndarray | None = None
        self._now_ns = self._past_ns = 0
        self._rates = []

    def take_rate(self, stamp_ns, rate_s):
        """Process a sample of the gyro, in its axes [rad/s]."""
        rate_b = rotation.rotate(self.gyro.mounting, rate_s)
        self._rates.append((stamp_ns, rate_b))
        if self.now is not None:
            self._now_ns = _predict(self.now, self._now_ns, stamp_ns, rate_b)
            self.rate_b = rate_b - self.now.bias

    def take_attitude(self, stamp_ns, q_is, variances):
        """Process a sample of the star tracker: sensor to inertial, variances (3,) [rad^2]."""
        q_ib = rotation.multiply(q_is, rotation.conjugate(self.tracker.mounting))
        to_body = rotation.matrix(self.tracker.mounting)
        R = to_body @ np.diag(variances) @ to_body.T
        known = [(t, rate_b) for t, rate_b in self._rates if t <= stamp_ns]
        self._rates = self._rates[len(known) :]
        if self.past is None:
            self.past = Estimator(q_ib, R, self.gyro.noise_density, self.gyro.bias_random_walk)
            self._past_ns = stamp_ns
        else:
            for t, rate_b in known:
                self._past_ns = _predict(self.past, self._past_ns, t, rate_b)
            self.past.update(q_ib, R)
        self.now, self._now_ns = copy.copy(self.past), self._past_ns
        for t, rate_b in self._rates:
            self._now_ns = _predict(self.now, self._now_ns, t, rate_b)


def _predict(estimator, since_ns, stamp_ns, rate_b):
    """Advance an estimator to a stamp, which is returned."""
    estimator.predict(rate_b, (stamp_ns - since_ns) / _NS)
    return stamp_ns


class EstimatorNode(Node):
    """The node: measurements in, estimates out."""

    def __init__(self, sensors, frames):
        super().__init__('estimator')
        self.error_rad = np.nan
        self._frames, self._estimator = frames, DelayedEstimator(sensors)
        self._attitude = self.create_publisher(QuaternionStamped, 'estimate/attitude', 10)
        self._rate = self.create_publisher(VelocityStamped, 'estimate/angular_velocity', 10)
        self._truth: tuple[int, np.ndarray] | None = None
        self._estimate: tuple[int, np.ndarray] | None = None
        self.create_subscription(Imu, 'gyro', self._take_rate, 1000)
        self.create_subscription(Imu, 'star_tracker', self._take_attitude, 1000)
        self.create_subscription(QuaternionStamped, 'attitude', self._take_truth, 1000)
        self.create_timer(2.0, self._tell)

    def _take_rate(self, message):
        rate = message.angular_velocity
        self._estimator.take_rate(_stamp_ns(message), np.array([rate.x, rate.y, rate.z]))
        now, rate_b = self._estimator.now, self._estimator.rate_b
        if now is not None and rate_b is not None:
            self._publish(message.header.stamp, now.q_ib, rate_b)

    def _take_attitude(self, message):
        q = message.orientation
        variances = message.orientation_covariance[[0, 4, 8]]
        self._estimator.take_attitude(
            _stamp_ns(message), np.array([q.x, q.y, q.z, q.w]), variances
        )

    def _publish(self, stamp, q_ib, omega_bi_b):
        attitude, rate = QuaternionStamped(), VelocityStamped()
        attitude.header.stamp = rate.header.stamp = stamp
        attitude.header.frame_id = rate.reference_frame_id = self._frames.inertial
        rate.header.frame_id = rate.body_frame_id = self._frames.body
        q, omega = attitude.quaternion, rate.velocity.angular
        q.x, q.y, q.z, q.w = q_ib.tolist()
        omega.x, omega.y, omega.z = omega_bi_b.tolist()
        self._attitude.publish(attitude)
        self._rate.publish(rate)
        self._estimate = _stamp_ns(attitude), q_ib
        self._compare()

    def _tell(self):
        error_arcsec = np.degrees(self.error_rad) * 3600.0
        print(f'attitude error {error_arcsec:7.1f} arcsec', flush=True)

    def _take_truth(self, message):
        q = message.quaternion
        self._truth = _stamp_ns(message), np.array([q.x, q.y, q.z, q.w])
        self._compare()

    def _compare(self):
        """Record the error where truth and estimate are of the same tick."""
        if self._truth is None or self._estimate is None:
            return
        (true_ns, true), (estimated_ns, estimated) = self._truth, self._estimate
        if true_ns == estimated_ns:
            self.error_rad = float(rotation.angle_between(estimated, true))


def _stamp_ns(message):
    return message.header.stamp.sec * _NS + message.header.stamp.nanosec


def main():
    """Estimate until interrupted, and report the error of the estimate."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('scenario', help="the node's parameter file, the sensors' data sheet")
    arguments = parser.parse_args(rclpy.utilities.remove_ros_args(sys.argv)[1:])
    scenario = Scenario.from_yaml(arguments.scenario)
    rclpy.init()
    node = EstimatorNode(scenario.sensors, scenario.frames)
    with suppress(KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
        rclpy.spin(node)
    node.destroy_node()
    rclpy.try_shutdown()


if __name__ == '__main__':
    main()
