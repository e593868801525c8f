"""Running a bag again distinguishes a true one from any other."""

import json
import struct
from dataclasses import replace
from pathlib import Path

import flights
import numpy as np
import pytest
from commands import motor_command, torque_command
from mcap.records import Channel, Message, Metadata, Schema
from mcap.stream_reader import StreamReader
from mcap.writer import CompressionType, Writer
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState

from satdyn_ros.bag import run_metadata
from satdyn_ros.bag.read_run import RecordedRun
from satdyn_ros.bag.verify import verify
from satdyn_ros.bag.write_run import Recording
from satdyn_ros.rosbag2.chunk import Contents
from satdyn_ros.rosbag2.errors import Damaged
from satdyn_ros.rosbag2.reader import Bag
from satdyn_ros.rosbag2.records import written
from satdyn_ros.rosbag2.scan import Block, scan
from satdyn_ros.run.events import Reset
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.run.simulation import Simulation

CONFIG = Path(__file__).parents[2] / 'config'


@pytest.fixture(scope='module')
def bag(tmp_path_factory):
    return flights.record(tmp_path_factory.mktemp('verify') / 'bag')


def rewritten(bag, path, change, without=None):
    """
    Write a bag's file again with the mcap library's own writer, in other chunks.

    change: a message (topic, log time, data) to a list of those that take its place.  without: a
    topic to leave out.
    """
    with open(path, 'wb') as file:
        writer = Writer(file, 5000, CompressionType.LZ4)
        writer.start('ros2', 'another')
        topics, schemas, channels = {}, {}, {}
        for record in StreamReader(str(bag / 'bag_0.mcap')).records:
            if type(record).__name__ == 'DataEnd':
                break
            if isinstance(record, Schema):
                schemas[record.id] = writer.register_schema(
                    record.name, record.encoding, record.data
                )
            elif isinstance(record, Channel):
                topics[record.id] = record.topic
                if record.topic == without:
                    continue
                channels[record.topic] = writer.register_channel(
                    record.topic, 'cdr', schemas[record.schema_id], record.metadata
                )
            elif isinstance(record, Metadata):
                writer.flush()
                writer.add_metadata(record.name, record.metadata)
            elif isinstance(record, Message) and topics[record.channel_id] != without:
                for topic, log_time, data in change(
                    topics[record.channel_id], record.log_time, record.data
                ):
                    writer.add_message(channels[topic], log_time, data, log_time)
        writer.finish()
    return path


def unchanged(topic, log_time, data):
    return [(topic, log_time, data)]


def stamp(tick):
    return flights.EPOCH_NS + round(tick * 10**9 / 30)


def test_progress_counts_the_ticks(bag):
    """Of those that the bag spans, and no further does the run go."""
    shown = []
    verify(bag, lambda *done: shown.append(done))
    done, total = zip(*shown, strict=True)
    assert set(total) == {150}
    assert done == tuple(sorted(done))
    assert done[-1] == 150


def test_a_bag_of_ours_verifies(bag):
    """Every message of every topic, requests, torques and a change of topics on the way."""
    verdict = verify(bag)
    assert verdict.is_true
    assert verdict.same_bytes
    assert verdict.message_count == len(flights.sequence(bag))
    assert verdict.other_machine == {}
    assert 0.0 < max(verdict.drift.values()) < verdict.allowed_drift
    assert str(verdict).startswith(f'{verdict.message_count} messages, the same byte for byte; ')


def test_what_is_not_conserved_is_reported(bag):
    """The same bytes are not enough where the run itself is not true."""
    verdict = verify(bag)
    untrue = replace(verdict, drift={'energy_balance': 2.0 * verdict.allowed_drift})
    assert not untrue.is_true
    assert 'drift of energy_balance' in str(untrue)


def test_a_coarse_run_may_drift_more(tmp_path):
    """What is allowed follows the tolerance: no run fails for its own tolerance."""
    scenario = flights.GYROSTAT.with_values({'motion.tolerance': 1e-6})
    verdict = verify(flights.record(tmp_path / 'bag', scenario, 3000, ()))
    assert verdict.is_true
    fine = verify(flights.record(tmp_path / 'fine', flights.GYROSTAT, 3000, ()))
    assert verdict.drift['energy_balance'] > 10.0 * fine.drift['energy_balance']


def test_other_chunks_verify(bag, tmp_path):
    """The same bytes means the same messages in the same order, whoever wrote the file."""
    verdict = verify(rewritten(bag, tmp_path / 'copy.mcap', unchanged))
    assert (verdict.is_true, verdict.same_bytes) == (True, True)
    assert verdict.message_count == len(flights.sequence(bag))


def test_a_flipped_bit_is_found_where_it_is(bag, tmp_path):
    """In the last bit of one number: topic, tick, time and field are named."""

    def change(topic, log_time, data):
        if (topic, log_time) == ('/imu', stamp(70)):
            data = bytearray(data)
            data[132] ^= 1
        return [(topic, log_time, bytes(data))]

    verdict = verify(rewritten(bag, tmp_path / 'copy.mcap', change))
    found = flights.difference(verdict)
    assert (found.topic, found.tick, found.field) == ('/imu', 70, 'angular_velocity')
    assert found.t_s == 70 / 30
    assert 'angular_velocity of /imu at tick 70, 2.33333333 s' in str(verdict)


def test_every_number_and_constant_counts(bag, tmp_path):
    """A flip anywhere in a message is a difference, also in padding and in strings."""
    length = len(next(data for topic, _, data in flights.sequence(bag) if topic == '/rotor'))
    fields = set()
    for offset in range(length):

        def change(topic, log_time, data, offset=offset):
            if (topic, log_time) == ('/rotor', stamp(5)):
                data = data[:offset] + bytes([data[offset] ^ 0x10]) + data[offset + 1 :]
            return [(topic, log_time, data)]

        if offset % 4 == 0:
            verdict = verify(rewritten(bag, tmp_path / f'{offset}.mcap', change))
            found = flights.difference(verdict)
            assert (found.topic, found.tick) == ('/rotor', 5)
            fields.add(found.field)
    assert fields >= {'a constant', 'header.stamp.sec', 'position[0]', 'velocity[0]', 'effort[0]'}


@pytest.mark.parametrize(
    ('change', 'tick'),
    [
        (lambda *m: [] if m[:2] == ('/imu', stamp(33)) else [m], 33),
        (lambda *m: [m, m] if m[:2] == ('/imu', stamp(33)) else [m], 33),
        (lambda t, s, d: [(t, s + 1, d)] if s == stamp(33) else [(t, s, d)], 33),
        (lambda t, s, d: [(t, s, d + b'\0')] if (t, s) == ('/tf', stamp(33)) else [(t, s, d)], 33),
        (lambda *m: [] if m[1] >= stamp(33) and m[1] < stamp(40) else [m], 33),
    ],
    ids=['missing', 'twice', 'late', 'longer', 'gap'],
)
def test_a_missing_or_foreign_message_is_a_difference(bag, tmp_path, change, tick):
    """The sequence counts: what is missing, added, longer or at another time."""
    verdict = verify(rewritten(bag, tmp_path / 'copy.mcap', change))
    assert flights.difference(verdict).tick == tick


@pytest.mark.parametrize('topic', ['/attitude', '/imu'])
def test_a_topic_that_is_gone_is_a_difference(bag, tmp_path, topic):
    """With its channel, as programs that filter a bag leave it out."""
    verdict = verify(rewritten(bag, tmp_path / 'filtered.mcap', unchanged, without=topic))
    difference = flights.difference(verdict)
    assert (difference.topic, difference.tick) == (topic, 0)


def test_another_order_within_a_tick_is_a_difference(bag, tmp_path):
    """Of the messages at one tick, too."""
    kept = []

    def change(topic, log_time, data):
        if (topic, log_time) == ('/attitude', stamp(3)):
            kept.append((topic, log_time, data))
            return []
        if (topic, log_time) == ('/angular_velocity', stamp(3)):
            return [(topic, log_time, data), *kept]
        return [(topic, log_time, data)]

    difference = flights.difference(verify(rewritten(bag, tmp_path / 'copy.mcap', change)))
    assert (difference.topic, difference.tick) == ('/attitude', 3)


def test_another_torque_gives_another_run(bag, tmp_path):
    """A changed input is run as it stands in the bag: the states after it do not fit."""

    def change(topic, log_time, data):
        if topic == '/torque' and log_time == stamp(20):
            data = data[:-8] + struct.pack('<d', 0.31)
        return [(topic, log_time, data)]

    difference = flights.difference(verify(rewritten(bag, tmp_path / 'copy.mcap', change)))
    assert (difference.topic, difference.tick) == ('/attitude', 21)


@pytest.mark.parametrize('duration_s', [1.0, 1.97])
def test_the_files_of_a_split_bag_verify_alone(tmp_path, duration_s):
    """A file begun in mid-run is run from its own snapshot; after 1.97 s just where events are."""
    scenario = flights.GYROSTAT.with_values({'record.max_duration_s': duration_s})
    path = flights.record(tmp_path / 'bag', scenario)
    files = sorted(path.glob('*.mcap'))
    assert len(files) > 2
    verdicts = [verify(file) for file in files]
    assert all(verdict.is_true and verdict.same_bytes for verdict in verdicts)
    assert sum(v.message_count for v in verdicts) == verify(path).message_count


@pytest.mark.parametrize('tick', [1, 20, 21, 60, 100])
def test_a_bag_begun_in_mid_run_verifies(tmp_path, tick):
    """Also where it begins at a tick with inputs, which it holds ahead of its first sample."""
    simulation = Simulation(flights.GYROSTAT, flights.EVENTS)
    while simulation.next_tick < tick:
        simulation.advance(tick - simulation.next_tick)
    recording = Recording(tmp_path / 'bag', flights.GYROSTAT, simulation.topics)
    for _ in flights.written(recording, simulation, 150):
        pass
    recording.close()
    verdict = verify(tmp_path / 'bag')
    assert (verdict.is_true, verdict.same_bytes) == (True, True)
    assert verdict.message_count == len(flights.sequence(tmp_path / 'bag'))
    first = RecordedRun(tmp_path / 'bag').snapshot
    assert first is not None
    assert first['tick'] == tick


def test_a_torque_with_a_timeout_verifies(tmp_path):
    """The run ends the torque by itself; the bag's record of it changes nothing."""
    scenario = flights.GYROSTAT.with_values({'torque.timeout': 0.5})
    events = [torque_command(20, (0.1, 0.0, 0.0), until_tick=35)]
    path = flights.record(tmp_path / 'bag', scenario, 60, events)
    assert verify(path).is_true


@pytest.mark.parametrize('torque_comes_first', [True, False])
def test_inputs_at_one_tick_keep_their_order(tmp_path, torque_comes_first):
    """Whichever input came first in the run comes first in the run again."""
    inputs = [
        torque_command(20, (0.1, 0.0, 0.0)),
        motor_command(20, {'rotor': 0.01}),
    ]
    inputs = inputs if torque_comes_first else inputs[::-1]
    path = flights.record(tmp_path / 'bag', ticks=40, events=inputs)
    assert RecordedRun(path).events == inputs
    assert verify(path).same_bytes


@pytest.mark.parametrize('attitude', [(0.0, 0.0, 0.0, 1.0), (2**-0.5, 0.0, 0.0, 2**-0.5)])
def test_a_bag_whose_integrals_start_at_zero_verifies(tmp_path, attitude):
    """About a fixed centre, from rest, the area is zero but for rounding errors, which grow."""
    scenario = Scenario(
        {
            'orbit.type': 'fixed',
            'orbit.gradient': 0.01,
            'initial.attitude': attitude,
            'initial.angular_velocity': (0.01, 0.0, 0.0),
            'time.epoch_ns': flights.EPOCH_NS,
        }
    )
    verdict = verify(flights.record(tmp_path / 'bag', scenario, 1000, ()))
    assert verdict.is_true, str(verdict)


def test_a_body_that_a_torque_moves_from_rest_verifies(tmp_path):
    """Its energy and the work begin at zero: the torque itself is what a step is uncertain of."""
    scenario = Scenario.from_dict(
        {
            'body': {'inertia': [0.02, 0.03, 0.04]},
            'publish': {'rate': 10.0},
            'time': {'epoch_ns': flights.EPOCH_NS},
        }
    )
    events = [torque_command(0, (5e-4, 5e-4, 5e-4), until_tick=10)]
    verdict = verify(flights.record(tmp_path / 'bag', scenario, 30, events))
    assert verdict.is_true, str(verdict)
    assert verdict.drift['energy_balance'] < 0.1 * verdict.allowed_drift


def test_a_run_that_halts_verifies(tmp_path):
    """The steps of a motion that ended count as those of one that goes on."""
    scenario = flights.GYROSTAT.with_values({'initial.angular_velocity': [300.0, 0.0, 400.0]})
    events = [
        torque_command(140, (1e9, 0.0, 0.0)),
        torque_command(145, (1e14, 0.0, 0.0)),
    ]
    verdict = verify(flights.record(tmp_path / 'bag', scenario, 150, events))
    assert verdict.is_true, str(verdict)


@pytest.mark.parametrize(
    ('values', 'name'),
    [
        ({}, 'steady rotation'),
        ({'body.inertia': [2.0, 3.0, 2.0]}, 'steady rotation'),
        ({'rotor.mode': 'constant_momentum', 'rotor.momentum': 0.3}, 'free rotation'),
        ({'rotor.mode': 'free', 'rotor.inertia': 0.05, 'rotor.speed': 3.0}, 'free rotation'),
    ],
    ids=['sphere', 'disc', 'rotor', 'free rotor'],
)
def test_a_closed_form_on_an_ellipse_verifies(tmp_path, values, name):
    """A sphere has a potential too, which changes with the distance."""
    # In LVLH axes the orbit's normal is -Y, about which a disc turns freely.
    rate = [0.0, 0.02, 0.0] if 'body.inertia' in values else [0.01, -0.02, 0.005]
    scenario = Scenario(
        {
            'body.inertia': [2.0, 2.0, 2.0],
            'orbit.type': 'kepler',
            'orbit.eccentricity': 0.3,
            'orbit.semi_major_axis': 1.2e7,
            'motion.method': 'auto',
            'initial.attitude': (0.0, 0.0, 0.0, 1.0),
            'initial.angular_velocity': rate,
            'publish.rate': 0.5,
            'time.epoch_ns': flights.EPOCH_NS,
            **values,
        }
    )
    assert scenario.motion().name == name
    verdict = verify(flights.record(tmp_path / 'bag', scenario, 4000, ()))
    assert verdict.is_true, str(verdict)
    assert verdict.drift['energy_balance'] < 0.1 * verdict.allowed_drift


@pytest.mark.parametrize('ticks', [0, 1])
def test_the_shortest_bags_verify(tmp_path, ticks):
    """No tick or one, and no published topic."""
    assert verify(flights.record(tmp_path / 'bag', ticks=ticks)).is_true
    silent = flights.GYROSTAT.with_values({'publish.topics': ()})
    path = flights.record(tmp_path / 'silent', silent, ticks, ())
    assert verify(path).message_count == 0


def test_inputs_before_the_first_sample_verify(tmp_path):
    """Nothing is published while a torque begins to act: the bag begins at tick 0 all the same."""
    silent = flights.GYROSTAT.with_values({'publish.topics': ()})
    events = (torque_command(5, (0.1, 0.0, 0.0)), flights.Topics(10, ('attitude',)))
    path = flights.record(tmp_path / 'bag', silent, 20, events)
    assert RecordedRun(path).events == list(events)
    verdict = verify(path)
    assert (verdict.message_count, verdict.same_bytes) == (11, True)


def test_a_timeout_after_the_last_message_is_compared(tmp_path):
    """Nothing is published any more where the torque ends: the run goes on to the last event."""
    events = (flights.Topics(3, ()), torque_command(5, (0.1, 0.0, 0.0), until_tick=20))
    path = flights.record(tmp_path / 'bag', ticks=30, events=events)
    assert [event.tick for event in RecordedRun(path).events] == [3, 5, 20]
    assert verify(path).same_bytes


def test_a_file_that_begins_at_tick_0_verifies_alone(tmp_path):
    """What happened at tick 0, a limit too, has filled the file before."""
    scenario = flights.GYROSTAT.with_values({'record.max_size_bytes': 1, 'rotor.max_torque': 0.01})
    events = (motor_command(0, {'rotor': 1.0}), flights.Request(0, {'rotor.speed': 3.0}))
    path = flights.record(tmp_path / 'bag', scenario, 3, events)
    files = Bag(path).files
    assert len(files) == 2
    for file in (path, *files):
        assert verify(file).same_bytes
    assert RecordedRun(files[1]).first_tick == 0
    assert RecordedRun(files[1]).events == []


def test_an_exact_run_verifies(tmp_path):
    """A closed form is as repeatable as a propagation, and conserves what it should."""
    scenario = Scenario.from_dict(
        {
            'body': {'inertia': [80.0, 80.0, 50.0]},
            'orbit': {'type': 'fixed'},
            'initial': {'angular_velocity': [0.1, 0.05, 0.3]},
            'motion': {'method': 'exact'},
            'time': {'epoch_ns': flights.EPOCH_NS},
        }
    )
    verdict = verify(flights.record(tmp_path / 'bag', scenario, 1000, ()))
    assert (verdict.is_true, verdict.same_bytes) == (True, True)
    assert verdict.drift.keys() >= {'energy', 'momentum'}


# -- another machine -----------------------------------------------------------------------------


def aside(tmp_path, monkeypatch, relative, scenario=flights.GYROSTAT, events=flights.EVENTS[:2]):
    """Record a run whose rates start aside, relatively, as on another machine; verify it."""
    here = run_metadata.machine()
    rate = scenario['initial.angular_velocity']
    flown = scenario.with_values(
        {'initial.angular_velocity': [x * (1.0 + relative) for x in rate]}
    )
    with monkeypatch.context() as patch:
        patch.setattr(run_metadata, 'machine', lambda *_: here | {'numba': '0.1'})
        recording = Recording(tmp_path / 'bag', scenario, scenario.topics)
    for _ in flights.written(recording, Simulation(flown, events), 1000):
        pass
    recording.close()
    return verify(tmp_path / 'bag')


def test_another_machine_may_round_otherwise(tmp_path, monkeypatch):
    """A few units in the last place at the start are what rounding may do; the answer says so."""
    verdict = aside(tmp_path, monkeypatch, 1e-15)
    assert (verdict.is_true, verdict.same_bytes) == (True, False)
    assert 0.0 < verdict.of_allowed < 1.0
    numba = run_metadata.machine()['numba']
    assert verdict.other_machine == {'numba': ('0.1', numba)}
    assert f'made on another machine or version (numba 0.1 then, {numba} now)' in str(verdict)


@pytest.mark.parametrize('name', ['agostinelli', 'beletsky', 'paladini'])
def test_another_machine_may_round_a_closed_form_otherwise(tmp_path, monkeypatch, name):
    """Rounding is measured with a start that is off by more, and may have no closed form."""
    scenario = Scenario.from_yaml(CONFIG / f'{name}.yaml').with_values(
        {'motion.method': 'exact', 'time.epoch_ns': flights.EPOCH_NS}
    )
    verdict = aside(tmp_path, monkeypatch, 1e-15, scenario, ())
    assert (verdict.is_true, verdict.same_bytes) == (True, False)
    assert 0.0 < verdict.of_allowed < 1.0


def test_another_machine_costs_one_run_more(tmp_path, monkeypatch):
    """However often a run restarts: nothing is made for each restart from all events."""
    made, make = [], Simulation.__init__

    def counted(self, *given):
        made.append(self)
        make(self, *given)

    monkeypatch.setattr(Simulation, '__init__', counted)
    resets = [Reset(tick) for tick in range(1, 1000, 10)]
    verdict = aside(tmp_path, monkeypatch, 1e-15, events=resets)
    assert verdict.other_machine
    # That which was recorded, the one that it is compared with, and its twin.
    assert len(made) == 3


def test_more_than_rounding_is_a_difference_there_too(tmp_path, monkeypatch):
    """A start that is 1e-11 off is another run on any machine."""
    verdict = aside(tmp_path, monkeypatch, 1e-11)
    assert not verdict.is_true
    assert verdict.difference.tick == 0


def test_the_angle_of_a_rotor_rounds_no_more_than_the_attitude(tmp_path, monkeypatch):
    """However fast it turns: 1e-9 rad more at one tick are a difference."""
    here = run_metadata.machine()
    with monkeypatch.context() as patch:
        patch.setattr(run_metadata, 'machine', lambda *_: here | {'numba': '0.1'})
        bag = flights.record(tmp_path / 'bag')

    def change(topic, log_time, data):
        if (topic, log_time) == ('/rotor', stamp(5)):
            (angle,) = deserialize_message(data, JointState).position
            data = data.replace(struct.pack('<d', angle), struct.pack('<d', angle + 1e-9))
        return [(topic, log_time, data)]

    assert verify(rewritten(bag, tmp_path / 'same.mcap', unchanged)).is_true
    found = flights.difference(verify(rewritten(bag, tmp_path / 'off.mcap', change)))
    assert (found.topic, found.tick, found.field) == ('/rotor', 5, 'position[0]')


def test_the_same_machine_owes_the_same_bytes(tmp_path, monkeypatch):
    """Where nothing has changed, rounding is no excuse."""
    monkeypatch.setattr(run_metadata, 'machine', lambda *_: {'numba': '0.1'})
    verdict = aside(tmp_path, monkeypatch, 1e-15)
    assert not verdict.is_true
    assert verdict.of_allowed == 0.0


def test_a_message_after_the_end_of_a_run_is_extra(tmp_path):
    """The last stamp of ROS ends a run, and its bag."""
    values = {'publish.rate': 10.0, 'publish.topics': ['attitude']}
    scenario = Scenario(values | {'time.epoch_ns': (2**31 - 3) * 10**9})
    bag = flights.record(tmp_path / 'bag', scenario, 30, ())
    assert verify(bag).is_true

    def doubled(topic, log_time, data):
        is_last = log_time == scenario['time.epoch_ns'] + 2_900_000_000
        return unchanged(topic, log_time, data) * (1 + is_last)

    verdict = verify(rewritten(bag, tmp_path / 'longer.mcap', doubled))
    assert not verdict.is_true
    assert 'an extra message of /attitude at tick 29, 2.9 s' in str(verdict)


def test_messages_without_their_start_are_extra(bag, tmp_path):
    """Without the snapshot that comes ahead of the first sample, no message can be compared."""
    records = [found.item for found in scan(bag / 'bag_0.mcap')]
    kept = [record for record in records if getattr(record, 'name', '') != run_metadata.SNAPSHOT]
    assert len(kept) < len(records)
    file = flights.rewritten(kept, tmp_path / 'bare.mcap')
    file.finish()
    verdict = verify(file.path)
    assert not verdict.is_true
    assert 'an extra message of /' in str(verdict)


def test_inputs_without_a_sample_verify(tmp_path):
    """A node may close its bag after an input and before the tick where it acts."""
    scenario = flights.GYROSTAT
    recording = Recording(tmp_path / 'bag', scenario, scenario.topics)
    recording.event(torque_command(0, (0.1, 0.0, 0.0)), flights.EPOCH_NS)
    recording.close()
    verdict = verify(tmp_path / 'bag')
    assert verdict.is_true
    assert verdict.message_count == 1


@pytest.mark.parametrize(
    ('method', 'changed'),
    [
        ('register_schema', lambda name, encoding, data: (name + '2', encoding, data)),
        ('register_schema', lambda name, encoding, data: (name, 'ros2idl', data)),
        (
            'register_schema',
            lambda name, encoding, data: (
                name,
                encoding,
                data.replace(b'float64 x', b'float64 w'),
            ),
        ),
        ('register_channel', lambda topic, _, schema, metadata: (topic, 'json', schema, metadata)),
    ],
)
def test_messages_declared_as_something_else_are_refused(
    bag, tmp_path, monkeypatch, method, changed
):
    """Their bytes are right, and a reader would take them for what they are not."""
    register = getattr(Writer, method)
    monkeypatch.setattr(
        Writer, method, lambda self, *declared: register(self, *changed(*declared))
    )
    path = rewritten(bag, tmp_path / 'other.mcap', unchanged)
    wanted = 'does not declare /attitude as geometry_msgs/msg/QuaternionStamped in CDR'
    with pytest.raises(Damaged, match=wanted):
        verify(path)


def test_another_comment_in_a_definition_is_allowed(bag, tmp_path, monkeypatch):
    """Versions of ROS differ in them."""
    register = Writer.register_schema

    def commented(self, name, encoding, data):
        return register(self, name, encoding, b'# As ever.\n\n' + data.replace(b'#', b'# Or:'))

    monkeypatch.setattr(Writer, 'register_schema', commented)
    assert verify(rewritten(bag, tmp_path / 'other.mcap', unchanged)).same_bytes


def test_files_of_another_scenario_are_refused(tmp_path):
    """Each file is to verify alone: what it says of the run is what the first one says."""
    scenario = flights.GYROSTAT.with_values({'record.max_duration_s': 1.0})
    bag = flights.record(tmp_path / 'bag', scenario, 60, ())
    (bag / 'metadata.yaml').unlink()
    last = bag / 'bag_1.mcap'
    records = [found.item for found in scan(last)]

    def changed(record):
        said = record.metadata
        return said | {'rules': '6'} if record.name == run_metadata.SCENARIO else said

    last.unlink()
    flights.rewritten(records, last, changed).finish()
    with pytest.raises(Damaged, match='satdyn_ros/scenario: it is not that of the file before'):
        verify(bag)


@pytest.mark.parametrize('name', ['state', 'begin_state', 'conditions', 'until'])
def test_a_file_that_would_continue_otherwise_is_a_difference(tmp_path, name):
    """A snapshot counts where the file before leads to it, too: alone its file runs from it."""
    scenario = flights.GYROSTAT.with_values({'record.max_duration_s': 1.0})
    bag = flights.record(tmp_path / 'bag', scenario, 60)
    assert verify(bag).is_true
    (bag / 'metadata.yaml').unlink()
    last = bag / 'bag_1.mcap'
    records = [found.item for found in scan(last)]

    def changed(record):
        said = record.metadata
        if record.name != run_metadata.SNAPSHOT:
            return said
        value = {'until': {'torque': 55}}.get(name, json.loads(said[name]))
        if 'q_ib' in value:
            value['q_ib'][0] += 1e-9
        if 'rotor.speed' in value:
            value['rotor.speed'] = 1.0
        return said | {name: json.dumps(value)}

    last.unlink()
    flights.rewritten(records, last, changed).finish()
    difference = flights.difference(verify(bag))
    assert (difference.topic, difference.field) == ('the snapshot', name)


def test_files_that_swap_their_topics_are_refused(tmp_path):
    """Messages are compared by channel: two topics of one type must not be exchanged."""
    scenario = flights.GYROSTAT.with_values(
        {'publish.topics': ['attitude', 'attitude_lvlh'], 'record.max_size_bytes': 20_000}
    )
    bag = flights.record(tmp_path / 'bag', scenario, 600, (), flush=True)
    (bag / 'metadata.yaml').unlink()
    first = bag / 'bag_0.mcap'
    assert verify(bag).is_true
    records = [found.item for found in scan(first)]
    names = {'/attitude': '/attitude_lvlh', '/attitude_lvlh': '/attitude'}
    for i, record in enumerate(records):
        if isinstance(record, Block):
            schemas, channels = record.contents.declarations
            swapped = [replace(c, topic=names.get(c.topic, c.topic)) for c in channels.values()]
            parts = [
                written([*schemas.values(), *swapped]),
                bytes(record.contents.message_records()),
            ]
            contents = Contents(np.frombuffer(b''.join(parts), np.uint8))
            assert record.chunk is not None
            chunk = replace(record.chunk, compression='', data=bytes(contents.data))
            records[i] = Block(contents, chunk)
    first.unlink()
    flights.rewritten(records, first).finish()
    with pytest.raises(Damaged, match='the channel of /attitude'):
        verify(bag)
