"""
The errors of a sensor of three axes, such as a gyro or a magnetometer.

With the true vector x in sensor axes, and white noise w, u, v of unit variance, sample i reads

    b_i = b_(i-1) + s_b u_i,    b_0 the initial bias
    g_i = exp(-dt / T) g_(i-1) + s_g sqrt(1 - exp(-2 dt / T)) v_i,    g_0 = s_g v_0
    y_i = (1 + S + M) x_i + b_i + g_i + s_w w_i,   rounded to a resolution and cut off

g, a Gauss-Markov process of the first order, is the bias instability of data sheets.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..base.key import Key

# Three of white noise, three of the bias; and three of the slow bias, in a stream of its own.
DEVIATES, SLOW_DEVIATES = 6, 3


def keys_of_errors(unit: str, quantity: str, of_another: str) -> tuple[Key, ...]:
    """
    Return what a scenario says of the errors of three axes.

    Parameters
    ----------
    unit : str
        of what they measure
    quantity : str
        what they measure
    of_another : str
        what an axis reads where it is misaligned, such as 'rate about another'
    """
    return *_keys_of_the_bias(unit), *_keys_of_the_axes(unit, quantity, of_another)


def _keys_of_the_bias(unit):
    return (
        Key(
            'initial_bias',
            'double_array',
            (0.0, 0.0, 0.0),
            unit,
            'bias of the first sample, sensor axes',
            lengths=(3,),
        ),
        Key(
            'bias_instability',
            'double',
            0.0,
            unit,
            'standard deviation of a bias that comes and goes, a Gauss-Markov process; 0: none',
            low=0.0,
            is_optional=True,
        ),
        Key(
            'bias_correlation_time',
            'double',
            1000.0,
            's',
            'correlation time of that bias',
            above=0.0,
            is_optional=True,
        ),
    )


def _keys_of_the_axes(unit, quantity, of_another):
    return (
        Key(
            'scale_factor',
            'double_array',
            (0.0, 0.0, 0.0),
            '',
            'relative errors of the scale factors, sensor axes',
            lengths=(3,),
            trade='ppm',
        ),
        Key(
            'misalignment',
            'double_array',
            (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
            'rad',
            f'xy xz yx yz zx zy: the part that an axis (first letter) reads of the {of_another}',
            lengths=(6,),
        ),
        Key(
            'resolution',
            'double',
            0.0,
            unit,
            'samples are rounded to multiples of this; 0: not rounded',
            low=0.0,
        ),
        Key(
            f'max_{quantity}',
            'double',
            0.0,
            unit,
            f'samples saturate at this {quantity}, axis by axis; 0: never',
            low=0.0,
        ),
    )


def allan_deviation(
    variance: float,
    interval_s: float,
    random_walk: float,
    tau_s: float,
    slow_bias: 'SlowBias | None' = None,
) -> float | None:
    """
    Return the Allan deviation of samples over tau_s; None: it is shorter than their interval.

    The squares of N / sqrt(tau) and of K sqrt(tau / 3) add up, N^2 being the variance times the
    interval (IEEE Std 952-1997, annex C).

    Parameters
    ----------
    variance : float
        of the white noise of a sample
    interval_s : s
        from sample to sample
    random_walk : float
        K, of the bias
    tau_s : s
        tau
    slow_bias : SlowBias or None
        None: there is none
    """
    if tau_s < interval_s:
        return None
    total = variance * interval_s / tau_s + random_walk**2 * tau_s / 3.0
    return math.sqrt(total + (slow_bias.allan_variance(tau_s) if slow_bias else 0.0))


@dataclass(frozen=True, eq=False)
class SlowBias:
    """
    A bias that comes and goes, of three axes.

    Attributes
    ----------
    size : float
        its standard deviation s_g
    interval_s : s
        dt from sample to sample
    time_s : s
        T
    """

    size: float
    interval_s: float
    time_s: float

    def values(self, deviates: np.ndarray, before: np.ndarray | None) -> np.ndarray:
        """
        Return g (M, 3) of successive samples.

        Parameters
        ----------
        deviates : (M, 3)
            standard normal
        before : (3,), or None
            g of the sample before; None: none
        """
        from scipy.signal import lfilter

        kept = math.exp(-self.interval_s / self.time_s)
        steps = self.size * math.sqrt(-math.expm1(-2.0 * self.interval_s / self.time_s)) * deviates
        if before is None:
            steps[0], before = self.size * deviates[0], np.zeros(3)
        # One sample after the other, so that blocks do not show in the bits.
        found, _ = lfilter([1.0], [1.0, -kept], steps, axis=0, zi=kept * before[None])
        return found

    def allan_variance(self, tau_s: float) -> float:
        """Return its part of the Allan variance over a multiple tau_s of the interval."""
        m = round(tau_s / self.interval_s)
        x = self.interval_s / self.time_s
        kept, lost, lost_in_m = math.exp(-x), -math.expm1(-x), -math.expm1(-m * x)
        ratio = lost_in_m / lost
        total = m * (1.0 + kept) / lost - 2.0 * kept * ratio / lost - kept * ratio**2
        return (self.size / m) ** 2 * total


@dataclass(frozen=True, eq=False)
class ThreeAxes:
    """
    What is wrong with three axes.

    Attributes
    ----------
    noise : float
        standard deviation s_w of a sample
    bias_step : float
        that of the bias from sample to sample, s_b
    initial_bias : (3,)
        b_0
    scale_factor : (3,)
        S
    misalignment : (6,)
        xy, xz, yx, yz, zx, zy of M
    resolution, largest : float
        0 for none
    """

    noise: float
    bias_step: float
    initial_bias: tuple[float, ...]
    scale_factor: tuple[float, ...]
    misalignment: tuple[float, ...]
    resolution: float
    largest: float

    def read(
        self,
        true: np.ndarray,
        deviates: np.ndarray,
        bias: np.ndarray | None,
        slow: np.ndarray | None = None,
    ) -> tuple[np.ndarray, np.ndarray]:
        """
        Return the samples (M, 3) of true vectors, and the biases (M, 3).

        Parameters
        ----------
        true : (M, 3), sensor axes
            the vectors
        deviates : (M, DEVIATES)
            standard normal
        bias : (3,), or None
            of the sample before, None: there is none
        slow : (M, 3), or None
            the slow bias, None: there is none
        """
        biases = self._biases(deviates[:, 3:], bias)
        return self._read(true, deviates, biases, slow), biases

    def read_each(
        self,
        true: np.ndarray,
        deviates: np.ndarray,
        before: np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return samples and biases as read does, each after a bias of its own, nan for none."""
        biases = self.bias_step * deviates[:, 3:] + before
        biases = np.where(np.isnan(before), self.initial_bias, biases)
        return self._read(true, deviates, biases, None), biases

    def _read(self, true, deviates, biases, slow):
        steady = self._misread(true) + biases
        if slow is not None:
            steady = steady + slow
        samples = steady + self.noise * deviates[:, :3]
        if self.resolution:
            samples = np.round(samples / self.resolution) * self.resolution
        if self.largest:
            samples = np.clip(samples, -self.largest, self.largest)
        return samples

    def _biases(self, deviates, before):
        steps = self.bias_step * deviates
        if before is None:
            steps[0] = self.initial_bias
        else:
            steps[0] += before
        # One addition after the other, so that blocks do not show in the bits.
        return np.cumsum(steps, axis=0)

    def _misread(self, true):
        """Return (1 + S + M) x; its sums are written out: a row has the same bits alone."""
        x, y, z = true.T
        s, (xy, xz, yx, yz, zx, zy) = self.scale_factor, self.misalignment
        return np.stack(
            [
                (1.0 + s[0]) * x + xy * y + xz * z,
                yx * x + (1.0 + s[1]) * y + yz * z,
                zx * x + zy * y + (1.0 + s[2]) * z,
            ],
            axis=-1,
        )


_WHERE_THERE_IS_ONE = 'slow_bias', 'dipole'


@dataclass(frozen=True, eq=False)
class BiasMemory:
    """
    What three axes remember from sample to sample, None before the first.

    Attributes
    ----------
    bias : (3,), sensor axes
        of the last sample
    slow_bias : (3,), sensor axes
        likewise, where there is one
    dipole : (3,), A m^2, body axes
        of the magnetorquers after the last tick, where it disturbs them
    """

    bias: np.ndarray | None = None
    slow_bias: np.ndarray | None = None
    dipole: np.ndarray | None = None

    @classmethod
    def from_plain(cls, plain: Mapping[str, Any]) -> 'BiasMemory':
        """Return the memory that to_plain gave."""
        carried = (plain.get(name) for name in ('bias', *_WHERE_THERE_IS_ONE))
        return cls(*(None if x is None else np.array(x) for x in carried))

    def to_plain(self) -> dict[str, Any]:
        """Return the memory as plain data."""
        bias = {'bias': None if self.bias is None else self.bias.tolist()}
        others = {name: getattr(self, name) for name in _WHERE_THERE_IS_ONE}
        return bias | {name: x.tolist() for name, x in others.items() if x is not None}

    def without_noise(self) -> 'BiasMemory':
        """Return the memory itself: the bias is not noise."""
        return self

    def perfect(self) -> 'BiasMemory':
        """Return the memory without a bias."""
        return replace(self, bias=None, slow_bias=None)

    def restarted(self) -> 'BiasMemory':
        """Return the memory after the motion has restarted: the bias goes on drifting."""
        return self
