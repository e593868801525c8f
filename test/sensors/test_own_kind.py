"""Several sensors of a kind, and a kind that one file adds."""

import numpy as np
import pytest
from rosbags.highlevel import AnyReader

from satdyn_ros.bag.simulate import simulate
from satdyn_ros.bag.verify import verify
from satdyn_ros.report.history import history
from satdyn_ros.report.html import playable
from satdyn_ros.report.plot import draw
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.sensors import KINDS

NAMES = ['low', 'gyro', 'st1', 'gyro2']
MOUNTING = [0.0, 0.6, 0.0, 0.8]
VALUES = {
    'publish.rate': 20.0,
    'publish.topics': ['attitude'],
    'time.epoch_ns': 10**18,
    'initial.angular_velocity': [0.01, 0.02, 0.03],
    'sensors.names': NAMES,
    'sensors.seed': 3,
    'sensors.gyro.noise_density': 1e-4,
    'sensors.gyro2.type': 'gyro',
    'sensors.gyro2.noise_density': 1e-4,
    'sensors.gyro2.mounting': MOUNTING,
    'sensors.gyro2.divisor': 2,
    'sensors.st1.type': 'star_tracker',
    'sensors.st1.roll': 1e-4,
    'sensors.low.type': 'horizon',
    'sensors.low.noise': 1e-3,
    'sensors.low.frame_id': 'bottom',
}


@pytest.fixture(scope='module', autouse=True)
def horizon():
    """Let scenarios have the kind, for these tests alone."""
    from sensors.horizon import Horizon

    yield Horizon
    del KINDS[Horizon.kind]


@pytest.fixture(scope='module')
def bag(tmp_path_factory):
    """Return a bag of two gyros, a star tracker, and a sensor of the kind of one's own."""
    path = tmp_path_factory.mktemp('own') / 'bag'
    for _ in simulate(Scenario(VALUES), 30, path):
        pass
    return path


@pytest.fixture(scope='module')
def messages(bag):
    """Return the messages by topic, as another program reads them."""
    found: dict[str, list] = {}
    with AnyReader([bag]) as reader:
        for connection, _, data in reader.messages():
            message = reader.deserialize(data, connection.msgtype)
            found.setdefault(connection.topic, []).append(message)
    return found


def vectors(messages, field):
    return np.array([[getattr(getattr(m, field), axis) for axis in 'xyz'] for m in messages])


def test_each_publishes_on_the_topic_of_its_name(bag, messages):
    """In its frame, with its covariance; what it does not measure is marked absent."""
    assert {name: len(messages[f'/{name}']) for name in NAMES} == {
        'low': 600, 'gyro': 600, 'st1': 600, 'gyro2': 300
    }  # fmt: skip
    (low, *_), (gyro2, *_) = messages['/low'], messages['/gyro2']
    assert (low.header.frame_id, gyro2.header.frame_id) == ('bottom', 'gyro2')
    np.testing.assert_array_equal(low.linear_acceleration_covariance, np.diag([1e-6] * 3).ravel())
    assert [low.orientation_covariance[0], low.angular_velocity_covariance[0]] == [-1.0, -1.0]
    (mounted,) = messages['/tf_static']
    names = [transform.child_frame_id for transform in mounted.transforms]
    assert names == ['gyro', 'gyro2', 'st1', 'bottom']
    assert verify(bag).same_bytes


def test_each_has_a_noise_of_its_own(bag, messages, tmp_path):
    """That of the gyro is as without the others; the second gyro's has nothing to do with it."""
    of_others = 'sensors.low', 'sensors.st1', 'sensors.gyro2'
    alone = {name: value for name, value in VALUES.items() if not name.startswith(of_others)}
    for _ in simulate(Scenario({**alone, 'sensors.names': ['gyro']}), 30, tmp_path / 'alone'):
        pass
    with AnyReader([tmp_path / 'alone']) as reader:
        raw = [data for connection, _, data in reader.messages() if connection.topic == '/gyro']
        rates = [reader.deserialize(data, 'sensor_msgs/msg/Imu') for data in raw]
    first = vectors(messages['/gyro'], 'angular_velocity')
    np.testing.assert_array_equal(first, vectors(rates, 'angular_velocity'))
    errors = history(bag).sensors
    noise, of_other = errors['gyro'].error[::2].ravel(), errors['gyro2'].error.ravel()
    # 900 independent numbers correlate within five times 1 / sqrt(900).
    assert abs(np.corrcoef(noise, of_other)[0, 1]) < 5.0 / 30.0


def test_each_has_a_panel(bag):
    """Of measured minus true values, in the unit of its kind, about the truth within its noise."""
    run = history(bag)
    labels = [axes.get_ylabel() for axes in draw(run, ['gyro', 'gyro2', 'st1', 'low']).axes]
    assert [label.split('\n')[0] for label in labels] == [
        'gyro minus', 'gyro2 minus', 'st1 minus', 'low minus'
    ]  # fmt: skip
    assert labels[2:] == ['st1 minus\ntruth [arcsec]', 'low minus\ntruth [mm/m]']
    for errors in run.sensors.values():
        # 600 samples of three axes stay within five of their standard deviations, and a rounding.
        assert np.all(np.abs(errors.error) <= 5.0 * errors.sigma + 1e-14)
    assert playable(run)['sensors']['low']['unit'] == 'mm/m'


@pytest.mark.parametrize(
    ('changes', 'sentence'),
    [
        (
            {'sensors.names': ['gyro2']},
            r'gyro2, which is not a type; sensors\.gyro2\.type must be',
        ),
        ({'sensors.names': ['rotor'], 'sensors.rotor.type': 'gyro'}, 'rotor, which is a topic'),
        ({'sensors.names': ['seed'], 'sensors.seed.type': 'gyro'}, 'neither names nor seed'),
        ({'sensors.names': ['gyro'], 'sensors.gyro.type': 'star_tracker'}, 'must be one of gyro'),
        (
            {'sensors.low.noise': 1.0},
            r'sensors\.low\.noise is given, but sensors\.names has no low',
        ),
        (
            {**VALUES, 'orbit.type': 'fixed', 'sensors.st1.earth_exclusion': 0.1},
            r'sensors\.st1\.earth_exclusion is 0\.1; with orbit\.type fixed',
        ),
    ],
)
def test_a_wrong_name_or_type_is_one_sentence(changes, sentence):
    """That names the key."""
    with pytest.raises(ValueError, match=sentence):
        Scenario(changes)


def test_a_scenario_with_names_reads_its_own_text():
    """As a bag does."""
    scenario = Scenario(VALUES)
    assert Scenario.from_yaml_text(scenario.to_yaml()) == scenario
