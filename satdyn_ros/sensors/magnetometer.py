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
from .noise import normals, slow_stream
from .sensor import Sensor
from .three_axes import (
    DEVIATES,
    SLOW_DEVIATES,
    BiasMemory,
    SlowBias,
    ThreeAxes,
    allan_deviation,
    keys_of_errors,
)

_NO_COUPLING = (0.0,) * 9


@dataclass(frozen=True, eq=False)
class Magnetometer(Sensor):
    """
    A three-axis magnetometer.

    Parameters
    ----------
    seed : int
        of its noise
    interval_s : s
        dt between samples, divisor ticks
    stream : int
        of its noise
    divisor : ticks
        from sample to sample
    mounting : (4,), x, y, z, w
        quaternion from sensor to body axes
    noise : T
        standard deviation of a sample
    bias_random_walk : T/sqrt(s)
        of the bias
    initial_bias : (3,), T, sensor axes
        of the first sample
    bias_instability, bias_correlation_time : T, s
        of the slow bias, 0: there is none
    scale_factor : (3,), sensor axes
        relative errors S
    misalignment : (6,), rad
        xy, xz, yx, yz, zx, zy of M
    resolution, max_field : T
        0 for none
    torquer_coupling : (9,), T/(A m^2)
        rows of what the dipole of the magnetorquers adds to the field, both in body axes
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
        Key(
            'torquer_coupling',
            'double_array',
            _NO_COUPLING,
            'T/(A m^2)',
            'row-major: the field at the sensor, body axes, of the dipole of the torquers, '
            'body axes, as it was before the commands of the tick',
            lengths=(9,),
        ),
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
    bias_instability: float = 0.0
    bias_correlation_time: float = 1000.0
    scale_factor: tuple[float, ...] = (0.0, 0.0, 0.0)
    misalignment: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    resolution: float = 0.0
    max_field: float = 0.0
    torquer_coupling: tuple[float, ...] = _NO_COUPLING

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
        return allan_deviation(
            variance, self.interval_s, self.bias_random_walk, tau_s, self._slow_bias
        )

    def without_noise(self) -> 'Magnetometer':
        """Return the magnetometer with its systematic errors alone."""
        return replace(self, noise=0.0, resolution=0.0, max_field=0.0)

    def perfect(self) -> 'Magnetometer':
        """Return the magnetometer without any error."""
        errors = (
            *('bias_random_walk', 'bias_instability', 'initial_bias', 'scale_factor'),
            *('misalignment', 'torquer_coupling'),
        )
        return replace(
            self.without_noise(), **{name: getattr(Magnetometer, name) for name in errors}
        )

    def truth(self, states: States, rows: slice = slice(None)) -> np.ndarray:
        """Return the field in sensor axes [T], (M, 3)."""
        return rotation.rotate(rotation.conjugate(self.mounting), states.magnetic_field_b[rows])

    def measure(
        self, ticks: range, states: States, memory: BiasMemory
    ) -> tuple[Measurements, BiasMemory]:
        """Return the fields [T] (M, 3) measured in sensor axes, and the new memory."""
        samples = sampled(ticks, self.divisor)
        dipole, before = memory.dipole, None
        if any(self.torquer_coupling) and len(ticks):
            assert states.torquer_dipole_b is not None
            # Measurements precede the commands of their tick, with which a motion begins.
            first = np.zeros(3) if memory.dipole is None else memory.dipole
            before = np.where(states.t_s[:, None] > 0.0, states.torquer_dipole_b, first)
            dipole = states.torquer_dipole_b[-1]
        if not samples:
            nothing = Measurements.prompt(as_array(samples), np.empty((0, 3)))
            return nothing, replace(memory, dipole=dipole)
        rows = slice(samples.start - ticks.start, None, self.divisor)
        true = self.truth(states, rows)
        if before is not None:
            true = true + self._of_torquers(before[rows])
        deviates = normals(self.seed, self.stream, samples, DEVIATES)
        slow = None
        if self._slow_bias:
            of_slow = normals(self.seed, slow_stream(self.stream), samples, SLOW_DEVIATES)
            slow = self._slow_bias.values(of_slow, memory.slow_bias)
        values, biases = self._axes.read(true, deviates, memory.bias, slow)
        after = BiasMemory(biases[-1], None if slow is None else slow[-1], dipole)
        return Measurements.prompt(as_array(samples), values), after

    def _of_torquers(self, dipole_b):
        """Return the field of dipoles (M, 3) in sensor axes; the sums are written out."""
        M, (x, y, z) = self.torquer_coupling, dipole_b.T
        rows = [M[i] * x + M[i + 1] * y + M[i + 2] * z for i in (0, 3, 6)]
        return rotation.rotate(rotation.conjugate(self.mounting), np.stack(rows, axis=-1))

    @property
    def _slow_bias(self):
        if not self.bias_instability:
            return None
        return SlowBias(self.bias_instability, self.interval_s, self.bias_correlation_time)

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
