"""
A magnetometer of three axes: the Earth's field as the scenario's model has it, with errors.

The errors are those of a gyro, see three_axes.py; its noise and its bias are stated as standard
deviations of a sample and of the bias after a second.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..base.key import Key
from ..dynamics.motion import States
from ..kernel import rotation
from .measurements import Measurements, as_array, sampled
from .noise import normals
from .sensor import Sensor
from .three_axes import DEVIATES, BiasMemory, ThreeAxes, allan_deviation, keys_of_errors


@dataclass(frozen=True, eq=False)
class Magnetometer(Sensor):
    """
    A three-axis magnetometer.

    seed: of its noise.  interval_s: dt between samples, divisor ticks.  mounting (4,): quaternion
    from sensor to body axes.  noise: the standard deviation of a sample [T].  bias_random_walk
    [T/sqrt(s)].  initial_bias (3,) [T].  scale_factor (3,): relative errors S.  misalignment (6,):
    xy, xz, yx, yz, zx, zy of M [rad].  resolution, max_field [T]: 0 for none.
    """

    kind = 'magnetometer'
    keys = (
        Key('noise', 'double', 0.0, 'T', 'standard deviation of a sample', low=0.0),
        Key(
            'bias_random_walk',
            'double',
            0.0,
            'T/sqrt(s)',
            'the bias changes by steps of standard deviation bias_random_walk sqrt(dt)',
            low=0.0,
        ),
        *keys_of_errors('T', 'field', 'field along another'),
    )
    needs = 'environment.magnetic_field'
    message, measures = 'sensor_msgs/msg/MagneticField', 'magnetic_field'
    columns = tuple(f'{axis}_t' for axis in 'xyz')
    says = (
        "the Earth's magnetic field [T] as the magnetometer measures it, in its axes, with its "
        'covariance; with environment.magnetic_field'
    )
    unit = 'T'

    seed: int
    interval_s: float
    stream: int
    divisor: int = 1
    mounting: np.ndarray = field(default_factory=lambda: rotation.IDENTITY)
    noise: float = 0.0
    bias_random_walk: float = 0.0
    initial_bias: tuple[float, ...] = (0.0, 0.0, 0.0)
    scale_factor: tuple[float, ...] = (0.0, 0.0, 0.0)
    misalignment: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    resolution: float = 0.0
    max_field: float = 0.0

    memory, deviates = BiasMemory(), DEVIATES

    @classmethod
    def of(cls, options: Mapping[str, Any], interval_s: float) -> 'Magnetometer':
        """Return the magnetometer of its fields by name."""
        return cls(interval_s=interval_s, **options)

    @property
    def is_at_every_tick(self) -> bool:
        """Whether it has a message at every tick."""
        return self.divisor == 1

    @property
    def variances(self) -> tuple[float, float, float]:
        """Return the variances of a sample along each axis, without its bias [T^2]."""
        variance = self.noise**2 + self.resolution**2 / 12.0
        return variance, variance, variance

    def allan_deviation(self, tau_s: float) -> float | None:
        """Return the Allan deviation of its samples over tau_s [T]."""
        variance = self.variances[0]
        return allan_deviation(variance, self.interval_s, self.bias_random_walk, tau_s)

    def without_noise(self) -> 'Magnetometer':
        """Return the magnetometer with its systematic errors alone."""
        return replace(self, noise=0.0, resolution=0.0, max_field=0.0)

    def perfect(self) -> 'Magnetometer':
        """Return the magnetometer without any error."""
        errors = ('bias_random_walk', 'initial_bias', 'scale_factor', 'misalignment')
        return replace(
            self.without_noise(), **{name: getattr(Magnetometer, name) for name in errors}
        )

    def truth(self, states: States, rows: slice = slice(None)) -> np.ndarray:
        """Return the field in sensor axes [T], (M, 3)."""
        return rotation.rotate(rotation.conjugate(self.mounting), states.magnetic_field_b[rows])

    def measure(
        self, ticks: range, states: States, memory: BiasMemory
    ) -> tuple[Measurements, BiasMemory]:
        """
        Return the fields [T] (M, 3) measured in sensor axes, and the new memory.

        ticks: consecutive, those of the rows of states.  memory: after the tick before them.
        """
        samples = sampled(ticks, self.divisor)
        if not samples:
            return Measurements.prompt(as_array(samples), np.empty((0, 3))), memory
        true = self.truth(states, slice(samples.start - ticks.start, None, self.divisor))
        deviates = normals(self.seed, self.stream, samples, DEVIATES)
        values, biases = self._axes.read(true, deviates, memory.bias)
        return Measurements.prompt(as_array(samples), values), BiasMemory(biases[-1])

    def read(
        self, states: States, rows: Any, deviates: np.ndarray, biases: np.ndarray
    ) -> tuple[np.ndarray, None, np.ndarray]:
        """Return fields [T] (N, 3) in sensor axes."""
        fields, biases = self._axes.read_each(self.truth(states, rows), deviates, biases)
        return fields, None, biases

    @property
    def _axes(self):
        return ThreeAxes(
            self.noise,
            self.bias_random_walk * np.sqrt(self.interval_s),
            self.initial_bias,
            self.scale_factor,
            self.misalignment,
            self.resolution,
            self.max_field,
        )
