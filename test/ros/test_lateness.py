"""The lags of ticks, counted, and the factor that they leave."""

import numpy as np
import pytest

from satdyn_ros.ros.lateness import Lateness, Pace, Punctuality


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


def reported(rate_hz, seconds):
    """Return what a pace reports, by the second; seconds: factor, ticks and late ticks of each."""
    pace, sentences = Pace(rate_hz), {}
    for second, (factor, ticks, late) in enumerate(seconds, 1):
        sentence = pace.take(factor, ticks, Punctuality(late_ticks=late), 1.0)
        if sentence is not None:
            sentences[second] = sentence
    return sentences


@pytest.mark.parametrize('begin', range(1, 10))
def test_a_factor_that_is_not_reached_is_reported_once(begin):
    """Within ten seconds, wherever it begins."""
    ((second, _),) = reported(100.0, [(2.0, 200, 0)] * begin + [(2.0, 100, 100)] * 30).items()
    assert begin < second <= begin + 10


def test_the_factor_that_is_reached_is_reported():
    """A hundred ticks of 100 Hz a second are a factor of 1."""
    (sentence,) = reported(100.0, [(2.0, 100, 100)] * 30).values()
    assert sentence == (
        'the factor reached is 1 and time.factor is 2: of 400 ticks in 4.0 s 400 came late'
    )


def test_each_time_that_a_factor_is_missed_is_reported():
    """It is reported again after it was reached, and where another one is asked for."""
    kept, missed, other = (1.0, 100, 0), (1.0, 50, 50), (3.0, 50, 50)
    assert len(reported(100.0, [missed] * 20 + [kept] * 10 + [missed] * 20)) == 2
    assert len(reported(100.0, [missed] * 20 + [other] * 20)) == 2


@pytest.mark.parametrize(
    'seconds',
    [
        [(1.0, 100, 100)] * 30,
        [(1.0, 40, 0), (0.0, 0, 0), (0.0, 0, 0), (1.0, 60, 0)] * 10,
        [(0.0, 20, 0)] * 30,
        [(0.01, 1, 0)] * 30,
        [(0.005, 1, 0), (0.005, 0, 0)] * 15,
    ],
    ids=['late, but as many as are due', 'pauses', 'none is asked for', 'slow', 'slower'],
)
def test_a_factor_that_is_reached_is_not_reported(seconds):
    """Nor one that nobody asked for, or of which a pause takes a part."""
    assert reported(100.0, seconds) == {}
