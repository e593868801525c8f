"""
The errors of a sensor of three axes, such as a gyro or a magnetometer.

With the true vector x in sensor axes, and white noise w, u of unit variance, sample i reads

    b_i = b_(i-1) + s_b u_i,    b_0 the initial bias
    y_i = (1 + S + M) x_i + b_i + s_w w_i,   rounded to a resolution and cut off
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..base.key import Key

# Three of white noise, three of the bias.
DEVIATES = 6


def keys_of_errors(unit: str, quantity: str, of_another: str) -> tuple[Key, ...]:
    """
    Return what a scenario says of the errors of three axes that measure a quantity.

    of_another: what an axis reads where it is misaligned, such as 'rate about another'.
    """
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
            'scale_factor',
            'double_array',
            (0.0, 0.0, 0.0),
            '',
            'relative errors of the scale factors, sensor axes',
            lengths=(3,),
        ),
        Key(
            'misalignment',
            'double_array',
            (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
            'rad',
            f'xy xz yx yz zx zy: what an axis (first letter) reads of the {of_another}',
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
    variance: float, interval_s: float, random_walk: float, tau_s: float
) -> float | None:
    """
    Return the Allan deviation of samples over tau_s; None: it is shorter than their interval.

    variance: of the white noise of a sample.  random_walk: K, of the bias.  IEEE Std 952-1997,
    annex C: the squares of N / sqrt(tau) and of K sqrt(tau / 3) add up, N^2 being the variance
    times the interval.
    """
    if tau_s < interval_s:
        return None
    return math.sqrt(variance * interval_s / tau_s + random_walk**2 * tau_s / 3.0)


@dataclass(frozen=True, eq=False)
class ThreeAxes:
    """
    What is wrong with three axes.

    noise: the standard deviation s_w of a sample.  bias_step: that of the bias from sample to
    sample, s_b.  initial_bias (3,).  scale_factor (3,): S.  misalignment (6,): xy, xz, yx, yz, zx,
    zy of M.  resolution, largest: 0 for none.
    """

    noise: float
    bias_step: float
    initial_bias: tuple[float, ...]
    scale_factor: tuple[float, ...]
    misalignment: tuple[float, ...]
    resolution: float
    largest: float

    def read(
        self, true: np.ndarray, deviates: np.ndarray, bias: np.ndarray | None
    ) -> tuple[np.ndarray, np.ndarray]:
        """
        Return the samples (M, 3) of true vectors (M, 3) in sensor axes, and the biases (M, 3).

        deviates (M, DEVIATES): standard normal.  bias (3,): of the sample before, None: there is
        none.
        """
        biases = self._biases(deviates[:, 3:], bias)
        return self._read(true, deviates, biases), biases

    def read_each(
        self, true: np.ndarray, deviates: np.ndarray, before: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return samples and biases as read does, each after a bias of its own, nan for none."""
        biases = self.bias_step * deviates[:, 3:] + before
        biases = np.where(np.isnan(before), self.initial_bias, biases)
        return self._read(true, deviates, biases), biases

    def _read(self, true, deviates, biases):
        samples = self._misread(true) + biases + self.noise * deviates[:, :3]
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


@dataclass(frozen=True, eq=False)
class BiasMemory:
    """What three axes remember from sample to sample: the bias (3,), None before the first."""

    bias: np.ndarray | None = None

    @classmethod
    def from_plain(cls, plain: Mapping[str, Any]) -> 'BiasMemory':
        """Return the memory that to_plain gave."""
        bias = plain.get('bias')
        return cls(None if bias is None else np.array(bias))

    def to_plain(self) -> dict[str, Any]:
        """Return the memory as plain data."""
        return {'bias': None if self.bias is None else self.bias.tolist()}

    def without_noise(self) -> 'BiasMemory':
        """Return the memory itself: the bias is not noise."""
        return self

    def perfect(self) -> 'BiasMemory':
        """Return the memory without a bias."""
        return replace(self, bias=None)

    def restarted(self) -> 'BiasMemory':
        """Return the memory after the motion has restarted: the bias goes on drifting."""
        return self
