"""Tick k is the only clock: stamps in exact rational arithmetic, seconds rounded once."""

import math
import sys
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np

from ..base.nanoseconds import SECOND_NS

# The seconds of a stamp are an int32.
LAST_STAMP_NS = 2**31 * SECOND_NS - 1


_LARGEST_DOUBLE = int(sys.float_info.max)


def rate_of(rate_hz: float) -> Fraction:
    """Return ticks a second, the simplest fraction that rounds to the given number."""
    simple = Fraction(rate_hz).limit_denominator(1000)
    return simple if float(simple) == rate_hz else Fraction(rate_hz)


@dataclass(frozen=True)
class Ticks:
    """
    The times of ticks at a rate [Hz], tick 0 at epoch_ns.

    >>> Ticks(Fraction(3), 0).stamps_ns(0, 4)
    array([         0,  333333333,  666666667, 1000000000])
    """

    rate: Fraction
    epoch_ns: int

    def seconds(self, tick: int) -> float:
        """Return tick / rate [s]."""
        return tick * self.rate.denominator / self.rate.numerator

    def seconds_between(self, begin: int, first: int, last: int) -> np.ndarray:
        """Return (k - begin) / rate [s] for the ticks k from first to before last."""
        return self.seconds_of(np.arange(first - begin, last - begin))

    def seconds_of(self, ticks: np.ndarray) -> np.ndarray:
        """Return ticks / rate [s] of ticks (N,) int64, each rounded once, as by seconds."""
        numerator, denominator = self.rate.numerator, self.rate.denominator
        # A product of doubles is exact below 2^53, and with a power of 2.
        is_exact = denominator.bit_count() == 1 or _largest(ticks) * denominator < 2**53
        if denominator > _LARGEST_DOUBLE or not (is_exact and numerator < 2**53):
            return np.array([self.seconds(k) for k in ticks.tolist()], dtype=float)
        return ticks.astype(float) * denominator / numerator

    @cached_property
    def _period_ns(self) -> Fraction:
        return SECOND_NS / self.rate

    @cached_property
    def last(self) -> int:
        """Return the last tick that has a stamp: the seconds of a stamp are an int32."""
        return math.floor((LAST_STAMP_NS - self.epoch_ns) * self.rate / SECOND_NS)

    def stamp_ns(self, tick: int) -> int:
        """Return the stamp of a tick: epoch_ns + tick 10^9 / rate, rounded half to even."""
        return self.epoch_ns + round(tick * SECOND_NS / self.rate)

    def stamps_ns(self, first: int, last: int) -> np.ndarray:
        """Return the stamps of the ticks from first to before last, int64."""
        return self.stamps_of(np.arange(first, last, dtype=np.int64))

    def stamps_of(self, ticks: np.ndarray) -> np.ndarray:
        """Return the stamps of ticks (N,) int64, of the same shape and type."""
        period = self._period_ns
        whole, rest = divmod(period.numerator, period.denominator)
        last = max(_largest(ticks), 1)
        if last * rest * 2 >= 2**63 or last * whole >= 2**63:
            return np.array([self.stamp_ns(k) for k in ticks.tolist()], dtype=np.int64)
        if rest == 0:
            return self.epoch_ns + ticks * whole
        quotient, remainder = np.divmod(ticks * rest, period.denominator)
        twice = 2 * remainder - period.denominator
        stamps = ticks * whole + quotient
        up = (twice > 0) | ((twice == 0) & (stamps % 2 == 1))
        return self.epoch_ns + stamps + up

    def ticks_of(self, stamps_ns: np.ndarray) -> np.ndarray:
        """Return the ticks nearest to stamps (N,) int64, of the same type."""
        # By doubles, which may miss a tick after years; those whose stamps they miss anew.
        ticks = np.rint((stamps_ns - self.epoch_ns) * (float(self.rate) * 1e-9)).astype(np.int64)
        for i in np.flatnonzero(self.stamps_of(ticks) != stamps_ns):
            ticks[i] = self.tick_of(int(stamps_ns[i]))
        return ticks

    def tick_of(self, stamp_ns: int) -> int:
        """Return the tick nearest to a stamp."""
        return round((stamp_ns - self.epoch_ns) * self.rate / SECOND_NS)

    def ceil(self, duration_s: str | float) -> int:
        """
        Return the number of ticks that last at least duration_s [s], by its decimal text.

        >>> Ticks(Fraction(10), 0).ceil(0.1)
        1
        """
        return math.ceil(Fraction(str(duration_s)) * self.rate)

    def timeout(self, tick: int, timeout_s: float) -> int | None:
        """Return the tick at which what is held from a tick on has timed out; 0 s: None, never."""
        return tick + self.ceil(timeout_s) if timeout_s > 0.0 else None


def _largest(ticks):
    """Return the largest size of ticks (N,) int64, 0 of none."""
    return max(abs(int(ticks.max(initial=0))), abs(int(ticks.min(initial=0))))
