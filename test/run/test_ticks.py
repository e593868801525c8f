"""Ticks in exact arithmetic, whatever the rate, against fractions."""

from fractions import Fraction

import numpy as np
import pytest

from satdyn_ros.run.ticks import LAST_STAMP_NS, Ticks, rate_of

EPOCH_NS = 1_704_067_200 * 10**9
# Whole, a simple fraction, and doubles whose fractions have denominators from 2^43 to 2^112.
RATES = [10.0, 1.0 / 3.0, 29.97, 0.03541954450465767, 7777.7777777777777, 1e-5, 1.0000001e-18]


def ticks_of(ticks):
    """Return the first ticks, some on the way and the last ones that have stamps."""
    last = ticks.last
    found = {*range(70), *(last * n // 20 for n in range(20)), *range(last - 5, last + 1)}
    return np.array(sorted(k for k in found if 0 <= k <= last), np.int64)


@pytest.mark.parametrize('rate_hz', RATES)
def test_times_of_ticks_are_rounded_once(rate_hz):
    """Seconds and stamps of the first ticks and of the last are the nearest to the fractions."""
    ticks = Ticks(rate_of(rate_hz), EPOCH_NS)
    some = ticks_of(ticks)
    # The quotient of a Fraction's integers is the double nearest to it.
    exact = [Fraction(k) / ticks.rate for k in some.tolist()]
    assert ticks.seconds_of(some).tolist() == [x.numerator / x.denominator for x in exact]
    assert ticks.seconds_of(-some).tolist() == [-x.numerator / x.denominator for x in exact]
    assert ticks.stamps_of(some).tolist() == [EPOCH_NS + round(x * 10**9) for x in exact]
    assert ticks.seconds_between(3, 5, 60).tolist() == ticks.seconds_of(np.arange(2, 57)).tolist()


@pytest.mark.parametrize('rate_hz', RATES)
def test_a_stamp_tells_its_tick(rate_hz):
    """Decades from tick 0 too, at any rate."""
    ticks = Ticks(rate_of(rate_hz), 1)
    some = ticks_of(ticks)
    stamps_ns = ticks.stamps_of(some)
    assert stamps_ns[-1] <= LAST_STAMP_NS
    assert ticks.ticks_of(stamps_ns).tolist() == some.tolist()
    assert [ticks.tick_of(stamp) for stamp in stamps_ns.tolist()] == some.tolist()
