"""The states of a bag as tables that other programs open."""

import csv
import sys

import flights
import numpy as np
import pytest

from satdyn_ros.bag.export import export, table
from satdyn_ros.dynamics import rotation

TICKS = 90
COLUMNS = [
    *('tick', 't_s', 'stamp_ns'),
    *('q_ib_x', 'q_ib_y', 'q_ib_z', 'q_ib_w'),
    *('omega_bi_b_x_rad_s', 'omega_bi_b_y_rad_s', 'omega_bi_b_z_rad_s'),
    *('r_i_x_m', 'r_i_y_m', 'r_i_z_m'),
    *('v_b_x_m_s', 'v_b_y_m_s', 'v_b_z_m_s'),
    *('q_lb_x', 'q_lb_y', 'q_lb_z', 'q_lb_w'),
    *('gravity_gradient_b_x_n_m', 'gravity_gradient_b_y_n_m', 'gravity_gradient_b_z_n_m'),
    *('rotor_angle_rad', 'rotor_speed_rad_s', 'rotor_torque_n_m'),
]


@pytest.fixture(scope='module')
def bag(tmp_path_factory):
    return flights.record(tmp_path_factory.mktemp('export') / 'bag', ticks=TICKS, events=())


def joined(columns, prefix):
    return np.stack([values for name, values in columns.items() if name.startswith(prefix)], -1)


def assert_true(columns):
    """Assert that a table holds what the motion answers at the ticks' times, bit for bit."""
    states = flights.GYROSTAT.motion().at(np.arange(TICKS) / 30.0)
    assert columns['tick'].tolist() == list(range(TICKS))
    assert columns['t_s'].tolist() == [k / 30 for k in range(TICKS)]
    assert columns['stamp_ns'].tolist() == [
        flights.EPOCH_NS + round(k * 10**9 / 30) for k in range(TICKS)
    ]
    np.testing.assert_array_equal(joined(columns, 'q_ib'), states.q_ib)
    np.testing.assert_array_equal(joined(columns, 'omega_bi_b'), states.omega_bi_b)
    np.testing.assert_array_equal(joined(columns, 'r_i'), states.r_i)
    np.testing.assert_array_equal(joined(columns, 'q_lb'), states.q_lb)
    np.testing.assert_array_equal(columns['rotor_angle_rad'], states.rotor_angle)
    np.testing.assert_array_equal(columns['rotor_speed_rad_s'], states.rotor_speed)
    v_i = rotation.rotate(states.q_ib, joined(columns, 'v_b'))
    # Turned there and back: a few roundings of 8 km/s.
    np.testing.assert_allclose(v_i, states.v_i, rtol=0.0, atol=1e-11)


def test_columns_say_what_they_hold_and_their_unit(bag):
    """A row a tick of all that the recorded topics tell, each quantity once."""
    columns = table(bag)
    assert list(columns) == COLUMNS
    assert_true(columns)


def test_csv_keeps_every_bit(bag, tmp_path):
    """Numbers are written so that they read back as they were."""
    assert export(bag, tmp_path / 'states.csv') == TICKS
    with open(tmp_path / 'states.csv', newline='') as file:
        header, *rows = csv.reader(file)
    assert header == COLUMNS
    values = np.array(rows).T
    whole = ('tick', 'stamp_ns')
    kinds = [np.int64 if name in whole else float for name in header]
    assert_true({n: v.astype(k) for n, v, k in zip(header, values, kinds, strict=True)})


def test_npz_keeps_every_bit(bag, tmp_path):
    """As NumPy saves it."""
    assert export(bag, tmp_path / 'states.npz') == TICKS
    with np.load(tmp_path / 'states.npz') as columns:
        assert_true(dict(columns))


def test_parquet_keeps_every_bit(bag, tmp_path):
    """As pyarrow writes and reads it, where it is installed."""
    parquet = pytest.importorskip('pyarrow.parquet')
    assert export(bag, tmp_path / 'states.parquet') == TICKS
    read = parquet.read_table(tmp_path / 'states.parquet')
    assert_true({name: read[name].to_numpy() for name in read.column_names})


def test_parquet_without_pyarrow_is_told(bag, tmp_path, monkeypatch):
    """One sentence that says what is missing and what goes without it."""
    monkeypatch.setitem(sys.modules, 'pyarrow', None)
    with pytest.raises(ValueError, match='takes pyarrow, which is not installed'):
        export(bag, tmp_path / 'states.parquet')
    assert not (tmp_path / 'states.parquet').exists()


def test_another_format_is_refused(bag, tmp_path):
    """By the name of the file."""
    with pytest.raises(ValueError, match=r'ends with neither \.csv, \.npz, \.parquet'):
        export(bag, tmp_path / 'states.xlsx')


def test_ticks_without_a_topic_are_nan(tmp_path):
    """After a change of the published topics each column goes on with what is there."""
    columns = table(flights.record(tmp_path / 'bag'))
    assert len(columns['tick']) == 150
    changed = np.arange(150) >= 80
    np.testing.assert_array_equal(np.isnan(columns['r_i_x_m']), changed)
    np.testing.assert_array_equal(np.isnan(columns['omega_bi_b_x_rad_s']), changed)
    assert not np.any(np.isnan(columns['q_ib_w']))
    assert not np.any(np.isnan(columns['rotor_speed_rad_s']))


def test_what_one_topic_lacks_another_tells(tmp_path):
    """With imu alone the attitude and the rate come from there."""
    scenario = flights.GYROSTAT.with_values({'publish.topics': ('imu',)})
    columns = table(flights.record(tmp_path / 'bag', scenario, TICKS, ()))
    assert list(columns) == COLUMNS[:10]
    states = flights.GYROSTAT.motion().at(np.arange(TICKS) / 30.0)
    np.testing.assert_array_equal(joined(columns, 'q_ib'), states.q_ib)
    np.testing.assert_array_equal(joined(columns, 'omega_bi_b'), states.omega_bi_b)


def test_an_empty_bag_is_an_empty_table(tmp_path):
    """No tick, no row."""
    assert export(flights.record(tmp_path / 'bag', ticks=0), tmp_path / 'states.csv') == 0
    assert (tmp_path / 'states.csv').read_text() == 'tick,t_s,stamp_ns\n'
