import numpy as np
import pytest
from scipy import stats
from sensors.truth import turning

from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import KeplerOrbit
from satdyn_ros.orbits.kepler import EARTH_MU
from satdyn_ros.sensors import StarTracker

ACROSS, ROLL = 2e-5, 2e-4
MOUNTING = rotation.about([0.6, 0.0, 0.8], 2.0)
RATE_B = [1e-3, 2e-3, -1e-3]


def measured(tracker, states, ends=(None,)):
    """Return all measurements of consecutive states, measured in blocks that end at `ends`."""
    memory, found, begin = tracker.memory, [], 0
    for end in [*(len(states) if end is None else end for end in ends)]:
        some, memory = tracker.measure(range(begin, end), states.rows(slice(begin, end)), memory)
        found.append(some)
        begin = end
    return tuple(
        np.concatenate([getattr(some, name) for some in found])
        for name in ('ticks', 'exposed', 'values')
    )


def squared_errors(tracker, across, roll, count=20_000):
    """Return the normalised squared errors (N,) of a tracker with stated standard deviations."""
    states = turning(count, RATE_B, 0.1)
    truth = rotation.multiply(states.q_ib, tracker.mounting)
    error = rotation.to_vector(
        rotation.multiply(rotation.conjugate(truth), measured(tracker, states)[2])
    )
    return np.sum((error / [across, across, roll]) ** 2, axis=-1)


def test_errors_are_those_of_the_data_sheet():
    """Normalised in sensor axes they are chi-square of 3 degrees, and not if sigma is 5% off."""
    tracker = StarTracker(11, mounting=MOUNTING, cross_boresight=ACROSS, roll=ROLL)
    for across, roll, is_right in [(1.0, 1.0, True), (1.05, 1.0, False), (1.0, 1.05, False)]:
        found = squared_errors(tracker, across * ACROSS, roll * ROLL)
        assert (stats.kstest(found, 'chi2', args=(3,)).pvalue > 1e-3) == is_right


def test_quaternions_are_unit_whatever_the_noise():
    """A rotation is composed, nothing is added: half a radian of noise leaves the norm."""
    tracker = StarTracker(11, cross_boresight=0.5, roll=0.5)
    values = measured(tracker, turning(1000, RATE_B, 0.1))[2]
    assert np.max(np.abs(np.linalg.norm(values, axis=-1) - 1.0)) < 1e-14


def test_a_sample_comes_late_with_the_stamp_of_its_exposure():
    """Published `latency` ticks after the exposure, whose attitude the values are."""
    tracker = StarTracker(1, divisor=4, latency=6)
    states = turning(30, RATE_B, 1.0)
    ticks, exposed, values = measured(tracker, states)
    assert ticks.tolist() == [6, 10, 14, 18, 22, 26]
    assert exposed.tolist() == [0, 4, 8, 12, 16, 20]
    assert np.array_equal(values, states.q_ib[exposed])


def test_blocks_do_not_show():
    """Exposures in flight pass from block to block: the same bits."""
    tracker = StarTracker(1, divisor=3, latency=5, cross_boresight=ACROSS, roll=ROLL)
    states = turning(50, RATE_B, 1.0)
    whole = measured(tracker, states)
    for ends in (range(1, 51), (7, 8, 31, None)):
        for part, expected in zip(measured(tracker, states, ends), whole, strict=True):
            assert np.array_equal(part, expected)


def test_a_body_that_turns_fast_is_not_seen():
    """Above max_rate nothing is published; what was exposed before still comes."""
    slow, fast = turning(10, [0.0, 0.0, 0.1], 0.1), turning(10, [0.0, 0.0, 0.3], 0.1)
    tracker = StarTracker(1, max_rate=0.2, latency=2)
    first, memory = tracker.measure(range(10), slow, tracker.memory)
    second, memory = tracker.measure(range(10, 20), fast, memory)
    third, _ = tracker.measure(range(20, 30), slow, memory)
    assert first.exposed.tolist() == list(range(8))
    assert second.exposed.tolist() == [8, 9]
    assert third.exposed.tolist() == list(range(20, 28))


@pytest.mark.parametrize(('angle_deg', 'sees'), [(25.0, False), (29.9, False), (30.1, True)])
def test_the_earth_blinds(angle_deg, sees):
    """Nothing is published with the centre within the half-angle of the boresight."""
    orbit = KeplerOrbit(mu=EARTH_MU, semi_major_axis=7e6)
    nadir = rotation.multiply(
        orbit.lvlh(np.zeros(1))[0], rotation.about([1.0, 0.0, 0.0], np.deg2rad(angle_deg))
    )
    states = turning(1, [0.0, 0.0, 0.0], 1.0, orbit, nadir)
    tracker = StarTracker(1, earth_exclusion=np.deg2rad(30.0))
    assert (len(measured(tracker, states)[0]) == 1) == sees
