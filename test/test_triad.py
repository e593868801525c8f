"""TRIAD of examples/: its errors are those that theory says, and the shadow is bridged."""

import sys
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from satdyn_ros.bag.simulate import simulate
from satdyn_ros.kernel import rotation
from satdyn_ros.run.scenario import Scenario

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / 'examples'))

import triad  # noqa: E402

FIELD_NOISE_T, SUN_NOISE, BIAS = 2e-7, 2e-3, 1e-5
SCENARIO = Scenario(
    {
        'publish.rate': 0.25,
        'publish.topics': ['attitude', 'sunlight'],
        'orbit.altitude': 500e3,
        'orbit.inclination': 0.9,
        'environment.magnetic_field': 'igrf',
        'environment.sun': 'ephemeris',
        'time.epoch': '2026-03-01T00:00:00Z',
        'initial.angular_velocity': [0.0, 0.001, 0.002],
        'sensors.names': ['gyro', 'magnetometer', 'sun_sensor'],
        'sensors.seed': 5,
        'sensors.gyro.integrating': True,
        'sensors.gyro.initial_bias': [BIAS, 0.0, 0.0],
        'sensors.magnetometer.noise': FIELD_NOISE_T,
        'sensors.magnetometer.mounting': [0.0, 0.6, 0.0, 0.8],
        'sensors.sun_sensor.noise': SUN_NOISE,
        'sensors.sun_sensor.mounting': [0.6, 0.0, 0.8, 0.0],
    }
)


def test_exact_directions_give_the_attitude():
    """Of any length, at any angle, whatever the attitude; a first one that is off is met."""
    rng = np.random.default_rng(1)
    for true in Rotation.random(50, rng):
        first_i, second_i = rng.normal(size=(2, 3))
        first_b, second_b = true.inv().apply([3.0 * first_i, second_i])
        found = Rotation.from_quat(triad.triad(first_b, second_b, first_i, second_i))
        assert (found.inv() * true).magnitude() < 1e-14
        off_b = second_b + 0.1 * rng.normal(size=3)
        found = Rotation.from_quat(triad.triad(first_b, off_b, first_i, second_i))
        np.testing.assert_allclose(found.apply(first_b), 3.0 * first_i, atol=1e-13)


def test_errors_are_those_of_shuster_and_oh():
    """
    Three-axis attitude determination from vector observations, 1981: TRIAD's covariance.

    About axes square to the first direction it is s1^2, about that direction
    (s2^2 + s1^2 cos^2) / sin^2 of the angle between the two; within 4 sigma of 4000 draws.
    """
    rng = np.random.default_rng(2)
    s1, s2, angle, count = 1e-4, 3e-4, np.radians(50.0), 4000
    first, second = np.array([1.0, 0.0, 0.0]), np.array([np.cos(angle), np.sin(angle), 0.0])
    errors = []
    for one, other in zip(
        Rotation.from_rotvec(s1 * rng.normal(size=(count, 3))).apply(first),
        Rotation.from_rotvec(s2 * rng.normal(size=(count, 3))).apply(second),
        strict=True,
    ):
        errors.append(Rotation.from_quat(triad.triad(one, other, first, second)).as_rotvec())
    about_first = (s2**2 + s1**2 * np.cos(angle) ** 2) / np.sin(angle) ** 2
    expected = np.array([about_first, s1**2, s1**2])
    found = np.mean(np.square(errors), axis=0) / expected
    assert np.all(np.abs(found - 1.0) < 4.0 * np.sqrt(2.0 / count))


def test_a_bag_through_the_shadow(tmp_path):
    """
    Of a bag's messages: in the light the errors are the sensors', in the shadow the gyro's.

    Each is within 5 sigma: the noise of the Sun about two axes, of both about the Sun, the angle
    at least LEAST_ANGLE.  In the dark, the bias times the time since is added.
    """
    for _ in simulate(SCENARIO, 6000, tmp_path / 'bag'):
        pass
    stamps_ns, field_b, sun_b, rate_b, truth = triad.read(tmp_path / 'bag', SCENARIO)
    field_i, sun_i = triad.known(SCENARIO, stamps_ns)
    q_ib, found = triad.attitudes(stamps_ns, field_b, sun_b, rate_b, field_i, sun_i)
    assert len(stamps_ns) == 1500
    seen = ~np.isnan(sun_b[:, 0])
    dark = np.flatnonzero(~seen)
    assert 400 < len(dark) < 700
    assert np.array_equal(np.unique(np.diff(dark)), [1])
    assert np.all(found <= seen)
    assert np.count_nonzero(found) > 0.8 * np.count_nonzero(seen)
    error = rotation.angle_between(q_ib, truth)
    sizes = np.linalg.norm(field_i, axis=1)
    cosine = np.sum(field_i * sun_i, axis=1) / sizes
    about_sun = (FIELD_NOISE_T / sizes) ** 2 + (SUN_NOISE * cosine) ** 2
    sigma = np.sqrt(2.0 * SUN_NOISE**2 + about_sun / (1.0 - cosine**2))
    assert np.all(error[found] < 5.0 * sigma[found])
    begun = int(np.argmax(found))
    last = np.maximum.accumulate(np.where(found, np.arange(len(found)), 0))
    drift = BIAS * (stamps_ns - stamps_ns[last]) * 1e-9
    carried = np.arange(len(found)) >= begun
    assert np.all(error[carried] < (5.0 * sigma[last] + drift)[carried] + 1e-9)
    assert np.max(drift[carried & ~seen]) > 10.0 * SUN_NOISE
    assert np.all(np.isnan(error[:begun]))
