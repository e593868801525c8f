"""
Estimate attitude and biases from a satellite's measurements, by a Kalman filter.

Run it beside a node:  satdyn node --params-file config/cubesat_sensors.yaml
                       python examples/estimator.py config/cubesat_sensors.yaml
                       python examples/controller.py --estimate
or with config/cubesat_leo.yaml, which has a magnetometer and sun sensors and no star tracker.  The
scenario file serves as the data sheet of the sensors, which has to state their noise, and says
what field and Sun are along the orbit.  The estimates are published on `estimate/attitude` and
`estimate/angular_velocity`; where the node publishes `attitude`, a line every two seconds says how
far off they are.

Take it for an estimate that other processes use.  A controller inside the run estimates for
itself, as controllers/attitude_estimate.py does.

The filter itself is in attitude_filter.py.  Here samples become its steps, in their order, and the
first attitude its beginning.
"""

import argparse
import sys
from bisect import bisect
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from operator import attrgetter

import numpy as np
import rclpy
import rclpy.utilities
from attitude_filter import Estimate
from geometry_msgs.msg import QuaternionStamped, Vector3Stamped, VelocityStamped
from rclpy.node import Node
from sensor_msgs.msg import Imu, MagneticField
from triad import is_wide, known_field, known_sun, triad

from satdyn_ros import Scenario
from satdyn_ros.kernel import rotation
from satdyn_ros.sensors import Gyro, Magnetometer, StarTracker, SunSensor

_NS = 10**9
# A sample that comes later than this is not used.
HELD_NS = 10 * _NS
# The order in which samples of one stamp act.
_RATE, _BEGIN, _UPDATE = range(3)


@dataclass(eq=False)
class Step:
    """
    A sample, and what it makes of an estimate.

    key: stamp [ns], and order among those of one stamp.  after: the estimate after it, None
    where there is none before.
    """

    key: tuple[int, int]
    act: Callable[[Estimate], Estimate]
    after: Estimate | None = None


class DelayedEstimator:
    """
    An estimator of samples in any order: each acts at its stamp, and the later ones act again.

    sensors: those of a Scenario, of which it uses one gyro, star tracker and magnetometer, and all
    sun sensors.  Stamps are integer nanoseconds, the gyro has each; where a rate was lost, the
    next one covers its interval too.  It begins at the first attitude, be it of the star tracker
    or, where Sun and field are measured at one stamp, by TRIAD.
    """

    def __init__(self, sensors):
        self.gyro, self.tracker, self.magnetometer = (
            next((name for name, sensor in sensors.items() if isinstance(sensor, kind)), None)
            for kind in (Gyro, StarTracker, Magnetometer)
        )
        self.rate_b: np.ndarray | None = None
        self._sensors = sensors
        self._walks = [sensors[self.gyro].noise_density, sensors[self.gyro].bias_random_walk]
        if self.magnetometer is not None:
            self._walks.append(sensors[self.magnetometer].bias_random_walk)
        self._steps: list[Step] = []
        self._vectors: dict[type, tuple[int, np.ndarray, np.ndarray]] = {}

    @property
    def now(self) -> Estimate | None:
        """The estimate after the last sample, None before the first attitude."""
        return self._steps[-1].after if self._steps else None

    def take_rate(self, stamp_ns, rate_s):
        """Process a sample of the gyro, in its axes [rad/s]."""
        rate_b = rotation.rotate(self._sensors[self.gyro].mounting, rate_s)
        walks = self._walks
        self._take((stamp_ns, _RATE), lambda before: before.predicted(stamp_ns, rate_b, *walks))
        if self.now is not None:
            self.rate_b = rate_b - self.now.bias[:3]

    def take_attitude(self, stamp_ns, q_is, variances):
        """Process a sample of the star tracker: sensor to inertial, variances (3,) [rad^2]."""
        mounting = self._sensors[self.tracker].mounting
        q_ib = rotation.multiply(q_is, rotation.conjugate(mounting))
        R = _in_body_axes(variances, mounting)
        if self.now is None:
            self._begin(stamp_ns, q_ib)
        self._take((stamp_ns, _UPDATE), lambda before: before.updated_by_attitude(q_ib, R))

    def take_field(self, stamp_ns, B_s, B_i):
        """Process a sample of the magnetometer, in its axes [T], where the field is B_i."""
        self._take_vector(self.magnetometer, Estimate.updated_by_field, stamp_ns, B_s, B_i)

    def take_sun(self, name, stamp_ns, s_s, s_i):
        """Process a sample of a sun sensor, in its axes, where the Sun is in direction s_i."""
        self._take_vector(name, Estimate.updated_by_direction, stamp_ns, s_s, s_i)

    def _take_vector(self, name, update, stamp_ns, v_s, v_i):
        sensor = self._sensors[name]
        v_b = rotation.rotate(sensor.mounting, v_s)
        R = _in_body_axes(sensor.variances, sensor.mounting)
        self._take((stamp_ns, _UPDATE), lambda before: update(before, v_b, v_i, R))
        if self.now is None:
            self._vectors[type(sensor)] = stamp_ns, v_b, v_i
            self._begin_by_triad()

    def _begin_by_triad(self):
        if len(self._vectors) < 2:
            return
        sun_ns, s_b, s_i = self._vectors[SunSensor]
        field_ns, B_b, B_i = self._vectors[Magnetometer]
        if sun_ns == field_ns and is_wide(s_i, B_i):
            self._begin(sun_ns, triad(s_b, B_b, s_i, B_i))

    def _begin(self, stamp_ns, q_ib):
        """Begin near an attitude, as if nothing were known of it: its samples are to act yet."""
        begin = stamp_ns, _BEGIN
        first = Estimate.near(stamp_ns, q_ib, self.magnetometer is not None)
        later = [step for step in self._steps if step.key > begin]
        self._steps = [Step(begin, lambda _: first, first), *later]
        self._let_act(1)

    def _take(self, key, act):
        """Insert a sample in order; what is behind acts once more."""
        i = bisect(self._steps, key, key=attrgetter('key'))
        if i == 0 and self.now is not None:
            return
        self._steps.insert(i, Step(key, act))
        self._let_act(i)
        oldest_ns = self._steps[-1].key[0] - HELD_NS
        del self._steps[: bisect(self._steps, (oldest_ns, _RATE), key=attrgetter('key'))]

    def _let_act(self, i):
        """Let the steps from number i on act."""
        for before, step in pairwise(self._steps[max(i - 1, 0) :]):
            if before.after is not None:
                step.after = step.act(before.after)


def _in_body_axes(variances, mounting):
    """Return the covariance (3, 3) in body axes of variances (3,) along those of a sensor."""
    to_body = rotation.matrix(mounting)
    return to_body @ np.diag(variances) @ to_body.T


class EstimatorNode(Node):
    """The node: measurements in, estimates out."""

    def __init__(self, scenario):
        super().__init__('estimator')
        self.error_rad = np.nan
        self._scenario = scenario
        # That of the node beside it, which has the namespace before its name.
        namespace = self.get_namespace().strip('/')
        own = scenario.frames.body.removeprefix(f'{namespace}/')
        self._body_frame = f'{namespace}/{own}'.lstrip('/')
        self._estimator = estimator = DelayedEstimator(scenario.sensors)
        self._attitude = self.create_publisher(QuaternionStamped, 'estimate/attitude', 10)
        self._rate = self.create_publisher(VelocityStamped, 'estimate/angular_velocity', 10)
        self._truth: tuple[int, np.ndarray] | None = None
        self._estimate: tuple[int, np.ndarray] | None = None
        heard = {
            'attitude': (QuaternionStamped, self._take_truth),
            estimator.gyro: (Imu, self._take_rate),
            estimator.tracker: (Imu, self._take_attitude),
            estimator.magnetometer: (MagneticField, self._take_field),
        }
        for name, sensor in scenario.sensors.items():
            if isinstance(sensor, SunSensor):
                heard[name] = Vector3Stamped, partial(self._take_sun, name)
        for name, (kind, take) in heard.items():
            if name is not None:
                self.create_subscription(kind, name, take, 1000)
        self.create_timer(2.0, self._report)

    def _take_rate(self, message):
        self._estimator.take_rate(_stamp_ns(message), _vector(message.angular_velocity))
        now, rate_b = self._estimator.now, self._estimator.rate_b
        if now is not None and rate_b is not None:
            self._publish(message.header.stamp, now.q_ib, rate_b)

    def _take_attitude(self, message):
        q = message.orientation
        variances = message.orientation_covariance[[0, 4, 8]]
        self._estimator.take_attitude(
            _stamp_ns(message), np.array([q.x, q.y, q.z, q.w]), variances
        )

    def _take_field(self, message):
        stamp_ns = _stamp_ns(message)
        (B_i,) = known_field(self._scenario, np.array([stamp_ns]))
        self._estimator.take_field(stamp_ns, _vector(message.magnetic_field), B_i)

    def _take_sun(self, name, message):
        stamp_ns = _stamp_ns(message)
        (s_i,) = known_sun(self._scenario, np.array([stamp_ns]))
        self._estimator.take_sun(name, stamp_ns, _vector(message.vector), s_i)

    def _publish(self, stamp, q_ib, omega_bi_b):
        frames = self._scenario.frames
        attitude, rate = QuaternionStamped(), VelocityStamped()
        attitude.header.stamp = rate.header.stamp = stamp
        attitude.header.frame_id = rate.reference_frame_id = frames.inertial
        rate.header.frame_id = rate.body_frame_id = self._body_frame
        q, omega = attitude.quaternion, rate.velocity.angular
        q.x, q.y, q.z, q.w = q_ib.tolist()
        omega.x, omega.y, omega.z = omega_bi_b.tolist()
        self._attitude.publish(attitude)
        self._rate.publish(rate)
        self._estimate = _stamp_ns(attitude), q_ib
        self._compare()

    def _report(self):
        error_arcsec = np.degrees(self.error_rad) * 3600.0
        if np.isnan(error_arcsec):
            print('no estimate yet to compare with the attitude', flush=True)
        else:
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


def _vector(components):
    return np.array([components.x, components.y, components.z])


def main():
    """Estimate until interrupted, and report the error of the estimate."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('scenario', help="the node's parameter file, the sensors' data sheet")
    arguments = parser.parse_args(rclpy.utilities.remove_ros_args(sys.argv)[1:])
    scenario = Scenario.from_yaml(arguments.scenario)
    if not any(isinstance(sensor, Gyro) for sensor in scenario.sensors.values()):
        parser.error(f'{arguments.scenario}: sensors.names is to name a gyro')
    rclpy.init()
    node = EstimatorNode(scenario)
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
        pass
    except RuntimeError:
        # Ctrl-C takes the publishers from under a sample that is being processed.
        if rclpy.ok():
            raise
    node.destroy_node()
    rclpy.try_shutdown()


if __name__ == '__main__':
    main()
