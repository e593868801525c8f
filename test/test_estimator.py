"""The estimator of examples/, with sensors of known errors: its errors are as it states."""

import sys
from pathlib import Path

import numpy as np
from scipy import stats

from satdyn_ros.kernel import rotation
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.run.simulation import Simulation

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / 'examples'))

from estimator import DelayedEstimator  # noqa: E402

RUNS = 50
TICKS = 301
SCENARIO = Scenario.from_yaml(ROOT / 'config' / 'cubesat_sensors.yaml').with_values(
    # Slow enough for many runs; the walk of the bias is large enough to matter within a minute.
    {
        'publish.rate': 10.0,
        'sensors.gyro.bias_random_walk': 2e-5,
        'sensors.gyro.resolution': 0.0,
        'sensors.star_tracker.divisor': 5,
        'sensors.star_tracker.latency': 3,
    }
)


def flown(seed):
    """Return the errors (6,) at the end of a run, and the covariance that the filter states."""
    scenario = SCENARIO.with_values({'sensors.seed': seed})
    simulation = Simulation(scenario)
    _, samples = simulation.advance(TICKS)
    gyro, tracker = (samples.measured[name] for name in ('gyro', 'star_tracker'))
    published = sorted(
        [(place, 0, i) for i, place in enumerate(gyro.places.tolist())]
        + [(place, 1, i) for i, place in enumerate(tracker.places.tolist())]
    )
    estimator = DelayedEstimator(scenario.sensors)
    for _, is_tracker, i in published:
        if is_tracker:
            variances = np.array(scenario.sensors['star_tracker'].variances)
            estimator.take_attitude(int(tracker.stamps_ns[i]), tracker.values[i], variances)
        else:
            estimator.take_rate(int(gyro.stamps_ns[i]), gyro.values[i])
    assert estimator.now is not None
    q_ib = samples.states.q_ib[-1]
    attitude = rotation.multiply(rotation.conjugate(estimator.now.q_ib), q_ib)
    bias = np.array(simulation.snapshot(TICKS)['sensors']['gyro']['bias'])
    errors = np.concatenate([rotation.to_vector(attitude), bias - estimator.now.bias])
    return errors, estimator.now.P


def test_the_estimate_is_as_good_as_it_says():
    """The mean normalised squared error over 50 runs is in its 95 per cent band (chi-square)."""
    squares = [error @ np.linalg.solve(P, error) for error, P in map(flown, range(1, RUNS + 1))]
    low, high = stats.chi2.ppf([0.025, 0.975], 6 * RUNS) / RUNS
    assert low < np.mean(squares) < high


def test_the_estimate_is_better_than_the_star_tracker():
    """After half a minute the attitude is within half the tracker's 3 sigma, the bias known."""
    error, _ = flown(7)
    assert np.linalg.norm(error[:3]) < 1.5 * SCENARIO['sensors.star_tracker.roll']
    assert np.linalg.norm(error[3:]) < 0.1 * np.linalg.norm(SCENARIO['sensors.gyro.initial_bias'])
