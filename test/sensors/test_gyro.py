from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy import stats
from sensors.three_axes import measured, within_three_sigma
from sensors.truth import turning

from satdyn_ros.kernel import rotation
from satdyn_ros.sensors import Gyro

INTERVAL_S = 0.01
NOISE_DENSITY = 2e-5
BIAS_RANDOM_WALK = 3e-6
STILL = np.zeros(3)


def noise_of(gyro):
    """Return 10^6 samples of a gyro at rest."""
    return measured(gyro, turning(10**6, STILL, INTERVAL_S))


def test_the_angle_random_walk_is_that_of_the_data_sheet():
    """White rate noise has the Allan deviation N / sqrt(tau), by another's program."""
    gyro = Gyro(3, INTERVAL_S, noise_density=NOISE_DENSITY)
    within_three_sigma(noise_of(gyro), INTERVAL_S, lambda tau: NOISE_DENSITY / np.sqrt(tau), 0)


def test_the_rate_random_walk_is_that_of_the_data_sheet():
    """A walking bias has the Allan deviation K sqrt(tau / 3), by another's program."""
    gyro = Gyro(3, INTERVAL_S, bias_random_walk=BIAS_RANDOM_WALK)
    within_three_sigma(
        noise_of(gyro), INTERVAL_S, lambda tau: BIAS_RANDOM_WALK * np.sqrt(tau / 3.0), -2
    )


def test_samples_scatter_as_the_variance_says():
    """Noise and rounding together have the published variance, within its 4-sigma scatter."""
    gyro = Gyro(1, INTERVAL_S, noise_density=1e-4, resolution=1e-3)
    samples = measured(gyro, turning(100_000, [0.1234, 0.0, 0.0], INTERVAL_S)) - [0.1234, 0.0, 0.0]
    spread = np.mean(samples**2) / gyro.variances[0]
    assert abs(spread - 1.0) < 4.0 * np.sqrt(2.0 / samples.size)


@pytest.mark.parametrize(
    ('errors', 'expected'),
    [
        ({}, [0.1, 0.2, 0.3]),
        ({'scale_factor': (0.01, -0.02, 0.5)}, [0.101, 0.196, 0.45]),
        ({'misalignment': (1e-2, 0.0, 0.0, 0.0, 0.0, 0.0)}, [0.102, 0.2, 0.3]),
        ({'misalignment': (0.0, 1e-2, 2e-2, 3e-2, 4e-2, 5e-2)}, [0.103, 0.211, 0.314]),
        ({'initial_bias': (1e-3, 2e-3, -3e-3)}, [0.101, 0.202, 0.297]),
        ({'resolution': 0.04}, [0.08, 0.2, 0.32]),
        ({'max_rate': 0.25}, [0.1, 0.2, 0.25]),
        ({'resolution': 0.04, 'max_rate': 0.25}, [0.08, 0.2, 0.25]),
        ({'mounting': rotation.about([0.0, 0.0, 1.0], np.pi / 2.0)}, [0.2, -0.1, 0.3]),
    ],
)
def test_each_error_is_what_its_definition_says(errors, expected):
    """By hand from y = (1 + S + M) omega + b, rounded, then cut; all in sensor axes."""
    gyro = Gyro(1, INTERVAL_S, **errors)
    samples = measured(gyro, turning(3, [0.1, 0.2, 0.3], INTERVAL_S))
    # 2.5 steps of the resolution may round to either side.
    assert_allclose(samples, np.tile(expected, (3, 1)), rtol=0.0, atol=1e-15)


def test_a_gyro_that_integrates_gives_the_mean_rate():
    """The turns of the ticks since the sample before over their time; the first is the rate."""
    states = turning(20, [0.3, -0.2, 0.1], INTERVAL_S)
    gyro = Gyro(1, 5 * INTERVAL_S, divisor=5, integrating=True)
    assert_allclose(measured(gyro, states), [[0.3, -0.2, 0.1]] * 4, rtol=0.0, atol=1e-14)
    turn_b = np.outer(np.arange(20.0), [1.0, 0.0, -2.0])
    samples = measured(gyro, replace(states, turn_b=turn_b))
    assert_allclose(samples[0], [0.3, -0.2, 0.1])
    sums = [np.sum(turn_b[first : first + 5], axis=0) for first in (1, 6, 11)]
    assert_allclose(samples[1:], np.divide(sums, 5 * INTERVAL_S), rtol=1e-15)


def test_a_gyro_of_earlier_rules_folds():
    """The rotation vector between samples over their time, whatever the rate was."""
    states = replace(turning(20, [2.0, 0.0, 0.0], INTERVAL_S), turn_b=None)
    gyro = Gyro(1, 5 * INTERVAL_S, divisor=5, integrating=True, folds=True)
    assert_allclose(measured(gyro, states), [[2.0, 0.0, 0.0]] * 4, rtol=0.0, atol=1e-14)
    fast = turning(20, [50.0, 0.0, 0.0], INTERVAL_S)
    samples = measured(gyro, fast)
    folded = 50.0 - 2.0 * np.pi / 0.05 * round(50.0 * 0.05 / (2.0 * np.pi))
    assert_allclose(samples[1:], [[folded, 0.0, 0.0]] * 3, rtol=0.0, atol=1e-12)


def test_blocks_do_not_show():
    """Tick by tick, in blocks or at once, with samples anywhere in them: the same bits."""
    gyro = Gyro(
        9,
        3 * INTERVAL_S,
        divisor=3,
        noise_density=NOISE_DENSITY,
        bias_random_walk=BIAS_RANDOM_WALK,
        initial_bias=(0.1, 0.2, 0.3),
        integrating=True,
    )
    states = turning(100, [0.3, -0.2, 0.1], INTERVAL_S)
    whole = measured(gyro, states)
    assert len(whole) == 34
    assert np.array_equal(measured(gyro, states, range(1, 101)), whole)
    assert np.array_equal(measured(gyro, states, (2, 31, 32, None)), whole)


def test_turns_are_added_in_their_order_whatever_the_blocks():
    """Turns of any size: a sum in another order would have other bits."""
    turn_b = np.random.default_rng(1).normal(size=(200, 3)) ** 5
    states = replace(turning(200, STILL, INTERVAL_S), turn_b=turn_b)
    gyro = Gyro(9, 7 * INTERVAL_S, divisor=7, integrating=True)
    whole = measured(gyro, states)
    assert np.array_equal(measured(gyro, states, range(1, 201)), whole)
    assert np.array_equal(measured(gyro, states, (2, 11, 100, None)), whole)


def test_a_restart_keeps_the_bias_and_forgets_the_attitude():
    """The first sample after a restart gives the rate at its tick, the bias walks on."""
    gyro = Gyro(9, INTERVAL_S, bias_random_walk=BIAS_RANDOM_WALK, integrating=True)
    states = turning(10, [0.3, -0.2, 0.1], INTERVAL_S)
    _, memory = gyro.measure(range(10), states, gyro.memory)
    jumped = turning(10, STILL, INTERVAL_S, q_ib=rotation.about([1.0, 0.0, 0.0], 1.0))
    after, _ = gyro.measure(range(10, 20), jumped, memory.restarted())
    assert np.max(np.abs(after.values)) < 1e-4
    assert memory.bias is not None
    assert np.linalg.norm(memory.bias) > 0.0
    assert np.linalg.norm(after.values[0] - memory.bias) < 6.0 * BIAS_RANDOM_WALK * INTERVAL_S**0.5


def test_noise_of_the_axes_is_normal():
    """Kolmogorov and Smirnov's test of all three axes at once."""
    gyro = Gyro(5, INTERVAL_S, noise_density=1.0)
    samples = measured(gyro, turning(30_000, STILL, INTERVAL_S)) * np.sqrt(INTERVAL_S)
    assert stats.kstest(samples.ravel(), 'norm').pvalue > 1e-6
