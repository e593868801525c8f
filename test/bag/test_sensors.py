"""A run with sensors, recorded, split, joined in the middle and run again."""

import copy
from pathlib import Path

import flights
import numpy as np
import pytest
from commands import torque_command
from mcap.records import Metadata

from satdyn_ros.bag import run_metadata
from satdyn_ros.bag.columns import StateTable
from satdyn_ros.bag.continuation import begun_in_bag
from satdyn_ros.bag.export import table
from satdyn_ros.bag.playback import Playback, offered
from satdyn_ros.bag.read_run import RecordedRun
from satdyn_ros.bag.run_recorder import RunRecorder
from satdyn_ros.bag.simulate import simulate
from satdyn_ros.bag.verify import verify
from satdyn_ros.bag.write_run import Recording
from satdyn_ros.messages.packers import packer
from satdyn_ros.rosbag2.reader import Bag
from satdyn_ros.rosbag2.scan import scan
from satdyn_ros.run.events import Request, Reset
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.run.simulation import Simulation

VALUES = {
    'publish.rate': 20.0,
    'publish.topics': ['attitude'],
    'time.epoch_ns': 10**9,
    'sensors.names': ['gyro', 'star_tracker'],
    'sensors.seed': 5,
    'sensors.gyro.noise_density': 1e-4,
    'sensors.gyro.bias_random_walk': 1e-5,
    'sensors.gyro.integrating': True,
    'sensors.gyro.divisor': 2,
    'sensors.star_tracker.cross_boresight': 1e-5,
    'sensors.star_tracker.divisor': 7,
    'sensors.star_tracker.latency': 5,
}
EVENTS = [
    torque_command(30, (0.0, 0.01, 0.0), 55),
    Request(101, {'initial.angular_velocity': [0.0, 0.0, 0.01]}),
    Reset(161),
]


def recorded(directory, changes=None, events=EVENTS, duration_s=20):
    for _ in simulate(Scenario(VALUES | (changes or {})), duration_s, directory, events):
        pass
    return directory


def read(directory):
    """Return the log times and data of each topic of a bag."""
    bag = Bag(directory)
    return {
        name: [(int(t), bytes(row)) for t, row in zip(*bag.messages(f'/{name}'), strict=True)]
        for name in ('attitude', 'gyro', 'star_tracker')
    }


@pytest.mark.parametrize(
    'changes',
    [{}, {'record.max_duration_s': 2.15}, {'publish.topics': []}, {'record.compression': 'none'}],
    ids=['one file', 'split', 'sensors alone', 'not compressed'],
)
def test_a_bag_with_sensors_proves_itself(tmp_path, changes):
    """Run again from its own scenario and events, every measurement has the same bytes."""
    bag = recorded(tmp_path / 'bag', changes)
    verdict = verify(bag)
    assert verdict.is_true, verdict
    assert verdict.same_bytes
    attitudes = 0 if 'publish.topics' in changes else 400
    files = len(list(bag.glob('*.mcap')))
    assert verdict.message_count == attitudes + 200 + 57 + 1 + files


def test_each_file_of_a_split_bag_proves_itself(tmp_path):
    """Bias, attitudes before and exposures in flight stand in the snapshot of each file."""
    recorded(tmp_path / 'bag', {'record.max_duration_s': 2.15})
    files = sorted((tmp_path / 'bag').glob('*.mcap'))
    assert len(files) > 8
    for file in files:
        assert verify(file).same_bytes, file


def test_mountings_are_latched_in_each_file(tmp_path):
    """
    One message on /tf_static ahead of each first sample, offered as latched, as it is live.

    /tf beside it has no sensors; a mounting that is not the scenario's is found.
    """
    changes = {'record.max_duration_s': 2.15, 'publish.topics': ['attitude', 'tf']}
    bag = Bag(recorded(tmp_path / 'bag', changes))
    times_ns, data = bag.messages('/tf_static')
    statistics = [flights.summary(file).statistics for file in bag.files]
    assert times_ns.tolist() == [file.message_start_time for file in statistics if file]
    run = RecordedRun(bag.path)
    assert {bytes(row) for row in data} == {*run.latched.values()}
    latched = offered(bag.topics['/tf_static'].qos)
    assert (latched.durability, latched.reliability) == ('transient_local', 'reliable')
    played = Playback(bag.path)
    topics = [message.topic for message in played.messages([*played.types], played.begin_ns)]
    assert topics[0] == '/tf_static'
    turned = {'sensors.gyro.mounting': [0.0, 0.0, 1.0, 0.0]}
    other = recorded(tmp_path / 'other', changes | turned)
    records = [found.item for found in scan(other / 'other_0.mcap')]
    wanted = {run_metadata.SCENARIO: bag_scenario(bag)}
    file = flights.rewritten(
        records, tmp_path / 'other.mcap', lambda r: wanted.get(r.name, r.metadata)
    )
    file.finish()
    found = flights.difference(verify(tmp_path / 'other.mcap'))
    assert (found.topic, found.tick) == ('/tf_static', 0)


def test_a_table_of_sensors_alone(tmp_path):
    """
    A row for each tick that a message is of, and the truth of a gyro that integrates.

    That is its turn since its last sample: of a body that spins about its axis of symmetry the
    rate itself, and the attitude is half of it in the quaternion.
    """
    spin = {'publish.topics': [], 'orbit.type': 'fixed', 'initial.angular_velocity': [0.0, 0, 0.2]}
    spin |= {'body.inertia': [800.0, 800.0, 600.0], 'initial.attitude': [0.0, 0.0, 0.0, 1.0]}
    bag = recorded(tmp_path / 'bag', spin, [])
    columns = table(bag)
    ticks = np.arange(400)
    of_gyro, of_tracker = ticks % 2 == 0, (ticks % 7 == 0) & (ticks < 395)
    assert columns['tick'].tolist() == ticks[of_gyro | of_tracker].tolist()
    measured = columns['gyro_measured_z_rad_s']
    assert columns['tick'][~np.isnan(measured)].tolist() == ticks[of_gyro].tolist()
    attitude = columns['star_tracker_measured_q_is_w']
    assert columns['tick'][~np.isnan(attitude)].tolist() == ticks[of_tracker].tolist()
    # Sampled at 10 Hz, its noise is 3e-4 rad/s.
    assert 2e-4 < np.nanstd(measured) < 4e-4
    names = (
        *(f'gyro_true_{axis}_rad_s' for axis in 'xyz'),
        *(f'star_tracker_true_q_is_{part}' for part in 'xyzw'),
    )
    (block,) = StateTable(RecordedRun(bag), ('t_s', *names)).blocks()
    truth = np.stack([*block.values()])
    gyro, tracker = truth[1:4, of_gyro[of_gyro | of_tracker]], truth[4:, ~np.isnan(truth[4])]
    np.testing.assert_allclose(gyro[:, 1:], [[0.0], [0.0], [0.2]] * np.ones(199), atol=1e-12)
    half = 0.1 * truth[0, ~np.isnan(truth[4])]
    np.testing.assert_allclose(tracker[2:], [np.sin(half), np.cos(half)], atol=1e-9)


def test_exposures_from_before_a_bag_are_in_its_table(tmp_path):
    """At their own ticks, ahead of the first, with nothing else there."""
    whole = table(recorded(tmp_path / 'bag', None, []))
    scenario, begin = begun_in_bag(Scenario(VALUES), tmp_path / 'bag', 1.5)
    for _ in simulate(scenario, 1, tmp_path / 'onward', begin=begin):
        pass
    onward = table(tmp_path / 'onward')
    assert onward['tick'].tolist() == [28, *range(30, 50)]
    wanted = {name: values[onward['tick']] for name, values in whole.items()}
    for name, values in wanted.items():
        if name.startswith('star_tracker'):
            # What was exposed in the last five ticks has no message yet.
            values[onward['tick'] >= 45] = np.nan
        elif name not in ('tick', 't_s', 'stamp_ns'):
            values[0] = np.nan
    assert list(onward) == list(wanted)
    for name, values in onward.items():
        np.testing.assert_array_equal(values, wanted[name], err_msg=name)


def bag_scenario(bag):
    """Return the record of the scenario in a bag."""
    return next(
        item.metadata
        for item in bag.items()
        if isinstance(item, Metadata) and item.name == run_metadata.SCENARIO
    )


def test_splitting_and_blocks_do_not_show(tmp_path, monkeypatch):
    """Whatever the length of files and blocks: the same messages at the same times."""
    whole = read(recorded(tmp_path / 'whole'))
    assert read(recorded(tmp_path / 'split', {'record.max_duration_s': 1.0})) == whole
    monkeypatch.setattr(RunRecorder, 'most', 13)
    assert read(recorded(tmp_path / 'blocks')) == whole


def test_noise_goes_on_through_a_restart(tmp_path):
    """With and without a reset the bias and the noise are the same: only the rate differs."""
    still = {'initial.angular_velocity': [0.0] * 3, 'sensors.gyro.integrating': False}
    still |= {'orbit.type': 'fixed', 'initial.attitude': [0.0, 0.0, 0.0, 1.0]}
    still |= {'initial.frame': 'inertial'}
    calm = read(recorded(tmp_path / 'calm', still, []))
    assert read(recorded(tmp_path / 'reset', still, [Reset(77)])) == calm


def test_a_gyro_that_integrates_goes_on_from_a_bag(tmp_path):
    """
    Its first sample is the bag's, also where another body begins there, or a torque had begun.

    A bag of rules 2 knows no turn: the sample is the rate at its tick.
    """
    fast = {'initial.angular_velocity': [0.3, -0.2, 40.0], 'motion.method': 'numeric'}
    bag = recorded(tmp_path / 'bag', fast, [torque_command(29, (0.0, 500.0, 0.0), 55)], 4)
    whole = dict(read(bag)['gyro'])
    for changes in ({}, {'body.inertia': [810.0, 900.0, 600.0]}):
        scenario, begin = begun_in_bag(Scenario(VALUES | fast | changes), bag, 1.5)
        for _ in simulate(scenario, 1, tmp_path / f'on{len(changes)}', begin=begin):
            pass
        onward = read(tmp_path / f'on{len(changes)}')['gyro']
        same = [data == whole[stamp_ns] for stamp_ns, data in onward]
        assert same[0]
        assert all(same) == (not changes)
    old = Path(__file__).parents[1] / 'reference' / 'bags_rules_2' / 'integrating_gyro'
    scenario, begin = begun_in_bag(RecordedRun(old).scenario, old, 4)
    simulation = Simulation.from_snapshot(scenario, begin)
    _, samples = simulation.advance(1)
    np.testing.assert_allclose(
        samples.measured['gyro'].values, samples.states.omega_bi_b, rtol=0.0, atol=1e-3
    )


def test_a_changed_measurement_is_found(tmp_path, monkeypatch):
    """A bag whose gyro had other noise than its seed gives is rejected, by the gyro."""
    with monkeypatch.context() as patch:
        patch.setattr('satdyn_ros.run.sensors.stream_of', lambda name: 77)
        recorded(tmp_path / 'bag')
    difference = flights.difference(verify(tmp_path / 'bag'))
    assert (difference.topic, difference.tick) == ('/gyro', 0)


def test_a_seed_of_zero_is_drawn_and_recorded(tmp_path):
    """Two runs differ, and each proves itself."""
    runs = [recorded(tmp_path / name, {'sensors.seed': 0}, []) for name in 'ab']
    seeds = [RecordedRun(bag).scenario['sensors.seed'] for bag in runs]
    assert seeds[0] != seeds[1]
    assert all(seeds)
    assert all(verify(bag).same_bytes for bag in runs)


def test_ticks_taken_back_are_measured_again():
    """As the node does when something comes up: what follows has the bits of a run without it."""
    straight = Simulation(Scenario(VALUES))
    _, whole = straight.advance(64)
    halting = Simulation(Scenario(VALUES))
    halting.advance(64)
    halting.rewind(11)
    _, first = halting.advance(20)
    as_it_was = copy.copy(halting)
    halting.rewind(31)
    _, second = halting.advance(33)
    for name in ('gyro', 'star_tracker'):
        wanted = whole.measured[name]
        values = np.concatenate([part.measured[name].values for part in (first, second)])
        assert np.array_equal(values, wanted.values[wanted.indices >= 11])
    assert as_it_was.snapshot(25)['sensors'] != as_it_was.snapshot(20)['sensors']


@pytest.mark.parametrize(('off_by', 'is_true'), [(1, True), (2, False)])
def test_another_machine_may_round_a_sample_to_the_next_step(
    tmp_path, monkeypatch, off_by, is_true
):
    """One step of the resolution is what rounding may do there, two are not."""
    step = 1e-4
    scenario = Scenario(VALUES | {'sensors.gyro.resolution': step})
    here = run_metadata.machine()
    with monkeypatch.context() as patch:
        patch.setattr(run_metadata, 'machine', lambda *_: here | {'numba': '0.1'})
        recording = Recording(tmp_path / 'bag', scenario, scenario.topics)
    _, samples = Simulation(scenario).advance(100)
    samples.measured['gyro'].values[20] += off_by * step
    names = (*scenario.topics, *scenario.sensors)
    rows = {name: packer(name, scenario).pack(samples) for name in names}
    recording.samples(samples.stamps_ns, rows, Simulation(scenario).snapshot)
    recording.close()
    verdict = verify(tmp_path / 'bag')
    assert (verdict.is_true, verdict.same_bytes) == (is_true, False)
