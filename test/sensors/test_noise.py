import numpy as np
from scipy import stats

from satdyn_ros.sensors.noise import normals

# The probability with which a correct generator would fail.
UNLIKELY = 1e-6


def test_a_tick_has_its_noise_whatever_was_drawn_before():
    """Drawn in one piece, in blocks of any length or alone: the same bits."""
    whole = normals(7, 1, range(0, 1000), 6)
    assert np.array_equal(normals(7, 1, range(313, 500), 6), whole[313:500])
    assert np.array_equal(normals(7, 1, range(999, 1000), 6), whole[999:])


def test_the_words_are_philox():
    """Another drawing of NumPy's raw words gives the same numbers: nothing is hidden between."""
    generator = np.random.Philox(key=[5, 0], counter=12)
    words = generator.random_raw(4)[:3]
    expected = stats.norm.ppf([((int(word) >> 11) + 0.5) / 2**53 for word in words])
    assert np.array_equal(normals(5, 0, range(12, 13), 3)[0], expected)


def test_deviates_are_normal_and_independent():
    """Kolmogorov and Smirnov's test, and no correlation of columns, streams, seeds and ticks."""
    ticks = range(100_000)
    drawn = np.hstack([normals(1, 0, ticks, 3), normals(1, 1, ticks, 3), normals(2, 0, ticks, 3)])
    for column in drawn.T:
        assert stats.kstest(column, 'norm').pvalue > UNLIKELY
    later = np.hstack([drawn[1:], drawn[:-1]])
    correlation = np.corrcoef(later.T) - np.eye(18)
    # Of 153 pairs of 10^5 independent numbers, the largest correlation is some 3 / sqrt(10^5).
    assert np.max(np.abs(correlation)) < 5.5 / np.sqrt(len(ticks))
