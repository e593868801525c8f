"""The estimator of examples/, with sensors of known errors: its errors are as it states."""

import sys
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from satdyn_ros.kernel import rotation
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.run.simulation import Simulation

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / 'examples'))

from estimator import HELD_NS, DelayedEstimator  # noqa: E402
from triad import known  # noqa: E402

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

# The Sun comes into view after 3 minutes, is in the shadow from 1092 s to 2976 s, then seen again.
LEO = Scenario.from_yaml(ROOT / 'config' / 'cubesat_leo.yaml').with_values(
    {
        'publish.rate': 0.25,
        'time.epoch': '2008-09-20T13:30:00Z',
        'sensors.magnetometer.resolution': 0.0,
    }
)
LEO_RUNS, LEO_DARK, LEO_LIT, LEO_END = 20, 273, 744, 900


def flown(seed):
    """Return the errors (6,) at the end of a run, and the covariance that the filter states."""
    scenario = SCENARIO.with_values({'sensors.seed': seed})
    simulation = Simulation(scenario)
    _, samples = simulation.advance(TICKS)
    gyro, tracker = (samples.measured[name] for name in ('gyro', 'star_tracker'))
    published = sorted(
        [(index, 0, i) for i, index in enumerate(gyro.indices.tolist())]
        + [(index, 1, i) for i, index in enumerate(tracker.indices.tolist())]
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


@pytest.mark.long
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


def fed(estimator, scenario, heard):
    """Feed samples (name, stamp, value) in their order; yield the estimate after each rate."""
    stamps_ns = np.array(sorted({stamp_ns for _, stamp_ns, _ in heard}))
    rows = zip(stamps_ns.tolist(), *known(scenario, stamps_ns), strict=True)
    there = {stamp_ns: (B_i, s_i) for stamp_ns, B_i, s_i in rows}
    for name, stamp_ns, value in heard:
        B_i, s_i = there[stamp_ns]
        if name == 'gyro':
            estimator.take_rate(stamp_ns, value)
            yield estimator.now
        elif name == 'magnetometer':
            estimator.take_field(stamp_ns, value, B_i)
        elif name == 'star_tracker':
            estimator.take_attitude(stamp_ns, value, scenario.sensors[name].variances)
        elif name.startswith('sun'):
            estimator.take_sun(name, stamp_ns, value, s_i)


def published(samples):
    """Return the samples (name, stamp, value) of all sensors in the order of their ticks."""
    heard = [
        (index, name, stamp_ns, value)
        for name, some in samples.measured.items()
        for index, stamp_ns, value in zip(
            some.indices.tolist(), some.stamps_ns.tolist(), some.values, strict=True
        )
    ]
    return [sample for _, *sample in sorted(heard, key=lambda sample: sample[0])]


def through_the_shadow(seed):
    """
    Return errors (3, 9) and covariances (3, 9, 9) at the shadow's begin, its end, and after it.

    And the attitude's errors (N, 3) and sigmas (N, 3) [rad] at each tick from the first estimate
    on.
    """
    scenario = LEO.with_values({'sensors.seed': seed})
    simulation, estimator = Simulation(scenario), DelayedEstimator(scenario.sensors)
    errors, covariances, attitudes, sigmas = [], [], [], []
    for end in (LEO_DARK, LEO_LIT, LEO_END):
        _, samples = simulation.advance(end - simulation.next_tick)
        assert simulation.next_tick == end
        estimates = fed(estimator, scenario, published(samples))
        for q_ib, estimate in zip(samples.states.q_ib, estimates, strict=True):
            if estimate is not None:
                turned = rotation.multiply(rotation.conjugate(estimate.q_ib), q_ib)
                attitudes.append(rotation.to_vector(turned))
                sigmas.append(np.sqrt(np.diag(estimate.P)[:3]))
        now, sensors = estimator.now, simulation.snapshot(end)['sensors']
        assert now is not None
        turned = rotation.multiply(rotation.conjugate(now.q_ib), samples.states.q_ib[-1])
        biases = np.concatenate([sensors[name]['bias'] for name in ('gyro', 'magnetometer')])
        errors.append(np.concatenate([rotation.to_vector(turned), biases - now.bias]))
        covariances.append(now.P)
    return np.array(errors), np.array(covariances), np.array(attitudes), np.array(sigmas)


@pytest.fixture(scope='module')
def leo():
    """Return what through_the_shadow gives, of all runs: (R, 3, 9) and so on."""
    runs = [through_the_shadow(seed) for seed in range(1, LEO_RUNS + 1)]
    return [np.array(some) for some in zip(*runs, strict=True)]


@pytest.mark.long
def test_field_and_sun_give_an_estimate_as_good_as_it_says(leo):
    """Before, in and after the shadow the mean NEES is in its 99 per cent band (chi-square)."""
    errors, covariances, *_ = leo
    weighted = np.linalg.solve(covariances, errors[..., None])[..., 0]
    squares = np.mean(np.sum(errors * weighted, axis=-1), axis=0)
    low, high = stats.chi2.ppf([0.005, 0.995], 9 * LEO_RUNS) / LEO_RUNS
    assert np.all((low < squares) & (squares < high)), squares


@pytest.mark.long
def test_field_and_gyro_go_through_the_shadow(leo):
    """
    At each tick of 20 runs the attitude is within 5 sigma, and sigma is small in half an hour.

    With no field, the gyro's rate random walk alone would make it K t^(3/2) / sqrt(3), 2.7 deg.
    """
    _, covariances, errors, sigmas = leo
    assert np.all(np.abs(errors) < 5.0 * sigmas)
    first = LEO_END - sigmas.shape[1]
    dark = sigmas[:, LEO_DARK - first : LEO_LIT - first]
    assert np.max(dark) < np.radians(0.5)
    assert np.max(sigmas[:, LEO_DARK - first - 1]) < np.radians(0.1)
    field_bias_sigma = np.sqrt(np.diagonal(covariances[:, -1], axis1=1, axis2=2)[:, 6:])
    assert np.max(field_bias_sigma) < 0.2 * np.linalg.norm(
        LEO['sensors.magnetometer.initial_bias']
    )


@pytest.mark.long
def test_the_order_in_which_samples_come_does_not_matter():
    """
    Rates behind what is of their tick, attitudes late or at once: the same estimate, bit by bit.

    One that comes too late changes nothing.
    """
    scenario = LEO.with_values(
        {
            'sensors.names': [*LEO['sensors.names'], 'star_tracker'],
            'sensors.star_tracker.divisor': 5,
            'sensors.star_tracker.latency': 2,
            'sensors.star_tracker.cross_boresight': 1e-3,
            'sensors.star_tracker.roll': 1e-2,
        }
    )
    _, samples = Simulation(scenario).advance(100)
    as_published = published(samples)
    orders = [
        as_published,
        sorted(as_published, key=lambda sample: sample[1]),
        sorted(as_published, key=lambda sample: (sample[1], sample[0] == 'gyro')),
    ]
    assert orders[0] != orders[1] != orders[2]
    ends = []
    for order in orders:
        estimator = DelayedEstimator(scenario.sensors)
        for _ in fed(estimator, scenario, order):
            pass
        assert estimator.now is not None
        ends.append(estimator.now)
    for end in ends[1:]:
        for name in ('stamp_ns', 'q_ib', 'bias', 'P'):
            assert np.array_equal(getattr(end, name), getattr(ends[0], name))
    too_late_ns = ends[-1].stamp_ns - HELD_NS - 1
    estimator.take_attitude(too_late_ns, rotation.IDENTITY, [1.0, 1.0, 1.0])
    assert estimator.now is ends[-1]
