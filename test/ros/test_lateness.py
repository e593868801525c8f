"""The lags of ticks, counted."""

import numpy as np

from satdyn_ros.ros.lateness import Lateness


def test_percentiles_are_those_of_the_lags():
    """To the width of a bin, 12 percent, and never too small; the most exactly."""
    lags_ns = np.random.default_rng(1).lognormal(np.log(70e3), 1.0, 50_000)
    lateness = Lateness()
    for part in np.split(lags_ns, 50):
        lateness.add(part.tolist())
    assert len(lateness) == 50_000
    for percent in (50.0, 99.0, 99.9):
        exact = np.percentile(lags_ns, percent, method='inverted_cdf')
        assert exact <= lateness.percentile_ns(percent) <= 1.13 * exact
    assert lateness.most_ns == lags_ns.max()


def test_the_histogram_counts_decades():
    """Every lag is in one of them, also those that are early or beyond the last."""
    lateness = Lateness()
    lateness.add([-10.0, 500.0, 1e3, 1.001e3, 99e3, 2e6, 11e9])
    assert lateness.histogram() == {
        'up to 1 us': 3,
        'up to 10 us': 1,
        'up to 100 us': 1,
        'up to 10 ms': 1,
        'above 10 s': 1,
    }
    assert str(lateness).startswith('lateness of 7 ticks: 50 % within ')
    assert 'at most 11 s; 3 up to 1 us, ' in str(lateness)
