"""What a sensor gives for consecutive ticks: which of them have a message, and its values."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Measurements:
    """
    M measurements of one sensor.

    Attributes
    ----------
    ticks : (M,) int64
        when each is published, ascending
    exposed : (M,) int64
        the ticks whose states were measured, and whose stamps the messages have
    values : (M, 3), (M, 4) or (M,)
        what was measured
    """

    ticks: np.ndarray
    exposed: np.ndarray
    values: np.ndarray

    @classmethod
    def prompt(cls, ticks: np.ndarray, values: np.ndarray) -> 'Measurements':
        """Return measurements that are published at the ticks of their exposures."""
        return cls(ticks, ticks, values)

    def __len__(self) -> int:
        return len(self.ticks)


def as_array(ticks: range) -> np.ndarray:
    """Return ticks as an array, int64."""
    return np.arange(ticks.start, ticks.stop, ticks.step, dtype=np.int64)


def sampled(ticks: range, divisor: int) -> range:
    """
    Return the ticks of a range at which a sensor with a divisor takes a sample.

    >>> list(sampled(range(3, 11), 4))
    [4, 8]
    """
    return range(-(-ticks.start // divisor) * divisor, ticks.stop, divisor)
