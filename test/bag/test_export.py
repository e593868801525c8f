"""The states of a bag as tables that other programs open."""

import csv
import re
import subprocess
import sys

import flights
import numpy as np
import pytest
from mcap.records import Channel, Message, Metadata, Schema
from mcap.stream_reader import StreamReader
from mcap.writer import Writer
from scipy.spatial.transform import Rotation

from satdyn_ros import Scenario
from satdyn_ros.bag import columns as columns_module
from satdyn_ros.bag.export import Options, export, table
from satdyn_ros.bag.simulate import simulate
from satdyn_ros.base import nanoseconds
from satdyn_ros.exchange.aem_reader import attitude_at
from satdyn_ros.kernel import rotation
from satdyn_ros.run.events import Topics

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
    *('roll_rad', 'pitch_rad', 'yaw_rad', 'nadir_angle_rad'),
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
    np.testing.assert_array_equal(columns['rotor_angle_rad'], states.rotor_angle[:, 0])
    np.testing.assert_array_equal(columns['rotor_speed_rad_s'], states.rotor_speed[:, 0])
    v_i = rotation.rotate(states.q_ib, joined(columns, 'v_b'))
    euler = Rotation.from_quat(joined(columns, 'q_lb')).as_euler('ZYX')
    angles = np.stack([columns['yaw_rad'], columns['pitch_rad'], columns['roll_rad']], -1)
    np.testing.assert_allclose(angles, euler, rtol=0.0, atol=1e-14)
    # The least moment of 800, 900 and 600 kg m^2 is about z, which LVLH has to nadir.
    tilt = np.arccos(np.abs(Rotation.from_quat(joined(columns, 'q_lb')).as_matrix()[:, 2, 2]))
    np.testing.assert_allclose(columns['nadir_angle_rad'], tilt, rtol=0.0, atol=1e-12)
    # Turned there and back, by a q of norm 1 to 1e-15: some roundings of 8 km/s.
    np.testing.assert_allclose(v_i, states.v_i, rtol=0.0, atol=4e-11)


def test_columns_say_what_they_hold_and_their_unit(bag):
    """One row per tick of everything in the recorded topics, each quantity once."""
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


def test_parquet_without_pyarrow_is_reported(bag, tmp_path, monkeypatch):
    """One sentence that says what is missing and what goes without it."""
    monkeypatch.setitem(sys.modules, 'pyarrow', None)
    with pytest.raises(ValueError, match='needs pyarrow: pip install pyarrow'):
        export(bag, tmp_path / 'states.parquet')
    assert not (tmp_path / 'states.parquet').exists()


def test_another_format_is_refused(bag, tmp_path):
    """By the name of the file."""
    with pytest.raises(
        ValueError,
        match=r'xlsx is unknown; allowed: \.csv, .* \.oem, \.a, \.czml, \.bc$',
    ):
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


def test_chunks_without_what_is_exported_make_no_rows(tmp_path):
    """After a change to a topic that no table holds the bag goes on, and the table ends."""
    events = [Topics(64, ('tf',))]
    columns = table(flights.record(tmp_path / 'bag', events=events, flush=True))
    assert columns['tick'].tolist() == list(range(64))


def test_columns_of_rotors_have_their_names(tmp_path):
    """Each of several rotors has its columns, with the values that the motion answers."""
    names = ('rw_x', 'ring')
    scenario = Scenario(
        {
            'rotor.names': names,
            'rotor.rw_x.mode': 'motor',
            'rotor.rw_x.axis': (1.0, 0.0, 0.0),
            'rotor.rw_x.inertia': 0.5,
            'rotor.rw_x.speed': 20.0,
            'rotor.ring.mode': 'free',
            'rotor.ring.inertia': 2.0,
            'rotor.ring.friction': 0.1,
            'publish.rate': 10.0,
            'publish.topics': ('attitude', 'rotor'),
            'time.epoch_ns': flights.EPOCH_NS,
        }
    )
    for _ in simulate(scenario, 5.0, tmp_path / 'bag'):
        pass
    columns = table(tmp_path / 'bag')
    states = scenario.motion().at(columns['t_s'])
    for i, name in enumerate(names):
        np.testing.assert_array_equal(columns[f'{name}_speed_rad_s'], states.rotor_speed[:, i])
        np.testing.assert_array_equal(columns[f'{name}_angle_rad'], states.rotor_angle[:, i])
    np.testing.assert_array_equal(columns['rw_x_torque_n_m'], 0.0)
    assert not [name for name in columns if name.startswith('rotor')]


def test_what_one_topic_lacks_another_has(tmp_path):
    """With imu alone the attitude and the rate come from there."""
    scenario = flights.GYROSTAT.with_values({'publish.topics': ('imu',)})
    columns = table(flights.record(tmp_path / 'bag', scenario, TICKS, ()))
    assert list(columns) == COLUMNS[:10] + COLUMNS[-4:]
    states = flights.GYROSTAT.motion().at(np.arange(TICKS) / 30.0)
    np.testing.assert_array_equal(joined(columns, 'q_ib'), states.q_ib)
    np.testing.assert_array_equal(joined(columns, 'omega_bi_b'), states.omega_bi_b)


def test_an_empty_bag_is_an_empty_table(tmp_path):
    """No tick, no row: the header alone."""
    pytest.importorskip('pyarrow')
    bag = flights.record(tmp_path / 'bag', ticks=0)
    for name in ('states.csv', 'states.npz', 'states.parquet'):
        assert export(bag, tmp_path / name) == 0
    assert (tmp_path / 'states.csv').read_text() == ','.join(COLUMNS) + '\n'
    with np.load(tmp_path / 'states.npz') as columns:
        assert [len(columns[name]) for name in COLUMNS] == [0] * len(COLUMNS)


def test_csv_without_polars_is_the_same_table(bag, tmp_path, monkeypatch):
    """By the standard library, slower."""
    monkeypatch.setitem(sys.modules, 'polars', None)
    assert export(bag, tmp_path / 'states.csv') == TICKS
    with open(tmp_path / 'states.csv', newline='') as file:
        rows = list(csv.DictReader(file))
    states = flights.GYROSTAT.motion().at(np.arange(TICKS) / 30.0)
    np.testing.assert_array_equal([float(row['q_ib_w']) for row in rows], states.q_ib[:, 3])


def test_blocks_of_any_size_make_the_same_table(bag, monkeypatch):
    """Rows are put together from the chunks of a bag, whatever is read at a time."""
    whole = table(bag)
    monkeypatch.setattr(columns_module, '_BLOCK_ROWS', 1)
    assert_true(table(bag))
    for name, column in table(bag).items():
        np.testing.assert_array_equal(column, whole[name])


def test_a_tick_whose_messages_are_apart_is_one_row(tmp_path):
    """As in a bag that another tool has put into chunks of its own, here one for each message."""
    scenario = flights.GYROSTAT.with_values(
        {'publish.topics': ('angular_velocity', 'attitude'), 'record.compression': 'none'}
    )
    bag = flights.record(tmp_path / 'bag', scenario, 20, ())
    rechunked = tmp_path / 'rechunked.mcap'
    with open(rechunked, 'wb') as file:
        writer = Writer(file, chunk_size=1)
        writer.start('ros2', '')
        schemas: dict[int, int] = {}
        channels: dict[int, int] = {}
        for record in StreamReader(str(bag / 'bag_0.mcap')).records:
            match record:
                case Metadata():
                    writer.add_metadata(record.name, record.metadata)
                case Schema() if record.id not in schemas:
                    schemas[record.id] = writer.register_schema(
                        record.name, record.encoding, record.data
                    )
                case Channel() if record.id not in channels:
                    channels[record.id] = writer.register_channel(
                        record.topic,
                        record.message_encoding,
                        schemas[record.schema_id],
                        record.metadata,
                    )
                case Message():
                    writer.add_message(
                        channels[record.channel_id],
                        record.log_time,
                        record.data,
                        record.publish_time,
                    )
        writer.finish()
    whole = table(bag)
    assert len(whole['tick']) == 20
    for name, column in table(rechunked).items():
        np.testing.assert_array_equal(column, whole[name])


def test_chosen_columns_and_a_step(bag, tmp_path):
    """In the requested order, one row in every few ticks."""
    options = Options(step_s='0.2', columns=('yaw_rad', 'tick'))
    assert export(bag, tmp_path / 'states.npz', options) == TICKS // 6
    whole = table(bag)
    with np.load(tmp_path / 'states.npz') as columns:
        assert list(columns) == ['yaw_rad', 'tick']
        assert columns['tick'].tolist() == list(range(0, TICKS, 6))
        np.testing.assert_array_equal(columns['yaw_rad'], whole['yaw_rad'][::6])


def test_a_message_has_a_segment_for_each_motion(tmp_path):
    """Readers must not interpolate over a request or a reset; times to the nanosecond."""
    bag = flights.record(tmp_path / 'bag')
    assert export(bag, tmp_path / 'flight.aem', Options(frame='GCRF')) == 150
    text = (tmp_path / 'flight.aem').read_text()
    # The request at tick 60 and the reset at tick 100 of 30 Hz.
    starts = re.findall(r'START_TIME = (\S+)\nSTOP_TIME = (\S+)\n', text)
    ticks = [(0, 59), (60, 99), (100, 149)]
    stamps = [[flights.EPOCH_NS + round(k * 10**9 / 30) for k in span] for span in ticks]
    assert [tuple(nanoseconds.epochs(span)) for span in stamps] == starts
    assert text.count('REF_FRAME_A = GCRF') == 3
    assert text.count('OBJECT_NAME = BAG') == 3
    whole = table(bag)
    for tick in (0, 59, 60, 149):
        found = attitude_at(
            tmp_path / 'flight.aem', nanoseconds.epoch(int(whole['stamp_ns'][tick]))
        )
        q_ib = joined(whole, 'q_ib')[tick]
        np.testing.assert_allclose(found.q_ib, q_ib, rtol=0.0, atol=1e-15)


def test_rates_are_written_where_they_were_recorded(tmp_path):
    """From tick 80 on angular_velocity was not published."""
    bag = flights.record(tmp_path / 'bag')
    assert export(bag, tmp_path / 'flight.aem', Options(with_rates=True)) == 80
    text = (tmp_path / 'flight.aem').read_text()
    rows = [line for line in text.splitlines() if line.startswith('2023-')]
    assert len(rows) == 80
    assert {len(row.split()) for row in rows} == {8}
    scenario = flights.GYROSTAT.with_values({'publish.topics': ('attitude',)})
    bag = flights.record(tmp_path / 'without', scenario, TICKS, ())
    with pytest.raises(
        ValueError, match='has not recorded the body rate; record one of the topics'
    ):
        export(bag, tmp_path / 'without.a', Options(with_rates=True))
    assert list(tmp_path.glob('without.a*')) == []


@pytest.mark.parametrize('kind', ['aem', 'a', 'bc', 'czml'])
def test_the_rows_counted_are_those_written(tmp_path, kind):
    """Ticks without an attitude are none; without a rate at any of them there is no message."""
    if kind == 'bc':
        pytest.importorskip('spiceypy')
    if kind == 'czml':
        pytest.importorskip('erfa')
    path, output = tmp_path / 'apart', tmp_path / f'apart.{kind}'
    scenario = Scenario(
        {
            'publish.rate': 10.0,
            'publish.topics': ['attitude'],
            'time.epoch_ns': 1_767_225_600 * 10**9,
        }
    )
    for _ in simulate(scenario, 2, path, [Topics(10, ('angular_velocity',))]):
        pass
    assert export(path, output) == 10
    output.unlink()
    if kind != 'czml':
        with pytest.raises(ValueError, match='apart has no attitude with a body rate to write'):
            export(path, output, Options(with_rates=True))
        assert not output.exists()


def test_an_orbit_is_written_thinned(bag, tmp_path):
    """In one segment, positions in km at the ticks of the step."""
    assert export(bag, tmp_path / 'orbit.oem', Options(step_s=1)) == 3
    text = (tmp_path / 'orbit.oem').read_text()
    rows = [line.split() for line in text.splitlines() if line.startswith('2023-')]
    states = flights.GYROSTAT.motion().at([0.0, 1.0, 2.0])
    assert [row[0] for row in rows] == nanoseconds.epochs(flights.EPOCH_NS + 10**9 * np.arange(3))
    numbers = np.array([row[1:] for row in rows], float) * 1000.0
    np.testing.assert_allclose(numbers[:, :3], states.r_i, rtol=1e-14)
    np.testing.assert_allclose(numbers[:, 3:], states.v_i, rtol=1e-14, atol=1e-11)


@pytest.mark.parametrize('kind', ['csv', 'aem', 'oem', 'a', 'czml'])
def test_one_tick_is_enough(bag, tmp_path, kind):
    """A step that is longer than the run leaves its first tick."""
    assert export(bag, tmp_path / f'one.{kind}', Options(step_s=1000)) == 1


@pytest.mark.parametrize(('rate', 'tick'), [(29.97, '100/2997'), (50.0, '0.02'), (3.0, '1/3')])
def test_the_tick_that_a_refusal_names_is_a_step(tmp_path, rate, tick):
    """As a fraction where no decimal is the tick."""
    scenario = flights.GYROSTAT.with_values({'publish.rate': rate})
    bag = flights.record(tmp_path / 'bag', scenario, 5, ())
    with pytest.raises(ValueError, match=f'tick of {tick} s'):
        export(bag, tmp_path / 'x.csv', Options(step_s='0.0333667'))
    assert export(bag, tmp_path / 'x.csv', Options(step_s=tick)) == 5


def test_what_does_not_fit_is_refused(bag, tmp_path):
    """In one sentence, and no file is left."""
    fixed = Scenario({'orbit.type': 'fixed', 'publish.topics': ('attitude',)})
    held = flights.record(tmp_path / 'held', fixed.with_values({'time.epoch_ns': 1}), 3, ())
    for source, name, options, reason in (
        (held, 'x.oem', Options(), 'orbit.type fixed: the body does not travel'),
        (
            bag,
            'x.csv',
            Options(with_rates=True),
            '--rates is for .aem and .a and .bc, not',
        ),
        (bag, 'x.aem', Options(columns=('tick',)), '--columns is for .csv and .npz and .parquet'),
        (bag, 'x.csv', Options(columns=('q',)), 'has no column q; it has tick, t_s'),
        (bag, 'x.csv', Options(step_s='0.05'), 'it must be a multiple of the bag'),
        (bag, 'x.csv', Options(step_s='soon'), 'the step is soon s'),
        (bag, 'x.aem', Options(frame='ITRF'), 'the frame is ITRF; it must be an inertial one'),
    ):
        with pytest.raises(ValueError, match=re.escape(reason)):
            export(source, tmp_path / name, options)
    assert list(tmp_path.glob('x.*')) == []


def test_a_bag_cut_off_is_reported_and_gives_no_file(tmp_path):
    """What would be half a table must not look like a whole one."""
    bag = flights.record(tmp_path / 'bag', ticks=900, events=(), flush=True)
    path = bag / 'bag_0.mcap'
    path.write_bytes(path.read_bytes()[:-3000])
    with pytest.raises(ValueError, match='satdyn recover'):
        export(bag, tmp_path / 'states.csv')
    assert list(tmp_path.glob('states*')) == []


def test_progress_counts_the_ticks(bag, tmp_path):
    """Of those that the bag spans."""
    shown = []
    export(bag, tmp_path / 'states.npz', Options(step_s=1), lambda *done: shown.append(done))
    assert shown[-1] == (TICKS, TICKS)


def test_the_summary_is_read_once(tmp_path, monkeypatch):
    """It is as long as the bag, and there are as many blocks of rows as the bag is long."""
    bag, read = flights.record(tmp_path / 'bag', flush=True), []
    monkeypatch.setattr(columns_module, '_BLOCK_ROWS', 1)
    read_summary = columns_module.read_summary

    def counted(path, **options):
        read.append(path)
        return read_summary(path, **options)

    monkeypatch.setattr(columns_module, 'read_summary', counted)
    shown = []
    export(bag, tmp_path / 'states.csv', show=lambda *done: shown.append(done))
    assert len(shown) > 1
    assert len(read) == 1


@pytest.mark.long
def test_memory_stays_flat(tmp_path):
    """Ten hours at 10 Hz take less than 60 MB more than a minute does, in every format."""
    program = f"""
import resource
from satdyn_ros.bag.export import Options, export
from satdyn_ros.bag.simulate import simulate
from satdyn_ros.run.scenario import Scenario
scenario = Scenario({{'publish.rate': 10.0, 'publish.topics': ['attitude', 'imu']}})
for duration_s in (60, 36000):
    for _ in simulate(scenario, duration_s, f'{tmp_path}/{{duration_s}}'):
        pass
for kind in ('csv', 'npz', 'parquet', 'aem', 'oem', 'a'):
    peaks = []
    for duration_s in (60, 36000):
        export(f'{tmp_path}/{{duration_s}}', f'{tmp_path}/{{duration_s}}.{{kind}}')
        peaks.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
    assert peaks[1] - peaks[0] < 60 * 1024, (kind, peaks)
"""
    result = subprocess.run([sys.executable, '-c', program], capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
