"""A kind of sensors in one file: where the attracting centre is, with noise."""

from dataclasses import dataclass, field, replace

import numpy as np

from satdyn_ros.base.key import Key
from satdyn_ros.kernel import rotation
from satdyn_ros.sensors import Measurements, Sensor
from satdyn_ros.sensors.measurements import as_array, sampled
from satdyn_ros.sensors.noise import normals


@dataclass(frozen=True, eq=False)
class Horizon(Sensor):
    kind = 'horizon'
    keys = (Key('noise', 'double', 0.0, '', 'standard deviation of each component', low=0.0),)
    message, measures = 'sensor_msgs/msg/Imu', 'linear_acceleration'
    columns = ('x', 'y', 'z')
    says = 'unit vector to the attracting centre in sensor axes, in place of an acceleration'
    unit, per_si = 'mm/m', 1000.0

    seed: int
    stream: int
    divisor: int = 1
    mounting: np.ndarray = field(default_factory=lambda: rotation.IDENTITY)
    noise: float = 0.0

    @property
    def variances(self):
        return (self.noise**2,) * 3

    def without_noise(self):
        return replace(self, noise=0.0)

    perfect = without_noise

    def measure(self, ticks, states, memory):
        samples = sampled(ticks, self.divisor)
        rows = slice(samples.start - ticks.start, None, self.divisor)
        true = -rotation.rotate(rotation.conjugate(self.mounting), states.c_b[rows])
        noise = self.noise * normals(self.seed, self.stream, samples, 3)
        return Measurements(as_array(samples), as_array(samples), true + noise), memory
