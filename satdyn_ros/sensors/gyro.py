"""
A rate gyro with the errors of its data sheet.

With the sample interval dt, the true rate omega in sensor axes, and white noise w, u of unit
variance, sample i reads

    b_i = b_(i-1) + K sqrt(dt) u_i,    b_0 the initial bias
    y_i = (1 + S + M) omega_i + b_i + N / sqrt(dt) w_i,   rounded to a resolution and cut off

as three_axes.py computes it.  N is the angle random walk, K the rate random walk: the Allan
deviation of y is N / sqrt(tau) and K sqrt(tau / 3) (IEEE Std 952-1997, annex C; Farrenkopf 1978).
The slow bias g of three_axes.py comes to b_i.
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
    SlowBias,
    ThreeAxes,
    allan_deviation,
    keys_of_errors,
)

_CARRIED = ('bias', 'q_ib', 'turn_b', 'slow_bias')


@dataclass(frozen=True, eq=False)
class GyroMemory:
    """
    What a gyro remembers from sample to sample.

    Attributes
    ----------
    bias : (3,), rad/s, sensor axes, or None
        of the last sample; None before the first
    q_ib : (4,), or None
        attitude at the last sample; None before the first and after a restart of the motion
    turn_b : (3,), rad, body axes, or None
        where it is counted, that since the last sample; None where q_ib is
    slow_bias : (3,), rad/s, sensor axes, or None
        of the last sample, where there is one
    """

    bias: np.ndarray | None = None
    q_ib: np.ndarray | None = None
    turn_b: np.ndarray | None = None
    slow_bias: np.ndarray | None = None

    @classmethod
    def from_plain(cls, plain: Mapping[str, Any]) -> 'GyroMemory':
        """Return the memory that to_plain gave."""
        carried = (plain.get(name) for name in _CARRIED)
        return cls(*(None if x is None else np.array(x) for x in carried))

    def to_plain(self) -> dict[str, Any]:
        """Return the memory as plain data."""
        carried = {name: getattr(self, name) for name in _CARRIED}
        for name in ('turn_b', 'slow_bias'):
            if carried[name] is None:
                del carried[name]
        return {name: None if x is None else x.tolist() for name, x in carried.items()}

    def without_noise(self) -> 'GyroMemory':
        """Return the memory itself: the bias is not noise."""
        return self

    def perfect(self) -> 'GyroMemory':
        """Return the memory without a bias."""
        return replace(self, bias=None, slow_bias=None)

    def restarted(self) -> 'GyroMemory':
        """Return the memory after the motion has restarted: the bias goes on drifting."""
        return replace(self, q_ib=None, turn_b=None)

    def turned(self, turn_b: np.ndarray) -> 'GyroMemory':
        """Return the memory after a turn (3,) [rad]."""
        return self if self.turn_b is None else replace(self, turn_b=self.turn_b + turn_b)


@dataclass(frozen=True, eq=False)
class Gyro(Sensor):
    """
    A three-axis gyro.

    Parameters
    ----------
    seed : int
        of its noise
    interval_s : s
        dt between samples, divisor ticks
    divisor : ticks
        from sample to sample
    mounting : (4,), x, y, z, w
        quaternion from sensor to body axes
    noise_density : rad/s/sqrt(Hz)
        N
    bias_random_walk : rad/s^2/sqrt(Hz)
        K
    initial_bias : (3,), rad/s, sensor axes
        of the first sample
    bias_instability, bias_correlation_time : rad/s, s
        of the slow bias, 0: there is none
    scale_factor : (3,), sensor axes
        relative errors S
    misalignment : (6,), rad
        xy, xz, yx, yz, zx, zy of M
    resolution, max_rate : rad/s
        0 for none
    integrating : bool
        whether a sample is the mean rate since the previous one, the integral of the rate over dt
    folds : bool
        whether it is the rotation vector over dt instead, which is less than half a turn, as by
        rules before 3
    stream : int
        of its noise
    """

    kind = 'gyro'
    keys = (
        Key(
            'noise_density',
            'double',
            0.0,
            'rad/s/sqrt(Hz)',
            'angle random walk N: white noise of standard deviation N / sqrt(dt)',
            low=0.0,
        ),
        Key(
            'bias_random_walk',
            'double',
            0.0,
            'rad/s^2/sqrt(Hz)',
            'rate random walk K: the bias changes by steps of standard deviation K sqrt(dt)',
            low=0.0,
        ),
        *keys_of_errors('rad/s', 'rate', 'rate about another'),
        Key(
            'integrating',
            'bool',
            False,
            '',
            'a sample is the mean rate since the last one, not the rate at its tick',
        ),
    )
    message, measures = 'sensor_msgs/msg/Imu', 'angular_velocity'
    columns = tuple(f'{axis}_rad_s' for axis in 'xyz')
    says = (
        'body rate [rad/s] as the gyro measures it, in its axes, with its covariance; all else is '
        'marked absent'
    )
    unit = 'rad/s'

    seed: int
    interval_s: float
    divisor: int = 1
    mounting: np.ndarray = field(default_factory=lambda: rotation.IDENTITY)
    noise_density: float = 0.0
    bias_random_walk: float = 0.0
    initial_bias: tuple[float, ...] = (0.0, 0.0, 0.0)
    bias_instability: float = 0.0
    bias_correlation_time: float = 1000.0
    scale_factor: tuple[float, ...] = (0.0, 0.0, 0.0)
    misalignment: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    resolution: float = 0.0
    max_rate: float = 0.0
    integrating: bool = False
    folds: bool = False
    stream: int = 0

    memory, deviates = GyroMemory(), DEVIATES

    @classmethod
    def of(cls, options: Mapping[str, Any], interval_s: float) -> 'Gyro':
        """Return the gyro of its fields by name."""
        return cls(interval_s=interval_s, **options)

    @property
    def is_at_every_tick(self) -> bool:
        """Whether it has a message at every tick."""
        return self.divisor == 1

    @property
    def counts_turns(self) -> bool:
        """Whether it needs turn_b of the states."""
        return self.integrating and not self.folds

    @property
    def variances(self) -> tuple[float, float, float]:
        """Return the variances of a sample about each axis, without its bias [rad^2/s^2]."""
        variance = self.noise_density**2 / self.interval_s + self.resolution**2 / 12.0
        return variance, variance, variance

    def allan_deviation(self, tau_s: float) -> float | None:
        """Return the Allan deviation of its samples over tau_s [rad/s]."""
        variance = self.variances[0]
        return allan_deviation(
            variance, self.interval_s, self.bias_random_walk, tau_s, self._slow_bias
        )

    def without_noise(self) -> 'Gyro':
        """Return the gyro with its systematic errors alone: bias, scale factor, misalignment."""
        return replace(self, noise_density=0.0, resolution=0.0, max_rate=0.0)

    def perfect(self) -> 'Gyro':
        """Return the gyro without any error."""
        errors = (
            *('bias_random_walk', 'bias_instability', 'initial_bias'),
            *('scale_factor', 'misalignment'),
        )
        return replace(self.without_noise(), **{name: getattr(Gyro, name) for name in errors})

    def measure(
        self, ticks: range, states: States, memory: GyroMemory
    ) -> tuple[Measurements, GyroMemory]:
        """Return the body rates [rad/s] (M, 3) measured in sensor axes, and the new memory."""
        samples = sampled(ticks, self.divisor)
        first_row = samples.start - ticks.start
        turns_b = rest_b = None
        if self.counts_turns:
            turns_b, rest_b = self._counted(samples, states.turn_b, first_row, memory.turn_b)
        if len(samples) == 0:
            nothing = Measurements.prompt(as_array(samples), np.empty((0, 3)))
            return nothing, replace(memory, turn_b=rest_b)
        rows = slice(first_row, None, self.divisor)
        q_ib, rate_b = states.q_ib[rows], states.omega_bi_b[rows]
        deviates = normals(self.seed, self.stream, samples, DEVIATES)
        if self.integrating and self.folds:
            turns_b = _rotation_vectors(q_ib, memory.q_ib)
        if turns_b is not None:
            # Of a first sample, for which there is no turn, it stays the rate at its tick.
            first = len(rate_b) - len(turns_b)
            rate_b = np.concatenate([rate_b[:first], turns_b / self.interval_s])
        true = rotation.rotate(rotation.conjugate(self.mounting), rate_b)
        slow = None
        if self._slow_bias:
            of_slow = normals(self.seed, slow_stream(self.stream), samples, SLOW_DEVIATES)
            slow = self._slow_bias.values(of_slow, memory.slow_bias)
        rate, biases = self._axes.read(true, deviates, memory.bias, slow)
        after = GyroMemory(biases[-1], q_ib[-1], rest_b, None if slow is None else slow[-1])
        return Measurements.prompt(as_array(samples), rate), after

    def read(
        self, states: States, rows: Any, deviates: np.ndarray, biases: np.ndarray
    ) -> tuple[np.ndarray, None, np.ndarray]:
        """Return body rates [rad/s] (N, 3) in sensor axes, of a gyro that does not integrate."""
        to_sensor = rotation.conjugate(self.mounting)
        true = rotation.rotate(to_sensor, states.omega_bi_b[rows])
        rates, biases = self._axes.read_each(true, deviates, biases)
        return rates, None, biases

    @property
    def _slow_bias(self):
        if not self.bias_instability:
            return None
        return SlowBias(self.bias_instability, self.interval_s, self.bias_correlation_time)

    @property
    def _axes(self):
        return ThreeAxes(
            self.noise_density / np.sqrt(self.interval_s),
            self.bias_random_walk * np.sqrt(self.interval_s),
            self.initial_bias,
            self.scale_factor,
            self.misalignment,
            self.resolution,
            self.max_rate,
        )

    def _counted(self, samples, turn_b, first_row, before):
        """
        Return the turns (M, 3) from sample to sample and that since the last one, None: none was.

        turn_b (N, 3): since the row before.  first_row: of the first sample.  before (3,): the
        turn from the sample before the rows to them; None: there is none, nor a turn from it.
        """
        next_sample = (np.arange(len(turn_b)) - first_row + self.divisor - 1) // self.divisor
        rows = np.concatenate([np.zeros((1, 3)) if before is None else before[None], turn_b])
        indices = np.concatenate([[0], next_sample])
        # One addition after the other, so that blocks do not show in the bits.
        sums = [np.bincount(indices, of_axis, len(samples) + 1) for of_axis in rows.T]
        turns = np.stack(sums, axis=-1)
        if before is None:
            return turns[1:-1], turns[-1] if samples else None
        return turns[:-1], turns[-1]


def _rotation_vectors(q_ib, before):
    """Return the rotation vectors from row to row of q_ib, to the first from before if it is."""
    previous = q_ib[:-1] if before is None else np.concatenate([before[None], q_ib[:-1]])
    turned = q_ib[len(q_ib) - len(previous) :]
    return rotation.to_vector(rotation.multiply(rotation.conjugate(previous), turned))
