import numpy as np
import pytest
from environment import truth
from numpy.testing import assert_allclose
from scipy import stats
from scipy.spatial.transform import Rotation
from sensors.three_axes import measured, within_three_sigma
from sensors.truth import at_tick_0, everywhere, turning

from satdyn_ros.kernel import rotation
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.sensors import KINDS, Magnetometer

INTERVAL_S = 0.1
FIELD_B = [1e-5, 2e-5, 3e-5]
NOISE_T, BIAS_RANDOM_WALK = 1e-7, 3e-9


def flown(count, field_b=FIELD_B):
    """Return the states of a body at rest in a field (3,) [T]."""
    environment = everywhere(magnetic_field=field_b)
    return turning(count, np.zeros(3), INTERVAL_S, environment=environment)


@pytest.mark.parametrize(
    ('errors', 'deviation', 'power'),
    [
        # White noise, and a walk: as of a gyro.
        ({'noise': NOISE_T}, lambda tau: NOISE_T * np.sqrt(INTERVAL_S / tau), 0),
        (
            {'bias_random_walk': BIAS_RANDOM_WALK},
            lambda tau: BIAS_RANDOM_WALK * np.sqrt(tau / 3.0),
            -2,
        ),
    ],
    ids=['noise', 'bias'],
)
def test_noise_is_that_of_the_data_sheet(errors, deviation, power):
    """The Allan deviations of 10^5 samples, by another's program, are the theory's."""
    samples = measured(Magnetometer(3, INTERVAL_S, 7, **errors), flown(10**5))
    within_three_sigma(samples, INTERVAL_S, deviation, power)


def test_errors_are_chi_square_of_the_covariance():
    """Over the published variances their squares are, and are not where sigma is 5% off."""
    magnetometer = Magnetometer(1, INTERVAL_S, 7, noise=NOISE_T, resolution=1e-8)
    errors = measured(magnetometer, flown(20_000)) - FIELD_B
    for factor, is_right in [(1.0, True), (1.05, False)]:
        squares = np.sum(errors**2 / magnetometer.variances, axis=-1) / factor**2
        assert (stats.kstest(squares, 'chi2', args=(3,)).pvalue > 1e-3) == is_right


@pytest.mark.parametrize(
    ('errors', 'expected'),
    [
        ({}, [1e-5, 2e-5, 3e-5]),
        ({'scale_factor': (0.01, -0.02, 0.5)}, [1.01e-5, 1.96e-5, 4.5e-5]),
        ({'misalignment': (0.0, 1e-2, 2e-2, 3e-2, 4e-2, 5e-2)}, [1.03e-5, 2.11e-5, 3.14e-5]),
        ({'initial_bias': (1e-7, 2e-7, -3e-7)}, [1.01e-5, 2.02e-5, 2.97e-5]),
        ({'resolution': 3e-6, 'max_field': 2.5e-5}, [0.9e-5, 2.1e-5, 2.5e-5]),
        ({'mounting': rotation.about([0.0, 0.0, 1.0], np.pi / 2.0)}, [2e-5, -1e-5, 3e-5]),
    ],
)
def test_each_error_is_what_its_definition_says(errors, expected):
    """By hand from y = (1 + S + M) B + b, rounded, then cut; all in sensor axes."""
    states = flown(3, [1e-5, 2e-5, 3e-5])
    samples = measured(Magnetometer(1, INTERVAL_S, 7, **errors), states)
    assert_allclose(samples, np.tile(expected, (3, 1)), rtol=0.0, atol=1e-19)


def test_blocks_do_not_show():
    """Tick by tick, in blocks or at once, with samples anywhere in them: the same bits."""
    magnetometer = Magnetometer(
        9, 3 * INTERVAL_S, 7, divisor=3, noise=NOISE_T, bias_random_walk=BIAS_RANDOM_WALK
    )
    environment = everywhere(magnetic_field=FIELD_B)
    states = turning(100, [0.3, -0.2, 0.1], INTERVAL_S, environment=environment)
    whole = measured(magnetometer, states)
    assert len(whole) == 34
    assert np.array_equal(measured(magnetometer, states, range(1, 101)), whole)
    assert np.array_equal(measured(magnetometer, states, (2, 31, 32, None)), whole)


@pytest.mark.parametrize('name', ['dipole_sso', 'igrf_sso', 'tle_cbers2'])
def test_the_field_is_the_references(name):
    """
    In a run the field at tick 0, in sensor axes, is that of a reference case.

    Tolerance: of fields whose axes and positions are another program's, 1e-9 of the field.
    """
    case = next(case for case in truth.cases('B_b') if case['name'] == name)
    mounting = [0.0, 0.6, 0.0, 0.8]
    of_sensor = {'names': ['mag'], 'mag': {'type': 'magnetometer', 'mounting': mounting}}
    scenario = Scenario.from_dict({**case['scenario'], 'sensors': of_sensor})
    states = at_tick_0(scenario)
    found, _ = scenario.sensors['mag'].measure(range(1), states, Magnetometer.memory)
    expected = Rotation.from_quat(mounting).inv().apply(case['fields'][0]['B_b'])
    assert_allclose(found.values[0], expected, rtol=0.0, atol=1e-9 * np.linalg.norm(expected))


def test_without_a_field_it_is_refused():
    """In one sentence, which names both keys."""
    sentence = (
        r'sensors\.names has mag, a magnetometer, and environment\.magnetic_field is none; give '
        r'environment\.magnetic_field, or leave mag out'
    )
    with pytest.raises(ValueError, match=sentence):
        Scenario({'sensors.names': ['mag'], 'sensors.mag.type': 'magnetometer'})


def test_what_is_not_there_is_not_written():
    """The text of a scenario, as bags have it, names none of the later kinds without them."""
    written = Scenario({'sensors.names': ['gyro']}).to_yaml()
    later = set(KINDS) - {'gyro', 'star_tracker'}
    assert later
    assert [name for name in later if name in written] == []
