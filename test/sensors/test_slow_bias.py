"""The bias instability of gyro and magnetometer, and what magnetorquers add to a magnetometer."""

import json
from typing import Any

import numpy as np
import pytest
from cases import REFERENCE
from sensors.three_axes import measured
from sensors.truth import everywhere, turning

from satdyn_ros import Scenario, Simulation
from satdyn_ros.kernel import rotation
from satdyn_ros.sensors import Gyro, Magnetometer
from satdyn_ros.sensors.three_axes import SlowBias

TRUTH = json.loads((REFERENCE / 'slow_biases.json').read_text())
PROCESSES = TRUTH['gauss_markov']
FAST = PROCESSES[2]


def slow(raw):
    return SlowBias(raw['sigma'], raw['dt'], raw['T'])


@pytest.mark.parametrize('raw', PROCESSES, ids=lambda raw: f'{raw["T"]} s')
def test_allan_variance_is_that_of_the_reference(raw):
    """The formula of the sequence, for means of one to ten million samples."""
    found = [slow(raw).allan_variance(tau_s) for tau_s in raw['taus']]
    # Over short times terms cancel that are as large as T / dt.
    np.testing.assert_allclose(found, raw['allan_variance'], rtol=2e-5)


def test_the_largest_allan_deviation_tells_the_process():
    """0.617 sigma at 1.893 T, from which a data sheet's floor gives both."""
    process, constants = SlowBias(1.0, 0.01, 100.0), TRUTH['constants']
    taus = np.arange(100.0, 300.0, 0.5)
    found = np.sqrt([process.allan_variance(tau_s) for tau_s in taus])
    assert np.max(found) == pytest.approx(constants['allan_maximum_over_sigma'], rel=1e-4)
    assert taus[np.argmax(found)] == pytest.approx(100.0 * constants['at_tau_over_T'], rel=0.01)


def test_samples_have_the_autocovariance_of_the_reference():
    """Of three axes and 4 10^5 samples, 5 10^4 correlation times; the lags within 3 sigma."""
    count, dt, T = 400_000, FAST['dt'], FAST['T']
    gyro = Gyro(5, dt, bias_instability=FAST['sigma'], bias_correlation_time=T)
    g = measured(gyro, turning(count, np.zeros(3), dt))
    for lag, expected in zip(FAST['lags'], FAST['autocovariance'], strict=True):
        found = np.mean(g[: count - lag] * g[lag:])
        # Bartlett's formula: so many samples are worth as much as independent ones.
        independent = 3.0 * count * dt / T
        assert abs(found - expected) < 3.0 * FAST['sigma'] ** 2 * np.sqrt(2.0 / independent)
    assert abs(g[0]).max() > 0.0


@pytest.mark.parametrize(
    'sensor',
    [
        Gyro(3, 0.1, noise_density=1e-5, bias_random_walk=1e-7, bias_instability=1e-5),
        Magnetometer(3, 0.1, 7, noise=1e-8, bias_instability=1e-7, bias_correlation_time=30.0),
    ],
    ids=['gyro', 'magnetometer'],
)
def test_blocks_do_not_show(sensor: Any) -> None:
    """Nor does a memory that goes through a record; the other deviates are those without it."""
    states = turning(50, [0.1, 0.0, 0.0], 0.1, environment=everywhere(magnetic_field=[1e-5] * 3))
    whole = measured(sensor, states)
    np.testing.assert_array_equal(measured(sensor, states, (1, 17, None)), whole)
    _, memory = sensor.measure(range(20), states.rows(slice(20)), sensor.memory)
    again = type(memory).from_plain(json.loads(json.dumps(memory.to_plain())))
    found, _ = sensor.measure(range(20, 50), states.rows(slice(20, 50)), again)
    np.testing.assert_array_equal(found.values, whole[20:])
    without = measured(type(sensor)(**{**vars(sensor), 'bias_instability': 0.0}), states)
    difference = whole - without
    assert 0.2 < np.std(difference[:, 0]) / sensor.bias_instability + 0.2 < 4.0
    assert measured(sensor.perfect(), states) == pytest.approx(
        measured(type(sensor)(3, 0.1, stream=0).perfect(), states)
    )


def test_a_memory_without_a_slow_bias_is_as_before():
    """So that records of old scenarios keep their bytes."""
    states = turning(3, np.zeros(3), 0.1, environment=everywhere(magnetic_field=[1e-5] * 3))
    sensors: list[Any] = [Gyro(1, 0.1), Magnetometer(1, 0.1, 2)]
    for sensor, keys in zip(sensors, [{'bias', 'q_ib'}, {'bias'}], strict=True):
        _, memory = sensor.measure(range(3), states, sensor.memory)
        assert memory.to_plain().keys() == keys


@pytest.mark.parametrize('raw', TRUTH['magnetometer_coupling'])
def test_torquers_disturb_a_magnetometer(raw):
    """By the dipole in force before the tick's command, cut to what the torquers have."""
    scenario = Scenario(
        {
            'orbit.inclination': 1.7,
            'environment.magnetic_field': 'dipole',
            'time.epoch': '2026-03-01T00:00:00Z',
            'magnetorquer.max_dipole': raw['max_dipole'],
            'sensors.names': ['magnetometer'],
            'sensors.seed': 1,
            'sensors.magnetometer.mounting': rotation.normalise(raw['mounting']).tolist(),
            'sensors.magnetometer.torquer_coupling': raw['torquer_coupling'],
            'publish.rate': 1.0,
        }
    )
    simulation = Simulation(scenario)
    mounting = rotation.conjugate(rotation.normalise(raw['mounting']))
    added = rotation.rotate(mounting, raw['added_b'])
    none = np.zeros(3)
    for dipole, expected in (
        (raw['command'], added),
        (raw['command'], added),
        ((0.0, 0.0, 0.0), none),
        ((0.0, 0.0, 0.0), none),
    ):
        sample = simulation.step(dipole_b=dipole)
        true = rotation.rotate(mounting, sample.magnetic_field_b)
        np.testing.assert_allclose(sample.measured['magnetometer'] - true, expected, atol=1e-19)
    undisturbed = Magnetometer(1, 1.0, 2).truth
    states = turning(1, none, 1.0, environment=everywhere(magnetic_field=raw['B_b']))
    assert undisturbed(states)[0] == pytest.approx(raw['B_b'])
    states = turning(2, none, 1.0, environment=everywhere(magnetic_field=raw['B_b']))
    vars(states)['torquer_dipole_b'] = np.array([raw['dipole_in_force']] * 2)
    sensor = Magnetometer(
        1,
        1.0,
        2,
        mounting=rotation.normalise(raw['mounting']),
        torquer_coupling=tuple(raw['torquer_coupling']),
    )
    first, second = measured(sensor, states)
    np.testing.assert_allclose(second, raw['B_sensor_axes'], rtol=1e-13)
    np.testing.assert_allclose(first, rotation.rotate(mounting, raw['B_b']), rtol=1e-13)
