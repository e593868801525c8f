"""Sensors that see the field and the Sun, through an orbit's shadow: recorded and run again."""

from typing import Any

import numpy as np
import pytest
from rosbags.highlevel import AnyReader

from satdyn_ros.bag.continuation import begun_in_bag
from satdyn_ros.bag.export import Options, export, table
from satdyn_ros.bag.simulate import simulate
from satdyn_ros.bag.verify import verify
from satdyn_ros.orbits.along_orbit import AlongOrbit
from satdyn_ros.report.history import history
from satdyn_ros.report.html import playable
from satdyn_ros.report.plot import draw
from satdyn_ros.rosbag2.reader import Bag
from satdyn_ros.run.events import Request
from satdyn_ros.run.scenario import Scenario

# Looks along body -z, where the Sun is at first.
MOUNTING = [1.0, 0.0, 0.0, 0.0]
VALUES = {
    'publish.rate': 1.0,
    'publish.topics': ['magnetic_field', 'sun_direction', 'sunlight'],
    'orbit.altitude': 500e3,
    'orbit.inclination': 0.9,
    'environment.magnetic_field': 'igrf',
    'environment.sun': 'ephemeris',
    'time.epoch': '2026-03-01T00:00:00Z',
    'initial.angular_velocity': [0.0, 0.001, 0.002],
    'sensors.names': ['magnetometer', 'mag2', 'sun_sensor', 'eye', 'coarse_sun_sensor', 'st'],
    'sensors.seed': 5,
    'sensors.magnetometer.noise': 1e-7,
    'sensors.magnetometer.bias_random_walk': 1e-9,
    'sensors.mag2.type': 'magnetometer',
    'sensors.mag2.divisor': 7,
    'sensors.mag2.noise': 1e-7,
    'sensors.mag2.mounting': MOUNTING,
    'sensors.sun_sensor.noise': 0.002,
    'sensors.eye.type': 'sun_sensor',
    'sensors.eye.divisor': 4,
    'sensors.eye.field_of_view': 0.8,
    'sensors.eye.mounting': MOUNTING,
    'sensors.coarse_sun_sensor.noise': 500.0,
    'sensors.coarse_sun_sensor.mounting': MOUNTING,
    'sensors.st.type': 'star_tracker',
    'sensors.st.roll': 1e-4,
    'sensors.st.mounting': MOUNTING,
    'sensors.st.divisor': 5,
    'sensors.st.latency': 2,
    'sensors.st.sun_exclusion': 0.7,
}
DURATION_S = 4000
EVENTS = [Request(1500, {'initial.angular_velocity': [0.001, 0.002, 0.0]})]


@pytest.fixture(scope='module')
def bag(tmp_path_factory):
    """Return a bag of all of them, in several files, with a restart in it."""
    path = tmp_path_factory.mktemp('environment') / 'bag'
    scenario = Scenario(VALUES | {'record.max_duration_s': 1100.0})
    for _ in simulate(scenario, DURATION_S, path, EVENTS):
        pass
    return path


def rows(bag, topic):
    """Return log times and data of a topic."""
    return [(int(t), bytes(row)) for t, row in zip(*Bag(bag).messages(f'/{topic}'), strict=True)]


def test_a_table_has_what_each_sensor_measured(bag, tmp_path):
    """
    At the tick of its stamp, as another reader of bags finds it, and nothing at the others.

    A tracker's message comes two ticks after its exposure.
    """
    columns = table(bag)
    stamps_ns = columns['stamp_ns'].tolist()
    assert columns['tick'].tolist() == list(range(DURATION_S))
    for name, field, parts in (
        ('magnetometer', 'magnetic_field', ('x_t', 'y_t', 'z_t')),
        ('mag2', 'magnetic_field', ('x_t', 'y_t', 'z_t')),
        ('eye', 'vector', 'xyz'),
        ('coarse_sun_sensor', 'illuminance', ('lx',)),
        ('st', 'orientation', ('q_is_x', 'q_is_y', 'q_is_z', 'q_is_w')),
    ):
        wanted = np.full((DURATION_S, len(parts)), np.nan)
        with AnyReader([bag]) as reader:
            connections = [found for found in reader.connections if found.topic == f'/{name}']
            for connection, _, data in reader.messages(connections):
                message: Any = reader.deserialize(data, connection.msgtype)
                at_ns = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
                value = getattr(message, field)
                components = [getattr(value, axis, value) for axis in 'xyzw'[: len(parts)]]
                wanted[stamps_ns.index(at_ns)] = components
        assert not np.all(np.isnan(wanted))
        found = np.stack([columns[f'{name}_measured_{part}'] for part in parts], axis=-1)
        np.testing.assert_array_equal(found, wanted, err_msg=name)


def test_the_truth_stands_beside_a_measurement(bag, tmp_path, monkeypatch):
    """
    Where it is asked for: the published field and Sun, turned by the mounting, at its own ticks.

    The tables of both are the same, so they agree to rounding; the field is some 3e-5 T.
    """
    parts = [f'{what}_{axis}_t' for what in ('mag2_true', 'magnetic_field_b') for axis in 'xyz']
    parts += [f'{what}_{axis}' for what in ('eye_true', 'sun_direction_b') for axis in 'xyz']
    chosen = ('tick', *parts, 'mag2_measured_x_t', 'eye_measured_x')
    export(bag, tmp_path / 'truth.npz', Options(columns=chosen))
    with np.load(tmp_path / 'truth.npz') as read:
        columns = dict(read)
    assert list(columns) == list(chosen)
    for first, measured, size in ((1, 'mag2_measured_x_t', 6e-5), (7, 'eye_measured_x', 1.0)):
        true, in_body = (
            np.stack([columns[name] for name in chosen[i : i + 3]], axis=-1)
            for i in (first, first + 3)
        )
        taken = ~np.isnan(columns[measured])
        assert 100 < np.sum(taken) < DURATION_S / 3
        np.testing.assert_array_equal(np.isnan(true), np.tile(~taken[:, None], 3))
        # Half a turn about x.
        wanted = in_body[taken] * [1.0, -1.0, -1.0]
        np.testing.assert_allclose(true[taken], wanted, rtol=0.0, atol=1e-14 * size)
    monkeypatch.setattr('satdyn_ros.bag.columns._BLOCK_ROWS', 37)
    export(bag, tmp_path / 'again.npz', Options(columns=chosen))
    with np.load(tmp_path / 'again.npz') as again:
        for name in chosen:
            np.testing.assert_array_equal(again[name], columns[name])


def test_the_bag_and_each_of_its_files_prove_themselves(bag):
    """Biases go on through files and the restart: the same bytes."""
    assert verify(bag).same_bytes
    files = sorted(bag.glob('*.mcap'))
    assert len(files) == 4
    assert verify(files[2]).same_bytes


def test_messages_are_what_another_program_reads(bag):
    """Frames, covariances and variance; the Sun is seen in light and view alone."""
    found: dict[str, list] = {}
    with AnyReader([bag]) as reader:
        for connection, _, data in reader.messages():
            if connection.topic != '/tf_static':
                message = reader.deserialize(data, connection.msgtype)
                found.setdefault(connection.topic[1:], []).append(message)
    lit = np.array([message.illuminance for message in found['sunlight']])
    # At least half of the disc is at least half of the light.
    seen = np.count_nonzero(lit > 0.5 * lit.max())
    assert 0.4 * DURATION_S < seen < 0.8 * DURATION_S
    counts = {name: len(messages) for name, messages in found.items()}
    assert counts['sun_sensor'] == seen
    assert 0 < counts['eye'] < seen / 4 - 10
    assert 0 < counts['st'] < DURATION_S / 5 - 10
    assert counts['coarse_sun_sensor'] == counts['magnetometer'] == DURATION_S
    assert counts['mag2'] == -(-DURATION_S // 7)
    mag, cell = found['mag2'][0], found['coarse_sun_sensor'][0]
    assert (mag.header.frame_id, cell.header.frame_id) == ('mag2', 'coarse_sun_sensor')
    np.testing.assert_array_equal(mag.magnetic_field_covariance, np.diag([1e-7**2] * 3).ravel())
    assert cell.variance == 500.0**2


def test_a_run_goes_on_from_the_bag(bag, tmp_path):
    """What is measured from there on is the bag's."""
    scenario, begin = begun_in_bag(Scenario(VALUES), bag, 1000.5)
    for _ in simulate(scenario, 200, tmp_path / 'on', begin=begin):
        pass
    # The Sun is on the star tracker there.
    for name in ('magnetometer', 'mag2', 'sun_sensor', 'eye', 'coarse_sun_sensor'):
        onward = rows(tmp_path / 'on', name)
        assert onward
        assert set(onward) <= set(rows(bag, name)), name


def test_errors_are_within_their_sigma(bag):
    """
    Measured minus true: the mean square over sigma is that of as many numbers.

    A direction has two angles of noise, along three axes.
    """
    errors = history(bag).sensors
    for name, share in (('magnetometer', 1.0), ('mag2', 1.0), ('sun_sensor', 2.0 / 3.0)):
        some = errors[name]
        noise = (some.error - some.systematic) / some.sigma
        # The variance of a mean of squares is 2 / n; 4 standard deviations.
        assert abs(np.mean(noise**2) / share - 1.0) < 4.0 * np.sqrt(2.0 / (noise.size * share))
    # Without noise: what the tables that fly are off by.
    assert len(errors['eye'].error) > 200
    np.testing.assert_allclose(errors['eye'].error, 0.0, atol=1e-11)
    cell = errors['coarse_sun_sensor']
    assert cell.error.shape == (DURATION_S, 1)
    assert abs(np.mean((cell.error / cell.sigma) ** 2) - 1.0) < 4.0 * np.sqrt(2.0 / DURATION_S)


def test_the_truth_is_not_taken_from_the_tables(tmp_path, monkeypatch):
    """A magnetometer that is given a wrong table of the field has the error of that table."""
    changes = {'sensors.names': ['magnetometer'], 'sensors.magnetometer.noise': 0.0}
    own = {name: x for name, x in VALUES.items() if not name.startswith('sensors.')}
    fitted = AlongOrbit._fitted

    def off(along, function, **others):
        return fitted(along, lambda t_s: 1.01 * function(t_s), **others)

    scenario = Scenario(own | changes | {'time.epoch': '2026-03-02T00:00:00Z'})
    monkeypatch.setattr(AlongOrbit, '_fitted', off)
    for _ in simulate(scenario, 10, tmp_path / 'bag'):
        pass
    run = history(tmp_path / 'bag')
    (found,) = run.sensors.values()
    size = np.linalg.norm(run.shown['magnetic_field'], axis=1)
    np.testing.assert_allclose(np.linalg.norm(found.error, axis=1), size / 101.0, rtol=1e-6)


def test_each_has_a_panel(bag):
    """In the unit of its kind; a cell's has the one axis along which it looks, in the dark too."""
    run = history(bag, 500)
    names = ['magnetometer', 'sun_sensor', 'coarse_sun_sensor']
    labels = [axes.get_ylabel().split('\n')[1] for axes in draw(run, names).axes]
    assert labels == ['truth [nT]', 'truth [deg]', 'truth [lx]']
    sensors = playable(run)['sensors']
    assert [len(sensors[name]['sigma']) for name in names] == [3, 3, 1]
    dark = history(bag, 500, 2000.0, 2500.0)
    assert len(dark.sensors['sun_sensor'].error) == 0
    draw(dark, names)
